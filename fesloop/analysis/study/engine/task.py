"""What a worker does: one run, from an experiment's document to the numbers that are kept.

A task takes and gives plain values only, so that a worker needs nothing but fesloop itself, and no disk in
common with the coordinator. Which worker does it, and after what, changes nothing in what it gives.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
import socket
import zlib
from collections.abc import Sequence
from functools import cache, lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple
from uuid import uuid4

from fesloop.analysis.study.design.study import KeptMetric
from fesloop.analysis.study.store.versions import version_text
from fesloop.errors import FesloopError, where_it_broke
from fesloop.experiment.experiment import Experiment
from fesloop.experiment.files.parse import from_document
from fesloop.experiment.running.blas import one_blas_thread
from fesloop.experiment.running.trial import Rehearsals, run

NO_ROOM = "no room"
"""Status of a run that could not be recorded: the worker's disk is full. It is not a result."""
_ROOM_BYTES = 2**25
_LONGEST_CAUSE = 400


class Wanted(NamedTuple):
    """What is kept of a run: metrics, and whether and where its recording."""

    metrics: tuple[KeptMetric, ...]
    recordings: str
    folder: str


class Outcome(NamedTuple):
    """What came of a run: as `fesloop.analysis.study.store.writing.StoredResult`, and the `version` of who
    ran it.

    `recording_bytes` is the size of its recording, kept or not.
    """

    id: str
    status: str
    cause: str
    metrics: dict[str, float | None]
    wall_s: float
    worker: str
    recording: str
    recording_bytes: int
    version: str


@one_blas_thread()
def run_one(id: str, document: bytes, seed: int, wanted: Wanted) -> Outcome:
    """One run of the experiment of a deflated document, with a seed. What fails is told in the outcome."""
    began = perf_counter()
    with TemporaryDirectory(prefix="fesloop-", dir=scratch_folder()) as folder:
        status, cause, metrics = _ending(document, seed, Path(folder), wanted.metrics)
        recorded = next(Path(folder).glob("*.h5"), None)
        size, recording = recorded.stat().st_size if recorded else 0, ""
        try:
            if recorded and (wanted.recordings == "all" or (wanted.recordings == status == "failed")):
                recording = _kept(recorded, id, Path(wanted.folder))
        except OSError as fault:
            status, cause, metrics = failure(fault), where_it_broke(fault), {}
        if status == "failed" and is_full(folder):
            status = NO_ROOM
    return Outcome(id, status, " ".join(cause.split())[:_LONGEST_CAUSE], metrics, perf_counter() - began,
                   f"{socket.gethostname()} {os.getpid()}", recording, size, version_text())


def _ending(document: bytes, seed: int, folder: Path, metrics: Sequence[KeptMetric]
            ) -> tuple[str, str, dict[str, float | None]]:
    """Status, cause and metrics of a run whose recording goes into a folder."""
    try:
        result = run(experiment_of(document, seed), folder, rehearsals=_rehearsals())
        if result.status == "interrupted":
            raise KeyboardInterrupt
        numbers = {each.name: each.of(result.metrics) for each in metrics} if result.status == "done" else {}
    except FesloopError as fault:
        return "failed", str(fault), {}
    except Exception as fault:  # noqa: BLE001 - a run that breaks is a row of the study, whatever breaks it
        return failure(fault), where_it_broke(fault), {}
    return result.status, result.cause, numbers


def failure(fault: Exception) -> str:
    """Status of what broke: no result, where it was for want of room."""
    full = isinstance(fault, OSError) and fault.errno in (errno.ENOSPC, errno.EDQUOT)
    return NO_ROOM if full else "failed"


def is_full(folder: str) -> bool:
    """Whether the disk of a folder has no room for a recording."""
    return shutil.disk_usage(folder).free < _ROOM_BYTES


def experiment_of(document: bytes, seed: int) -> Experiment:
    """The experiment of a deflated document with a seed; a cell's is made once for all its replicates."""
    return _of_cell(document).with_seed(seed)


@lru_cache(maxsize=1)
def _of_cell(document: bytes) -> Experiment:
    return from_document(json.loads(zlib.decompress(document)))


@cache
def _rehearsals() -> Rehearsals:
    """Of all runs of this worker."""
    return Rehearsals()


def scratch_folder() -> str | None:
    """Where temporary files go: a worker's own folder, which is cleared after it, even if it is killed."""
    try:
        from distributed import get_worker

        return str(get_worker().local_directory)
    except (ImportError, ValueError):
        return None


def _kept(recorded: Path, id: str, folder: Path) -> str:
    """Path of a recording in the folder where it is kept: named by its run, there whole or not at all."""
    folder.mkdir(parents=True, exist_ok=True)
    draft, path = folder / f".{id}-{uuid4().hex[:8]}.h5", folder / f"{id}.h5"
    try:
        shutil.move(recorded, draft)
    except OSError:
        draft.unlink(missing_ok=True)
        raise
    draft.replace(path)
    return str(path)
