"""Learning laws: drives of the next trial from those of the last and their error.

With drives v and errors e = r - y stacked over a trial, y = G v + y_0, weights W (0 where an output was not
observed), v' = first + (1 - forgetting) (v - first) and the limits of `Limits`:

    phase_lead          v+ = Q (v' + gain K^+ e shifted forward by the lead), then clipped
    gradient            v+ = v' + step / |G'WG| G'W e, then clipped
    noilc               v+ = v' + (G'WG + rho I)^-1 G'W e, then clipped
    noilc_constrained   v+ = v' + argmin |e - G d|^2_W + rho |d|^2 with v' + d inside the limits
    point_to_point      the same, W zero but at the chosen instants and outputs
    newton              noilc in pulse widths, G linearised about the last trial through the recruitment

K is the static gain and Q a zero-phase low-pass. Instants without a measurement change nothing, so that the
laws learn from trials of any length (variable pass length: Seel, Schauer and Raisch 2017, Int. J. Control
90(3), 393).

Sources: Bristow, Tharayil and Alleyne 2006 (doi 10.1109/MCS.2006.1636313) for phase-lead; Owens, Hatonen and
Daley 2009 (doi 10.1002/rnc.1338) for the gradient; Amann, Owens and Rogers 1996 (doi
10.1049/ip-cta:19960244) for norm-optimal; Freeman and Tan 2013 (IEEE Trans. Control Syst. Technol. 21(3),
604) for points and limits; Lin, Owens and Hatonen 2006 (Int. J. Control 79(10), 1263) for Newton;
Heinzinger et al. 1992 (doi 10.1109/9.109645) for forgetting.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import block_diag

from controllers.allocation import Allocation, allocate
from controllers.quadratic_programme import Qp, QpResult, solve_sparse
from controllers.trajectories import adjoint, optimal_change, response, strongest
from fesloop.errors import InputError
from fesloop.models.linear_model import SampledModel

Array = NDArray[np.float64]
_CHARGE_HALVINGS = 40
_LEAST_DRIVE = 0.01
"""Sum of a channel's drives over a trial below which it counts as at rest (chosen: 1 % of a muscle, once)."""


def pulses_of(allocation: Allocation, drives: Array) -> Array:
    """Pulses (samples, muscles, 2) in A and s from drives (samples, muscles)."""
    pulses, table = np.empty((*drives.shape, 2)), allocation.table()
    for k, drive in enumerate(np.ascontiguousarray(drives)):
        allocate(table, drive, pulses[k])
    return pulses


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Limits:
    """Limits 0 <= v <= reach, |v_k - v_{k-1}| <= slew from rest, and of each channel's charge in a trial.

    Attributes
    ----------
    reach: (muscles,), greatest drive.
    slew: greatest change of a drive a tick.
    allocation: conversion of drives to pulses, where charge is limited; else None.
    charge_c: limit on the charge of each channel over a trial, one pulse a tick, C; infinite for none.
    """

    reach: Array
    slew: float
    allocation: Allocation | None = None
    charge_c: float = np.inf

    @property
    def counts_charge(self) -> bool:
        """Whether charge is limited."""
        return self.allocation is not None and bool(np.isfinite(self.charge_c))

    def within(self, drives: Array) -> Array:
        """Drives clipped to their box, then tick by tick to the slew limit, then scaled to the charge."""
        limited = np.clip(drives, 0.0, self.reach)
        before = np.zeros(drives.shape[1])
        for k in range(drives.shape[0]):
            before = limited[k] = np.clip(limited[k], before - self.slew, before + self.slew)
        if not self.counts_charge:
            return limited
        low, high = np.zeros(drives.shape[1]), np.ones(drives.shape[1])
        if (self.charges(limited) <= self.charge_c).all():
            return limited
        for _ in range(_CHARGE_HALVINGS):
            middle = 0.5 * (low + high)
            fits = self.charges(middle * limited) <= self.charge_c
            low, high = np.where(fits, middle, low), np.where(fits, high, middle)
        return np.where(self.charges(limited) <= self.charge_c, 1.0, low) * limited

    def charges(self, drives: Array) -> Array:
        """Charge of each channel over the trial, (muscles,) C; zero where it is not limited."""
        if self.allocation is None:
            return np.zeros(drives.shape[1])
        pulses = pulses_of(self.allocation, drives)
        total: Array = np.abs(pulses[:, :, 0] * pulses[:, :, 1]).sum(axis=0)
        return total

    def charge_slopes(self, drives: Array) -> Array:
        """Charge per unit of drive over a trial, (muscles,) C, for the programme's linear limit on charge.

        There is one value a channel, for the whole trial: exact at `drives`, and for a channel at rest in
        these that of half its reach.
        """
        if self.allocation is None:
            return np.zeros(drives.shape[1])
        total = drives.sum(axis=0)
        resting = total < _LEAST_DRIVE
        half = np.tile(0.5 * np.minimum(self.reach, 1.0), (1, 1))
        slopes: Array = np.where(resting, self.charges(half) / half[0],
                                 self.charges(drives) / np.maximum(total, _LEAST_DRIVE))
        return slopes


Mask = NDArray[np.bool_]
SolverName = Literal["daqp", "osqp"]
_CHARGE_PASSES = 2
"""Number of programmes solved where charge is limited, each linearised at the solution before (chosen: the
first, linearised at zero drive, uses much less charge than allowed)."""
_ITERATIONS = 4000
"""Most iterations (chosen: some seconds; programmes without charge take some tens)."""
_TOLERANCE = 1e-4
"""Tolerance on drives of 0 to 1 (chosen: 1 us of pulse width changes them by 1e-2 on a steep curve)."""


def limited_change(
    model: SampledModel, errors: Array, weights: Array, change_weight: float, drives: Array, limits: Limits,
    solver: SolverName, kept: Mask | None = None,
) -> tuple[Array, str]:
    """Change d (samples, muscles), and a status: "" or why the solver gave none.

    Charge is not linear in drive: it is linearised at the trial's drives, then at the solution.

    Parameters
    ----------
    errors, weights: e and the diagonal of W, (samples, outputs).
    drives: v (samples, muscles), inside the limits.
    kept: (samples, muscles), drives that do not change; None for none.
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
    """Quadratic programme of one trial; charge is linearised at `change`."""

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
        """Lower and upper bounds of d, flat."""
        free = np.ones_like(self.drives) if self.kept is None else np.where(self.kept, 0.0, 1.0)
        return (-free * self.drives).ravel(), (free * (self.limits.reach - self.drives)).ravel()

    def slew_rows(self) -> tuple[sparse.csc_matrix, Array, Array]:
        """Rows of the slew limit on d, with lower and upper bounds."""
        size, slew = self.drives.size, self.limits.slew
        rise = np.diff(self.drives, axis=0, prepend=0.0).ravel()
        rows = sparse.csc_matrix(sparse.eye(size) - sparse.eye(size, k=-self.drives.shape[1]))
        return rows, -slew - rise, slew - rise

    def room(self) -> Array:
        """Largest sum of d over the trial that the charge allows, (muscles,)."""
        slopes = self.limits.charge_slopes(np.clip(self.drives + self.change, 0.0, self.limits.reach))
        room: Array = self.limits.charge_c / slopes - self.drives.sum(axis=0)
        return room


def _structured(programme: _Programme, before: QpResult | None) -> QpResult:
    """Programme with the unknowns d and x_1 ... x_{samples-1}, states from rest.

    Where charge is limited, the sums of the drives are states too: as rows over a whole trial they cost OSQP
    ten times the iterations.
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
    """The model with the cumulative sums of its drives, times `share`, as additional last states."""
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
    """Programme with the unknowns d alone."""
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


_HALVINGS = 7
_NUDGE = 1e-3
"""Half the step of the central difference, as a share of the longest pulse."""


class PulseCurves(Protocol):
    """Conversion between drives and pulse widths, each width a share of the channel's longest."""

    def widths(self, drives: Array) -> Array:
        """Widths (samples, muscles) for drives (samples, muscles)."""

    def drives(self, widths: Array) -> Array:
        """Drives (samples, muscles) for widths (samples, muscles), 0 or more."""


@dataclass(frozen=True, slots=True)
class AllocatedCurves:
    """Recruitment curves of an allocation."""

    allocation: Allocation

    def widths(self, drives: Array) -> Array:
        """Widths for drives, as shares of the longest."""
        shares: Array = pulses_of(self.allocation, drives)[:, :, 1] / self._longest_s
        return shares

    def drives(self, widths: Array) -> Array:
        """Drives for widths."""
        recruitment = self.allocation.recruitment
        if recruitment is None:
            return np.maximum(widths, 0.0)
        currents = np.asarray(self.allocation.current_ma) / 1e3
        return np.stack([recruitment.fraction(np.column_stack([currents, row]))
                         for row in self._longest_s * np.maximum(widths, 0.0)])

    @property
    def _longest_s(self) -> float:
        linear = self.allocation.recruitment is None
        return 1e-6 * (self.allocation.full_scale_us if linear else self.allocation.width_max_us)


def newton_drives(
    model: SampledModel, errors: Array, weights: Array, change_weight: float, drives: Array,
    curves: PulseCurves,
) -> Array:
    """Drives at the widths w + t d, d = argmin |e - G S d|^2_W + rho |d|^2, S the slope of the curves at w.

    With S inside, the change of drives S d has the weight rho / S^2. The tangent at the flat ends of an
    S-shaped curve predicts badly: slopes below the curve's mean slope are replaced by it, and
    t = 1, 1/2, ... is the best by the curves themselves. Shapes are as in `limited_change`; widths stay
    between zero and the longest, other limits do not apply.
    """
    widths = curves.widths(np.maximum(drives, _LEAST_DRIVE))
    narrower = np.maximum(widths - _NUDGE, 0.0)
    slopes = (curves.drives(widths + _NUDGE) - curves.drives(narrower)) / (widths + _NUDGE - narrower)
    slopes = np.maximum(slopes, curves.drives(np.ones_like(widths)))
    change = optimal_change(model, errors, weights, change_weight / slopes**2) / slopes
    candidates = [curves.drives(np.clip(widths + change * 0.5**i, 0.0, 1.0)) for i in range(_HALVINGS)]
    costs = [float(np.sum(weights * (errors - response(model, candidate - drives)) ** 2))
             + change_weight * 0.25**i * float(np.sum(change**2)) for i, candidate in enumerate(candidates)]
    return candidates[int(np.argmin(costs))]


LawName = Literal["phase_lead", "gradient", "noilc", "noilc_constrained", "point_to_point", "newton"]
PADDING = 15
"""Samples by which Q extends a trial at either end (chosen: a third of the longest period at 3 Hz, 40 ms)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Learning:
    """A learning law over trials of one length.

    Attributes
    ----------
    law: name of the law.
    model: model sampled at the controller's period.
    samples: number of ticks of a trial.
    limits: limits of the drives.
    first: (samples, muscles), drives that forgetting returns to.
    output_weight: (outputs,), weights.
    points: (samples, outputs), mask of the errors that count for "point_to_point".
    curves: conversion between drives and pulse widths, for "newton".
    change_weight: rho, for drives; for "newton" for widths as shares of the longest.
    forgetting: 0 to 1 (not included), share of the drives forgotten a trial.
    step: step of "gradient", below 2.
    gain, lead: gain and lead, in ticks, of "phase_lead".
    cutoff: cut-off of its low-pass Q, as a share of the Nyquist frequency, below 1; 0 for none.
    solver: solver of the laws with limits inside.
    """

    law: LawName
    model: SampledModel
    samples: int
    limits: Limits
    first: Array
    output_weight: Array
    points: Mask
    curves: PulseCurves
    change_weight: float
    forgetting: float
    step: float
    gain: float
    lead: int
    cutoff: float
    solver: SolverName

    def learn(self, drives: Array, errors: Array, covered: Mask,
              kept: Mask | None = None) -> tuple[Array, str]:
        """Drives of the next trial (samples, muscles), and a status: "" or why nothing was learnt.

        Parameters
        ----------
        drives: (samples, muscles), drives of the trial.
        errors: (samples, outputs), reference less posture, rad.
        covered: (samples, outputs), mask of the observed samples; other errors are ignored.
        kept: (samples, muscles), drives that do not change; laws with limits inside compensate for them.
        """
        learnt, status = self._learnt(drives, errors, covered, kept)
        return (learnt if kept is None else np.where(kept, drives, learnt)), status

    def _learnt(self, drives: Array, errors: Array, covered: Mask, kept: Mask | None) -> tuple[Array, str]:
        heeded = covered & self.points if self.law == "point_to_point" else covered
        if not heeded.any():
            return drives, "no_valid_samples"
        errors = np.where(heeded, errors, 0.0)
        start = self.limits.within(self.first + (1.0 - self.forgetting) * (drives - self.first))
        if self.law in ("noilc_constrained", "point_to_point"):
            change, status = limited_change(self.model, errors, heeded * self.output_weight,
                                            self.change_weight, start, self.limits, self.solver, kept)
            return (drives, status) if status else (self.limits.within(start + change), "")
        if self.law == "newton":
            return self.limits.within(newton_drives(
                self.model, errors, heeded * self.output_weight, self.change_weight, start, self.curves)), ""
        return self.limits.within(self.smoothed(start + self.change(errors, heeded))), ""

    def weights(self) -> Array:
        """Weights (samples, outputs) of a fully observed trial."""
        heeded = self.points if self.law == "point_to_point" else np.ones_like(self.points)
        return heeded * self.output_weight

    def change(self, errors: Array, covered: Mask) -> Array:
        """Change L e (samples, muscles) by the laws without limits or recruitment inside: linear in e."""
        if self.law == "phase_lead":
            return self.gain * led(errors, covered, self.lead) @ np.linalg.pinv(static_gain(self.model)).T
        weights = covered * self.output_weight
        if self.law == "gradient":
            greatest = strongest(self.model, self.weights())
            return self.step / greatest * adjoint(self.model, weights * errors)
        return optimal_change(self.model, errors, weights,
                              np.full((self.samples, self.model.b.shape[1]), self.change_weight))

    def smoothed(self, drives: Array) -> Array:
        """Low-pass Q along the first axis."""
        if self.law != "phase_lead" or self.cutoff == 0.0:
            return drives
        padding = min(PADDING, self.samples - 1)
        from scipy.signal import sosfiltfilt  # 0.5 s to import

        smooth: Array = sosfiltfilt(low_pass(self.cutoff), drives, axis=0, padlen=padding)
        return smooth


def static_gain(model: SampledModel) -> Array:
    """Static gain K (outputs, muscles): outputs in steady state per constant drive.

    Raises InputError for an unstable model.
    """
    if np.abs(np.linalg.eigvals(model.a)).max() >= 1.0:
        raise InputError("model", "is not stable and so has no static gain", "a stable model",
                         "another law than phase_lead")
    gain: Array = model.c @ np.linalg.solve(np.eye(model.a.shape[0]) - model.a, model.b)
    return gain


def low_pass(cutoff: float) -> Array:
    """Second-order sections of one pass of Q."""
    from scipy.signal import butter  # 0.5 s to import

    sections: Array = butter(2, cutoff, output="sos")
    return sections


def led(errors: Array, covered: Mask, lead: int) -> Array:
    """Errors (samples, outputs) `lead` ticks ahead; after the last covered one, that one's, then zero."""
    shifted = np.zeros_like(errors)
    for j in range(errors.shape[1]):
        seen = np.flatnonzero(covered[:, j])
        if seen.size:
            length = seen[-1] + 1
            shifted[:length, j] = errors[np.minimum(np.arange(length) + lead, seen[-1]), j]
    return shifted
