"""Studies: an experiment run over axes and replicates, and the results.

    from fesloop.analysis.study import load, read_study, run_study

    summary = run_study(read_study("latency_map"))
    results = load(summary.store)
    results.compare("error_deg", {"controller": "mpc"}, {"controller": "pid"})

Everything named here is imported on first use, so that `import fesloop.analysis.study` itself takes no time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fesloop.analysis.study.design.figure_specs import Figure
    from fesloop.analysis.study.design.study import Study
    from fesloop.analysis.study.design.study_file import read_study, study_of
    from fesloop.analysis.study.engine.coordinator import Summary, run_study
    from fesloop.analysis.study.results.study_results import StudyResults, load

_HOMES = {
    "Figure": "fesloop.analysis.study.design.figure_specs",
    "Study": "fesloop.analysis.study.design.study",
    "StudyResults": "fesloop.analysis.study.results.study_results",
    "Summary": "fesloop.analysis.study.engine.coordinator",
    "load": "fesloop.analysis.study.results.study_results",
    "read_study": "fesloop.analysis.study.design.study_file",
    "run_study": "fesloop.analysis.study.engine.coordinator",
    "study_of": "fesloop.analysis.study.design.study_file",
}

__all__ = [
    "Figure",
    "Study",
    "StudyResults",
    "Summary",
    "load",
    "read_study",
    "run_study",
    "study_of",
]


def __getattr__(name: str) -> Any:
    """Import a public name where it is first used."""
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module 'fesloop.analysis.study' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return list(__all__)
