"""Closed-loop co-simulation of functional electrical stimulation of the hand.

    import fesloop

    result = fesloop.run("finger_ilc", {"law": "gradient"})
    result.metrics["joint_rmse_deg"]
    fesloop.report(result)

Everything named here is imported on first use, so that `import fesloop` itself takes no time.
"""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fesloop.apps.functions import export_block, film, identify, report, run, study
    from fesloop.errors import FesloopError, InputError, RunError
    from fesloop.experiment.files.parse import load
    from fesloop.experiment.own_blocks import block
    from fesloop.experiment.record_spec import Record
    from fesloop.experiment.recording.reading import Recording
    from fesloop.experiment.running import Experiment, Result
    from fesloop.experiment.score_spec import Score
    from fesloop.loop.duration import Duration
    from fesloop.loop.nodes import Node
    from fesloop.loop.realtime import Pacing
    from fesloop.loop.run import Loop
    from fesloop.loop.wire import Wire
    from fesloop.loop.wiring import Wiring

_HOMES = {
    "Duration": "fesloop.loop.duration",
    "Experiment": "fesloop.experiment.running",
    "FesloopError": "fesloop.errors",
    "InputError": "fesloop.errors",
    "Loop": "fesloop.loop.run",
    "Node": "fesloop.loop.nodes",
    "Pacing": "fesloop.loop.realtime",
    "Record": "fesloop.experiment.record_spec",
    "Recording": "fesloop.experiment.recording.reading",
    "Result": "fesloop.experiment.running",
    "RunError": "fesloop.errors",
    "Score": "fesloop.experiment.score_spec",
    "Wire": "fesloop.loop.wire",
    "Wiring": "fesloop.loop.wiring",
    "block": "fesloop.experiment.own_blocks",
    "export_block": "fesloop.apps.functions",
    "film": "fesloop.apps.functions",
    "identify": "fesloop.apps.functions",
    "load": "fesloop.experiment.files.parse",
    "report": "fesloop.apps.functions",
    "run": "fesloop.apps.functions",
    "study": "fesloop.apps.functions",
}

__all__ = [
    "Duration",
    "Experiment",
    "FesloopError",
    "InputError",
    "Loop",
    "Node",
    "Pacing",
    "Record",
    "Recording",
    "Result",
    "RunError",
    "Score",
    "Wire",
    "Wiring",
    "block",
    "export_block",
    "film",
    "identify",
    "load",
    "report",
    "run",
    "study",
]

_SIBLINGS = ("plants", "estimators", "controllers")


def _check_siblings(home: Path | None = None) -> None:
    """Raise ImportError, naming the file, if something else stands where a block package should be.

    `home` is the folder that holds fesloop and its three siblings.
    """
    home = home or Path(__file__).resolve().parent.parent
    for name in _SIBLINGS:
        found = _location(name)
        expected = home / name / "__init__.py"
        if found is None:
            raise ImportError(f"fesloop: its package {name!r} is missing; expected {expected}; "
                              "reinstall fesloop")
        if found != expected:
            raise ImportError(f"fesloop: its package {name!r} is shadowed by {found}; "
                              f"expected {expected}; rename or move that file, or run from another folder")


def _location(name: str) -> Path | None:
    """The file that `import name` would load or has loaded, None if there is none."""
    module = sys.modules.get(name)
    if module is not None:
        file = getattr(module, "__file__", None)
        return Path(file).resolve() if file else None
    spec = find_spec(name)
    if spec is None:
        return None
    if spec.origin is None:
        places = list(spec.submodule_search_locations or [])
        return Path(places[0]).resolve() if places else None
    return Path(spec.origin).resolve()


_check_siblings()


def __getattr__(name: str) -> Any:
    """Import a public name where it is first used; `__version__` comes from the installed package."""
    from importlib import import_module, metadata

    if name == "__version__":
        return metadata.version("fesloop")
    if name not in _HOMES:
        raise AttributeError(f"module 'fesloop' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
