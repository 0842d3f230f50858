"""The norm-optimal change of a trial's drives with the limits of stimulation inside the minimisation.

    min |e - G d|^2_W + rho |d|^2   subject to   v + d inside the limits

OSQP gets it with the model's states as unknowns beside d, x_{k+1} = A x_k + B d_k: its matrices then grow
with the samples, not with their square. daqp, being dense, gets it condensed.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import block_diag

from controllers.ilc.limits import Limits
from controllers.qp.dense import Qp, QpResult
from controllers.qp.sparse import solve_sparse
from fesloop.models.linear_model import SampledModel

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
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
    solver: SolverName, kept: Mask | None = None,
) -> tuple[Array, str]:
    """(d, status): the change (samples, muscles), and "" or why the solver gave none.

    Charge is no linear function of drive: it is taken by the slopes at the trial's drives, then by those at
    the answer.

    Parameters
    ----------
    errors, weights: e and the diagonal of W, (samples, outputs).
    drives: v (samples, muscles), inside the limits.
    kept: (samples, muscles), drives that stay as they are; None for none.
    """
    solve = _structured if solver == "osqp" else _condensed
    change, result = np.zeros_like(drives), None
    for _ in range(_CHARGE_PASSES if limits.counts_charge else 1):
        programme = _Programme(model, errors, weights, change_weight, drives, limits, change, kept)
        result = solve(programme, result)
        if not result.solved:
            return np.zeros_like(drives), result.status
        change = result.x[:drives.size].reshape(drives.shape)
    return change, ""


class _Programme(NamedTuple):
    """What is to be solved; `change` is where the slopes of charge are taken."""

    model: SampledModel
    errors: Array
    weights: Array
    change_weight: float
    drives: Array
    limits: Limits
    change: Array
    kept: Mask | None = None

    @property
    def box(self) -> tuple[Array, Array]:
        """Bounds of d, flat."""
        free = np.ones_like(self.drives) if self.kept is None else np.where(self.kept, 0.0, 1.0)
        return (-free * self.drives).ravel(), (free * (self.limits.reach - self.drives)).ravel()

    def slew_rows(self) -> tuple[sparse.csc_matrix, Array, Array]:
        """(rows on d, their lower and upper bounds)."""
        size, slew = self.drives.size, self.limits.slew
        rise = np.diff(self.drives, axis=0, prepend=0.0).ravel()
        rows = sparse.csc_matrix(sparse.eye(size) - sparse.eye(size, k=-self.drives.shape[1]))
        return rows, -slew - rise, slew - rise

    def room(self) -> Array:
        """(muscles,), what the sum of d over the trial may be for the charge."""
        slopes = self.limits.charge_slopes(np.clip(self.drives + self.change, 0.0, self.limits.reach))
        room: Array = self.limits.charge_c / slopes - self.drives.sum(axis=0)
        return room


def _structured(programme: _Programme, before: QpResult | None) -> QpResult:
    """Unknowns d and x_1 ... x_{samples-1}, states from rest.

    Where charge is limited, the sums of the drives are states too: as rows over a whole trial they would
    cost OSQP ten times the iterations.
    """
    model, limits, size = programme.model, programme.limits, programme.drives.size
    samples, muscles = programme.drives.shape
    if limits.counts_charge:
        model = _with_sums(model, 1.0 / math.sqrt(samples))
    states = model.a.shape[0]
    later = (samples - 1) * states
    stages = [(model.c.T * weights) @ model.c for weights in programme.weights[1:]]
    hessian = sparse.block_diag([programme.change_weight * sparse.eye(size), *stages], format="csc")
    pull = -((programme.weights * programme.errors)[1:] @ model.c).ravel()
    scale = size / (programme.change_weight * size + _curvature(model, programme.weights))
    slew, slew_lower, slew_upper = programme.slew_rows()
    rows = [sparse.hstack([sparse.kron(sparse.eye(samples - 1, samples), model.b),
                           sparse.kron(sparse.eye(samples - 1, k=-1), model.a) - sparse.eye(later)]),
            sparse.hstack([slew, sparse.csc_matrix((size, later))])]
    free = np.full(later, np.inf)
    lower = [programme.box[0], -free, np.zeros(later), slew_lower]
    upper = [programme.box[1], free, np.zeros(later), slew_upper]
    if limits.counts_charge:
        share = 1.0 / math.sqrt(samples)
        last = sparse.eye(muscles, size, k=size - muscles)
        rows.append(sparse.hstack([share * last, sparse.eye(muscles, later, k=later - muscles)]))
        lower.append(np.full(muscles, -np.inf))
        upper.append(share * programme.room())
    return solve_sparse(sparse.csc_matrix(scale * hessian), sparse.vstack(rows, format="csc"),
                        scale * np.concatenate([np.zeros(size), pull]), np.concatenate(lower),
                        np.concatenate(upper), tolerance=_TOLERANCE, max_iterations=_ITERATIONS, start=before)


def _with_sums(model: SampledModel, share: float) -> SampledModel:
    """The model with the sums of its drives so far, times `share`, as last states that do not show."""
    muscles = model.b.shape[1]
    return replace(model, a=block_diag(model.a, np.eye(muscles)),
                   b=np.vstack([model.b, share * np.eye(muscles)]),
                   c=np.hstack([model.c, np.zeros((model.c.shape[0], muscles))]))


def _curvature(model: SampledModel, weights: Array) -> float:
    """Trace of G'WG: sum over outputs of their weight times the squared response to all drives before."""
    total, power, strength = 0.0, model.b, np.zeros(model.c.shape[0])
    for k in range(1, weights.shape[0]):
        strength += np.sum((model.c @ power) ** 2, axis=1)
        power = model.a @ power
        total += float(weights[k] @ strength)
    return total


def _condensed(programme: _Programme, before: QpResult | None) -> QpResult:
    """Unknowns d alone."""
    size, muscles = programme.drives.size, programme.drives.shape[1]
    lifted = programme.model.lifted(programme.drives.shape[0])
    weighted = lifted.T * programme.weights.ravel()
    hessian = weighted @ lifted + programme.change_weight * np.eye(size)
    scale = 1.0 / np.mean(np.diag(hessian))
    slew, slew_lower, slew_upper = programme.slew_rows()
    rows, lower, upper = [slew.toarray()], [programme.box[0], slew_lower], [programme.box[1], slew_upper]
    if programme.limits.counts_charge:
        rows.append(np.tile(np.eye(muscles), (1, programme.drives.shape[0])))
        lower.append(np.full(muscles, -np.inf))
        upper.append(programme.room())
    solver = Qp(scale * 0.5 * (hessian + hessian.T), np.vstack(rows), solver="daqp", tolerance=_TOLERANCE,
                max_iterations=_ITERATIONS)
    if before is not None:
        solver.start_from(before.x, before.multipliers)
    return solver.solve(-scale * weighted @ programme.errors.ravel(), np.concatenate(lower),
                        np.concatenate(upper))
