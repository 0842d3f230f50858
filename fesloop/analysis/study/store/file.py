"""The file of a store: its tables, how it is opened, the lock beside it, and what SQLite says."""

from __future__ import annotations

import errno
import os
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile

from fesloop.errors import InputError, RunError

FORMAT = "fesloop study 1"
FILE = "study.sqlite"
THEORY = "theory.json"
"""Beside the store: what `fesloop.show.figures.theory_overlays` keeps."""
ROOM_BYTES = 2**24
"""What must be free on the disk before a study starts (chosen: as for a recording)."""
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
CREATE INDEX runs_by_id ON runs(id);
"""
TABLE_NAMES = {"about", "cells", "runs", "results", "versions", "prepared"}


def require_room(folder: Path) -> None:
    """Make a folder; InputError where that cannot be, it cannot be written to, or has no room for a study."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        free = shutil.disk_usage(folder).free
        # SQLite opens, and even locks, what it cannot write to, and says so at its first commit only.
        with TemporaryFile(dir=folder):
            pass
        if (folder / FILE).exists() and not os.access(folder / FILE, os.W_OK):
            raise PermissionError(errno.EACCES, f"{FILE} in it may only be read")
    except OSError as fault:
        full = fault.errno == errno.ENOSPC
        raise unusable(folder, "the disk is full" if full else
                       f"cannot be written to: {fault.strerror}") from None
    if free < ROOM_BYTES:
        raise unusable(folder, f"the disk is full, {free / 1e6:.0f} MB are left")


def opened(path: Path) -> sqlite3.Connection:
    """The file of a store, in which nothing is written but by explicit transactions."""
    try:
        file = sqlite3.connect(path, timeout=_BUSY_S, isolation_level=None, check_same_thread=False)
        file.execute("PRAGMA synchronous = FULL")
    except sqlite3.OperationalError as fault:
        raise unusable(path.parent, why(fault)) from None
    return file


def locked(folder: Path) -> sqlite3.Connection:
    """A lock that ends with this process, however it ends: a transaction on a file beside the store."""
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
    """What is wrong with a folder."""
    return InputError(f"--out {folder}", found,
                      f"a folder that can be written to, with {ROOM_BYTES / 1e6:.0f} MB free",
                      "make room, or give another folder")


def why(fault: sqlite3.Error) -> str:
    """SQLite's words, with those for a full disk as a user knows them."""
    text = str(fault)
    return "the disk is full" if "full" in text else f"cannot be written ({text})"


@contextmanager
def transaction(file: sqlite3.Connection, path: Path) -> Iterator[None]:
    """All or nothing, and on the disk when it is over. Raises RunError where that cannot be."""
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
        raise RunError(f"{path}: {why(fault)}; what stood in it before is kept; make room or mend the disk, "
                       "and start the study again") from None


@contextmanager
def named(path: Path) -> Iterator[None]:
    """What SQLite says of a file that is none of its own, as an error of the user's."""
    try:
        yield
    except sqlite3.DatabaseError as fault:
        raise InputError(str(path), f"is damaged, or no study of fesloop: {fault}", FORMAT,
                         "give another --out, or move the file away") from None
