"""What results depend on beside the experiment: the code that ran, and the libraries under it."""

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
    """JSON of versions, the same text where the same results come out: fesloop, its code, libraries, machine.

    The code is a hash of the files of fesloop's four packages, so that an edited copy is another version.
    """
    versions = {"fesloop": metadata.version("fesloop"), "code": _code()[:12],
                "python": platform.python_version(), "machine": platform.machine()}
    for library in _LIBRARIES:
        try:
            versions[library] = metadata.version(library)
        except metadata.PackageNotFoundError:
            versions[library] = "absent"
    return json.dumps(versions)


def differences(one: str, other: str) -> str:
    """What differs between two such texts: "numpy 2.3 there, 2.4 here"."""
    first, second = json.loads(one), json.loads(other)
    return ", ".join(f"{name} {first.get(name)} there, {second.get(name)} here"
                     for name in {**first, **second} if first.get(name) != second.get(name))


def _code() -> str:
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
