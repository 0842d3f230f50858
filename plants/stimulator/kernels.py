"""Charge and current density of the pulses that a stimulator gives."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled

Array = NDArray[np.float64]


@compiled
def share_out(given: Array, shares: Array, hertz: float, elements: Array) -> None:
    """Put a pulse, current and width (2,), on the `elements` (e, 3) that have `shares` (e,) of it."""
    if given[0] > 0.0:
        for e in range(shares.size):
            if shares[e] > 0.0:
                elements[e, 0] = given[0] * shares[e]
                elements[e, 1] = given[1]
                elements[e, 2] = hertz


@compiled
def tally(
    given: Array, shares: Array, hertz: float, area_cm2: float
) -> tuple[Array, Array, Array, Array, Array]:
    """Account for biphasic pulses (channels, 2), each given `hertz` times a second through `shares`.

    Charge of each channel, C a phase and C/s; of each element, C a phase (of the channel that gives it most)
    and C/s of all channels; and the r.m.s. current density under it, mA/cm^2. Over a period the mean square
    of a pulse I, w is 2 I^2 w f: both phases count.
    """
    channels, elements = shares.shape
    charge, charge_rate = np.empty(channels), np.empty(channels)
    most, rate, density = np.zeros(elements), np.zeros(elements), np.zeros(elements)
    for c in range(channels):
        charge[c] = given[c, 0] * given[c, 1]
        charge_rate[c] = charge[c] * hertz
        for e in range(elements):
            share = shares[c, e]
            if share > 0.0:
                most[e] = max(most[e], share * charge[c])
                rate[e] += share * charge_rate[c]
                density[e] += 2.0 * (share * given[c, 0]) ** 2 * given[c, 1] * hertz
    for e in range(elements):
        density[e] = 1e3 * math.sqrt(density[e]) / area_cm2
    return charge, charge_rate, most, rate, density
