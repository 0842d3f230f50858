"""Studies: an experiment run over axes and replicates, and what came of it.

    from fesloop.study import load, read_study, run_study

    summary = run_study(read_study("latency_map"))
    results = load(summary.store)
    results.compare("error_deg", {"controller": "mpc"}, {"controller": "pid"})

Everything named here is imported on first use, so that `import fesloop.study` itself takes no time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fesloop.study.coordinator import Summary, run_study
    from fesloop.study.figure_specs import Figure
    from fesloop.study.figures import draw
    from fesloop.study.overlays import Overlay
    from fesloop.study.results import StudyResults, load
    from fesloop.study.study import Study
    from fesloop.study.study_file import read_study, study_of

_HOMES = {
    "Figure": "fesloop.study.figure_specs",
    "Overlay": "fesloop.study.overlays",
    "Study": "fesloop.study.study",
    "StudyResults": "fesloop.study.results",
    "Summary": "fesloop.study.coordinator",
    "draw": "fesloop.study.figures",
    "load": "fesloop.study.results",
    "read_study": "fesloop.study.study_file",
    "run_study": "fesloop.study.coordinator",
    "study_of": "fesloop.study.study_file",
}

__all__ = [
    "Figure",
    "Overlay",
    "Study",
    "StudyResults",
    "Summary",
    "draw",
    "load",
    "read_study",
    "run_study",
    "study_of",
]


def __getattr__(name: str) -> Any:
    """Import a public name where it is first used."""
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module 'fesloop.study' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return list(__all__)
