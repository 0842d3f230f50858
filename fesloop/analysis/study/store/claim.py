"""Whether a store's file is that of a study: new, or begun by the same study in the same version."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from fesloop.analysis.study.design.study import Study
from fesloop.analysis.study.store.file import FORMAT, TABLE_NAMES, TABLES, THEORY, transaction
from fesloop.analysis.study.store.versions import differences, version_text
from fesloop.errors import InputError

_REMEDY = "give another --out, or move the file away"


def claim(file: sqlite3.Connection, path: Path, study: Study, mix_versions: bool) -> int:
    """Make the tables of a new file, or hold an old one against the study; the number of this version in it.

    Raises InputError for a file that is none of fesloop's, of another study, or, unless versions may be
    mixed, begun with other code or libraries.
    """
    tables = {name for (name,) in file.execute("SELECT name FROM sqlite_master")}
    if not tables or (tables >= TABLE_NAMES and is_empty(file)):
        _make(file, path, study, tables)
    else:
        _hold_against(file, path, study, tables)
    version = _known_version(file, path, mix_versions)
    _take_words(file, path, study)
    return version


def decisive(document: Mapping[str, Any]) -> dict[str, Any]:
    """What of a study's document decides on its runs: not figures, nor what is said to people."""
    tables = {key: table for key, table in document.items() if key not in ("study", "axes", "figures")}
    return tables | {
        "study": _but(document.get("study", {}), "description"),
        "axes": {name: _but(axis, "label", "unit") for name, axis in document.get("axes", {}).items()}}


def _but(table: Mapping[str, Any], *keys: str) -> dict[str, Any]:
    return {key: value for key, value in table.items() if key not in keys}


def is_empty(file: sqlite3.Connection) -> bool:
    """Whether nothing has come of a study yet: its file is any study's then."""
    return not any(file.execute(f"SELECT 1 FROM {name} LIMIT 1").fetchone()
                   for name in ("results", "prepared"))


def _make(file: sqlite3.Connection, path: Path, study: Study, old: set[str]) -> None:
    about = {"format": FORMAT, "name": study.name, "form": study.form, "study": _document(study),
             "created": datetime.now(UTC).isoformat(timespec="seconds")}
    with transaction(file, path):
        for name in sorted(old & TABLE_NAMES):
            file.execute(f"DROP TABLE {name}")
        for statement in TABLES.split(";")[:-1]:
            file.execute(statement)
        file.executemany("INSERT INTO about VALUES(?, ?)", about.items())


def _hold_against(file: sqlite3.Connection, path: Path, study: Study, tables: set[str]) -> None:
    about = dict(file.execute("SELECT key, value FROM about")) if "about" in tables else {}
    if about.get("format") != FORMAT:
        raise InputError(str(path), f"is {about.get('format', 'no study of fesloop')!r}", FORMAT, _REMEDY)
    there, here = (decisive(json.loads(text)) for text in (about["study"], _document(study)))
    if there != here:
        raise InputError(str(path), f"was made by another study: {_first_difference(there, here)}",
                         "the study that made it", _REMEDY)


def _take_words(file: sqlite3.Connection, path: Path, study: Study) -> None:
    """Note figures, and what is said to people, as they are now; theory that was kept for others goes."""
    (there,) = file.execute("SELECT value FROM about WHERE key = 'study'").fetchone()
    if json.loads(there) != json.loads(_document(study)):
        (path.parent / THEORY).unlink(missing_ok=True)
        with transaction(file, path):
            file.execute("UPDATE about SET value = ? WHERE key = 'study'", (_document(study),))


def _document(study: Study) -> str:
    return json.dumps(study.document)


def _known_version(file: sqlite3.Connection, path: Path, mix_versions: bool) -> int:
    here = version_text()
    there = [text for (text,) in file.execute("SELECT text FROM versions ORDER BY version")]
    if there and here not in there and not mix_versions:
        raise InputError(str(path), f"was made by another version: {differences(there[-1], here)}",
                         "the version that made it",
                         "give another --out, or --mix-versions to go on regardless")
    if here not in there:
        with transaction(file, path):
            file.execute("INSERT INTO versions VALUES(?, ?)", (len(there), here))
        return len(there)
    return there.index(here)


def _first_difference(there: Any, here: Any, path: str = "") -> str:
    """The first key in which two study documents differ, and both values."""
    if isinstance(there, dict) and isinstance(here, dict):
        for key in {**there, **here}:
            if there.get(key) != here.get(key):
                return _first_difference(there.get(key), here.get(key), f"{path}.{key}" if path else str(key))
    return f"{path} is {_shown(there)} there, {_shown(here)} here"


def _shown(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else text[:57] + "..."
