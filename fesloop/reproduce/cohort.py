"""Many runs of shipped experiments, a virtual subject a seed, on as many processes as asked for.

A run is a function of experiment, settings and seed alone, so results do not depend on the number of
processes nor on their order.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fesloop.errors import RunError
from fesloop.experiment.parse import load
from fesloop.experiment.reading import Recording
from fesloop.experiment.trial import run

Progress = Callable[[float], None]
Scoring = Callable[[Recording], dict[str, Any]]
"""What is kept of a recording; a function of a module, so that other processes find it."""


@dataclass(frozen=True, slots=True)
class Job:
    """One run.

    Attributes
    ----------
    key: by which its result is found: condition, movement, subject, ...
    experiment: name of a shipped experiment.
    settings: as of `fesloop run --set`.
    seed: of the subject.
    score: what is kept of the recording.
    """

    key: tuple[str | int, ...]
    experiment: str
    settings: tuple[str, ...]
    seed: int
    score: Scoring


def run_jobs(
    jobs: Sequence[Job], workers: int, progress: Progress | None = None
) -> dict[tuple[str | int, ...], dict[str, Any]]:
    """What each job's scoring kept, by key; recordings are not.

    Raises RunError for the first run that fails.
    """
    done: dict[tuple[str | int, ...], dict[str, Any]] = {}
    for key, kept in _results(jobs, workers):
        done[key] = kept
        if progress is not None:
            progress(len(done) / len(jobs))
    return {job.key: done[job.key] for job in jobs}


def _results(jobs: Sequence[Job], workers: int) -> Any:
    if workers < 2 or len(jobs) < 2:
        yield from (_scored(job) for job in jobs)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        try:
            for future in as_completed([pool.submit(_scored, job) for job in jobs]):
                yield future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _scored(job: Job) -> tuple[tuple[str | int, ...], dict[str, Any]]:
    """Run, score, and let the recording go."""
    with TemporaryDirectory(prefix="fesloop-") as folder:
        result = run(load(job.experiment, job.settings, job.seed), Path(folder))
        if result.status != "done":
            raise RunError(f"{job.experiment} {' '.join(job.settings)} (seed {job.seed}): "
                           f"{result.cause or result.status}")
        with Recording(result.recording) as recording:
            return job.key, job.score(recording)
