"""`fesloop bench mpc`: a whole step of the predictive controller, compared with a bare daqp solve of its QP.

The problems are those of the peers' scripts, consecutive ones of a receding horizon, in three sizes. The
controller does all its work (observer, prediction, QP, checks, inverse recruitment); the bare solver gets the
vectors of the QP, computed beforehand. Both alternate at each problem. Where do-mpc is installed, the peers'
script for it solves the first problems of the same sequences.

Times are CPU times of the thread: for each problem the least over the passes of a process, over problems the
median, 99th percentile and maximum, and of these the medians over processes. The place of arrays in memory
changes the speed of the same solve by up to 2x between processes, so one process says little.
"""

from __future__ import annotations

import json
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from time import CLOCK_THREAD_CPUTIME_ID, clock_gettime_ns
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import logm

from fesloop.apps.bench import _peers
from fesloop.errors import InputError
from fesloop.experiment import registry
from fesloop.loop.block import Block, Context, Tick
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.loop.signals import NEVER, Sample
from fesloop.models.linear_model import LinearModel, Recruitment

Array = NDArray[np.float64]
SIZES = ("S", "M", "L")
MISMATCH, SEED = 0.15, 7
"""Mismatch of the plant, and seed, of the sequences, as in the peers' scripts."""
CURRENT_MA, THRESHOLD_MA, SPREAD = 100.0, 5.0, 0.1
"""Recruitment that reaches 1 within rounding, so that the limits equal those of the peers (chosen)."""


@dataclass(slots=True, eq=False)
class Problems:
    """Consecutive problems of one size.

    Attributes
    ----------
    mpc: object of the peers: matrices, and `cond_vec`, the vectors of a problem.
    sequence: (state, previous drive, reference over the horizon, flat) of each.
    optima: (problems, N muscles), by the bare solver.
    solvers: module of the peers.
    """

    mpc: Any
    sequence: list[tuple[Array, Array, Array]]
    optima: Array
    solvers: ModuleType

    def bare(self) -> Any:
        """Set up the peers' daqp; its `step(vectors)` returns the first drive."""
        solver = self.solvers.Daqp(self.mpc, 0.0)
        solver.setup(self.mpc.cond_vec(*self.sequence[0]))
        return solver

    def vectors(self) -> list[Any]:
        """Vectors of each problem for the bare solver."""
        return [self.mpc.cond_vec(*problem) for problem in self.sequence]


def problems(size: str, count: int) -> Problems:
    """Make `count` problems of a loop of the bare solver and a plant that differs from the model.

    Random numbers are those of the peers' `make_sequence`, which closes the loop with another solver.
    """
    scripts = _peers.folder("mpc")
    told, solvers = _peers.module(scripts / "mpc_problem.py"), _peers.module(scripts / "qp_bench.py")
    mpc = told.MPC(size)
    at_rest = np.zeros(mpc.nx), np.zeros(mpc.nu), np.zeros(mpc.N * mpc.ny)
    made = Problems(mpc, [at_rest], np.empty(0), solvers)
    solver, optima = made.bare(), []
    solver.nu = mpc.n_c  # the whole optimum, not the first drive alone
    made.sequence.clear()
    rng = np.random.default_rng(SEED)
    a, b, _ = told.plant(mpc.nu, mpc.ny, mismatch=MISMATCH)
    reference = told.reference(mpc.ny, count + mpc.N + 1)
    x, previous = np.zeros(mpc.nx), np.zeros(mpc.nu)
    for k in range(count):
        seen = x + 0.005 * rng.standard_normal(mpc.nx) * (np.abs(x) + 0.1)
        ahead = reference[k + 1:k + 1 + mpc.N].ravel()
        made.sequence.append((seen, previous.copy(), ahead))
        optima.append(solver.step(mpc.cond_vec(seen, previous, ahead)).copy())
        previous = np.clip(optima[-1][:mpc.nu], 0.0, 1.0)
        x = a @ x + b @ previous + 0.004 * rng.standard_normal(mpc.nx)
    made.optima = np.array(optima)
    return made


def controller(mpc: Any, slew: float, period_s: float) -> Block:
    """Make the controller with the peers' model, cost and limits."""
    states, muscles = mpc.nx, mpc.nu
    stacked = np.block([[mpc.A, mpc.B], [np.zeros((muscles, states)), np.eye(muscles)]])
    continuous = np.real(logm(stacked)) / period_s
    model = LinearModel(
        a=continuous[:states, :states], b=continuous[:states, states:], c=mpc.C, offset=np.zeros(mpc.ny),
        recruitment=Recruitment(threshold_ma=(THRESHOLD_MA,) * muscles, spread=(SPREAD,) * muscles))
    made: Block = registry.find("mpc")(
        model=model, current_ma=(CURRENT_MA,) * muscles, horizon=mpc.N, move_weight=mpc.R,
        effort_weight=mpc.eps, cocontraction_weight=0.0, slew=slew, charge_max_uc=1e3, charge_rise_uc=1e3)
    return made


class Stepper:
    """Steps the controller through the problems.

    Its state is set to that of one period before each problem: the estimate that leads to the problem's state
    under the previous drive, without disturbance. The measurement then confirms the estimate, so the QP
    equals that of the peers to rounding, and no part of a step is left out.
    """

    def __init__(self, made: Problems, slew: float, period_s: float) -> None:
        self.block = controller(made.mpc, slew, period_s)
        self.clock = RateClock(round(period_s * NS_PER_S), 1)
        self.state, self.tick = self.block.init(Context("mpc", clock=self.clock)), Tick()
        mpc = made.mpc
        back = np.linalg.inv(mpc.A)
        self.drives = [drive for _, drive, _ in made.sequence]
        self.earlier = [back @ (x - mpc.B @ drive) for x, drive, _ in made.sequence]
        self.measured = [mpc.C @ x for x, _, _ in made.sequence]
        self.ahead = [ahead.reshape(mpc.N, mpc.ny) for _, _, ahead in made.sequence]
        self.unwired = Sample(np.zeros(mpc.ny), NEVER, NEVER, NEVER)

    def place(self, k: int) -> list[Sample]:
        """Set the state before problem k, and return the inputs of its tick."""
        before, now = self.clock.tick(k), self.clock.tick(k + 1)
        estimate = self.state.estimate
        estimate.at_ns, estimate.x[:], estimate.disturbance[:] = before, self.earlier[k], 0.0
        estimate.stamps[-1], estimate.inputs[-1] = before, self.drives[k]
        self.state.drive = self.drives[k]
        self.tick.index, self.tick.time_ns = k + 1, now
        return [Sample(self.ahead[k], now, now, now), self.unwired,
                Sample(self.measured[k], now, now, now), self.unwired]

    def step(self, inputs: list[Sample]) -> None:
        """Run one tick of the controller."""
        self.block.step(self.state, inputs, self.tick)

    @property
    def drive(self) -> Array:
        """Drive computed by the controller, (muscles,)."""
        drive: Array = self.state.drive
        return drive


PROBLEMS, PASSES, PROCESSES = 1000, 3, 5
WARM_UP = 1
"""Problems at the start that are not counted: the first is solved without a warm start."""
PEER_PROBLEMS = {"S": 100, "M": 60, "L": 20}
"""Problems that do-mpc solves of each size; it takes up to 0.3 s for one."""
BARE, PEER = "bare daqp", "do-mpc"


def run(
    count: int = PROBLEMS, passes: int = PASSES, processes: int = PROCESSES,
    progress: Callable[[float], None] | None = None,
) -> dict[str, Any]:
    """Make a row for each size relative to bare daqp, and one relative to do-mpc where it is installed.

    `max_abs_error` is the largest difference of a first drive from the bare solver's, of full scale 1.
    Without the peers' scripts there are no rows, and the reason is on standard error.
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
    """Times of step and bare solve, (problems, 2), us; largest difference of a first drive."""
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
    """Times of the controller's step and of the bare solve of problem k, ns, in alternating order."""
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
    """Median time of a do-mpc step over the first problems of a sequence, by the peers' script, ms."""
    made: Problems = problems(size, count)
    script = _peers.folder("mpc") / "user_level.py"
    with tempfile.TemporaryDirectory(prefix="fesloop-bench-") as folder:
        (Path(folder) / f"seq_{size}.pkl").write_bytes(pickle.dumps((made.sequence, made.optima)))
        told = subprocess.run([sys.executable, str(script), size, "do_mpc", str(count)], cwd=folder,
                              capture_output=True, text=True, check=True)
    return float(json.loads(told.stdout.splitlines()[-1])["median_ms"])


def _row(size: str, times: list[Array], reference: str, reference_us: float) -> dict[str, Any]:
    """Row of one size relative to a reference; ratios to the bare solver are taken within a process."""
    ours = [measured[:, 0] for measured in times]
    median = float(np.median([np.median(us) for us in ours]))
    ratio = median / reference_us
    if reference == BARE:
        ratio = float(np.median([np.median(t[:, 0]) / np.median(t[:, 1]) for t in times]))
    return {"case": size if reference == BARE else f"{size} against {reference}", "us_median": median,
            "us_p99": float(np.median([np.percentile(us, 99) for us in ours])),
            "us_worst": float(np.median([us.max() for us in ours])), "reference": reference,
            "reference_us_median": reference_us, "ratio": ratio}
