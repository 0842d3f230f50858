"""Runs of shipped experiments on several processes, one virtual subject for each seed.

A run is a function of experiment, settings and seed alone, so results depend neither on the number of
processes nor on their order.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from tempfile import TemporaryDirectory
from threading import Thread
from typing import Any, Protocol

from fesloop.apps.reproduce.worker import Worker
from fesloop.errors import InputError, RunError
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.running import run

Key = tuple[str | int, ...]
Kept = dict[str, Any]
Progress = Callable[[float], None]
Scoring = Callable[[Recording], Kept]
"""Function of a recording that returns what is kept; defined in a module, so that other processes find it."""


class Task(Protocol):
    """Independent work, for this process or another."""

    @property
    def key(self) -> Key:
        """Key of the result: condition, movement, subject, ..."""

    def kept(self) -> Kept:
        """Do the work and return what is kept of it."""


@dataclass(frozen=True, slots=True)
class Job:
    """One run.

    Attributes
    ----------
    key: of the result: condition, movement, subject, ...
    experiment: name of a shipped experiment.
    settings: as in `fesloop run --set`.
    seed: of the subject.
    score: returns what is kept of the recording.
    """

    key: Key
    experiment: str
    settings: tuple[str, ...]
    seed: int
    score: Scoring

    @property
    def name(self) -> str:
        """Name in messages."""
        return f"{self.experiment}, {' '.join(map(str, self.key))} (seed {self.seed})"

    def kept(self) -> Kept:
        """Run, score, and delete the recording."""
        experiment = load(self.experiment, self.settings, self.seed)
        with TemporaryDirectory(prefix="fesloop-") as folder:
            try:
                result = run(experiment, Path(folder))
            except InputError as fault:
                raise RunError(f"{self.name}: {fault}") from fault
            if result.status == "interrupted":
                raise KeyboardInterrupt
            if result.status != "done":
                raise RunError(f"{self.name}: {result.cause or result.status}")
            with Recording(result.recording) as recording:
                return self.score(recording)


@dataclass(frozen=True, slots=True)
class Attempt:
    """A job that may fail, as where a hand cannot bring two points together: it then keeps None."""

    key: Key
    job: Job

    def kept(self) -> Kept:
        """Run the job; `kept` is what it keeps."""
        try:
            return {"kept": self.job.kept()}
        except (InputError, RunError):
            return {"kept": None}


def run_jobs(jobs: Sequence[Task], workers: int, progress: Progress | None = None) -> dict[Key, Kept]:
    """Run all jobs and return what each kept, by key; recordings are deleted.

    Raises RunError, naming the job, for the first run that fails, and KeyboardInterrupt where one is
    interrupted; no process outlives either.
    """
    done: dict[Key, Kept] = {}
    alone = workers < 2 or len(jobs) < 2
    with closing(_one_by_one(jobs) if alone else _shared(jobs, workers)) as results:
        for key, kept in results:
            done[key] = kept
            if progress is not None:
                progress(len(done) / len(jobs))
    return {job.key: done[job.key] for job in jobs}


def _one_by_one(jobs: Sequence[Task]) -> Generator[tuple[Key, Kept]]:
    yield from ((job.key, job.kept()) for job in jobs)


def _shared(jobs: Sequence[Task], workers: int) -> Generator[tuple[Key, Kept]]:
    """Yield results as jobs end; a thread for each process gives it one job after the other."""
    waiting: SimpleQueue[Task] = SimpleQueue()
    results: SimpleQueue[tuple[Key, Kept | Exception]] = SimpleQueue()
    for job in jobs:
        waiting.put(job)
    crew: list[Worker] = []
    try:
        for _ in range(min(workers, len(jobs))):
            crew.append(Worker())
            Thread(target=_employ, args=(crew[-1], waiting, results), daemon=True).start()
        for _ in jobs:
            key, kept = results.get()
            if isinstance(kept, Exception):
                raise kept
            yield key, kept
    finally:
        for worker in crew:
            worker.ask_to_end()
        for worker in crew:
            worker.end()


def _employ(
    worker: Worker, waiting: SimpleQueue[Task], results: SimpleQueue[tuple[Key, Kept | Exception]]
) -> None:
    """Give jobs to a process until none is left, or one fails."""
    while True:
        try:
            job = waiting.get_nowait()
        except Empty:
            return
        try:
            results.put((job.key, worker.call(_done, job)))
        except Exception as fault:  # noqa: BLE001 - raised in the thread that waits
            results.put((job.key, fault))
            return


def _done(task: Task) -> Kept:
    return task.kept()
