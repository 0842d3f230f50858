"""One run of a study, as a worker does it: from an experiment's document to the kept numbers.

A task takes and returns plain values, so that a worker needs nothing but fesloop, and no disk in common with
the coordinator. The outcome depends neither on the worker nor on its earlier tasks.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
import socket
import zlib
from collections.abc import Mapping
from functools import cache, lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple
from uuid import uuid4

from fesloop.analysis.study.design.study import KeptMetric
from fesloop.analysis.study.store.versions import version_text
from fesloop.errors import FesloopError, where_it_broke
from fesloop.experiment.files.parse import from_document
from fesloop.experiment.running import Experiment, Rehearsals, run
from fesloop.loop.machine import one_blas_thread

NO_ROOM = "no room"
"""Status of a run that could not be recorded as the worker's disk is full. It is no result."""
_ROOM_BYTES = 2**25
_LONGEST_CAUSE = 400


NO_CODE: Mapping[str, str] = {}


class ResultSpec(NamedTuple):
    """The kept part of a run: metrics, which recordings (none, failed, all), and the folder of these.

    `code` has the sources of classes that no package registers, by kind.
    """

    metrics: tuple[KeptMetric, ...]
    recordings: str
    folder: str
    code: Mapping[str, str] = NO_CODE


class Outcome(NamedTuple):
    """The outcome of a run: a `fesloop.analysis.study.store.writing.StoredResult`, and more.

    `recording_bytes` is the size of its recording, kept or not; `version` that of the worker.
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
def run_one(id: str, document: bytes, seed: int, spec: ResultSpec) -> Outcome:
    """Run the experiment of a deflated document once, with a seed. The outcome names what failed."""
    began = perf_counter()
    with TemporaryDirectory(prefix="fesloop-", dir=scratch_folder()) as folder:
        status, cause, metrics = _ending(document, seed, Path(folder), spec)
        recorded = next(Path(folder).glob("*.h5"), None)
        size, recording = recorded.stat().st_size if recorded else 0, ""
        try:
            if recorded and (spec.recordings == "all" or (spec.recordings == status == "failed")):
                recording = _kept(recorded, id, Path(spec.folder))
        except OSError as fault:
            status, cause, metrics = failure(fault), where_it_broke(fault), {}
        if status == "failed" and is_full(folder):
            status = NO_ROOM
    return Outcome(id, status, " ".join(cause.split())[:_LONGEST_CAUSE], metrics, perf_counter() - began,
                   f"{socket.gethostname()} {os.getpid()}", recording, size, version_text())


def _ending(document: bytes, seed: int, folder: Path, spec: ResultSpec
            ) -> tuple[str, str, dict[str, float | None]]:
    """Status, cause and metrics of a run that records into a folder."""
    try:
        result = run(experiment_of(document, seed, spec.code), folder, rehearsals=_rehearsals())
        if result.status == "interrupted":
            raise KeyboardInterrupt
        numbers = ({each.name: each.of(result.metrics) for each in spec.metrics}
                   if result.status == "done" else {})
    except FesloopError as fault:
        return "failed", str(fault), {}
    except Exception as fault:  # noqa: BLE001 - a run that breaks is a row of the study, whatever breaks it
        return failure(fault), where_it_broke(fault), {}
    return result.status, result.cause, numbers


def failure(fault: Exception) -> str:
    """Status after an error: failed, or `NO_ROOM` where the disk is full."""
    full = isinstance(fault, OSError) and fault.errno in (errno.ENOSPC, errno.EDQUOT)
    return NO_ROOM if full else "failed"


def is_full(folder: str) -> bool:
    """Whether the disk of a folder has no room for a recording."""
    return shutil.disk_usage(folder).free < _ROOM_BYTES


def experiment_of(document: bytes, seed: int, code: Mapping[str, str] = NO_CODE) -> Experiment:
    """The experiment of a deflated document with a seed; it is parsed once for all replicates of a cell.

    Classes that no package registers are defined from the coordinator's sources of them, `code`. Those in the
    document, which may come from a file, are only compared with these.
    """
    return _parsed(document, tuple(code.items())).with_seed(seed)


@lru_cache(maxsize=1)
def _parsed(document: bytes, code: tuple[tuple[str, str], ...]) -> Experiment:
    tables = json.loads(zlib.decompress(document))
    if needed := {kind: source for kind, source in code if kind in tables.get("code", {})}:
        from fesloop.experiment.own_blocks import define  # runs of installed kinds do without

        define(needed)
    return from_document(tables)


@cache
def _rehearsals() -> Rehearsals:
    """The rehearsals that all runs of this worker share."""
    return Rehearsals()


def scratch_folder() -> str | None:
    """Folder for temporary files: the worker's own, which is removed after it even if it is killed."""
    try:
        from distributed import get_worker

        return str(get_worker().local_directory)
    except (ImportError, ValueError):
        return None


def _kept(recorded: Path, id: str, folder: Path) -> str:
    """Move a recording to the folder of kept ones, named by its run, whole or not at all; its path."""
    folder.mkdir(parents=True, exist_ok=True)
    draft, path = folder / f".{id}-{uuid4().hex[:8]}.h5", folder / f"{id}.h5"
    try:
        shutil.move(recorded, draft)
    except OSError:
        draft.unlink(missing_ok=True)
        raise
    draft.replace(path)
    return str(path)
