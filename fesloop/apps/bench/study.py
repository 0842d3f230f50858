"""`fesloop bench study`: the cost of the study engine beyond the runs themselves.

A study with two workers does the same runs of a finger, cell by cell and seed by seed, as the reference
`bare`: one process that has loaded them before and does one after the other, with recording and scores. A row
gives the microseconds of a worker per run (wall time times two workers, over the runs), `ratio` that over the
bare run, and `efficiency` its inverse: the share of the ideal, twice as many runs as bare. Coordinator and
scheduler share the machine's cores with the workers, as in every study on one machine.

Studies and bare runs take turns, each in a new process whose libraries use one thread, as workers do. The
bare runs before and after a study are its reference, and the median over turns is reported. The start of the
workers, and of the code that they load for their first four runs, is left out; `start_s` reports it, and
`efficiency_with_start` includes it. `two processes` do bare runs at the same time, independently: the speed
that two cores of this machine have without an engine, as cores share caches and memory. `efficiency_of_pair`
is the study's share of that, and `efficiency_cpu` the same for processor time (coordinator and workers),
which other load on the machine affects least.

On some machines runs of one process differ from those of another by a tenth or more, so two figures compare a
process with itself: `share_in_tasks` is the workers' time within the tasks of runs, with `outside_tasks_ms`
per run beside it, and the last row compares a task (making its experiment, the run, the kept numbers) with a
bare run in turns in one process.

`overhead_ms` per run is a worker's time less a bare run's, `overhead_cpu_ms` processor time less that of a
run of the pair. `peaks_mb` are the greatest resident memories of coordinator and workers. `max_abs_error` is
the greatest difference between results of a study and of bare runs.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.bench._study_runs import WORKERS, Timed, alternating, bare, document, duration_for, studied

Array = NDArray[np.float64]
_LONG_S = 0.3
"""Time of a long bare run (chosen: 200 ms and more, whatever the load of the machine)."""
_SHORT_DURATION_S = 1.0
_THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")


def run(rounds: int = 3, long_runs: int = 80, short_runs: int = 2000, short_bare: int = 200,
        progress: Callable[[float], None] | None = None) -> dict[str, Any]:
    """Time runs of `_LONG_S` in so many rounds, and short runs once."""
    steps = _Steps(3 * rounds + 7, progress)
    with _one_thread(), ProcessPoolExecutor(
            WORKERS, mp_context=get_context("spawn"), max_tasks_per_child=1) as pool:
        duration_s = steps.done(pool.submit(duration_for, _LONG_S).result())
        long, short = document(long_runs, duration_s), document(short_runs, _SHORT_DURATION_S)
        bares = [steps.done(pool.submit(bare, long).result())]
        studies, pairs = [], []
        for _ in range(rounds):
            studies.append(steps.done(pool.submit(studied, long).result()))
            bares.append(steps.done(pool.submit(bare, long).result()))
            pairs.append(steps.done(_at_once(pool, long)))
        few = document(short_bare, _SHORT_DURATION_S)
        short_bares = [steps.done(pool.submit(bare, few).result())]
        short_study = steps.done(pool.submit(studied, short).result())
        short_bares.append(steps.done(pool.submit(bare, few).result()))
        short_pair = steps.done(_at_once(pool, few))
        tasks, beside = (1e6 * np.array(each) for each in steps.done(pool.submit(alternating, long).result()))
    rows = [_row(f"study, {len(bares[0].found)} runs", studies, bares, pairs),
            _timing("two processes, the same runs", pairs, bares),
            _row(f"study, {len(short_study.found)} short runs", [short_study], short_bares, [short_pair]),
            _timing("two processes, short runs", [short_pair], short_bares),
            {"case": "a task, in one process", "us_median": float(np.median(tasks)),
             "us_p99": float(np.percentile(tasks, 99)), "us_worst": float(tasks.max()),
             "reference": "bare run beside it", "reference_us_median": float(np.median(beside)),
             "ratio": float(np.median(tasks) / np.median(beside))}]
    return {"bench": "study", "rows": rows,
            "max_abs_error": max(_apart(each, bares[0]) for each in studies)}


class _Steps:
    """Reports the progress of the bench."""

    def __init__(self, total: int, progress: Callable[[float], None] | None) -> None:
        self._total, self._progress, self._done = total, progress, 0

    def done(self, result: Any) -> Any:
        """Count a step, and return its result."""
        self._done += 1
        if self._progress:
            self._progress(min(1.0, self._done / self._total))
        return result


@contextmanager
def _one_thread() -> Iterator[None]:
    """Limit libraries of processes started in the context to one thread, as Dask does for its workers."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _at_once(pool: ProcessPoolExecutor, tables: dict[str, Any]) -> Timed:
    """Do the bare runs in two processes at the same time; the slower of the two."""
    several = [pool.submit(bare, tables) for _ in range(WORKERS)]
    return max((each.result() for each in several), key=lambda timed: timed.run_s)


def _timing(case: str, turns: Sequence[Timed], bares: Sequence[Timed]) -> dict[str, Any]:
    """Columns that every bench has; bare runs were done before the first turn and after each."""
    us, bare_us = 1e6 * np.array([each.run_s for each in turns]), 1e6 * _around(bares, "run_s")
    return {"case": case, "us_median": float(np.median(us)), "us_p99": float(np.percentile(us, 99)),
            "us_worst": float(us.max()), "reference": "bare run in one process",
            "reference_us_median": float(np.median(bare_us)), "ratio": float(np.median(us / bare_us))}


def _row(case: str, studies: Sequence[Timed], bares: Sequence[Timed], pairs: Sequence[Timed]
         ) -> dict[str, Any]:
    """A row of the table, from the measurements of each turn of a study."""
    runs, task_s = len(studies[0].found), _each(studies, "task_s")
    wall_s, run_s, cpu_s = (_each(studies, key) for key in ("wall_s", "run_s", "cpu_s"))
    bare_s, pair_s, pair_cpu_s = _around(bares, "run_s"), _each(pairs, "run_s"), _each(pairs, "cpu_s")
    return {
        **_timing(case, studies, bares),
        "efficiency": float(np.median(bare_s / run_s)),
        "efficiency_with_start": float(np.median(bare_s / (WORKERS * wall_s / runs))),
        "efficiency_of_pair": float(np.median(pair_s / run_s)),
        "efficiency_cpu": float(np.median(pair_cpu_s / cpu_s)),
        "start_s": float(np.median(wall_s - run_s * runs / WORKERS)),
        "share_in_tasks": float(np.median(task_s / run_s)),
        "outside_tasks_ms": 1e3 * float(np.median(run_s - task_s)),
        "overhead_ms": 1e3 * float(np.median(run_s - bare_s)),
        "overhead_cpu_ms": 1e3 * float(np.median(cpu_s - pair_cpu_s)),
        "peaks_mb": {who: max(peak for each in studies for peak in each.peaks_mb[who])
                     for who in ("coordinator", "workers")}}


def _each(turns: Sequence[Timed], key: str) -> Array:
    return np.array([getattr(each, key) for each in turns])


def _around(bares: Sequence[Timed], key: str) -> Array:
    """Mean of a quantity before and after each turn."""
    values = _each(bares, key)
    return np.asarray((values[:-1] + values[1:]) / 2.0)


def _apart(study: Timed, reference: Timed) -> float:
    """Greatest difference of a result, by the runs' ids."""
    return max(abs(study.found[id] - value) for id, value in reference.found.items())
