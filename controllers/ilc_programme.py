"""The norm-optimal change of a trial's drives with the limits of stimulation inside the minimisation.

    min |e - G d|^2_W + rho |d|^2   subject to   v + d inside the limits

OSQP gets it with the model's states as unknowns beside d, x_{k+1} = A x_k + B d_k: its matrices then grow
with the samples, not with their square. daqp, being dense, gets it condensed.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from controllers.ilc_limits import Limits
from controllers.qp import Qp, QpResult
from controllers.qp_sparse import solve_sparse
from fesloop.models.linear_model import SampledModel

Array = NDArray[np.float64]
SolverName = Literal["daqp", "osqp"]
_CHARGE_PASSES = 2
"""Programmes solved one after the other where charge is limited, the second about the first's answer
(chosen: the first, about no drive, leaves much of the budget)."""
_ITERATIONS = 4000
"""(chosen: some seconds; programmes without charge take some tens.)"""
_TOLERANCE = 1e-4
"""On drives of 0 to 1 (chosen: 1 us of pulse width is worth some 1e-2 where a curve is steep)."""


def limited_change(
    model: SampledModel, errors: Array, weights: Array, change_weight: float, drives: Array, limits: Limits,
    solver: SolverName,
) -> tuple[Array, str]:
    """(d, status): the change (samples, muscles), and "" or why the solver gave none.

    Parameters
    ----------
    errors, weights: e and the diagonal of W, (samples, outputs).
    drives: v (samples, muscles), inside the limits.
    """
    solve = _structured if solver == "osqp" else _condensed
    change, result = np.zeros_like(drives), None
    for _ in range(_CHARGE_PASSES if limits.counts_charge else 1):
        rows = _limit_rows(drives, change, limits)
        result = solve(model, errors, weights, change_weight, rows, drives, limits, result)
        if not result.solved:
            return np.zeros_like(drives), result.status
        change = result.x[:drives.size].reshape(drives.shape)
    return change, ""


def _limit_rows(drives: Array, change: Array, limits: Limits) -> tuple[sparse.csc_matrix, Array, Array]:
    """(rows on d, their lower and upper bounds): slew, and charge where it is limited.

    Charge is no linear function of drive: the mean drive may be what it takes by the slopes at `drives` +
    `change`.
    """
    size, muscles = drives.size, drives.shape[1]
    rows = [sparse.csc_matrix(sparse.eye(size) - sparse.eye(size, k=-muscles))]
    rise = np.diff(drives, axis=0, prepend=0.0).ravel()
    lower, upper = [-limits.slew - rise], [limits.slew - rise]
    if limits.counts_charge:
        slopes = limits.charge_slopes(np.clip(drives + change, 0.0, limits.reach))
        share = 1.0 / drives.shape[0]
        means = sparse.kron(np.full((1, drives.shape[0]), share), sparse.eye(muscles))
        rows.append(sparse.csc_matrix(means))
        lower.append(np.full(muscles, -np.inf))
        upper.append(share * (limits.charge_c / slopes - drives.sum(axis=0)))
    return sparse.vstack(rows, format="csc"), np.concatenate(lower), np.concatenate(upper)


def _structured(
    model: SampledModel, errors: Array, weights: Array, change_weight: float,
    limit_rows: tuple[sparse.csc_matrix, Array, Array], drives: Array, limits: Limits,
    before: QpResult | None,
) -> QpResult:
    """Unknowns d and x_1 ... x_{samples-1}, states from rest."""
    samples, size, states = drives.shape[0], drives.size, model.a.shape[0]
    later = (samples - 1) * states
    rows, row_lower, row_upper = limit_rows
    stages = [(model.c.T * weights[k]) @ model.c for k in range(1, samples)]
    hessian = sparse.block_diag([change_weight * sparse.eye(size), *stages], format="csc")
    linear = np.concatenate([np.zeros(size), (-(weights * errors)[1:] @ model.c).ravel()])
    dynamics = sparse.hstack([
        sparse.kron(sparse.eye(samples - 1, samples), model.b),
        sparse.kron(sparse.eye(samples - 1, k=-1), model.a) - sparse.eye(later)])
    scale = size / (change_weight * size + _curvature(model, weights))
    free = np.full(later, np.inf)
    return solve_sparse(
        sparse.csc_matrix(scale * hessian),
        sparse.vstack([dynamics, sparse.hstack([rows, sparse.csc_matrix((rows.shape[0], later))])],
                      format="csc"),
        scale * linear,
        np.concatenate([-drives.ravel(), -free, np.zeros(later), row_lower]),
        np.concatenate([(limits.reach - drives).ravel(), free, np.zeros(later), row_upper]),
        tolerance=_TOLERANCE, max_iterations=_ITERATIONS, start=before)


def _curvature(model: SampledModel, weights: Array) -> float:
    """Trace of G'WG: sum over outputs of their weight times the squared response to all drives before."""
    total, power, strength = 0.0, model.b, np.zeros(model.c.shape[0])
    for k in range(1, weights.shape[0]):
        strength += np.sum((model.c @ power) ** 2, axis=1)
        power = model.a @ power
        total += float(weights[k] @ strength)
    return total


def _condensed(
    model: SampledModel, errors: Array, weights: Array, change_weight: float,
    limit_rows: tuple[sparse.csc_matrix, Array, Array], drives: Array, limits: Limits,
    before: QpResult | None,
) -> QpResult:
    """Unknowns d alone."""
    size = drives.size
    lifted = model.lifted(drives.shape[0])
    weighted = lifted.T * weights.ravel()
    hessian = weighted @ lifted + change_weight * np.eye(size)
    scale = 1.0 / np.mean(np.diag(hessian))
    rows, row_lower, row_upper = limit_rows
    programme = Qp(scale * 0.5 * (hessian + hessian.T), rows.toarray(), solver="daqp", tolerance=_TOLERANCE,
                   max_iterations=_ITERATIONS)
    if before is not None:
        programme.start_from(before.x, before.multipliers)
    return programme.solve(-scale * weighted @ errors.ravel(),
                           np.concatenate([-drives.ravel(), row_lower]),
                           np.concatenate([(limits.reach - drives).ravel(), row_upper]))
