"""What results depend on beside the experiment: the code that ran, and the libraries under it."""

from __future__ import annotations

import hashlib
import json
import platform
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import quote

from fesloop.errors import InputError

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


_VERSIONS = """
SELECT text, count(id) FROM versions LEFT JOIN results USING (version) GROUP BY version ORDER BY version
"""
_WHEN = "SELECT min(finished), max(finished), count(DISTINCT worker) FROM results WHERE worker <> ''"


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """Who made the results of a store.

    Attributes
    ----------
    versions: of fesloop, its code, libraries, machine, by name; with how many results each made.
    first, last: when the first and the last result was noted, UTC; empty where there is none.
    workers: how many processes have run something.
    """

    versions: tuple[tuple[dict[str, str], int], ...]
    first: str
    last: str
    workers: int


def provenance_of(path: Path) -> Provenance:
    """Of a store. Raises InputError where its tables do not tell."""
    with opened_to_read(path) as store:
        try:
            versions = tuple((dict(json.loads(text)), int(count)) for text, count in store.execute(_VERSIONS))
            first, last, workers = store.execute(_WHEN).fetchone()
        except (sqlite3.DatabaseError, TypeError, ValueError) as fault:
            raise InputError(str(path), f"does not tell which versions made its results: {fault}") from None
    return Provenance(versions=versions, first=first or "", last=last or "", workers=int(workers))


@contextmanager
def opened_to_read(path: Path) -> Iterator[sqlite3.Connection]:
    """A store, to be read only; text that is none is replaced."""
    address = f"file:{quote(str(path.resolve()))}?mode=ro"
    try:
        with closing(sqlite3.connect(address, uri=True, isolation_level=None)) as store:
            store.text_factory = lambda text: text.decode("utf-8", errors="replace")
            yield store
    except sqlite3.OperationalError as fault:
        raise InputError(str(path), f"cannot be opened: {fault}", "a file that you may read") from None
