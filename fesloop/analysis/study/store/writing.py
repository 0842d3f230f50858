"""Results on disk: one SQLite file, written by the coordinator alone.

It keeps a rollback journal, not a write-ahead log: the file is whole by itself, others may read it while
it is written, and a coordinator that is killed in the middle of a transaction leaves it as it was before that
one. A result is there once or not at all: its row's key is the run's id.

    about(key, value)                               format, name, form, study (JSON), created
    cells(cell, levels, experiment, settings, document)     levels and settings JSON; document JSON, deflated
    runs(cell, replicate, seed, id)                 what is planned; several cells may share a run
    results(id, status, cause, metrics, wall_s, worker, finished, version, recording)
    versions(version, text)                         `fesloop.analysis.study.store.versions`
    prepared(id, key, status, cause, content)       models of patients
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
from typing import Any, Self

from fesloop.analysis.study.design.plan import PlannedCell
from fesloop.analysis.study.design.study import Study
from fesloop.analysis.study.store.claim import claim, is_empty
from fesloop.analysis.study.store.file import FILE, locked, named, opened, require_room, transaction
from fesloop.errors import InputError, RunError
from fesloop.experiment.files.overlay import key_text

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
    """What is kept of a run.

    Attributes
    ----------
    id: of the run.
    status: done or failed; cause: why it failed, in one line.
    metrics: numbers, None where the run has none.
    wall_s: how long it took. worker: where. recording: path of it, "" where it was not kept.
    """

    id: str
    status: str
    cause: str
    metrics: dict[str, float | None]
    wall_s: float
    worker: str
    recording: str = ""


class Store:
    """The file of one study, open for its coordinator.

    Parameters
    ----------
    folder: made if it is not there.
    study: whose results the file holds, or will hold.
    mix_versions: take a file on that was begun with other code or libraries.

    Raises InputError for a folder that cannot be written to, a file that is no study's, of another study or
    version, and one that another coordinator is at.
    """

    def __init__(self, folder: Path, study: Study, *, mix_versions: bool = False) -> None:
        self.path = folder / FILE
        require_room(folder)
        with ExitStack() as taken:
            self._lock = taken.enter_context(closing(locked(folder)))
            with named(self.path):
                self._file = taken.enter_context(closing(opened(self.path)))
                self._version = claim(self._file, self.path, study, mix_versions)
            taken.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()
        if isinstance(fault, sqlite3.Error):  # of a plain read: what is written names itself
            raise RunError(f"{self.path}: cannot be read on: {fault}; mend the disk, or move the file away"
                           ) from None

    def close(self) -> None:
        """Let the file go, for another coordinator to take."""
        self._file.close()
        self._lock.close()

    def put_plan(self, cells: Iterable[PlannedCell]) -> float:
        """Note every cell and run, or hold them against those that are there; the simulated seconds of all.

        Raises InputError where a file's plan is another one, as when its base experiment has changed.
        """
        planned = self._file.execute("SELECT count(*) FROM cells").fetchone()[0]
        simulated_s = 0.0
        with named(self.path), self._transaction():
            for each in cells:
                self._hold_against(each) if planned else self._add(each)
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

    def _hold_against(self, each: PlannedCell) -> None:
        found = self._file.execute("SELECT id FROM runs WHERE cell = ? ORDER BY replicate",
                                   (each.cell.number,)).fetchall()
        if [id for (id,) in found] == [run.id for run in each.runs]:
            return
        if then := self.document(each.cell.number):
            what = _difference(json.loads(zlib.decompress(then)), json.loads(each.document or "{}"))
            raise InputError(str(self.path), f"was made when {each.cell.experiment} was another experiment "
                             f"(seen at {each.cell.place}{what})", "the same experiments as then",
                             "give another --out, or move the file away")
        # What it needs could not be prepared then, and has been now.
        self._file.executemany("DELETE FROM results WHERE id = ?", found)
        for table in ("cells", "runs"):
            self._file.execute(f"DELETE FROM {table} WHERE cell = ?", (each.cell.number,))
        self._add(each)

    def pending(self, *, retry_failed: bool = False) -> Iterator[tuple[int, int, str]]:
        """(cell, seed, id) of every run without a result, cell by cell; of failed ones too if asked for.

        Not of those for which something could not be prepared. A run that several cells share comes once,
        with the first of them. They are read some at a time, so that results may be put meanwhile.
        """
        place = -1, -1
        while page := self._file.execute(_PENDING, (*place, retry_failed)).fetchall():
            yield from ((cell, seed, id) for cell, _, seed, id in page)
            place = page[-1][:2]

    def first_runs(self) -> dict[str, tuple[int, int, str]]:
        """(cell, seed, id) of the first planned run of each experiment, by its name or path."""
        rows = self._file.execute(
            "SELECT experiment, min(cell), seed, id FROM cells JOIN runs USING (cell) WHERE replicate = 0 "
            "GROUP BY experiment")
        return {experiment: (cell, seed, id) for experiment, cell, seed, id in rows}

    def document(self, cell: int) -> bytes:
        """JSON of a cell's experiment, deflated; empty where what it needs could not be prepared."""
        row = self._file.execute("SELECT document FROM cells WHERE cell = ?", (cell,)).fetchone()
        return bytes(row[0])

    def put(self, results: Sequence[StoredResult]) -> None:
        """Note results, all or none; those that are there already stay, but for failed ones.

        Raises RunError where the disk has no room or cannot be written to; what was noted before is kept.
        """
        with self._transaction():
            self._put(results)

    def _put(self, results: Sequence[StoredResult]) -> None:
        finished = datetime.now(UTC).isoformat(timespec="seconds")
        self._file.executemany(_PUT, [
            (each.id, each.status, each.cause, json.dumps(each.metrics), each.wall_s, each.worker, finished,
             self._version, each.recording) for each in results])

    def prepared(self) -> dict[str, tuple[str, str, str]]:
        """(status, cause, content) of what was prepared, by id."""
        return {id: (status, cause, content) for id, status, cause, content in self._file.execute(
            "SELECT id, status, cause, content FROM prepared")}

    def put_prepared(self, id: str, key: str, status: str, cause: str, content: str) -> None:
        """Note what was prepared, or why it could not be."""
        with self._transaction():
            self._file.execute("INSERT OR REPLACE INTO prepared VALUES(?, ?, ?, ?, ?)",
                               (id, key, status, cause, content))

    @property
    def started(self) -> bool:
        """Whether anything has come of the study before."""
        return not is_empty(self._file)

    def distinct_runs(self) -> int:
        """How many runs are planned, those that several cells share counted once."""
        return int(self._file.execute("SELECT count(DISTINCT id) FROM runs").fetchone()[0])

    def counts(self) -> tuple[int, dict[str, int]]:
        """How many distinct runs are done, and how many failed for each cause."""
        done = self._file.execute("SELECT count(*) FROM results WHERE status = 'done'").fetchone()[0]
        causes = self._file.execute("SELECT cause, count(*) FROM results WHERE status = 'failed' "
                                    "GROUP BY cause ORDER BY count(*) DESC").fetchall()
        return done, dict(causes)

    def not_prepared(self) -> dict[str, int]:
        """How many runs cannot be for what could not be prepared, by cause."""
        return dict(self._file.execute(
            "SELECT cause, count(*) FROM results WHERE id IN (SELECT id FROM runs JOIN cells USING (cell) "
            "WHERE length(document) = 0) GROUP BY cause"))

    def _transaction(self) -> AbstractContextManager[None]:
        return transaction(self._file, self.path)


def _difference(then: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """What differs between an experiment's tables, for a message: the patient's file, or the first key.

    `drawn` of a patient is what was read from the file; its other keys choose file and member.
    """
    paths = list(_differing(then, now, ()))
    of_patient = [path for path in paths if path[0] == "patient"]
    if of_patient and all(path[1:2] == ("drawn",) for path in of_patient):
        return f"; what has changed is the patient file {now['patient'].get('file')!r}"
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
