"""The condensed quadratic programme of linear predictive control.

Over a horizon of N periods, with drives V = [v_0; ...; v_{N-1}] and y_j = C A^j x_0 + ... + d + offset,

    min  1/2 sum_j |y_j - r_j|^2_Q + |v_j - v_{j-1}|^2_R + effort |v_j|^2 + cocontraction |Z'v_j|^2
         + price sum_j (e_j + e_j^2 / (2 knee))
    0 <= v_j <= reach,  |v_j - v_{j-1}| <= slew,  v_0 <= rise,  s'(v_0 + ... + v_j) <= charge_j
    least - e_j <= y_j <= greatest + e_j,  e_j >= 0

(Maciejowski 2002, Predictive Control with Constraints, chapter 3). Z spans the drives that move no output
in steady state (co-contraction), so weighing them leaves control free of offset, which `effort` does not;
where a muscle lies at its limit, that holds as far as `cocontraction` is small. `rise` is the drive that
the rise of charge allows at this tick; at later ticks it depends on the pulse then. s is the charge per
drive of each muscle; charge_j is what the charge limit over any N successive ticks leaves for the next j.

Boxes of angles are soft, so that a posture outside them never leaves the programme without an answer. Their
price is exact (Kerrigan and Maciejowski 2000, "Soft constraints and exact penalty functions in model
predictive control"): an angle leaves its box only where no admissible drive keeps it in, as long as the price
is above the multipliers of the hard box. It is N x the greatest weight x 1 rad, the pull over the whole
horizon of a reference 1 rad beyond the box. Outputs within the delay, which no drive moves, have no box.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, cho_factor, cho_solve, null_space

from controllers.allocation import planned_charge
from fesloop.compiled import assign, compiled
from fesloop.models.linear_model import SampledModel

Array = NDArray[np.float64]
KNEE_RAD = 0.1
"""Excess at which the price of leaving a box has doubled (chosen: about 6 deg)."""


class Weights(NamedTuple):
    """Weights of the cost: per output (outputs,), and scalars per unit of drive squared."""

    outputs: Array
    move: float
    effort: float
    cocontraction: float


class Limits(NamedTuple):
    """Limits that enter the matrices of the programme.

    Attributes
    ----------
    least, greatest: (outputs,) rad, boxes of the outputs; infinite where there is none.
    charge_slopes: (muscles,), charge per drive as a fraction of the limit; of size 0 without a limit.
    """

    least: Array
    greatest: Array
    charge_slopes: Array


class Plan(NamedTuple):
    """Constant matrices of the condensed programme.

    The unknowns are the drives, (N muscles,), then, where an output has a box, the excess of every output at
    every step, (N outputs,).

    Attributes
    ----------
    hessian: (unknowns, unknowns).
    rows: (constraints, unknowns): differences of drives, sums of charge where it is limited, boxes.
    free: (states + N outputs + muscles, unknowns), transposed map from x_0, d + offset - r and the last drive
        to the optimal drives without limits, and to y - r without drives.
    boxes: (boxes, 3), for each row that is a box: index of the step's output, least and greatest, rad.
    """

    hessian: Array
    rows: Array
    free: Array
    boxes: Array

    def vectors(self) -> tuple[Array, Array, Array, Array, Array]:
        """New arrays for one tick: the unknowns, then four times bounds of unknowns and rows."""
        unknowns, bounded = self.rows.shape[1], sum(self.rows.shape)
        return (np.empty(unknowns), np.empty(bounded), np.empty(bounded), np.empty(bounded),
                np.empty(bounded))


def make_plan(model: SampledModel, horizon: int, weights: Weights, bounds: Limits) -> Plan:
    """Condense a sampled model over `horizon` periods."""
    outputs, muscles = model.c.shape[0], model.b.shape[1]
    lifted = model.lifted(horizon + 1)[outputs:, :horizon * muscles]
    responses, power = [], np.eye(model.a.shape[0])
    for _ in range(horizon):
        power = model.a @ power
        responses.append(model.c @ power)
    response, size = np.vstack(responses), horizon * muscles
    weighted = lifted.T * np.tile(weights.outputs, horizon)
    rows = np.eye(size) - np.eye(size, k=-muscles)
    steady = model.c @ np.linalg.solve(np.eye(model.a.shape[0]) - model.a, model.b)
    idle = null_space(steady)
    hessian = weighted @ lifted + weights.move * rows.T @ rows + weights.effort * np.eye(size)
    hessian += weights.cocontraction * np.kron(np.eye(horizon), idle @ idle.T)
    hessian = 0.5 * (hessian + hessian.T)
    linear = np.vstack([(weighted @ response).T, weighted.T, -weights.move * np.eye(muscles, size)])
    free = -cho_solve(cho_factor(hessian), linear.T).T
    if bounds.charge_slopes.size:
        rows = np.vstack([rows, np.kron(np.tri(horizon), bounds.charge_slopes)])
    boxed, boxes = _boxes(lifted, horizon, model.delay_steps, bounds)
    if boxes.size:
        price = horizon * weights.outputs.max() * 1.0
        hessian = block_diag(hessian, price / KNEE_RAD * np.eye(horizon * outputs))
        rows = np.vstack([np.hstack([rows, np.zeros((rows.shape[0], horizon * outputs))]), boxed])
        unmoved = np.vstack([response.T, np.eye(horizon * outputs), np.zeros((muscles, horizon * outputs))])
        free = np.hstack([free, unmoved])
    return Plan(hessian, rows, np.ascontiguousarray(free), boxes)


def _boxes(lifted: Array, horizon: int, delay_steps: int, bounds: Limits) -> tuple[Array, Array]:
    """Rows on drives and excesses, one for each finite end of a box, and `Plan.boxes` (boxes, 3)."""
    outputs = bounds.least.size
    excess, rows, boxes = np.eye(horizon * outputs), [], []
    for at in range(delay_steps * outputs, horizon * outputs):
        least, greatest = bounds.least[at % outputs], bounds.greatest[at % outputs]
        if np.isfinite(least):
            rows.append(np.concatenate([lifted[at], excess[at]]))
            boxes.append((at, least, np.inf))
        if np.isfinite(greatest):
            rows.append(np.concatenate([lifted[at], -excess[at]]))
            boxes.append((at, -np.inf, greatest))
    return np.array(rows), np.array(boxes, dtype=np.float64).reshape(-1, 3)


def charge_room(
    budget_uc: float, given_uc: Array, plan: Plan, planned: Array, strength: Array, table: Array
) -> Array:
    """Remaining charge for the next 1 ... N ticks, (N,), as fractions of the limit.

    Parameters
    ----------
    budget_uc: limit over any N successive ticks, on all channels together.
    given_uc: (N,), charge of the last N ticks, oldest first.
    planned: last solution, at which the linearised charge is made exact; of size 0 before the first.
    strength: (muscles,), ratio of the programme's drives to the issued ones.
    table: as in `allocate`.
    """
    steps, muscles = given_uc.size, strength.size
    sums = plan.rows[steps * muscles:steps * (muscles + 1), :steps * muscles]
    exact = 1.0
    if planned.size:
        drives = planned[:steps * muscles]
        actual_uc = 1e6 * planned_charge(table, drives.reshape(steps, muscles) / strength)
        exact = float(sums[-1] @ drives) * budget_uc / actual_uc if actual_uc > 0.0 else 1.0
    before_uc = np.append(np.cumsum(given_uc[:0:-1])[::-1], 0.0)
    left: Array = np.maximum(exact * (1.0 - before_uc / budget_uc), 0.0)
    return left


@compiled
def free_optimum(
    free: Array, present: Array, shift: Array, reference: Array, previous: Array, drives: Array
) -> None:
    """Fill `drives` (unknowns,) with the optimal ones without limits; `free` is as in `Plan`.

    After the drives, in place of excesses, follows y - r without drives, (N outputs,).

    Parameters
    ----------
    present: (states,), state of the sampled model.
    shift: (outputs,), disturbance plus offset.
    reference: (N, outputs).
    previous: (muscles,), drive of the last tick.

    Sums run in a fixed order, so that equal numbers give equal bits wherever they lie in memory.
    """
    known = np.empty(free.shape[0])
    assign(known[:present.size], present)
    at = present.size
    for k in range(reference.shape[0]):
        for j in range(shift.size):
            known[at] = shift[j] - reference[k, j]
            at += 1
    assign(known[at:], previous)
    drives[:] = 0.0
    # Four rows at a time: the sum is read and written a quarter as often.
    whole = known.size - known.size % 4
    for j in range(0, whole, 4):
        a, b, c, d = known[j], known[j + 1], known[j + 2], known[j + 3]
        for i in range(drives.size):
            drives[i] += a * free[j, i] + b * free[j + 1, i] + c * free[j + 2, i] + d * free[j + 3, i]
    for j in range(whole, known.size):
        for i in range(drives.size):
            drives[i] += known[j] * free[j, i]


@compiled
def limits(
    reach: Array, slew: Array, previous: Array, rise: Array, charge: Array, boxes: Array, reference: Array,
    best: Array, lower: Array, upper: Array,
) -> None:
    """Fill the bounds of the programme at this tick, (unknowns + constraints,), boxes before rows.

    Parameters
    ----------
    reach, slew: (muscles,), greatest drive and greatest change of it a tick.
    previous: (muscles,), drive of the last tick.
    rise: (muscles,), greatest drive of this tick, above `previous`.
    charge: from `charge_room`; of size 0 without a limit on charge.
    boxes: as in `Plan`.
    reference: (N, outputs).
    best: from `free_optimum`; its entries after the drives become the excesses of least cost.
    """
    muscles, unknowns = reach.size, best.size
    size = reference.shape[0] * muscles
    for k in range(reference.shape[0]):
        for i in range(muscles):
            at = k * muscles + i
            lower[at], upper[at] = 0.0, reach[i]
            lower[unknowns + at], upper[unknowns + at] = -slew[i], slew[i]
    for i in range(muscles):
        lower[unknowns + i] += previous[i]
        upper[unknowns + i] = min(previous[i] + slew[i], rise[i])
    first = unknowns + size
    for k in range(charge.size):
        lower[first + k], upper[first + k] = -np.inf, charge[k]
    first += charge.size
    for row in range(boxes.shape[0]):
        at = int(boxes[row, 0])
        unmoved = best[size + at] + reference[at // reference.shape[1], at % reference.shape[1]]
        lower[first + row], upper[first + row] = boxes[row, 1] - unmoved, boxes[row, 2] - unmoved
    for at in range(size, unknowns):
        best[at], lower[at], upper[at] = -KNEE_RAD, 0.0, np.inf
