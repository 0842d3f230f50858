"""Writes a study's store, one SQLite file; only the coordinator of the study does.

The file keeps SQLite's rollback journal, not its write-ahead log: it is one file, other processes may read it
while it is written, and a coordinator that is killed within a transaction leaves it as it was before. Each
result is stored once or not at all: its row's key is the run's id.

    about(key, value)                               format, name, form, study (JSON), created
    cells(cell, levels, experiment, settings, document)     levels and settings JSON; document JSON, deflated
    runs(cell, replicate, seed, id)                 the plan; several cells may share a run
    results(id, status, cause, metrics, wall_s, worker, finished, version, recording)
    versions(version, text)                         `fesloop.analysis.study.store.versions`
    prepared(id, key, status, cause, content)       models of patients
    checksum(value)                                 of all rows, so that a changed one shows itself
"""

from __future__ import annotations

import json
import sqlite3
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, closing
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Self

from fesloop.analysis.study.design.plan import PlannedCell
from fesloop.analysis.study.design.study import Study
from fesloop.analysis.study.store.file import (
    FILE,
    FORMAT,
    TABLE_NAMES,
    TABLES,
    THEORY,
    checked_rows,
    keep_checksum,
    locked,
    named,
    opened,
    require_room,
    require_unchanged,
    transaction,
)
from fesloop.analysis.study.store.versions import differences, version_text
from fesloop.errors import InputError, RunError
from fesloop.experiment.files.overlay import key_text

_REMEDY = "give another --out, or move the file away"


def decisive(document: Mapping[str, Any]) -> dict[str, Any]:
    """The part of a study's document that decides its runs: all but figures, labels and descriptions."""
    def without(table: Mapping[str, Any], *keys: str) -> dict[str, Any]:
        return {key: value for key, value in table.items() if key not in keys}

    return without(document, "study", "axes", "figures") | {
        "study": without(document.get("study", {}), "description"),
        "axes": {name: without(axis, "label", "unit") for name, axis in document.get("axes", {}).items()}}


def _claimed(file: sqlite3.Connection, path: Path, study: Study, mix_versions: bool) -> int:
    """Create the tables of a new file, or compare an old one with the study; number of this version in it.

    Raises InputError for a file that is not a store, is damaged, of another study, or, unless versions may be
    mixed, started with other code or libraries.
    """
    tables = {name for (name,) in file.execute("SELECT name FROM sqlite_master")}
    if not tables or (tables >= TABLE_NAMES and _is_empty(file)):
        _create(file, path, study, tables)
    else:
        _require_same_study(file, path, study, tables)
        keep_checksum(file)
    version = _known_version(file, path, mix_versions)
    _update_document(file, path, study)
    return version


def _is_empty(file: sqlite3.Connection) -> bool:
    """Whether a store has neither results nor prepared models, so that any study may take it over."""
    return not any(file.execute(f"SELECT 1 FROM {name} LIMIT 1").fetchone()
                   for name in ("results", "prepared"))


def _create(file: sqlite3.Connection, path: Path, study: Study, old: set[str]) -> None:
    about = {"format": FORMAT, "name": study.name, "form": study.form, "study": json.dumps(study.document),
             "created": datetime.now(UTC).isoformat(timespec="seconds")}
    with transaction(file, path):
        for name in sorted(old & TABLE_NAMES):
            file.execute(f"DROP TABLE {name}")
        for statement in TABLES.split(";")[:-1]:
            file.execute(statement)
        file.execute("INSERT INTO checksum VALUES('0')")
        keep_checksum(file)
        file.executemany("INSERT INTO about VALUES(?, ?)", about.items())


def _require_same_study(file: sqlite3.Connection, path: Path, study: Study, tables: set[str]) -> None:
    about = dict(file.execute("SELECT key, value FROM about")) if "about" in tables else {}
    if about.get("format") != FORMAT:
        raise InputError(str(path), f"is {about.get('format', 'not a study of fesloop')!r}", FORMAT, _REMEDY)
    require_unchanged(file, path, checked_rows(file))
    there, here = (decisive(document) for document in (json.loads(about["study"]), _plain(study)))
    if there != here:
        raise InputError(str(path), f"was made by another study: {_first_difference(there, here)}",
                         "the study that made it", _REMEDY)


def _plain(study: Study) -> dict[str, Any]:
    """The study's document with lists in place of tuples, as a store has it."""
    return dict(json.loads(json.dumps(study.document)))


def _update_document(file: sqlite3.Connection, path: Path, study: Study) -> None:
    """Store figures, labels and descriptions as they are now; theory computed for others is deleted."""
    (there,) = file.execute("SELECT value FROM about WHERE key = 'study'").fetchone()
    if json.loads(there) != _plain(study):
        (path.parent / THEORY).unlink(missing_ok=True)
        with transaction(file, path):
            file.execute("UPDATE about SET value = ? WHERE key = 'study'", (json.dumps(study.document),))


def _known_version(file: sqlite3.Connection, path: Path, mix_versions: bool) -> int:
    here = version_text()
    there = [text for (text,) in file.execute("SELECT text FROM versions ORDER BY version")]
    if there and here not in there and not mix_versions:
        raise InputError(str(path), f"was made by another version: {differences(there[-1], here)}",
                         "the version that made it",
                         "give another --out, or --mix-versions to continue regardless")
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

    def shown(value: Any) -> str:
        text = json.dumps(value)
        return text if len(text) <= 60 else text[:57] + "..."

    return f"{path} is {shown(there)} there, {shown(here)} here"


_PUT = """
INSERT INTO results VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT(id) DO UPDATE SET status = excluded.status,
    cause = excluded.cause, metrics = excluded.metrics, wall_s = excluded.wall_s, worker = excluded.worker,
    finished = excluded.finished, version = excluded.version, recording = excluded.recording
    WHERE results.status = 'failed'
"""
_PENDING = """
SELECT cell, replicate, seed, id FROM runs AS this WHERE (cell, replicate) > (?, ?)
    AND NOT EXISTS (SELECT 1 FROM results WHERE results.id = this.id AND NOT (? AND status = 'failed'))
    AND EXISTS (SELECT 1 FROM cells WHERE cells.cell = this.cell AND length(document) > 0)
    AND NOT EXISTS (SELECT 1 FROM runs AS other WHERE other.id = this.id
                    AND (other.cell, other.replicate) < (this.cell, this.replicate))
    ORDER BY cell, replicate LIMIT 1000
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredResult:
    """The stored outcome of a run.

    Attributes
    ----------
    id: of the run.
    status: done or failed. cause: of the failure, one line.
    metrics: numbers, None where the run has none.
    wall_s: duration. worker: host and process. recording: path, "" where it was not kept.
    """

    id: str
    status: str
    cause: str
    metrics: dict[str, float | None]
    wall_s: float
    worker: str
    recording: str = ""


class PendingRun(NamedTuple):
    """A planned run that has no result yet."""

    cell: int
    seed: int
    id: str


class Store:
    """The store of one study, open for its coordinator.

    Parameters
    ----------
    folder: created where it does not exist.
    study: the study whose results are stored.
    mix_versions: accept a file that was started with other code or libraries.

    Raises InputError for a folder that cannot be written to, a file that is not a store, is damaged, of
    another study or version, or in use by another coordinator.
    """

    def __init__(self, folder: Path, study: Study, *, mix_versions: bool = False) -> None:
        self.path = folder / FILE
        require_room(folder)
        with ExitStack() as taken:
            self._lock = taken.enter_context(closing(locked(folder)))
            with named(self.path):
                self._file = taken.enter_context(closing(opened(self.path)))
                self._version = _claimed(self._file, self.path, study, mix_versions)
            taken.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()
        if isinstance(fault, sqlite3.Error):  # of a plain read; transactions raise RunError
            raise RunError(f"{self.path}: cannot be read any more: {fault}; repair the disk, or move the "
                           "file away") from None

    def close(self) -> None:
        """Close the file and release its lock."""
        self._file.close()
        self._lock.close()

    @property
    def planned(self) -> int:
        """Number of cells of the stored plan."""
        return int(self._file.execute("SELECT count(*) FROM cells").fetchone()[0])

    def put_plan(self, cells: Iterable[PlannedCell]) -> float:
        """Store every cell and run, or compare them with the stored plan; the simulated seconds of all runs.

        Raises InputError where the stored plan differs, as when the base experiment has changed.
        """
        planned, simulated_s = self.planned, 0.0
        with named(self.path), self._transaction():
            for each in cells:
                self._compare(each) if planned else self._add(each)
                simulated_s += each.simulated_s * len(each.runs)
        return simulated_s

    def _add(self, each: PlannedCell) -> None:
        cell = each.cell
        self._file.execute("INSERT INTO cells VALUES(?, ?, ?, ?, ?)", (
            cell.number, json.dumps(cell.levels), cell.experiment, json.dumps(cell.settings),
            zlib.compress(each.document.encode()) if each.document else b""))
        self._file.executemany("INSERT INTO runs VALUES(?, ?, ?, ?)",
                               ((run.cell, run.replicate, run.seed, run.id) for run in each.runs))
        if each.cause:
            self._put([StoredResult(id=run.id, status="failed", cause=each.cause, metrics={}, wall_s=0.0,
                                    worker="") for run in each.runs])

    def _compare(self, each: PlannedCell) -> None:
        found = self._file.execute("SELECT id FROM runs WHERE cell = ? ORDER BY replicate",
                                   (each.cell.number,)).fetchall()
        if [id for (id,) in found] == [run.id for run in each.runs]:
            return
        if then := self.document(each.cell.number):
            what = _difference(json.loads(zlib.decompress(then)), json.loads(each.document or "{}"))
            raise InputError(str(self.path), f"was made when {each.cell.experiment} was another experiment "
                             f"(seen at {each.cell.place}{what})", "the same experiments as then",
                             "give another --out, or move the file away")
        # Its preparation failed then and has succeeded now.
        self._file.executemany("DELETE FROM results WHERE id = ?", found)
        for table in ("cells", "runs"):
            self._file.execute(f"DELETE FROM {table} WHERE cell = ?", (each.cell.number,))
        self._add(each)

    def pending(self, *, retry_failed: bool = False) -> Iterator[PendingRun]:
        """Every run without a result, cell by cell; failed ones too with `retry_failed`.

        Runs whose preparation failed are left out. A run that several cells share comes once, with the first
        of them. Runs are read in pages, so that results may be stored meanwhile.
        """
        last = -1, -1
        while page := self._file.execute(_PENDING, (*last, retry_failed)).fetchall():
            yield from (PendingRun(cell, seed, id) for cell, _, seed, id in page)
            cell, replicate, *_ = page[-1]
            last = cell, replicate

    def first_runs(self) -> dict[str, PendingRun]:
        """The first planned run of each experiment, by its name or path."""
        rows = self._file.execute(
            "SELECT experiment, min(cell), seed, id FROM cells JOIN runs USING (cell) WHERE replicate = 0 "
            "GROUP BY experiment")
        return {experiment: PendingRun(cell, seed, id) for experiment, cell, seed, id in rows}

    def document(self, cell: int) -> bytes:
        """JSON of a cell's experiment, deflated; empty where its preparation failed."""
        row = self._file.execute("SELECT document FROM cells WHERE cell = ?", (cell,)).fetchone()
        return bytes(row[0])

    def put(self, results: Sequence[StoredResult]) -> None:
        """Store results, all or none; only failed results are replaced.

        Raises RunError where the disk is full or cannot be written to; earlier results are kept.
        """
        with self._transaction():
            self._put(results)

    def _put(self, results: Sequence[StoredResult]) -> None:
        finished = datetime.now(UTC).isoformat(timespec="seconds")
        self._file.executemany(_PUT, [
            (each.id, each.status, each.cause, json.dumps(each.metrics), each.wall_s, each.worker, finished,
             self._version, each.recording) for each in results])

    def prepared(self) -> dict[str, tuple[str, str, str]]:
        """Status, cause and content of each preparation, by id."""
        return {id: (status, cause, content) for id, status, cause, content in self._file.execute(
            "SELECT id, status, cause, content FROM prepared")}

    def put_prepared(self, id: str, key: str, status: str, cause: str, content: str) -> None:
        """Store a prepared model, or the cause of its failure."""
        with self._transaction():
            self._file.execute("INSERT OR REPLACE INTO prepared VALUES(?, ?, ?, ?, ?)",
                               (id, key, status, cause, content))

    @property
    def started(self) -> bool:
        """Whether the store has results or prepared models."""
        return not _is_empty(self._file)

    def distinct_runs(self) -> int:
        """Number of planned runs, those that several cells share counted once."""
        return int(self._file.execute("SELECT count(DISTINCT id) FROM runs").fetchone()[0])

    def counts(self) -> tuple[int, dict[str, int]]:
        """Number of distinct runs that are done, and of failed ones by cause."""
        done = self._file.execute("SELECT count(*) FROM results WHERE status = 'done'").fetchone()[0]
        causes = self._file.execute("SELECT cause, count(*) FROM results WHERE status = 'failed' "
                                    "GROUP BY cause ORDER BY count(*) DESC").fetchall()
        return done, dict(causes)

    def not_prepared(self) -> dict[str, int]:
        """Number of runs whose preparation failed, by cause."""
        return dict(self._file.execute(
            "SELECT cause, count(*) FROM results WHERE id IN (SELECT id FROM runs JOIN cells USING (cell) "
            "WHERE length(document) = 0) GROUP BY cause"))

    def _transaction(self) -> AbstractContextManager[None]:
        return transaction(self._file, self.path)


def _difference(then: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """The difference between two experiments' tables, for a message: the patient's file, or the first key.

    A patient's key `drawn` has the parameters read from the file; its other keys choose file and member.
    """
    paths = list(_differing(then, now, ()))
    of_patient = [path for path in paths if path[0] == "patient"]
    if of_patient and all(path[1:2] == ("drawn",) for path in of_patient):
        return f"; what has changed is the patient file {now['patient'].get('file')!r}"
    changed = [path[1] for path in paths if path[0] == "code" and len(path) == 2]
    if changed:
        return f"; what has changed is the class of the kind {changed[0]!r}"
    path = next(iter(of_patient or paths), ())
    return f"; the first key that has changed is {key_text(path)}" if path else ""


def _differing(then: Any, now: Any, path: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """Paths of the keys that differ; the seed is a run's own."""
    if isinstance(then, dict) and isinstance(now, dict):
        for key in dict.fromkeys([*then, *now]):
            if (*path, key) != ("experiment", "seed"):
                yield from _differing(then.get(key), now.get(key), (*path, key))
    elif then != now:
        yield path
