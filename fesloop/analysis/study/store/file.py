"""The SQLite file of a study's results: tables, checksum, lock, and messages for SQLite's errors."""

from __future__ import annotations

import errno
import os
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import blake2b
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

from fesloop.errors import InputError, RunError

FORMAT = "fesloop study 2"
FILE = "study.sqlite"
THEORY = "theory.json"
"""File beside the store with the lines that `fesloop.show.figures.theory_overlays` has computed."""
ROOM_BYTES = 2**24
"""Free disk space that a study needs to start (chosen: as for a recording)."""
_BUSY_S = 10.0
TABLES = """
CREATE TABLE about(key TEXT PRIMARY KEY, value TEXT) WITHOUT ROWID;
CREATE TABLE cells(cell INTEGER PRIMARY KEY, levels TEXT, experiment TEXT, settings TEXT, document BLOB);
CREATE TABLE runs(cell INTEGER, replicate INTEGER, seed INTEGER, id TEXT, PRIMARY KEY(cell, replicate))
    WITHOUT ROWID;
CREATE TABLE results(id TEXT PRIMARY KEY, status TEXT, cause TEXT, metrics TEXT, wall_s REAL, worker TEXT,
    finished TEXT, version INTEGER, recording TEXT) WITHOUT ROWID;
CREATE TABLE versions(version INTEGER PRIMARY KEY, text TEXT UNIQUE);
CREATE TABLE prepared(id TEXT PRIMARY KEY, key TEXT, status TEXT, cause TEXT, content TEXT) WITHOUT ROWID;
CREATE TABLE checksum(value TEXT);
CREATE INDEX runs_by_id ON runs(id);
"""
CHECKED = {
    "about": ("key", "value"),
    "cells": ("cell", "levels", "experiment", "settings"),
    "runs": ("cell", "replicate", "seed", "id"),
    "results": ("id", "status", "cause", "metrics", "wall_s", "worker", "finished", "version", "recording"),
    "versions": ("version", "text"),
    "prepared": ("id", "key", "status", "cause", "content"),
}
"""Columns that the checksum covers, by table. (A deflated document carries a checksum of its own.)"""
TABLE_NAMES = {*CHECKED, "checksum"}
_HASH_BYTES = 8


def row_hash(table: str, row: tuple[Any, ...]) -> int:
    """Hash of one row of a table."""
    return int.from_bytes(blake2b(repr((table, *row)).encode(), digest_size=_HASH_BYTES).digest(), "big")


def checksum(rows: dict[str, list[tuple[Any, ...]]]) -> str:
    """Checksum of the rows of all tables: the sum of their hashes, so that their order does not matter."""
    return _text(sum(row_hash(table, row) for table, several in rows.items() for row in several))


def checked_rows(file: sqlite3.Connection) -> dict[str, list[tuple[Any, ...]]]:
    """All rows that the checksum covers, by table."""
    return {table: file.execute(f"SELECT {', '.join(columns)} FROM {table}").fetchall()
            for table, columns in CHECKED.items()}


def require_unchanged(file: sqlite3.Connection, path: Path, rows: dict[str, list[tuple[Any, ...]]]) -> None:
    """Raise InputError where the rows of a store are not those that fesloop wrote."""
    if file.execute("SELECT value FROM checksum").fetchall() != [(checksum(rows),)]:
        raise InputError(str(path), "is damaged: its rows are not those that fesloop wrote; at least one was "
                         "changed, lost or added", "", "restore a copy, or move the file away and run the "
                         "study again")


def keep_checksum(file: sqlite3.Connection) -> None:
    """Have SQLite update the checksum in the transaction of every change that this connection makes."""
    def changed(total: str, sign: int, table: str, *row: Any) -> str:
        return _text(int(total, 16) + sign * row_hash(table, row))

    file.execute("PRAGMA recursive_triggers = ON")  # without it REPLACE deletes a row and fires no trigger
    file.create_function("changed", -1, changed)
    events = {"INSERT": {"NEW": 1}, "DELETE": {"OLD": -1}, "UPDATE": {"OLD": -1, "NEW": 1}}
    for table, columns in CHECKED.items():
        for event, signs in events.items():
            updates = " ".join(
                f"UPDATE checksum SET value = changed(value, {sign}, '{table}', "
                f"{', '.join(f'{row}.{column}' for column in columns)});" for row, sign in signs.items())
            file.execute(f"CREATE TEMP TRIGGER {table}_{event} AFTER {event} ON main.{table} "
                         f"BEGIN {updates} END")


def _text(total: int) -> str:
    return f"{total % 2 ** (8 * _HASH_BYTES):0{2 * _HASH_BYTES}x}"


def require_room(folder: Path) -> None:
    """Create a folder. Raises InputError where it cannot be created or written to, or the disk is full."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        free = shutil.disk_usage(folder).free
        # SQLite opens and locks a file that it cannot write to, and reports that at the first commit only.
        with TemporaryFile(dir=folder):
            pass
        if (folder / FILE).exists() and not os.access(folder / FILE, os.W_OK):
            raise PermissionError(errno.EACCES, f"{FILE} in it is read-only")
    except OSError as fault:
        full = fault.errno == errno.ENOSPC
        raise unusable(folder, "the disk is full" if full else
                       f"cannot be written to: {fault.strerror}") from None
    if free < ROOM_BYTES:
        raise unusable(folder, f"the disk is full, {free / 1e6:.0f} MB are left")


def opened(path: Path) -> sqlite3.Connection:
    """Open a store for writing; nothing is written outside explicit transactions."""
    file = None
    try:
        file = sqlite3.connect(path, timeout=_BUSY_S, isolation_level=None, check_same_thread=False)
        file.execute("PRAGMA synchronous = FULL")
    except sqlite3.DatabaseError as fault:
        if file is not None:
            file.close()
        if isinstance(fault, sqlite3.OperationalError):
            raise unusable(path.parent, why(fault)) from None
        raise
    return file


def locked(folder: Path) -> sqlite3.Connection:
    """Lock a study's folder by a transaction on a file beside the store; it ends with this process."""
    lock = None
    try:
        lock = sqlite3.connect(folder / f".{FILE}.lock", timeout=0.0, isolation_level=None,
                               check_same_thread=False)
        lock.execute("BEGIN EXCLUSIVE")
    except sqlite3.DatabaseError as fault:
        if lock is not None:
            lock.close()
        if "locked" in str(fault):
            raise InputError(str(folder), "another fesloop study is writing there", "one at a time",
                             "wait for it, or give another --out") from None
        raise unusable(folder, f"cannot be written to: {why(fault)}") from None
    return lock


def unusable(folder: Path, found: str) -> InputError:
    """The error for a folder that cannot take results."""
    return InputError(f"--out {folder}", found,
                      f"a folder that can be written to, with {ROOM_BYTES / 1e6:.0f} MB free",
                      "make room, or give another folder")


def why(fault: sqlite3.Error) -> str:
    """SQLite's message; a full disk is named as such."""
    text = str(fault)
    return "the disk is full" if "full" in text else f"cannot be written ({text})"


@contextmanager
def transaction(file: sqlite3.Connection, path: Path) -> Iterator[None]:
    """Write all changes of the context to the disk, or none. Raises RunError where SQLite fails."""
    try:
        file.execute("BEGIN IMMEDIATE")
        try:
            yield
            file.execute("COMMIT")
        except BaseException:
            if file.in_transaction:
                file.execute("ROLLBACK")
            raise
    except sqlite3.Error as fault:
        raise RunError(f"{path}: {why(fault)}; earlier results are kept; make room or repair the disk, "
                       "and start the study again") from None


@contextmanager
def named(path: Path) -> Iterator[None]:
    """Turn SQLite's error for a file that is not a store into an InputError."""
    try:
        yield
    except sqlite3.DatabaseError as fault:
        raise InputError(str(path), f"is damaged, or not a study of fesloop: {fault}", FORMAT,
                         "give another --out, or move the file away") from None
