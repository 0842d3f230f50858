"""The receding-horizon problems of `fesloop bench mpc`, from the peers' plant, limits and references."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import logm

from fesloop.apps.bench import _peers
from fesloop.experiment import registry
from fesloop.loop.block import Block, Context, Tick
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.loop.signals import NEVER, Sample
from fesloop.models.linear_model import LinearModel
from fesloop.models.recruitment import Recruitment

Array = NDArray[np.float64]
SIZES = ("S", "M", "L")
MISMATCH, SEED = 0.15, 7
"""Of the sequences, as the peers' own."""
CURRENT_MA, THRESHOLD_MA, SPREAD = 100.0, 5.0, 0.1
"""Recruitment that reaches 1 within rounding, so that the limits are the peers' (chosen)."""


@dataclass(slots=True, eq=False)
class Problems:
    """Consecutive problems of one size.

    Attributes
    ----------
    mpc: the peers' object: matrices, and `cond_vec`, the vectors of a problem.
    sequence: (state now, drive in force, reference over the horizon, flat) of each.
    optima: (problems, N muscles), by the bare solver.
    solvers: the peers' module of them.
    """

    mpc: Any
    sequence: list[tuple[Array, Array, Array]]
    optima: Array
    solvers: ModuleType

    def bare(self) -> Any:
        """The peers' daqp, set up: `step(vectors)` gives the first drive."""
        solver = self.solvers.Daqp(self.mpc, 0.0)
        solver.setup(self.mpc.cond_vec(*self.sequence[0]))
        return solver

    def vectors(self) -> list[Any]:
        """What the bare solver is handed for each problem."""
        return [self.mpc.cond_vec(*problem) for problem in self.sequence]


def problems(size: str, count: int) -> Problems:
    """`count` problems of a loop that the bare solver closes around a plant that is not the model.

    The draws are those of the peers' `make_sequence`, which closes the loop with another solver.
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
    """Our controller with the peers' model, cost and limits."""
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
    """Steps our controller through the problems.

    Its state is set as it stands one period before each: the estimate that leads to the problem's state
    under the drive in force, nothing unexplained. What is measured then confirms the estimate, so the
    programme is the peers' to rounding, and nothing of a step is left out.
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
        """Set the state as it is before problem k; the inputs of its tick."""
        before, now = self.clock.tick(k), self.clock.tick(k + 1)
        estimate = self.state.estimate
        estimate.at_ns, estimate.x[:], estimate.disturbance[:] = before, self.earlier[k], 0.0
        estimate.stamps[-1], estimate.inputs[-1] = before, self.drives[k]
        self.state.drive = self.drives[k]
        self.tick.index, self.tick.time_ns = k + 1, now
        return [Sample(self.ahead[k], now, now, now), self.unwired,
                Sample(self.measured[k], now, now, now), self.unwired]

    def step(self, inputs: list[Sample]) -> None:
        """One tick of the controller."""
        self.block.step(self.state, inputs, self.tick)

    @property
    def drive(self) -> Array:
        """What the controller decided, (muscles,)."""
        drive: Array = self.state.drive
        return drive
