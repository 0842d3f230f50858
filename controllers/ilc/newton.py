"""Newton's step through the recruitment: what changing the last trial's widths does, to first order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from controllers.ilc.limits import pulses_of
from controllers.ilc.trajectories import optimal_change, response
from controllers.limits.allocation import Allocation
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
