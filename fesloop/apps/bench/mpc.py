"""`fesloop bench mpc`: a whole step of the predictive controller, beside a bare daqp solve of its programme.

The problems are those of the peers' scripts, consecutive ones of a receding loop, in three sizes. The
controller does all its work (observer, prediction, programme, checks, recruitment inverted); the bare
solver is handed the programme's vectors, made beforehand. Both take turns at each problem. Where do-mpc
is installed, the peers' script of it solves the first problems of the same sequences.

Times are CPU time of the thread, of each problem the least over the passes of a process; median, 99th
percentile and worst are over the problems, and of these the medians over the processes. Where a process
happens to lay its arrays changes the speed of the same solve by up to 2x, so one process says little.
"""

from __future__ import annotations

import json
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from time import CLOCK_THREAD_CPUTIME_ID, clock_gettime_ns
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.bench import _peers
from fesloop.apps.bench._mpc_problems import SIZES, Problems, Stepper, problems
from fesloop.errors import InputError

Array = NDArray[np.float64]
PROBLEMS, PASSES, PROCESSES = 1000, 3, 5
WARM_UP = 1
"""Problems at the start that are not counted: the first one is solved cold."""
PEER_PROBLEMS = {"S": 100, "M": 60, "L": 20}
"""Problems that do-mpc solves of each size; it takes up to 0.3 s for one."""
BARE, PEER = "bare daqp", "do-mpc"


def run(
    count: int = PROBLEMS, passes: int = PASSES, processes: int = PROCESSES,
    progress: Callable[[float], None] | None = None,
) -> dict[str, Any]:
    """One row a size against bare daqp, and one a size against do-mpc where it is installed.

    `max_abs_error` is the greatest difference of a first drive from the bare solver's, full scale 1.
    No rows, with the reason on standard error, where the peers' scripts are absent.
    """
    try:
        _peers.folder("mpc")
    except InputError as absent:
        print(f"bench mpc: {absent}", file=sys.stderr)
        return {"bench": "mpc", "rows": []}
    times: dict[str, list[Array]] = {size: [] for size in SIZES}
    error, turns = 0.0, [(size, i) for i in range(processes) for size in SIZES]
    with ProcessPoolExecutor(1, mp_context=get_context("spawn"), max_tasks_per_child=1) as pool:
        for number, (size, _) in enumerate(turns):
            measured, worst = pool.submit(measure, size, count, passes).result()
            times[size].append(measured)
            error = max(error, worst)
            if progress:
                progress((number + 1) / (len(turns) + len(SIZES)))
    rows = [_row(size, times[size], BARE, float(np.median([np.median(t[:, 1]) for t in times[size]])))
            for size in SIZES]
    if find_spec("do_mpc") is None:
        print("bench mpc: do-mpc is not installed, so there are no rows against it", file=sys.stderr)
    else:
        rows += [_row(size, times[size], PEER, 1e3 * peer_median_ms(size, PEER_PROBLEMS[size]))
                 for size in SIZES]
    return {"bench": "mpc", "rows": rows, "max_abs_error": error}


def measure(size: str, count: int, passes: int) -> tuple[Array, float]:
    """(us of our step and of the bare solve, (problems, 2); greatest difference of a first drive)."""
    made = problems(size, count)
    told = sys.modules["mpc_problem"]
    vectors, best, error = made.vectors(), np.full((count, 2), np.inf), 0.0
    for _ in range(passes + 1):  # the first pass compiles and warms up
        stepper, bare, times = Stepper(made, told.DU, told.TS), made.bare(), np.empty((count, 2))
        for k in range(count):
            times[k] = _turn(stepper, bare, vectors, k)
            error = max(error, float(np.abs(stepper.drive - made.optima[k, :made.mpc.nu]).max()))
        best = np.minimum(best, times)
    return best[WARM_UP:] / 1e3, error


def _turn(stepper: Stepper, bare: Any, vectors: list[Any], k: int) -> tuple[int, int]:
    """ns of our step and of the bare solve of problem k; who goes first changes from problem to problem."""
    inputs, problem = stepper.place(k), vectors[k]
    if k % 2:
        bare_ns = _time(bare.step, problem)
        return _time(stepper.step, inputs), bare_ns
    return _time(stepper.step, inputs), _time(bare.step, problem)


def _time(work: Callable[[Any], Any], given: Any) -> int:
    started = clock_gettime_ns(CLOCK_THREAD_CPUTIME_ID)
    work(given)
    return clock_gettime_ns(CLOCK_THREAD_CPUTIME_ID) - started


def peer_median_ms(size: str, count: int) -> float:
    """Median time of a do-mpc step over the first problems of a sequence, by the peers' own script, ms."""
    made: Problems = problems(size, count)
    script = _peers.folder("mpc") / "user_level.py"
    with tempfile.TemporaryDirectory(prefix="fesloop-bench-") as folder:
        (Path(folder) / f"seq_{size}.pkl").write_bytes(pickle.dumps((made.sequence, made.optima)))
        told = subprocess.run([sys.executable, str(script), size, "do_mpc", str(count)], cwd=folder,
                              capture_output=True, text=True, check=True)
    return float(json.loads(told.stdout.splitlines()[-1])["median_ms"])


def _row(size: str, times: list[Array], reference: str, reference_us: float) -> dict[str, Any]:
    """One size against a reference; against the bare solver, ratios are of the same process."""
    ours = [measured[:, 0] for measured in times]
    median = float(np.median([np.median(us) for us in ours]))
    ratio = median / reference_us
    if reference == BARE:
        ratio = float(np.median([np.median(t[:, 0]) / np.median(t[:, 1]) for t in times]))
    return {"case": size if reference == BARE else f"{size} against {reference}", "us_median": median,
            "us_p99": float(np.median([np.percentile(us, 99) for us in ours])),
            "us_worst": float(np.median([us.max() for us in ours])), "reference": reference,
            "reference_us_median": reference_us, "ratio": ratio}
