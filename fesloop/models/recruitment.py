"""Axon recruitment: from a stimulation pulse to the fraction of a muscle that it excites, and back.

An axon fires when the pulse's effective current I / (1 + chronaxie / width) passes its threshold
(Lapicque's strength-duration curve); thresholds within a muscle are lognormal, so the recruited fraction
is the normal distribution function of ln(effective current / median threshold) / spread.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from fesloop.errors import InputError

SQRT_HALF = math.sqrt(0.5)


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

    def __post_init__(self) -> None:
        if len(self.threshold_ma) != len(self.spread):
            raise InputError("recruitment.spread", f"{len(self.spread)} values",
                             f"{len(self.threshold_ma)}, one a muscle as in threshold_ma")
        for key, values in (("threshold_ma", self.threshold_ma), ("spread", self.spread),
                            ("chronaxie_us", (self.chronaxie_us,))):
            if not all(math.isfinite(v) and v > 0 for v in values):
                raise InputError(f"recruitment.{key}", f"{values} holds a value that is not positive",
                                 "finite values above 0")

    @property
    def muscles(self) -> int:
        """Number of muscles."""
        return len(self.threshold_ma)

    def fraction(self, stimulation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Recruited fraction of each muscle, (muscles,) in [0, 1].

        `stimulation` is (muscles, 2): current in A and pulse width in s.
        """
        out = np.zeros(self.muscles)
        for i, (threshold, spread) in enumerate(zip(self.threshold_ma, self.spread, strict=True)):
            current, width = float(stimulation[i, 0]), float(stimulation[i, 1])
            if current > 0.0 and width > 0.0:
                effective_ma = 1e3 * current / (1.0 + 1e-6 * self.chronaxie_us / width)
                z = math.log(effective_ma / threshold) / spread
                out[i] = 0.5 * math.erfc(-z * SQRT_HALF)
        return out

    def pulse_width_s(
        self, fraction: NDArray[np.float64], current_a: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Pulse width in s that recruits `fraction` of each muscle at the given current, (muscles,).

        Zero where the fraction is zero or less; infinite where no width at this current reaches it.
        """
        effective_ma = np.asarray(self.threshold_ma) * np.exp(
            np.asarray(self.spread) * ndtri(np.clip(fraction, 0.0, 1.0)))
        room = 1e3 * np.asarray(current_a) - effective_ma
        wanted = np.asarray(fraction) > 0.0
        width = np.full(self.muscles, np.inf)
        reachable = room > 0.0
        width[reachable] = 1e-6 * self.chronaxie_us * effective_ma[reachable] / room[reachable]
        return np.where(wanted, width, 0.0)
