"""The condensed quadratic programme of linear predictive control.

Over a horizon of N periods, with drives V = [v_0; ...; v_{N-1}] and y_j = C A^j x_0 + ... + d + offset,

    min  sum_j |y_j - r_j|^2_Q + sum_j |v_j - v_{j-1}|^2_R + effort |v_j|^2 + null |Z'v_j|^2
    0 <= v_j <= reach,  |v_j - v_{j-1}| <= slew

(Maciejowski 2002, Predictive Control with Constraints, chapter 3). Z spans the drives that move no output
in steady state (co-contraction), so weighing them leaves control free of offset, which `effort` does not;
where a muscle lies at its limit, that holds as far as `null` is small.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space

from fesloop.models.linear_model import SampledModel

Array = NDArray[np.float64]


class Weights(NamedTuple):
    """Weights of the cost: per output (outputs,), and scalars per unit of drive squared."""

    outputs: Array
    move: float
    effort: float
    null: float


class Plan(NamedTuple):
    """Matrices of the condensed programme; nothing here is ever written to.

    Attributes
    ----------
    hessian: (N muscles, N muscles).
    rows: (N muscles, N muscles), differences of drives.
    from_state: (states, N muscles), transposed map from x_0 to the linear term.
    from_target: (N outputs, N muscles), transposed map from d + offset - r to the linear term.
    from_previous: weight of the first difference.
    lower, upper: (2 N muscles,), with the first difference relative to v_{-1} = 0.
    """

    hessian: Array
    rows: Array
    from_state: Array
    from_target: Array
    from_previous: float
    lower: Array
    upper: Array


def make_plan(model: SampledModel, horizon: int, weights: Weights, reach: Array, slew: float) -> Plan:
    """Condense a sampled model over `horizon` periods; `reach` (muscles,) is the greatest drive."""
    outputs, muscles = model.c.shape[0], model.b.shape[1]
    lifted = model.lifted(horizon + 1)[outputs:, :horizon * muscles]
    free, power = [], np.eye(model.a.shape[0])
    for _ in range(horizon):
        power = model.a @ power
        free.append(model.c @ power)
    weighted = lifted.T * np.tile(weights.outputs, horizon)
    size = horizon * muscles
    rows = np.eye(size) - np.eye(size, k=-muscles)
    steady = model.c @ np.linalg.solve(np.eye(model.a.shape[0]) - model.a, model.b)
    idle = null_space(steady)
    hessian = weighted @ lifted + weights.move * rows.T @ rows + weights.effort * np.eye(size)
    hessian += weights.null * np.kron(np.eye(horizon), idle @ idle.T)
    return Plan(
        0.5 * (hessian + hessian.T), rows, np.ascontiguousarray((weighted @ np.vstack(free)).T),
        np.ascontiguousarray(weighted.T), weights.move,
        np.concatenate([np.zeros(size), np.full(size, -slew)]),
        np.concatenate([np.tile(reach, horizon), np.full(size, slew)]))


@numba.njit(cache=True)
def fill(
    from_state: Array, from_target: Array, from_previous: float, plan_lower: Array, plan_upper: Array,
    state: Array, previous: Array, shift: Array, reference: Array,
) -> tuple[Array, Array, Array]:
    """(q, lower, upper) of the programme at this tick, fresh; the first five are those of `Plan`.

    Parameters
    ----------
    state: (states,), of the sampled model.
    previous: (muscles,), the drive in force.
    shift: (outputs,), disturbance plus offset.
    reference: (N, outputs).

    Sums run in a fixed order, so equal numbers give equal bits wherever they lie in memory.
    """
    size = from_state.shape[1]
    q = np.zeros(size)
    for j in range(state.size):
        for i in range(size):
            q[i] += from_state[j, i] * state[j]
    outputs = shift.size
    for j in range(from_target.shape[0]):
        target = shift[j % outputs] - reference[j // outputs, j % outputs]
        for i in range(size):
            q[i] += from_target[j, i] * target
    lower, upper = plan_lower.copy(), plan_upper.copy()
    for i in range(previous.size):
        q[i] -= from_previous * previous[i]
        lower[size + i] += previous[i]
        upper[size + i] += previous[i]
    return q, lower, upper
