"""Axon recruitment: from a stimulation pulse to the fraction of a muscle that it excites, and back.

An axon fires when the pulse's effective current I / (1 + chronaxie / width) passes its threshold
(Lapicque's strength-duration curve); thresholds within a muscle are lognormal, so the recruited fraction
is the normal distribution function of ln(effective current / median threshold) / spread.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from fesloop.compiled import compiled
from fesloop.errors import InputError

Array = NDArray[np.float64]


@compiled
def recruit(
    stimulation: Array, threshold_ma: Array, spread: Array, chronaxie_us: float, fraction: Array
) -> None:
    """Fill `fraction` (muscles,) under `stimulation` (muscles, 2): current in A, pulse width in s."""
    for i in range(threshold_ma.size):
        current, width = stimulation[i, 0], stimulation[i, 1]
        if current > 0.0 and width > 0.0:
            effective_ma = 1e3 * current / (1.0 + 1e-6 * chronaxie_us / width)
            z = math.log(effective_ma / threshold_ma[i]) / spread[i]
            fraction[i] = 0.5 * math.erfc(-z * math.sqrt(0.5))
        else:
            fraction[i] = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Recruitment:
    """Recruitment curves of several muscles.

    Attributes
    ----------
    threshold_ma: effective current that recruits half of each muscle, mA.
    spread: standard deviation of the logarithm of the thresholds (lower is steeper).
    chronaxie_us: of the strength-duration curve, us.
    """

    threshold_ma: tuple[float, ...]
    spread: tuple[float, ...]
    chronaxie_us: float = 200.0
    _threshold_ma: Array = field(init=False, repr=False, compare=False)
    _spread: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if len(self.threshold_ma) != len(self.spread):
            raise InputError("recruitment.spread", f"{len(self.spread)} values",
                             f"{len(self.threshold_ma)}, one a muscle as in threshold_ma")
        for key, values in (("threshold_ma", self.threshold_ma), ("spread", self.spread),
                            ("chronaxie_us", (self.chronaxie_us,))):
            if not all(math.isfinite(v) and v > 0 for v in values):
                raise InputError(f"recruitment.{key}", f"{values} holds a value that is not positive",
                                 "finite values above 0")
        object.__setattr__(self, "_threshold_ma", np.array(self.threshold_ma, dtype=np.float64))
        object.__setattr__(self, "_spread", np.array(self.spread, dtype=np.float64))

    @property
    def muscles(self) -> int:
        """Number of muscles."""
        return len(self.threshold_ma)

    def fraction(self, stimulation: Array) -> Array:
        """Recruited fraction of each muscle, (muscles,) in [0, 1].

        `stimulation` is (muscles, 2): current in A and pulse width in s. Zero where either is zero or
        less. Raises InputError for another shape.
        """
        if stimulation.shape != (self.muscles, 2):
            raise InputError("stimulation", f"shape {stimulation.shape}", f"({self.muscles}, 2)")
        fraction = np.empty(self.muscles)
        recruit(stimulation, self._threshold_ma, self._spread, self.chronaxie_us, fraction)
        return fraction

    def pulse_width_s(self, fraction: Array, current_a: Array) -> Array:
        """Pulse width in s that recruits `fraction` of each muscle at the given current, (muscles,).

        Zero where the fraction is zero or less; infinite where no width at this current reaches it.
        """
        effective_ma = self._threshold_ma * np.exp(self._spread * ndtri(np.clip(fraction, 0.0, 1.0)))
        room = 1e3 * np.asarray(current_a) - effective_ma
        wanted = np.asarray(fraction) > 0.0
        width = np.full(self.muscles, np.inf)
        reachable = room > 0.0
        width[reachable] = 1e-6 * self.chronaxie_us * effective_ma[reachable] / room[reachable]
        return np.where(wanted, width, 0.0)
