"""The loop from grip force to the pulse widths of the channels that close the hand, in logarithms."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from controllers.pid.tuning import Gains, Lag, simc
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_MS, duration_ns

Array = NDArray[np.float64]
_LEAST_S = 1e-9
"""What is shorter is no pulse (chosen: a thousandth of a device's step)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceLoop:
    """PI control of ln(force) by ln(scale), the scale that of pulse widths.

        e = ln(wanted / force)        ln s = kp e + I        I[k+1] = I[k] + (kp h / Ti) e

    I stands still where s would leave its limits. Force goes with a power of pulse width over most of a
    recruitment curve, so that in logarithms the loop's gain is the same for weak and strong muscles, and
    stays so while they tire.

    Attributes
    ----------
    exponent: that power (chosen: 1 to 5 between threshold and saturation).
    lag_ms: of force behind pulse width (activation rises in 133 ms); delay_ms: likewise, with the age of the
        samples (chosen: electromechanical 20 to 40 ms and two periods of 25 ms).
    scale_min, scale_max: of s (chosen).
    """

    exponent: float = 3.0
    lag_ms: float = 133.0
    delay_ms: float = 80.0
    scale_min: float = 0.3
    scale_max: float = 2.0

    def __post_init__(self) -> None:
        for key in ("exponent", "lag_ms"):
            value = getattr(self, key)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(f"loop.{key}", f"{value}", "a finite number above 0")
        duration_ns(self.delay_ms, NS_PER_MS, "loop.delay_ms")
        if not 0.0 < self.scale_min <= 1.0 <= self.scale_max < math.inf:
            raise InputError("loop.scale_max", f"{self.scale_min:g} to {self.scale_max:g}", "around 1")

    @property
    def span(self) -> float:
        """From the least to the greatest ln s."""
        return math.log(self.scale_max / self.scale_min)

    def gains(self, period_s: float) -> Gains:
        """By Skogestad's rule (`controllers.pid.tuning.simc`), half a period of the hold in the delay."""
        delay_s = 1e-3 * self.delay_ms + 0.5 * period_s
        return simc(Lag(self.exponent, 1e-3 * self.lag_ms, delay_s), delay_s)

    def next(self, gains: Gains, period_s: float, integral: float, error: float,
             highest: float) -> tuple[float, float]:
        """(ln s, I of the next tick) for an error; ln s is `highest` at most, where its limits allow that."""
        low = math.log(self.scale_min)
        high = max(min(math.log(self.scale_max), highest), low)
        wanted = gains.kp * error + integral
        growth = gains.kp * period_s / gains.integral_s * error
        if low < wanted < high or (wanted >= high and growth < 0.0) or (wanted <= low and growth > 0.0):
            integral += growth
        return min(max(wanted, low), high), integral


def longest_s(current: Array, width_max_us: float, charge_max_uc: float) -> Array:
    """Longest pulses (channels,), s, at currents (channels,), A, within a width and a charge per phase."""
    widths = np.full(current.shape, 1e-6 * width_max_us)
    np.divide(1e-6 * charge_max_uc, current, out=widths, where=current * widths > 1e-6 * charge_max_uc)
    return widths


def useful_scale(widths_s: Array, longest: Array) -> float:
    """ln s above which all channels are at their `longest` pulses (channels,), s, from `widths_s`; 0 where no
    channel has a pulse."""
    on = widths_s > _LEAST_S
    return math.log(float((longest[on] / widths_s[on]).max())) if on.any() else 0.0
