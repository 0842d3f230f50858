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
    from fesloop.study.design.figure_specs import Figure
    from fesloop.study.design.study import Study
    from fesloop.study.design.study_file import read_study, study_of
    from fesloop.study.engine.coordinator import Summary, run_study
    from fesloop.study.figures.drawing import draw
    from fesloop.study.figures.overlays import Overlay
    from fesloop.study.results.study_results import StudyResults, load

_HOMES = {
    "Figure": "fesloop.study.design.figure_specs",
    "Overlay": "fesloop.study.figures.overlays",
    "Study": "fesloop.study.design.study",
    "StudyResults": "fesloop.study.results.study_results",
    "Summary": "fesloop.study.engine.coordinator",
    "draw": "fesloop.study.figures.drawing",
    "load": "fesloop.study.results.study_results",
    "read_study": "fesloop.study.design.study_file",
    "run_study": "fesloop.study.engine.coordinator",
    "study_of": "fesloop.study.design.study_file",
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
