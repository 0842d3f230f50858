"""Studies some of whose processes are killed, and clusters started by hand.

    python tests/study_kills.py [MOMENTS]

kills, at random moments (five unless given), a worker, the coordinator, both, or the scheduler of a study's
cluster, starts the study again where it ended, and prints a JSON row per victim: `identical` counts the
moments after which the results equal those of the undisturbed study bit for bit.
"""

import json
import os
import random
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

import psutil

from fesloop.analysis.study.results.study_results import load
from fesloop.errors import RunError

VICTIMS = ("worker", "coordinator", "both", "scheduler")
"""Killed processes: `both` are worker and coordinator; the scheduler is of a cluster started by hand."""
_WORKERS, _CELLS = 2, 12
_PATIENCE_S, _ENDED_S, _AT_MOST_S, _LOOK_S = 60.0, 20.0, 300.0, 0.02
_STUDY = """
[study]
name = "killed"
experiment = "finger_pid_latency"
replicates = {replicates}
metrics = {{ error_deg = "joint_rmse_deg", seen_deg = "tracker_rmse_deg" }}

[axes.latency_ms]
from = 0
to = 110
count = {cells}
"""


class StartedCluster(NamedTuple):
    """Processes of a cluster, and the scheduler's address."""

    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]]
    address: str


@contextmanager
def started_cluster(folder: Path, workers: int) -> Iterator[StartedCluster]:
    """A scheduler and workers of one thread each, their files in `folder`; all end with the context."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "scheduler.json"
    file.unlink(missing_ok=True)
    with _ended(_dask("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file",
                      str(file))) as scheduler:
        address = _address(file, scheduler)
        started = [_dask("worker", address, "--nthreads", "1", "--no-nanny", "--host", "127.0.0.1",
                         "--local-directory", str(folder), "--death-timeout", "60") for _ in range(workers)]
        try:
            yield StartedCluster(scheduler, started, address)
        finally:
            for worker in started:
                _end(worker)


def _dask(program: str, *arguments: str) -> subprocess.Popen[bytes]:
    return _started(f"distributed.cli.dask_{program}", "--no-dashboard", *arguments)


def _started(module: str, *arguments: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-m", module, *arguments], stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL, start_new_session=True)


def _address(file: Path, scheduler: subprocess.Popen[bytes]) -> str:
    """The address that a scheduler writes when it has started."""
    until = time.monotonic() + _PATIENCE_S
    while time.monotonic() < until and scheduler.poll() is None:
        with suppress(OSError, ValueError, KeyError):
            return str(json.loads(file.read_text())["address"])
        time.sleep(0.1)
    raise RunError("a Dask scheduler could not be started")


@contextmanager
def _ended(process: subprocess.Popen[bytes]) -> Iterator[subprocess.Popen[bytes]]:
    try:
        yield process
    finally:
        _end(process)


def _end(process: subprocess.Popen[bytes]) -> None:
    process.terminate()
    with suppress(subprocess.TimeoutExpired):
        process.wait(_ENDED_S)
        return
    process.kill()
    process.wait()


class Killing(NamedTuple):
    """Number of killed processes, exit codes until the study's end, and the digest of its results."""

    processes: int
    exit_codes: tuple[int, ...]
    digest: str


class KilledStudy:
    """A study of `_CELLS` cells in `folder`, run by `fesloop study` with two workers."""

    def __init__(self, folder: Path, replicates: int, *, by_hand: bool) -> None:
        folder.mkdir()
        self.runs = _CELLS * replicates
        self._study, self._out, self._by_hand = folder / "study.toml", folder / "results", by_hand
        self._study.write_text(_STUDY.format(replicates=replicates, cells=_CELLS))

    def run(self, victim: str = "", results: int = 0) -> Killing:
        """Run it, kill the victim once so many results are stored, and restart it until it ends well."""
        codes: list[int] = []
        killed = 0
        until = time.monotonic() + _AT_MOST_S
        while not codes or codes[-1]:
            if time.monotonic() > until:
                raise RunError(f"the study did not end in {_AT_MOST_S:.0f} s; exit codes {codes}")
            with self._cluster() as cluster, _ended(self._coordinator(cluster)) as coordinator:
                if victim and not codes:
                    while coordinator.poll() is None and self._results() < results:
                        time.sleep(_LOOK_S)
                    for process in _chosen(victim, coordinator, cluster):
                        with suppress(ProcessLookupError):
                            os.kill(process, signal.SIGKILL)
                            killed += 1
                coordinator.wait(_AT_MOST_S)
            codes.append(coordinator.returncode)
        return Killing(killed, tuple(codes), load(self._out / "killed").digest())

    def _results(self) -> int:
        path = self._out / "killed" / "study.sqlite"
        with suppress(sqlite3.Error), closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as store:
            return int(store.execute("SELECT count(*) FROM results").fetchone()[0])
        return 0

    @contextmanager
    def _cluster(self) -> Iterator[StartedCluster | None]:
        if not self._by_hand:
            yield None
            return
        with started_cluster(self._out.parent, _WORKERS) as cluster:
            yield cluster

    def _coordinator(self, cluster: StartedCluster | None) -> subprocess.Popen[bytes]:
        where = ["--scheduler", cluster.address] if cluster else ["--workers", str(_WORKERS)]
        return _started("fesloop", "study", str(self._study), "--out", str(self._out), *where)


def _chosen(victim: str, coordinator: subprocess.Popen[bytes], cluster: StartedCluster | None) -> list[int]:
    if victim == "scheduler":
        assert cluster is not None
        return [cluster.scheduler.pid]
    workers = []
    with suppress(psutil.NoSuchProcess):
        workers = [child.pid for child in psutil.Process(coordinator.pid).children()
                   if any("spawn_main" in word for word in child.cmdline())]
    return {"worker": workers[-1:], "coordinator": [coordinator.pid],
            "both": [*workers[-1:], coordinator.pid]}[victim]


def undisturbed(folder: Path, replicates: int, *, by_hand: bool) -> str:
    """Digest of the results where nothing is killed."""
    return KilledStudy(folder, replicates, by_hand=by_hand).run().digest


def disturbed(folder: Path, replicates: int, victim: str, chance: random.Random) -> Killing:
    """A study whose victim is killed at a random moment."""
    study = KilledStudy(folder, replicates, by_hand=victim == "scheduler")
    return study.run(victim, chance.randrange(1, 3 * study.runs // 4))


if __name__ == "__main__":
    moments = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    with tempfile.TemporaryDirectory(prefix="fesloop-kills-") as scratch:
        expected = undisturbed(Path(scratch) / "whole", 8, by_hand=False)
        for victim in VICTIMS:
            tries = [disturbed(Path(scratch) / f"{victim}-{i}", 8, victim, random.Random())
                     for i in range(moments)]
            print(json.dumps({
                "victim": victim, "killed": [each.processes for each in tries],
                "identical": f"{sum(each.digest == expected for each in tries)} of {moments}",
                "exit_codes": [each.exit_codes for each in tries]}))
