"""Sampling rates, as the stamps of a signal say them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.clock import NS_PER_S

_FIGURES = 12
"""Of a rate: stamps are whole ns, so the mean over a minute has as many."""


@dataclass(frozen=True, slots=True)
class StampedRate:
    """Mean rate of stamps, Hz, 0 for fewer than two; whether they are evenly spaced, to a ns."""

    hertz: float
    even: bool


def rate_of_stamps(times_ns: NDArray[np.int64]) -> StampedRate:
    """The rate of stamps (n,), ns, that do not decrease."""
    steps = np.diff(times_ns)
    if not steps.size or times_ns[-1] == times_ns[0]:
        return StampedRate(0.0, False)
    hertz = NS_PER_S * steps.size / float(times_ns[-1] - times_ns[0])
    return StampedRate(float(f"{hertz:.{_FIGURES}g}"), bool(steps.max() - steps.min() <= 1))
