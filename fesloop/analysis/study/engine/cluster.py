"""The Dask cluster that a study runs on: processes on this machine, or a cluster that is already running.

The local cluster listens on loopback only, without a dashboard, and no process outlives the coordinator.
"""

from __future__ import annotations

import contextlib
import json
import logging
import multiprocessing
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from fesloop.analysis.study.store.versions import differences, version_text
from fesloop.errors import InputError, RunError
from fesloop.posix import blocked_interrupts

_LOOPBACK = "127.0.0.1"
_CONNECT_S = 10.0
_MOST_WORKERS = 1024
_GUARD = 'if __name__ == "__main__":'
_SETTINGS = {
    "distributed.admin.system-monitor.gil.enabled": False,
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.admin.tick.interval": "1s",
    "distributed.deploy.lost-worker-timeout": "5s",
    "distributed.nanny.pre-spawn-environ": dict.fromkeys(
        ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), 1),
    "distributed.scheduler.allowed-failures": 1,
    "distributed.scheduler.worker-saturation": 2.0,
    "distributed.worker.daemon": True,
    "distributed.worker.memory.monitor-interval": "1s",
    "distributed.worker.profile.enabled": False,
}
"""Dask's settings for the local cluster: a worker has its next task ready when it ends one; monitoring takes
little time; a task during which two workers have died is given to no third. Its environment for workers, less
MALLOC_TRIM_THRESHOLD_: with that, memory goes back to the system after each array, and a run takes a fifth
longer."""


def require_dask() -> Any:
    """Import `distributed`. Raises InputError, naming the extra, where it is not installed."""
    try:
        import distributed
    except ImportError as fault:
        raise InputError("study", f"needs Dask's distributed, which is missing: {fault}",
                         remedy="pip install 'fesloop[study]'") from None
    return distributed


def require_workers(workers: int | None) -> None:
    """Raise InputError for a number of processes out of range."""
    if workers is not None and not 1 <= workers <= _MOST_WORKERS:
        raise InputError("--workers", f"{workers}", f"1 to {_MOST_WORKERS} processes")


def require_started() -> None:
    """Raise InputError in a worker that is still starting, which imports the script that started it."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise InputError("study", "is started again by its own worker process, which imports the script",
                         f"a study started under: {_GUARD}")


def threads(client: Any) -> int:
    """Number of threads of all workers; 0 where there are none, or the scheduler does not answer."""
    try:
        return sum(client.nthreads().values())
    except OSError:
        return 0


def renew(client: Any) -> None:
    """Have a local cluster replace workers that Dask does not restart, as those that die while they start."""
    if client.cluster is not None:
        client.cluster.scale(len(client.cluster.worker_spec))


@contextmanager
def connected(workers: int | None, scheduler: str | None) -> Iterator[Any]:
    """A client of a local cluster of so many workers (None: one per core), or of the cluster at an address.

    Raises InputError for an address at which no scheduler answers, and for workers of another version.
    """
    distributed = require_dask()
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with contextlib.ExitStack() as stack:
        if scheduler is None:
            client = stack.enter_context(_local(distributed, workers))
        else:
            client = stack.enter_context(_remote(distributed, scheduler))
        yield client


@contextmanager
def _local(distributed: Any, workers: int | None) -> Iterator[Any]:
    import dask

    count = workers if workers is not None else os.cpu_count() or 1
    with contextlib.ExitStack() as stack:
        stack.enter_context(dask.config.set(_SETTINGS))
        try:
            # A terminal sends Ctrl-C to workers too, which would print tracebacks.
            with blocked_interrupts():
                cluster = stack.enter_context(distributed.LocalCluster(
                    n_workers=count, threads_per_worker=1, processes=True, host=_LOOPBACK,
                    dashboard_address=f"{_LOOPBACK}:0", silence_logs=logging.CRITICAL,
                    scheduler_kwargs={"dashboard": False}))
        except RuntimeError as fault:
            raise RunError(f"workers do not start: {fault} Each imports the script that started it; start "
                           f"the study there under: {_GUARD}") from None
        yield stack.enter_context(distributed.Client(cluster))


@contextmanager
def _remote(distributed: Any, scheduler: str) -> Iterator[Any]:
    try:
        client = distributed.Client(scheduler, timeout=_CONNECT_S)
    except (OSError, ValueError, TypeError) as fault:
        raise InputError(f"--scheduler {scheduler}", f"no Dask scheduler answers there: {fault}",
                         "the address that dask scheduler prints, such as tcp://127.0.0.1:8786") from None
    with client:
        _require_same_version(client, scheduler)
        yield client


def _require_same_version(client: Any, scheduler: str) -> None:
    """Raise InputError where a worker has no fesloop, another version, or several threads."""
    here = version_text()
    try:
        found = client.run(version_text, on_error="return")
    except OSError as fault:
        raise RunError(f"the scheduler at {scheduler} has gone: {fault}") from None
    for worker, count in client.nthreads().items():
        if count > 1:
            raise InputError(f"--scheduler {scheduler}", f"worker {worker} has {count} threads",
                             "workers of one thread, which share nothing while they run",
                             "start them with --nthreads 1, and more of them")
    for worker, text in found.items():
        if isinstance(text, BaseException):
            raise InputError(f"--scheduler {scheduler}", f"worker {worker} cannot import fesloop: {text}",
                             remedy="install the same fesloop for the workers")
        if json.loads(text) != json.loads(here):
            raise InputError(f"--scheduler {scheduler}", f"worker {worker} has another version: "
                             f"{differences(text, here)}", remedy="install the same versions for the workers")
