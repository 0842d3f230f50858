"""Where the results of a store come from: which versions made them, on how many workers and when."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from fesloop.errors import InputError

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
