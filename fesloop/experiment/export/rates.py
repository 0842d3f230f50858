"""Sampling rates, computed from the stamps of a signal."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.clock import NS_PER_S
from fesloop.streams.timebase import simplest_rate

_NONE = Fraction(0)
_WHOLE_NS = 2.0
"""Tolerance, ns, between instants in whole ns and evenly spaced ones: two of them are rounded down."""
_ROUNDING = 1e-15
"""Relative, of a product and a quotient of doubles."""


@dataclass(frozen=True, slots=True)
class StampedRate:
    """Rate of stamps, Hz, 0 for fewer than two; whether they are evenly spaced, but for being whole ns."""

    exact: Fraction
    even: bool

    @property
    def hertz(self) -> float:
        """The nearest double."""
        return float(self.exact)


def rate_of_stamps(times_ns: NDArray[np.int64]) -> StampedRate:
    """The rate of stamps (n,), ns, that do not decrease: the simplest ratio that they allow."""
    steps = len(times_ns) - 1
    if steps < 1 or times_ns[-1] == times_ns[0]:
        return StampedRate(_NONE, False)
    length = int(times_ns[-1] - times_ns[0])
    rate = simplest_rate(times_ns)
    period = NS_PER_S / float(rate)
    apart = np.arange(steps + 1) * period - (times_ns - times_ns[0])
    return StampedRate(rate, bool(np.abs(apart).max() < _WHOLE_NS + _ROUNDING * length))
