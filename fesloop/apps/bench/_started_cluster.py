"""A Dask scheduler and workers, each a process that is started by hand, on this machine's loopback."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from fesloop.errors import RunError

_PATIENCE_S = 60.0
_ENDED_S = 20.0
_LOOK_S = 0.1


@dataclass(frozen=True, slots=True)
class StartedCluster:
    """Processes of a cluster, and the scheduler's address."""

    scheduler: subprocess.Popen[bytes]
    workers: tuple[subprocess.Popen[bytes], ...]
    address: str


@contextmanager
def started_cluster(folder: Path, workers: int) -> Iterator[StartedCluster]:
    """A scheduler and workers of one thread each, their files in `folder`; all end when it is left."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "scheduler.json"
    file.unlink(missing_ok=True)
    with ended(_dask("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
                     "--scheduler-file", str(file))) as scheduler:
        address = _address(file, scheduler)
        started = [_dask("dask_worker", address, "--nthreads", "1", "--no-dashboard", "--no-nanny",
                         "--host", "127.0.0.1", "--local-directory", str(folder), "--death-timeout", "60")
                   for _ in range(workers)]
        try:
            yield StartedCluster(scheduler, tuple(started), address)
        finally:
            for worker in started:
                end(worker)


@contextmanager
def ended(process: subprocess.Popen[bytes]) -> Iterator[subprocess.Popen[bytes]]:
    """A process that has ended when the context is left."""
    try:
        yield process
    finally:
        end(process)


def end(process: subprocess.Popen[bytes]) -> None:
    """Ask a process to end, and see that it does."""
    process.terminate()
    with suppress(subprocess.TimeoutExpired):
        process.wait(_ENDED_S)
        return
    process.kill()
    process.wait()


def _dask(program: str, *arguments: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-m", f"distributed.cli.{program}", *arguments],
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)


def _address(file: Path, scheduler: subprocess.Popen[bytes]) -> str:
    """The address that a scheduler writes when it is there."""
    until = time.monotonic() + _PATIENCE_S
    while time.monotonic() < until and scheduler.poll() is None:
        with suppress(OSError, ValueError, KeyError):
            return str(json.loads(file.read_text())["address"])
        time.sleep(_LOOK_S)
    raise RunError("a Dask scheduler could not be started")
