"""What a grasp costs: charge, and fitness of the muscles that close the hand."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fesloop.hand.muscles import MUSCLES

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]
CLOSING = tuple(name for name in MUSCLES if name.startswith(("FDS", "FDP", "FPL", "THENAR", "INT")))
"""Muscles that close the hand on an object: flexors of fingers and thumb."""
_COLUMNS = [MUSCLES.index(name) for name in CLOSING]


def charge_c(times_s: Array, pulses: Array, frequency_hz: float) -> float:
    """Charge of one phase, C, summed over the pulses of all channels.

    `pulses` (n, channels, 2), A and s, or (n, channels), C a phase, each standing until the next row, the
    last as long as the one before it; a device gives `frequency_hz` pulses a second of what stands.
    """
    charges = pulses[..., 0] * pulses[..., 1] if pulses.ndim == 3 else pulses
    if times_s.size < 2:
        return math.nan
    lasting_s = np.diff(times_s, append=2.0 * times_s[-1] - times_s[-2])
    return float(frequency_hz * (charges.sum(axis=1) @ lasting_s))


def fitness_ratio(activation: Array, before: Array, after: Array) -> float:
    """Fitness `after` over that `before` (29,), of the muscles that close the hand.

    Each counts by its activation (29,), the mean of a hold. NaN where none is active.
    """
    share = activation[_COLUMNS]
    total = float(share @ before[_COLUMNS])
    return float(share @ after[_COLUMNS]) / total if total > 0.0 else math.nan


def grasps_until_fatigue(margin: float, ratio: float) -> float:
    """How many grasps hold, one after the other under unchanged stimulation.

    Grip force over the force needed is `margin` in the first, and `ratio` times that of the one before in
    each that follows; a grasp holds while it is 1 or more: 1 + floor(ln margin / -ln ratio). 0 where the
    first does not hold, inf where fitness does not fall, NaN where an argument is.
    """
    if math.isnan(margin) or math.isnan(ratio):
        return math.nan
    if margin < 1.0:
        return 0.0
    if ratio >= 1.0:
        return math.inf
    return 1.0 + math.floor(math.log(margin) / -math.log(ratio)) if ratio > 0.0 else 1.0
