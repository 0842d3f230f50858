"""Reading a study's store: one SQLite file, also while its coordinator writes, or after that was killed."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from fesloop.analysis.study.store.file import FILE, FORMAT
from fesloop.errors import InputError
from fesloop.given_files import is_file, is_folder

_BUSY_S = 30.0
"""Chosen: a coordinator holds its lock for the milliseconds of one commit, longer on a slow shared disk."""
TABLES = {
    "cells": "SELECT cell, levels FROM cells ORDER BY cell",
    "runs": "SELECT cell, replicate, seed, id FROM runs ORDER BY cell, replicate",
    "results": "SELECT id, status, cause, metrics, wall_s, recording FROM results",
}


@dataclass(frozen=True, slots=True, eq=False)
class StoreRows:
    """What stands in a store, as it stands there, at one instant.

    Attributes
    ----------
    about: its facts by key: format, name, form, study, created.
    cells: (cell, levels). runs: (cell, replicate, seed, id), of every planned run in order of cell and
        replicate. results: (id, status, cause, metrics, wall_s, recording).
    """

    about: dict[str, str]
    cells: list[tuple[Any, ...]]
    runs: list[tuple[Any, ...]]
    results: list[tuple[Any, ...]]


def store_path(path: str | Path) -> Path:
    """The store itself, of a store or of the folder that holds one; InputError where there is none."""
    given = Path(path)
    found = given / FILE if is_folder(given) else given
    if not is_file(found):
        what = f"holds no {FILE}" if is_folder(given) else "does not exist"
        raise InputError(str(given), what, "a study's store, or the folder that holds it")
    return found


def read_store(path: Path) -> StoreRows:
    """Every planned run and what came of those that are over.

    A store whose coordinator was killed within a commit has to be rolled back before it can be read; that
    takes the right to write. Raises InputError for what is no study's store, is damaged, of another version,
    locked for good, or cannot be rolled back.
    """
    try:
        return _read(path, "ro")
    except UnicodeDecodeError as fault:  # of a column's name, or within SQLite's message on one
        raise InputError(str(path), f"is damaged: {fault}", "a study's store, as `fesloop study` writes it"
                         ) from None
    except sqlite3.OperationalError as fault:
        if not _needs_rollback(path, fault):
            raise _refusal(path, fault) from None
    except sqlite3.DatabaseError as fault:
        raise _refusal(path, fault) from None
    try:
        return _read(path, "rw")
    except sqlite3.DatabaseError as fault:
        raise InputError(str(path), f"its writer was killed within a commit, which cannot be undone: {fault}",
                         "a folder that can be written",
                         f"copy it together with {path.name}-journal to where you may write") from None


def _needs_rollback(path: Path, fault: sqlite3.OperationalError) -> bool:
    """Whether a killed writer's journal is in the way, which only one who may write can play back."""
    codes = (sqlite3.SQLITE_READONLY, sqlite3.SQLITE_CANTOPEN)
    return _code(fault) in codes and Path(f"{path}-journal").exists()


def _code(fault: sqlite3.Error) -> int:
    """SQLite's own; 0 where Python is at fault with what it read, as of text that is no UTF-8."""
    return getattr(fault, "sqlite_errorcode", 0) & 0xFF


def _refusal(path: Path, fault: sqlite3.DatabaseError) -> InputError:
    code = _code(fault)
    if code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
        return InputError(str(path), f"stayed locked for {_BUSY_S:.0f} s", "",
                          "another process writes to it without end: try again when that is over")
    if code in (sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_PERM, sqlite3.SQLITE_AUTH):
        return InputError(str(path), f"cannot be opened: {fault}", "a file that you may read")
    if code == sqlite3.SQLITE_NOTADB:
        return InputError(str(path), "is no SQLite file", "a study's store, as `fesloop study` writes it")
    return InputError(str(path), f"is damaged: {fault}", "a study's store, as `fesloop study` writes it")


def _read(path: Path, mode: str) -> StoreRows:
    address = f"file:{quote(str(path.resolve()))}?mode={mode}"
    with closing(sqlite3.connect(address, uri=True, timeout=_BUSY_S, isolation_level=None)) as store:
        # One transaction, so that all tables are of one instant, whatever is written meanwhile.
        store.execute("BEGIN")
        about = _about(path, store)
        found = {name: store.execute(query).fetchall() for name, query in TABLES.items()}
        store.execute("COMMIT")
    return StoreRows(about, found["cells"], found["runs"], found["results"])


def _about(path: Path, store: sqlite3.Connection) -> dict[str, str]:
    """Facts about the store, once it is sure that it is one of ours and of this version."""
    there = {name for (name,) in store.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if "about" not in there:
        raise InputError(str(path), "is an SQLite file, but no study's store",
                         "a study's store, as `fesloop study` writes it")
    about = dict(store.execute("SELECT key, value FROM about"))
    if about.get("format") != FORMAT:
        raise InputError(str(path), f"is of the format {about.get('format')!r}", f"{FORMAT!r}",
                         "read it with the version of fesloop that wrote it")
    lacking = sorted(TABLES.keys() - there)
    if lacking:
        raise InputError(str(path), f"is damaged: there is no table {', '.join(lacking)}",
                         "a study's store, as `fesloop study` writes it")
    return about
