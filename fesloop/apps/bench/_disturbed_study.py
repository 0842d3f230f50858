"""A study in processes of its own, of which some are killed at a given moment."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from fesloop.apps.bench._started_cluster import StartedCluster, ended, started_cluster
from fesloop.errors import RunError

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
