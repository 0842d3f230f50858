"""`fesloop bench study_kills`: what comes of a study some of whose processes are killed.

A row a victim, SIGKILL being sent at random moments, when so many results stand in the store (`standing`): a
worker, the coordinator, both, the scheduler of a cluster that was started by hand. Started again where it
ended, the study must end with each result once, equal to the undisturbed study's bit for bit: `identical`
says of how many moments that is true, `killed` how many processes were, `exit_codes` how often it was
started. Times are those of the whole study with its restarts, `reference` that of the undisturbed one.
"""

from __future__ import annotations

import json
import os
import random
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fesloop.analysis.study.results.study_results import load
from fesloop.errors import RunError

_PATIENCE_S = 60.0
_ENDED_S = 20.0
_CLUSTER_LOOK_S = 0.1


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
        time.sleep(_CLUSTER_LOOK_S)
    raise RunError("a Dask scheduler could not be started")


VICTIMS = ("worker", "coordinator", "both", "scheduler")
"""What is killed: `both` are worker and coordinator; workers and scheduler of a cluster started by hand are
processes of their own."""
_WORKERS = 2
_AT_MOST_S = 300.0
_LOOK_S = 0.02


class Killing(NamedTuple):
    """How many processes were killed, how many results stood then, and exit codes until the study's end."""

    processes: int
    standing: int
    exit_codes: tuple[int, ...]


class DisturbedStudy:
    """A study file, run by `fesloop study` with two workers.

    Parameters
    ----------
    study: the file. out: folder of results; files of the cluster stand beside it.
    by_hand: on a cluster that is started beside it, on loopback.
    """

    def __init__(self, study: Path, out: Path, *, by_hand: bool = False) -> None:
        self._command = [sys.executable, "-m", "fesloop", "study", str(study), "--out", str(out)]
        self._by_hand, self._out = by_hand, out
        self._scratch = out.parent

    def to_its_end(self, codes: tuple[int, ...] = ()) -> tuple[int, ...]:
        """Run it until it ends well, started again where it ends otherwise; its exit codes.

        Raises RunError where it does not end well.
        """
        until = time.monotonic() + _AT_MOST_S
        while not codes or codes[-1]:
            if time.monotonic() > until:
                raise RunError(f"the study did not end in {_AT_MOST_S:.0f} s; exit codes {codes}")
            with self._cluster() as cluster, ended(self._coordinator(cluster)) as coordinator:
                coordinator.wait(_AT_MOST_S)
            codes = (*codes, coordinator.returncode)
        return codes

    def killed(self, victim: str, results: int) -> Killing:
        """As `to_its_end`, one of `VICTIMS` being killed when so many results stand in the store."""
        with self._cluster() as cluster, ended(self._coordinator(cluster)) as coordinator:
            while coordinator.poll() is None and self._results() < results:
                time.sleep(_LOOK_S)
            standing, dead = self._results(), 0
            for process in self._chosen(victim, coordinator, cluster):
                with suppress(ProcessLookupError):
                    os.kill(process, signal.SIGKILL)
                    dead += 1
            coordinator.wait(_AT_MOST_S)
        return Killing(dead, standing, self.to_its_end((coordinator.returncode,)))

    def _results(self) -> int:
        """How many stand in the store."""
        for path in self._out.glob("*/study.sqlite"):
            with suppress(sqlite3.Error), closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as store:
                return int(store.execute("SELECT count(*) FROM results").fetchone()[0])
        return 0

    @contextmanager
    def _cluster(self) -> Iterator[StartedCluster | None]:
        if not self._by_hand:
            yield None
            return
        with started_cluster(self._scratch, _WORKERS) as cluster:
            yield cluster

    def _coordinator(self, cluster: StartedCluster | None) -> subprocess.Popen[bytes]:
        where = ["--scheduler", cluster.address] if cluster else ["--workers", str(_WORKERS)]
        return subprocess.Popen([*self._command, *where], stdout=subprocess.DEVNULL,
                                stderr=subprocess.DEVNULL, start_new_session=True)

    def _chosen(self, victim: str, coordinator: subprocess.Popen[bytes],
                cluster: StartedCluster | None) -> list[int]:
        if victim == "scheduler":
            assert cluster is not None
            return [cluster.scheduler.pid]
        workers = [worker.pid for worker in cluster.workers] if cluster else _workers_of(coordinator.pid)
        return {"worker": workers[-1:], "coordinator": [coordinator.pid],
                "both": [*workers[-1:], coordinator.pid]}[victim]


def _workers_of(process: int) -> list[int]:
    """Its children that are workers; none before they are started."""
    import psutil

    with suppress(psutil.NoSuchProcess):
        return [child.pid for child in psutil.Process(process).children()
                if any("spawn_main" in word for word in child.cmdline())]
    return []


NAME, CELLS = "killed", 12
_STUDY = """
[study]
name = "{name}"
experiment = "finger_pid_latency"
replicates = {replicates}
metrics = {{ error_deg = "joint_rmse_deg", seen_deg = "tracker_rmse_deg" }}

[axes.latency_ms]
from = 0
to = 110
count = {cells}
"""


def run(moments: int = 5, replicates: int = 8, seed: int | None = None,
        progress: Callable[[float], None] | None = None) -> dict[str, Any]:
    """One row a victim; `seed` of the moments, None for new ones each time."""
    chance = random.Random(seed)
    with tempfile.TemporaryDirectory(prefix="fesloop-bench-") as folder:
        study = Path(folder) / "study.toml"
        study.write_text(_STUDY.format(name=NAME, replicates=replicates, cells=CELLS))
        whole = {by_hand: _undisturbed(study, Path(folder) / f"whole-{by_hand}", by_hand)
                 for by_hand in (False, True)}
        rows = []
        for number, victim in enumerate(VICTIMS):
            by_hand = victim == "scheduler"
            digest, usual_s = whole[by_hand]
            tries = []
            for i in range(moments):
                results = chance.randrange(1, 3 * CELLS * replicates // 4)
                tries.append(_disturbed(study, Path(folder) / f"{victim}-{i}", victim, by_hand, results))
                if progress:
                    progress((number + (i + 1) / moments) / len(VICTIMS))
            rows.append(_row(victim, tries, digest, usual_s))
    return {"bench": "study_kills", "rows": rows, "same_on_both_clusters": whole[False][0] == whole[True][0]}


def _undisturbed(study: Path, out: Path, by_hand: bool) -> tuple[str, float]:
    """Digest of the results, and how long they took."""
    began = time.perf_counter()
    DisturbedStudy(study, out / "results", by_hand=by_hand).to_its_end()
    return load(out / "results" / NAME).digest(), time.perf_counter() - began


def _disturbed(study: Path, out: Path, victim: str, by_hand: bool, results: int) -> dict[str, Any]:
    began = time.perf_counter()
    killing = DisturbedStudy(study, out / "results", by_hand=by_hand).killed(victim, results)
    seconds = time.perf_counter() - began
    return {"killing": killing, "seconds": seconds, "digest": load(out / "results" / NAME).digest()}


def _row(victim: str, tries: list[dict[str, Any]], digest: str, usual_s: float) -> dict[str, Any]:
    micros = 1e6 * np.array([each["seconds"] for each in tries])
    return {"case": victim, "us_median": float(np.median(micros)), "us_p99": float(np.percentile(micros, 99)),
            "us_worst": float(micros.max()), "reference": "undisturbed study",
            "reference_us_median": 1e6 * usual_s, "ratio": float(np.median(micros)) / (1e6 * usual_s),
            "identical": f"{sum(each['digest'] == digest for each in tries)} of {len(tries)}",
            "killed": [each["killing"].processes for each in tries],
            "standing": [each["killing"].standing for each in tries],
            "exit_codes": [list(each["killing"].exit_codes) for each in tries]}
