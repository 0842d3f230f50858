"""Versions of fesloop's code, of libraries and of the machine, on which results depend."""

from __future__ import annotations

import hashlib
import json
import platform
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

_PACKAGES = ("fesloop", "plants", "estimators", "controllers")
_LIBRARIES = ("numpy", "scipy", "numba", "mujoco", "vqf", "daqp", "osqp", "fmpy")
_SUFFIXES = (".py", ".toml", ".c", ".h")


@cache
def version_text() -> str:
    """JSON of the versions of fesloop, its code, Python, libraries and machine; equal texts, equal results.

    The code's version is a hash of the files of fesloop's four packages, so that an edited copy differs.
    """
    versions = {"fesloop": metadata.version("fesloop"), "code": _code_hash()[:12],
                "python": platform.python_version(), "machine": platform.machine()}
    for library in _LIBRARIES:
        try:
            versions[library] = metadata.version(library)
        except metadata.PackageNotFoundError:
            versions[library] = "absent"
    return json.dumps(versions)


def differences(there: str, here: str) -> str:
    """The differences between two version texts: "numpy 2.3 there, 2.4 here"."""
    first, second = json.loads(there), json.loads(here)
    return ", ".join(f"{name} {first.get(name)} there, {second.get(name)} here"
                     for name in {**first, **second} if first.get(name) != second.get(name))


def _code_hash() -> str:
    """SHA-256 of every source file of the four packages."""
    found = hashlib.sha256()
    for package in _PACKAGES:
        spec = find_spec(package)
        for folder in (spec.submodule_search_locations or ()) if spec else ():
            for path in sorted(Path(folder).rglob("*")):
                if path.suffix in _SUFFIXES:
                    found.update(f"{package}/{path.relative_to(folder)}\n".encode())
                    found.update(path.read_bytes())
    return found.hexdigest()
