"""What can be read of a store that is damaged, or that another version wrote."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fesloop.analysis.study.store.file import FORMAT
from fesloop.analysis.study.store.reading import TABLES, StoreRows
from fesloop.errors import InputError

Rows = list[tuple[Any, ...]]
_MAGIC = b"SQLite format 3\0"
_MOST_FILLED = 2**30
"""Bytes of a missing end that are made up for (chosen: more than any study has)."""
_ONE = "SELECT id, status, cause, metrics, wall_s, recording FROM results WHERE id = ?"
_ALLOWED = "a study's store, as `fesloop study` writes it"


@dataclass(frozen=True, slots=True, eq=False)
class Salvage:
    """What could be read of a store.

    Attributes
    ----------
    rows: as of a whole store; its tables are shorter, or empty, and hang together.
    lost: what could not be read, a sentence each.
    """

    rows: StoreRows
    lost: list[str]


def salvaged(path: Path) -> Salvage:
    """Every row of a damaged store up to the first of its table that cannot be read; of results all that can.

    Of another version's store only what it says about itself is read. Raises InputError for a file that does
    not even say that it is a study's.
    """
    lost: list[str] = []
    with closing(_in_memory(path, lost)) as store:
        about = _about(path, store)
        if about["format"] != FORMAT:
            lost.append(f"It is of the format {about['format']!r}, and this fesloop reads {FORMAT!r}: its "
                        "results are not shown. Read it with the version of fesloop that wrote it.")
            return Salvage(StoreRows(about, [], [], []), lost)
        found = {name: _readable(store, name, query, lost) for name, query in TABLES.items()}
        found["results"] += _others(store, found)
    return Salvage(StoreRows(about, *_joined(found, lost)), lost)


def _in_memory(path: Path, lost: list[str]) -> sqlite3.Connection:
    """A copy of a store, its missing end filled with nothing: SQLite opens no file that was cut short."""
    try:
        content = path.read_bytes()
    except OSError as fault:
        raise InputError(str(path), f"cannot be read: {fault.strerror}", "a file that you may read") from None
    if not content.startswith(_MAGIC):
        raise InputError(str(path), "is no SQLite file", _ALLOWED)
    page = int.from_bytes(content[16:18]) or 1
    told = (65536 if page == 1 else page) * int.from_bytes(content[28:32])
    lacking = told - len(content)
    if 0 < lacking <= _MOST_FILLED:
        lost.append(f"It was cut short: {lacking} of its {told} bytes are missing.")
        content += bytes(lacking)
    store = sqlite3.connect(":memory:", isolation_level=None)
    store.deserialize(content)
    store.text_factory = lambda text: text.decode("utf-8", errors="replace")
    return store


def _about(path: Path, store: sqlite3.Connection) -> dict[str, str]:
    """What a store says about itself."""
    try:
        about = {str(key): str(value) for key, value in store.execute("SELECT key, value FROM about")}
    except sqlite3.DatabaseError as fault:
        raise InputError(str(path), f"is no study's store, or damaged from its start on: {fault}",
                         _ALLOWED) from None
    if not about.get("format", "").startswith("fesloop study"):
        raise InputError(str(path), "does not say that it is a study's store", _ALLOWED)
    return about


def _readable(store: sqlite3.Connection, name: str, query: str, lost: list[str]) -> Rows:
    """Rows of a table until one cannot be read; `lost` is told."""
    found: Rows = []
    try:
        # In the order in which they lie in the file: to sort them would be to read all of them first.
        for row in store.execute(query.partition(" ORDER BY")[0]):
            found.append(row)
    except sqlite3.DatabaseError as fault:
        lost.append(f"Its table `{name}` cannot be read beyond row {len(found)} ({fault}); runs whose "
                    "results are lost count as not over yet.")
    return found


def _others(store: sqlite3.Connection, found: dict[str, Rows]) -> Rows:
    """Results beyond the first that cannot be read, each by its run."""
    known = {row[0] for row in found["results"]}
    others: Rows = []
    for id_ in dict.fromkeys(row[3] for row in found["runs"] if row[3] not in known):
        with suppress(sqlite3.DatabaseError):
            others += store.execute(_ONE, (id_,)).fetchall()
    return others


def _joined(found: dict[str, Rows], lost: list[str]) -> tuple[Rows, Rows, Rows]:
    """Cells, runs and results that belong together; `lost` is told of what does not."""
    cells = sorted(row for row in found["cells"] if isinstance(row[0], int) and _is_json(row[1]))
    known = {cell for cell, _ in cells}
    runs = sorted(row for row in found["runs"] if row[0] in known)
    results = [row for row in found["results"]
               if row[1] in ("done", "failed") and (not row[3] or _is_json(row[3]))]
    for name, kept in (("cells", cells), ("runs", runs), ("results", results)):
        if len(kept) < len(found[name]):
            lost.append(f"{len(found[name]) - len(kept)} rows of its table `{name}` do not fit the others "
                        "and are left out.")
    return cells, runs, results


def _is_json(text: Any) -> bool:
    """Whether it is the text of a table in JSON."""
    try:
        return isinstance(json.loads(text), dict)
    except (TypeError, ValueError):
        return False
