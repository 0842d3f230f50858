"""The three block packages are top-level names that anybody could use: check that ours are found."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path

SIBLINGS = ("plants", "estimators", "controllers")


def check_siblings(home: Path | None = None) -> None:
    """Raise ImportError, naming the file, if something else stands where a block package should be.

    `home` is the folder that holds fesloop and its three siblings.
    """
    home = home or Path(__file__).resolve().parent.parent
    for name in SIBLINGS:
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
