"""Times the same runs as a study and bare, each in a process of its own."""

from __future__ import annotations

import json
import os
import time
import zlib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from fesloop.analysis.study.design.cells import cells_of
from fesloop.analysis.study.design.plan import Resolver, plan
from fesloop.analysis.study.design.study_file import study_of
from fesloop.analysis.study.engine.coordinator import run_study
from fesloop.analysis.study.engine.worker import ResultSpec, run_one
from fesloop.analysis.study.results.study_results import load
from fesloop.errors import RunError
from fesloop.experiment.files.parse import from_document
from fesloop.experiment.files.parse import load as load_experiment
from fesloop.experiment.running import run

EXPERIMENT = "finger_pid_latency"
METRIC = "error_deg"
WORKERS = 2
REPLICATES = 4
"""Replicates per cell, so that resolving cells, which the engine does, counts with their runs."""
_PATH = "joint_rmse_deg"
_WARM = 4
"""Runs of each worker that load its code."""
_TRIED, _TRIED_S = 5, 12.0


def document(runs: int, duration_s: float) -> dict[str, Any]:
    """Document of a study of so many runs, rounded up to whole cells, of a finger for `duration_s`."""
    return {
        "study": {"name": "bench", "experiment": EXPERIMENT, "replicates": REPLICATES,
                  "settings": [f"experiment.duration_s={duration_s!r}"], "metrics": {METRIC: _PATH}},
        "axes": {"latency_ms": {"from": 0.0, "to": 100.0, "count": -(-runs // REPLICATES)}}}


def duration_for(run_s: float) -> float:
    """Simulated seconds, a whole number, that a bare run takes so long for on this machine."""
    experiment = load_experiment(EXPERIMENT, [f"experiment.duration_s={_TRIED_S!r}"])
    with TemporaryDirectory(prefix="fesloop-bench-") as folder:
        took = []
        for _ in range(_TRIED):
            began = time.perf_counter()
            run(experiment, Path(folder)).recording.unlink()
            took.append(time.perf_counter() - began)
    return float(max(1, round(_TRIED_S * run_s / median(took[1:]))))


class Timed(NamedTuple):
    """Times and results of some runs.

    Attributes
    ----------
    wall_s: from the first to the last run; a study's includes the start of its workers.
    run_s: wall time per run without the start; a study's is multiplied by its number of workers.
    cpu_s: processor time per run without the start; a study's is of coordinator and workers.
    found: metric of each run, by its id.
    peaks_mb: greatest resident memory of coordinator and workers, of a study only.
    task_s: wall time of a worker within the task of a run, of a study only.
    """

    wall_s: float
    run_s: float
    cpu_s: float
    found: dict[str, float]
    peaks_mb: dict[str, list[float]]
    task_s: float = 0.0


def bare(tables: Mapping[str, Any]) -> Timed:
    """Run the runs of a study one after the other here: loaded before, recorded, scored, deleted."""
    study = study_of(tables)
    resolver = Resolver(study)
    seeds = range(study.about.seed, study.about.seed + study.about.replicates)
    cells = [resolver.experiment(cell.experiment, cell.settings, seeds[0]) for cell in cells_of(study)]
    every = [cell.with_seed(seed) for cell in cells for seed in seeds]
    with TemporaryDirectory(prefix="fesloop-bench-") as folder:
        for experiment in every[:_WARM]:
            run(experiment, Path(folder)).recording.unlink()
        began, used = time.perf_counter(), time.process_time()
        results = []
        for experiment in every:
            result = run(experiment, Path(folder))
            result.recording.unlink()
            results.append(result.metrics[_PATH][-1])
        wall_s, cpu_s = time.perf_counter() - began, time.process_time() - used
    found = {each.fingerprint(): float(value) for each, value in zip(every, results, strict=True)}
    return Timed(wall_s, wall_s / len(every), cpu_s / len(every), found, {})


def studied(tables: Mapping[str, Any]) -> Timed:
    """Run the same runs as a study with `WORKERS` workers. Raises RunError where a run fails."""
    study, watch = study_of(tables), _Stopwatch()
    with TemporaryDirectory(prefix="fesloop-bench-") as folder:
        summary = run_study(study, folder, workers=WORKERS, watch=watch)
        if summary.failed:
            raise RunError(f"runs of the bench fail: {summary.failed}")
        rows = load(summary.store).table()
        found = {str(id): float(value) for id, value in zip(rows["id"], rows[METRIC], strict=True)}
    peaks = {"coordinator": [_peak_mb("self")], "workers": watch.peaks_mb}
    task_s = float(rows["wall_s"][_WARM * WORKERS:].mean())
    return Timed(summary.wall_s, *watch.of_a_run(), found, peaks, task_s)


def alternating(tables: Mapping[str, Any]) -> tuple[list[float], list[float]]:
    """Seconds of each run of a study as a worker's task, and bare, in turns in this process."""
    study = study_of(tables)
    spec = ResultSpec(study.metrics, "none", "")
    tasks, bares = [], []
    with TemporaryDirectory(prefix="fesloop-bench-") as folder:
        for cell in plan(study, lambda _: ()):
            document = zlib.compress(cell.document.encode())
            experiment = from_document(json.loads(cell.document))
            for each in cell.runs:
                began = time.perf_counter()
                run_one(each.id, document, each.seed, spec)
                between = time.perf_counter()
                run(experiment.with_seed(each.seed), Path(folder)).recording.unlink()
                tasks.append(between - began)
                bares.append(time.perf_counter() - between)
    return tasks[_WARM:], bares[_WARM:]


class _Stopwatch:
    """Reads the clocks when all workers are warm, and at the end of a study.

    Attributes
    ----------
    peaks_mb: memory of the workers at the end.
    """

    def __init__(self) -> None:
        self._workers: list[str] = []
        self._seen: list[tuple[int, float, float]] = []
        self.peaks_mb: list[float] = []

    def stage(self, text: str, fraction: float | None = None) -> None:
        """Ignore stages before the runs."""

    def runs(self, done: int, failed: Mapping[str, int], total: int) -> None:
        """Read the clocks, if it is time."""
        if done >= _WARM * WORKERS and not self._seen:
            self._workers = _children()
            self._look(done)
        if done == total and self._seen:
            self._look(done)
            self.peaks_mb = [_peak_mb(worker) for worker in self._workers]

    def _look(self, done: int) -> None:
        cpu_s = time.process_time() + sum(_cpu_s(worker) for worker in self._workers)
        self._seen.append((done, time.perf_counter(), cpu_s))

    def of_a_run(self) -> tuple[float, float]:
        """Wall time per run times the workers, and processor time per run, s."""
        before, after = np.array(self._seen[0]), np.array(self._seen[-1])
        runs, wall_s, cpu_s = after - before
        return WORKERS * float(wall_s / runs), float(cpu_s / runs)


def _children() -> list[str]:
    """Process numbers of the workers, which this process has spawned."""
    own, found = _status("self")["Pid"], []
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError, KeyError):
            if _status(folder.name)["PPid"] == own and b"spawn_main" in (folder / "cmdline").read_bytes():
                found.append(folder.name)
    return found


def _cpu_s(process: str) -> float:
    """Processor time of a process in user and system mode, s (`proc(5)`, fields 14, 15)."""
    fields = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _peak_mb(process: str) -> float:
    """Greatest resident memory of a process so far, MB (`VmHWM`; Linux)."""
    return int(_status(process)["VmHWM"].split()[0]) * 1024 / 1e6


def _status(process: str) -> dict[str, str]:
    lines = Path(f"/proc/{process}/status").read_text(encoding="utf-8").splitlines()
    return {key: value.strip() for key, _, value in (line.partition(":") for line in lines)}
