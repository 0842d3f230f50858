"""Scripts of peers, found by path, which are measured in the same run."""

from __future__ import annotations

import os
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import fesloop
from fesloop.errors import InputError

VARIABLE = "FESLOOP_PEERS"


def folder(name: str) -> Path:
    """A folder of scripts under FESLOOP_PEERS, by default beside the project.

    Raises InputError, naming the variable, where it is absent.
    """
    default = Path(fesloop.__file__).resolve().parent.parent.parent / "shared" / "peers"
    found = Path(os.environ.get(VARIABLE, default)) / name
    if not found.is_dir():
        raise InputError(VARIABLE, f"there is no folder {found}", "the folder of the peers' scripts",
                         f"set {VARIABLE} to measure against them")
    return found


def module(script: Path) -> ModuleType:
    """Load a script as a module under its own name, by which the others of its folder import it."""
    known = sys.modules.get(script.stem)
    if known is not None and known.__file__ == str(script):
        return known
    spec = spec_from_file_location(script.stem, script)
    if spec is None or spec.loader is None:
        raise InputError(VARIABLE, f"{script} is no script", "a Python file")
    made = module_from_spec(spec)
    sys.modules[script.stem] = made
    spec.loader.exec_module(made)
    return made
