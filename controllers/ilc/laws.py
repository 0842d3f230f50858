"""Learning laws: the drives of the next trial from those of the last and the error that they left.

With drives v and errors e = r - y stacked over a trial, y = G v + y_0, weights W (0 where an output was not
observed), v' = first + (1 - forgetting) (v - first) and the limits of `ilc.limits`:

    phase_lead          v+ = Q (v' + gain K^+ e shifted forward by the lead), then clipped
    gradient            v+ = v' + step / |G'WG| G'W e, then clipped
    noilc               v+ = v' + (G'WG + rho I)^-1 G'W e, then clipped
    noilc_constrained   v+ = v' + argmin |e - G d|^2_W + rho |d|^2 with v' + d inside the limits
    point_to_point      the same, W zero but at the chosen instants and outputs
    newton              noilc in pulse widths, G linearised about the last trial through the recruitment

K is the static gain and Q a zero-phase low-pass. What a trial did not cover changes nothing, so trials of
any length teach (variable pass length: Seel, Schauer and Raisch 2017, Int. J. Control 90(3), 393).

Sources: Bristow, Tharayil and Alleyne 2006 (doi 10.1109/MCS.2006.1636313) for phase-lead; Owens, Hatonen and
Daley 2009 (doi 10.1002/rnc.1338) for the gradient; Amann, Owens and Rogers 1996 (doi
10.1049/ip-cta:19960244) for norm-optimal; Freeman and Tan 2013 (IEEE Trans. Control Syst. Technol. 21(3),
604) for points and limits; Lin, Owens and Hatonen 2006 (Int. J. Control 79(10), 1263) for Newton;
Heinzinger et al. 1992 (doi 10.1109/9.109645) for forgetting.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from controllers.ilc.limits import Limits, pulses_of
from controllers.ilc.programme import SolverName, limited_change
from controllers.ilc.trajectories import adjoint, optimal_change, response, strongest
from controllers.limits.allocation import Allocation
from fesloop.errors import InputError
from fesloop.models.linear_model import SampledModel

Array = NDArray[np.float64]
_LEAST_DRIVE = 0.01
"""Drive at which a resting muscle is linearised (chosen): the curve is flat at rest, nothing would start."""
_HALVINGS = 7
_NUDGE = 1e-3
"""Half the step of the central difference, of the longest pulse."""


class PulseCurves(Protocol):
    """Recruited fractions against pulse widths, each width a share of the channel's longest."""

    def widths(self, drives: Array) -> Array:
        """Widths (samples, muscles) of drives (samples, muscles)."""

    def drives(self, widths: Array) -> Array:
        """Drives (samples, muscles) of widths (samples, muscles), 0 or more."""


@dataclass(frozen=True, slots=True)
class AllocatedCurves:
    """The curves by which an allocation turns drives into pulses."""

    allocation: Allocation

    def widths(self, drives: Array) -> Array:
        """Widths of drives, as shares of the longest."""
        shares: Array = pulses_of(self.allocation, drives)[:, :, 1] / self._longest_s
        return shares

    def drives(self, widths: Array) -> Array:
        """Drives of widths."""
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
    """Drives of the widths w + t d, d = argmin |e - G S d|^2_W + rho |d|^2, S the slope of the curves at w.

    With S inside, the change of drives S d is weighed by rho / S^2. The tangent of an S-shaped curve leads
    astray from its flat ends: where it is flatter than the curve's mean slope it counts as that steep, and
    t = 1, 1/2, ... is what is best by the curves themselves. Shapes as in `limited_change`; widths stay
    between none and the longest, other limits are not kept.
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


Mask = NDArray[np.bool_]
LawName = Literal["phase_lead", "gradient", "noilc", "noilc_constrained", "point_to_point", "newton"]
PADDING = 15
"""Samples by which Q extends a trial at either end (chosen: a third of the longest period at 3 Hz, 40 ms)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Learning:
    """A learning law over trials of one length.

    Attributes
    ----------
    law: by name.
    model: sampled at the controller's period.
    samples: ticks of a trial.
    limits: of the drives.
    first: (samples, muscles), drives towards which forgetting goes.
    output_weight: (outputs,).
    points: (samples, outputs), what "point_to_point" heeds.
    curves: drives against pulse widths, for "newton".
    change_weight: rho, for drives; for "newton" for widths as shares of the longest.
    forgetting: 0 to 1 (not included), share of the drives forgotten a trial.
    step: of "gradient", below 2.
    gain, lead: of "phase_lead"; lead in ticks.
    cutoff: of its low-pass Q, as a share of the Nyquist frequency, below 1; 0 for none.
    solver: of the laws with limits inside.
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
        """(drives of the next trial, status): (samples, muscles), and "" or why nothing was learnt.

        Parameters
        ----------
        drives: (samples, muscles), of the trial.
        errors: (samples, outputs), reference less posture, rad.
        covered: (samples, outputs), where the trial was observed; elsewhere errors count for nothing.
        kept: (samples, muscles), drives that stay as they are; laws with limits inside make up for them.
        """
        learnt, status = self._learnt(drives, errors, covered, kept)
        return (learnt if kept is None else np.where(kept, drives, learnt)), status

    def _learnt(self, drives: Array, errors: Array, covered: Mask, kept: Mask | None) -> tuple[Array, str]:
        heeded = covered & self.points if self.law == "point_to_point" else covered
        if not heeded.any():
            return drives, "unobserved"
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
        """(samples, outputs), of a trial that was observed throughout."""
        heeded = self.points if self.law == "point_to_point" else np.ones_like(self.points)
        return heeded * self.output_weight

    def change(self, errors: Array, covered: Mask) -> Array:
        """L e (samples, muscles) of the laws without limits or recruitment inside: linear in the errors."""
        if self.law == "phase_lead":
            return self.gain * led(errors, covered, self.lead) @ np.linalg.pinv(static_gain(self.model)).T
        weights = covered * self.output_weight
        if self.law == "gradient":
            greatest = strongest(self.model, self.weights())
            return self.step / greatest * adjoint(self.model, weights * errors)
        return optimal_change(self.model, errors, weights,
                              np.full((self.samples, self.model.b.shape[1]), self.change_weight))

    def smoothed(self, drives: Array) -> Array:
        """Q along the first axis."""
        if self.law != "phase_lead" or self.cutoff == 0.0:
            return drives
        padding = min(PADDING, self.samples - 1)
        smooth: Array = sosfiltfilt(low_pass(self.cutoff), drives, axis=0, padlen=padding)
        return smooth


def static_gain(model: SampledModel) -> Array:
    """K (outputs, muscles): outputs at rest under drives held for ever.

    Raises InputError for a model that comes to no rest.
    """
    if np.abs(np.linalg.eigvals(model.a)).max() >= 1.0:
        raise InputError("model", "is not stable and so has no static gain", "a stable model",
                         "another law than phase_lead")
    gain: Array = model.c @ np.linalg.solve(np.eye(model.a.shape[0]) - model.a, model.b)
    return gain


def low_pass(cutoff: float) -> Array:
    """Second-order sections of one pass of Q."""
    sections: Array = butter(2, cutoff, output="sos")
    return sections


def led(errors: Array, covered: Mask, lead: int) -> Array:
    """Errors (samples, outputs) `lead` ticks ahead; past the last covered one it is that one's, then none."""
    shifted = np.zeros_like(errors)
    for j in range(errors.shape[1]):
        seen = np.flatnonzero(covered[:, j])
        if seen.size:
            length = seen[-1] + 1
            shifted[:length, j] = errors[np.minimum(np.arange(length) + lead, seen[-1]), j]
    return shifted
