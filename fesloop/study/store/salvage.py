"""What can be read of a store that is damaged, or that another version wrote."""

from __future__ import annotations

import json
import sqlite3
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fesloop.errors import InputError
from fesloop.study.store.file import FORMAT
from fesloop.study.store.provenance import opened_to_read
from fesloop.study.store.reading import TABLES, StoreRows

Rows = list[tuple[Any, ...]]
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
    """Every row of a damaged store that can be read, up to the first of its table that cannot.

    Of another version's store only what it says about itself is read. Raises InputError for a file that does
    not even say that it is a study's.
    """
    lost: list[str] = []
    with opened_to_read(path) as store:
        about = _about(path, store)
        if about["format"] != FORMAT:
            lost.append(f"It is of the format {about['format']!r}, and this fesloop reads {FORMAT!r}: its "
                        "results are not shown. Read it with the version of fesloop that wrote it.")
            return Salvage(StoreRows(about, [], [], []), lost)
        found = {name: _readable(store, name, query, lost) for name, query in TABLES.items()}
    return Salvage(StoreRows(about, *_joined(found, lost)), lost)


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
        lost.append(f"Of its table `{name}` only {len(found)} rows can be read ({fault}).")
    return found


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
