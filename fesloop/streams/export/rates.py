"""Sampling rates, as the stamps of a signal say them."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.clock import NS_PER_S

_NONE = Fraction(0)
_ROUNDING = 1e-15
"""Relative, of a product and a quotient of doubles."""


@dataclass(frozen=True, slots=True)
class StampedRate:
    """Rate of stamps, Hz, 0 for fewer than two; whether they are evenly spaced, to a ns."""

    exact: Fraction
    even: bool

    @property
    def hertz(self) -> float:
        """The nearest double."""
        return float(self.exact)


def rate_of_stamps(times_ns: NDArray[np.int64]) -> StampedRate:
    """The rate of stamps (n,), ns, that do not decrease: the simplest ratio that they allow.

    Stamps are whole ns, so their mean period is known to 1 / (n - 1) ns: 285714285.7 mHz are 2000/7 Hz.
    """
    steps = len(times_ns) - 1
    if steps < 1 or times_ns[-1] == times_ns[0]:
        return StampedRate(_NONE, False)
    length = int(times_ns[-1] - times_ns[0])
    low, high = Fraction(NS_PER_S * steps, length + 1), Fraction(NS_PER_S * steps, max(length - 1, 1))
    rate = _simplest(low, high) if length > 1 else Fraction(NS_PER_S * steps, length)
    period = NS_PER_S / float(rate)
    apart = np.arange(steps + 1) * period - (times_ns - times_ns[0])
    return StampedRate(rate, bool(np.abs(apart).max() < 1.0 + _ROUNDING * length))


def _simplest(low: Fraction, high: Fraction) -> Fraction:
    """The ratio of least denominator between two, above 0, by continued fractions."""
    whole = low.numerator // low.denominator
    if low == whole:
        return Fraction(whole)
    if high > whole + 1:
        return Fraction(whole + 1)
    return whole + 1 / _simplest(1 / (high - whole), 1 / (low - whole))
