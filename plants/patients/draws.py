"""Random numbers that say how one patient differs: within limits, and independent of all others."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from fesloop.hand.muscles import MUSCLES
from fesloop.loop.noise import NoiseStream, stream_key
from plants.patients.limits import Limits

MOST_SD = 2.5
"""No draw is further from the middle (chosen: the most unusual of a hundred)."""
_NEW_SEEDS = 2**53


@dataclass(frozen=True, slots=True)
class Draws:
    """Numbers drawn for one member or one day, each from a stream of its own name.

    So members, days and quantities do not depend on each other, nor on how many there are.
    """

    seed: int
    name: str
    number: int

    def uniform(self, quantity: str, width: int = 1) -> NDArray[np.float64]:
        """(width,), in [0, 1)."""
        return NoiseStream(stream_key(self.seed, f"{self.name}/{quantity}", self.number), width,
                           "uniform").row(0)

    def near(self, quantity: str, middle: float, sd: float, limits: Limits) -> float:
        """A normal number around `middle`, within `MOST_SD` and the limits."""
        return _truncated(float(self.uniform(quantity)[0]), middle, sd, limits)

    def scaled(self, quantity: str, middle: float, sd: float, limits: Limits) -> float:
        """A lognormal number of median `middle`, `sd` of its logarithm, within `MOST_SD` and the limits."""
        return _scaled(float(self.uniform(quantity)[0]), middle, sd, limits)

    def of_muscles(self, quantity: str, middles: dict[str, float], sd: float, limits: Limits,
                   ) -> dict[str, float]:
        """Lognormal factors of all muscles, of medians `middles` (where not named, 1)."""
        if sd == 0.0:
            return middles
        shares = self.uniform(quantity, len(MUSCLES))
        return {name: _scaled(float(share), middles.get(name, 1.0), sd, limits)
                for name, share in zip(MUSCLES, shares, strict=True)}

    def new_seed(self, quantity: str) -> int:
        """A seed that nobody else has."""
        return stream_key(self.seed, f"{self.name}/{quantity}", self.number) % _NEW_SEEDS


def _truncated(share: float, middle: float, sd: float, limits: Limits) -> float:
    """Quantile `share` of the normal distribution around `middle`, cut off."""
    if sd == 0.0:
        return middle
    low, high = (min(max((limit - middle) / sd, -MOST_SD), MOST_SD) for limit in limits)
    below, above = float(ndtr(low)), float(ndtr(high))
    drawn = middle + sd * float(ndtri(below + share * (above - below)))
    return min(max(drawn, limits[0]), limits[1])


def _scaled(share: float, middle: float, sd: float, limits: Limits) -> float:
    if sd == 0.0 or middle == 0.0:
        return middle
    low, high = (math.log(max(limit, 1e-300) / middle) for limit in limits)
    return min(max(middle * math.exp(_truncated(share, 0.0, sd, (low, high))), limits[0]), limits[1])
