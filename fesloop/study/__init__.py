"""Studies: an experiment run over axes and replicates, and what came of it.

    from fesloop.study import load

    results = load("studies/latency_map")
    results.compare("error_deg", {"controller": "mpc"}, {"controller": "pid"})

Everything named here is imported on first use, so that `import fesloop.study` itself takes no time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fesloop.study.figure_specs import Figure
    from fesloop.study.results import StudyResults, load

_HOMES = {
    "Figure": "fesloop.study.figure_specs",
    "StudyResults": "fesloop.study.results",
    "load": "fesloop.study.results",
}

__all__ = ["Figure", "StudyResults", "load"]


def __getattr__(name: str) -> Any:
    """Import a public name where it is first used."""
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module 'fesloop.study' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return list(__all__)
