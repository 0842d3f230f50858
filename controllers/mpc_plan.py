"""The condensed quadratic programme of linear predictive control.

Over a horizon of N periods, with drives V = [v_0; ...; v_{N-1}] and y_j = C A^j x_0 + ... + d + offset,

    min  sum_j |y_j - r_j|^2_Q + sum_j |v_j - v_{j-1}|^2_R + effort |v_j|^2 + cocontraction |Z'v_j|^2
    0 <= v_j <= reach,  |v_j - v_{j-1}| <= slew,  v_0 <= rise

(Maciejowski 2002, Predictive Control with Constraints, chapter 3). Z spans the drives that move no output
in steady state (co-contraction), so weighing them leaves control free of offset, which `effort` does not;
where a muscle lies at its limit, that holds as far as `cocontraction` is small. `rise` is the drive that
the rise of charge allows at this tick; at later ticks it follows the pulse then in force.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, null_space

from fesloop.models.linear_model import SampledModel

Array = NDArray[np.float64]


class Weights(NamedTuple):
    """Weights of the cost: per output (outputs,), and scalars per unit of drive squared."""

    outputs: Array
    move: float
    effort: float
    cocontraction: float


class Plan(NamedTuple):
    """Matrices of the condensed programme; nothing here is ever written to.

    Attributes
    ----------
    hessian: (N muscles, N muscles).
    rows: (N muscles, N muscles), differences of drives.
    free: (states + N outputs + muscles, N muscles), transposed map from x_0, from d + offset - r and from
        the drive in force to the drives that would be best without limits.
    """

    hessian: Array
    rows: Array
    free: Array


def make_plan(model: SampledModel, horizon: int, weights: Weights) -> Plan:
    """Condense a sampled model over `horizon` periods."""
    outputs, muscles = model.c.shape[0], model.b.shape[1]
    lifted = model.lifted(horizon + 1)[outputs:, :horizon * muscles]
    responses, power = [], np.eye(model.a.shape[0])
    for _ in range(horizon):
        power = model.a @ power
        responses.append(model.c @ power)
    weighted = lifted.T * np.tile(weights.outputs, horizon)
    size = horizon * muscles
    rows = np.eye(size) - np.eye(size, k=-muscles)
    steady = model.c @ np.linalg.solve(np.eye(model.a.shape[0]) - model.a, model.b)
    idle = null_space(steady)
    hessian = weighted @ lifted + weights.move * rows.T @ rows + weights.effort * np.eye(size)
    hessian += weights.cocontraction * np.kron(np.eye(horizon), idle @ idle.T)
    hessian = 0.5 * (hessian + hessian.T)
    linear = np.vstack([(weighted @ np.vstack(responses)).T, weighted.T,
                        -weights.move * np.eye(muscles, size)])
    return Plan(hessian, rows, np.ascontiguousarray(-cho_solve(cho_factor(hessian), linear.T).T))


@numba.njit(cache=True)
def free_optimum(
    free: Array, present: Array, shift: Array, reference: Array, previous: Array, drives: Array
) -> None:
    """Fill `drives` (N muscles,) with those that would be best without limits; `free` is that of `Plan`.

    Parameters
    ----------
    present: (states,), of the sampled model.
    shift: (outputs,), disturbance plus offset.
    reference: (N, outputs).
    previous: (muscles,), the drive in force.

    Sums run in a fixed order, so equal numbers give equal bits wherever they lie in memory.
    """
    known = np.empty(free.shape[0])
    known[:present.size] = present
    at = present.size
    for k in range(reference.shape[0]):
        for j in range(shift.size):
            known[at] = shift[j] - reference[k, j]
            at += 1
    known[at:] = previous
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


@numba.njit(cache=True)
def limits(
    reach: Array, slew: Array, previous: Array, rise: Array, lower: Array, upper: Array
) -> None:
    """Fill the bounds of the programme at this tick, (2 N muscles,), boxes before differences.

    Parameters
    ----------
    reach, slew: (muscles,), greatest drive and greatest change of it a tick.
    previous: (muscles,), the drive in force.
    rise: (muscles,), greatest drive of this tick, above `previous`.
    """
    muscles = reach.size
    size = lower.size // 2
    for k in range(size // muscles):
        for i in range(muscles):
            at = k * muscles + i
            lower[at], upper[at] = 0.0, reach[i]
            lower[size + at], upper[size + at] = -slew[i], slew[i]
    for i in range(muscles):
        lower[size + i] += previous[i]
        upper[size + i] = min(previous[i] + slew[i], rise[i])
