"""Arithmetic of one tick of predictive control, before and after the quadratic programme.

Compiled functions fill arrays of the caller: returning an array takes them as long as filling it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.allocation import allocate, risen
from controllers.mpc.observer import correct, predict, record
from controllers.mpc.parameters import MpcParameters
from controllers.mpc.plan import charge_room, free_optimum, limits
from controllers.mpc.state import Loop, MpcState
from controllers.quadratic_programme import NOT_FINITE, QpResult, check_vectors
from fesloop.compiled import compiled

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]


@compiled
def assemble_qp(
    ladder: Array, c: Array, offset: Array, gain: Array, x: Array, disturbance: Array, strength: Array,
    stamps: Stamps, inputs: Array, period_ns: int, delay_ns: int, at_ns: int, captured_ns: int, now_ns: int,
    measured: Array, free: Array, rows: Array, boxes: Array, reach: Array, slew: float, table: Array,
    charge_rise_c: float, charge: Array, drive: Array, pulses: Array, target: Array, reference: Array,
    best: Array, lower: Array, upper: Array, below: Array, above: Array,
) -> int:
    """Fill the free optimum and the bounds of this tick's programme; return its fault code (`qp.dense`).

    The observer is corrected in place by the measurement of `captured_ns` if that is after `at_ns`; the
    prediction starts from its estimate at `now_ns`. Nothing is written if an input is not finite. Drives
    in the programme are multiplied by the muscles' `strength`.

    Parameters
    ----------
    ladder ... delay_ns: as in `Observer` and `ObserverState`.
    measured, target: (outputs,) and (N, outputs), rad, less the disturbance that is expected of the trial.
    reference: (N, outputs), rad, the target with it.
    free, rows, boxes: as in `Plan`.
    reach, slew: greatest drive of each muscle, (muscles,), and its greatest change a tick.
    table, charge_rise_c: as in `risen`.
    charge: as in `limits`.
    drive, pulses: present ones, (muscles,) and (muscles, 2).
    best, lower, upper: (unknowns,) and twice (unknowns + constraints,); filled.
    below, above: bounds relative to `best`; filled.
    """
    muscles = drive.size
    for value in measured:
        if not np.isfinite(value):
            return NOT_FINITE
    for value in reference.flat:
        if not np.isfinite(value):
            return NOT_FINITE
    if captured_ns > at_ns:
        correct(ladder, c, offset, gain, x, disturbance, strength, stamps, inputs, period_ns, delay_ns,
                at_ns, captured_ns, measured)
        at_ns = captured_ns
    stored = (free.shape[0] - reference.size - x.size) // muscles - 1
    present = predict(ladder, x, strength, stamps, inputs, period_ns, delay_ns, at_ns, now_ns, stored)
    answered = strength * drive
    rise = np.empty(muscles)
    risen(table, pulses, charge_rise_c, rise)
    for i in range(muscles):
        rise[i] = strength[i] * max(rise[i], drive[i])
    free_optimum(free, present, disturbance + offset, target, answered, best)
    limits(strength * reach, slew * strength, answered, rise, charge, boxes, reference, best, lower, upper)
    fault: int = check_vectors(best, lower, upper)
    centre_bounds(rows, reference.shape[0] * muscles, muscles, best, lower, upper, below, above)
    return fault


@compiled
def centre_bounds(
    rows: Array, differences: int, muscles: int, best: Array, lower: Array, upper: Array, below: Array,
    above: Array,
) -> None:
    """Fill the bounds relative to `best`, bit for bit as `qp.dense.around` does.

    The first `differences` rows are differences between the drives of successive ticks.
    """
    unknowns = best.size
    for i in range(unknowns):
        below[i], above[i] = lower[i] - best[i], upper[i] - best[i]
    for row in range(rows.shape[0]):
        if row < differences:
            total = best[row] - best[row - muscles] if row >= muscles else best[row]
        else:
            total = 0.0
            for i in range(unknowns):
                total += rows[row, i] * best[i]
        at = unknowns + row
        below[at], above[at] = lower[at] - total, upper[at] - total


@compiled
def issue_drive(
    table: Array, drive: Array, stamps: Stamps, inputs: Array, time_ns: int, pulses: Array
) -> int:
    """Record a drive and fill its pulses (muscles, 2); return how many channels are at their longest."""
    record(stamps, inputs, time_ns, drive)
    saturated: int = allocate(table, drive, pulses)
    return saturated


class Problem(NamedTuple):
    """Arguments of `Qp.solve_around`."""

    best: Array
    lower: Array
    upper: Array
    below: Array
    above: Array
    fault: int


class Task(NamedTuple):
    """Measurement and reference of a tick.

    Attributes
    ----------
    measured: (outputs,), rad, less the disturbance that is expected of the trial at the capture.
    captured_ns, now_ns: instants of the capture and of the tick.
    reference: (N, outputs), rad, at the coming ticks; target: the same less the expected disturbance.
    """

    measured: Array
    captured_ns: int
    now_ns: int
    reference: Array
    target: Array


def build_problem(mpc: MpcParameters, state: MpcState, loop: Loop, gain: Array, task: Task) -> Problem:
    """Programme of this tick, from the loop's estimate corrected by the sample with the observer `gain`."""
    candidate, estimate = state.candidates[state.chosen], loop.estimate
    plan, observer, charge = candidate.plan, candidate.observer, state.given_uc
    if charge.size:
        charge = charge_room(mpc.horizon_charge_max_uc, charge, plan, state.fallback.planned,
                             estimate.strength, state.table)
    vectors = plan.vectors()
    fault = assemble_qp(
        observer.ladder, observer.c, observer.offset, gain, estimate.x, estimate.disturbance,
        estimate.strength, estimate.stamps, estimate.inputs, observer.period_ns, observer.delay_ns,
        estimate.at_ns, task.captured_ns, task.now_ns, task.measured, plan.free, plan.rows, plan.boxes,
        state.reach, mpc.slew, state.table, 1e-6 * mpc.charge_rise_uc, charge, loop.drive, loop.pulses,
        task.target, task.reference, *vectors)
    if fault != NOT_FINITE:
        estimate.at_ns = max(estimate.at_ns, task.captured_ns)
    return Problem(*vectors, fault)


SLACK = 1e-4
"""Tolerance on prescribed drives, so that the programme has an interior (chosen; without effect)."""


def solve_in_contact(
    mpc: MpcParameters, state: MpcState, now: Loop, problem: Problem, task: Task
) -> QpResult:
    """Solve `problem` with the drives of `grasping_channels` fixed to those of a simulated loop.

    The simulated loop starts as a copy of `now` and has the model as its plant, without measurements. Only
    its drives of `grasping_channels` reach the plant.
    """
    candidate = state.candidates[state.chosen]
    state.alone = alone = state.alone or now.copied()
    still = np.zeros_like(candidate.observer.gain)
    led = candidate.qp.solve_around(*build_problem(mpc, state, alone, still, task))
    if not led.solved:
        return led
    alone.drive = np.minimum(led.x[:alone.drive.size] / alone.estimate.strength, state.reach)
    issue_drive(state.table, alone.drive, alone.estimate.stamps, alone.estimate.inputs, task.now_ns,
                alone.pulses)
    _prescribe(mpc, problem, led.x, alone.drive.size)
    return candidate.qp.solve_around(*problem)


def _prescribe(mpc: MpcParameters, problem: Problem, led: Array, muscles: int) -> None:
    """Restrict `grasping_channels` to their drives in `led` (unknowns,), within the problem's bounds."""
    steps = np.arange(mpc.horizon)[:, np.newaxis] * muscles
    given = (steps + np.array(mpc.grasping_channels)).ravel()
    low = np.minimum(np.maximum(led[given] - SLACK, problem.lower[given]), problem.upper[given])
    problem.lower[given], problem.upper[given] = low, np.minimum(low + 2.0 * SLACK, problem.upper[given])
    problem.below[given] = problem.lower[given] - problem.best[given]
    problem.above[given] = problem.upper[given] - problem.best[given]
