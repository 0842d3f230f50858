"""Reads a study's store, also while its coordinator writes or after that was killed."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

from fesloop.analysis.study.store.file import (
    CHECKED,
    FILE,
    FORMAT,
    TABLE_NAMES,
    checked_rows,
    require_unchanged,
)
from fesloop.errors import InputError
from fesloop.given_files import is_file, is_folder

_BUSY_S = 30.0
"""Longest wait for a lock (chosen: a commit takes milliseconds, longer on a slow shared disk)."""
_ALLOWED = "a study's store, as `fesloop study` writes it"


class CellRow(NamedTuple):
    """A cell of the plan; `levels` is a table by axis, as JSON."""

    cell: int
    levels: str


class RunRow(NamedTuple):
    """A planned run."""

    cell: int
    replicate: int
    seed: int
    id: str


class ResultRow(NamedTuple):
    """The outcome of a run; `metrics` is JSON."""

    id: str
    status: str
    cause: str | None
    metrics: str | None
    wall_s: float | None
    recording: str | None


@dataclass(frozen=True, slots=True, eq=False)
class StoreRows:
    """The content of a store at one instant.

    Attributes
    ----------
    about: facts by key: format, name, form, study, created.
    cells, runs: the plan, in order of cell and replicate.
    results: outcomes of the runs that have ended.
    """

    about: dict[str, str]
    cells: list[CellRow]
    runs: list[RunRow]
    results: list[ResultRow]


def store_path(path: str | Path) -> Path:
    """Path of the store file, given that file or its folder. Raises InputError where there is none."""
    given = Path(path)
    found = given / FILE if is_folder(given) else given
    if not is_file(found):
        what = f"holds no {FILE}" if is_folder(given) else "does not exist"
        raise InputError(str(given), what, "a study's store, or the folder that holds it")
    return found


def read_store(path: Path, *, check: bool = True) -> StoreRows:
    """Read the plan and all results.

    Where the coordinator was killed within a commit, SQLite rolls that back first, which needs the right to
    write. `check` compares the rows with the store's checksum.

    Raises InputError for a file that is not a store, is damaged, of another version, locked, or cannot be
    rolled back.
    """
    with opened_to_read(path) as store:
        # One transaction, so that all tables are of one instant, whatever is written meanwhile.
        store.execute("BEGIN")
        about = _about(path, store)
        rows = checked_rows(store)
        if check:
            require_unchanged(store, path, rows)
        store.execute("COMMIT")
    return StoreRows(about, sorted(_named(CellRow, "cells", rows)), sorted(_named(RunRow, "runs", rows)),
                     _named(ResultRow, "results", rows))


def _named(kind: Any, table: str, rows: dict[str, list[tuple[Any, ...]]]) -> list[Any]:
    places = [CHECKED[table].index(field) for field in kind._fields]
    return [kind(*(row[place] for place in places)) for row in rows[table]]


@contextmanager
def opened_to_read(path: Path) -> Iterator[sqlite3.Connection]:
    """A connection that cannot change a store; SQLite's errors become InputErrors."""
    try:
        address = f"file:{quote(str(path.resolve()))}?mode=rw"
        with closing(sqlite3.connect(address, uri=True, timeout=_BUSY_S, isolation_level=None)) as store:
            store.execute("PRAGMA query_only = ON")
            yield store
    except UnicodeDecodeError as fault:  # of a column's name, or within SQLite's message about one
        raise InputError(str(path), f"is damaged: {fault}", _ALLOWED) from None
    except sqlite3.DatabaseError as fault:
        raise _refusal(path, fault) from None


def _refusal(path: Path, fault: sqlite3.DatabaseError) -> InputError:
    # Python's own errors, as of text that is no UTF-8, have no code.
    code = getattr(fault, "sqlite_errorcode", 0) & 0xFF
    if code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
        return InputError(str(path), f"stayed locked for {_BUSY_S:.0f} s", "",
                          "another process writes to it all the time: try again when it has ended")
    if code in (sqlite3.SQLITE_READONLY, sqlite3.SQLITE_CANTOPEN) and Path(f"{path}-journal").exists():
        return InputError(str(path), f"its writer was killed within a commit; no rollback possible: {fault}",
                          "a folder that can be written to",
                          f"copy it together with {path.name}-journal to such a folder")
    if code in (sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_PERM, sqlite3.SQLITE_AUTH):
        return InputError(str(path), f"cannot be opened: {fault}", "a file that you may read")
    if code == sqlite3.SQLITE_NOTADB:
        return InputError(str(path), "is not an SQLite file", _ALLOWED)
    return InputError(str(path), f"is damaged: {fault}", _ALLOWED,
                      "what is left of it: `sqlite3 study.sqlite .recover | sqlite3 rest.sqlite`")


def _about(path: Path, store: sqlite3.Connection) -> dict[str, str]:
    """The facts of a store. Raises InputError for a file that is not a store of this format."""
    there = {name for (name,) in store.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if "about" not in there:
        raise InputError(str(path), "is an SQLite file, but not a study's store", _ALLOWED)
    about = dict(store.execute("SELECT key, value FROM about"))
    if about.get("format") != FORMAT:
        raise InputError(str(path), f"is of the format {about.get('format')!r}", f"{FORMAT!r}",
                         "read it with the version of fesloop that wrote it")
    lacking = sorted(TABLE_NAMES - there)
    if lacking:
        raise InputError(str(path), f"is damaged: there is no table {', '.join(lacking)}", _ALLOWED)
    return about


_VERSIONS = """
SELECT text, count(id) FROM versions LEFT JOIN results USING (version) GROUP BY version ORDER BY version
"""
_WHEN = "SELECT min(finished), max(finished), count(DISTINCT worker) FROM results WHERE worker <> ''"


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """Origin of the results of a store.

    Attributes
    ----------
    versions: of fesloop, its code, libraries and machine, by name, each with the number of results it made.
    first, last: when the first and the last result was stored, UTC; empty where there is none.
    workers: number of processes that have run something.
    """

    versions: tuple[tuple[dict[str, str], int], ...]
    first: str
    last: str
    workers: int


def provenance_of(path: Path) -> Provenance:
    """The origin of a store's results. Raises InputError where its tables do not say."""
    with opened_to_read(path) as store:
        try:
            versions = tuple((dict(json.loads(text)), int(count)) for text, count in store.execute(_VERSIONS))
            first, last, workers = store.execute(_WHEN).fetchone()
        except (sqlite3.DatabaseError, TypeError, ValueError) as fault:
            raise InputError(str(path), f"does not say which versions made its results: {fault}") from None
    return Provenance(versions=versions, first=first or "", last=last or "", workers=int(workers))
