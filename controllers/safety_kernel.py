"""The arithmetic of the safety limits, channel by channel."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TEST_LOAD_OHM = 500.0
"""Load of IEC 60601-2-10 into which the energy of a pulse is reckoned."""
PHASES = 2.0
"""Both phases of a biphasic pulse deliver energy."""
SIGN, CURRENT, WIDTH, CHARGE, ENERGY, SLEW = 1, 2, 4, 8, 16, 32
"""Bits of what was limited."""
_SHAVE = 1.0 - 2.0**-51
"""Takes a rounded quotient below the limit that it was made for."""


@numba.njit(cache=True)
def limit_pulses(wanted: Array, limits: Array, charges: Array) -> tuple[int, Array]:
    """(bits of what was limited, pulses (channels, 2) within the limits).

    Parameters
    ----------
    wanted: (channels, 2), finite, A and s.
    limits: (5,): current A, width s, charge C, energy J, rise of charge C a tick.
    charges: (channels,), charge per phase of the tick before, C; updated in place.
    """
    hit = 0
    pulses = np.zeros((wanted.shape[0], 2))
    for i in range(wanted.shape[0]):
        current, width = wanted[i, 0], wanted[i, 1]
        if current < 0.0 or width < 0.0:
            hit |= SIGN
            current = 0.0
        if current > limits[0]:
            hit |= CURRENT
            current = limits[0]
        if width > limits[1]:
            hit |= WIDTH
            width = limits[1]
        if current <= 0.0 or width <= 0.0:
            charges[i] = 0.0
            continue
        if current * width > limits[2]:
            hit |= CHARGE
            width = limits[2] / current * _SHAVE
        energy_per_s = PHASES * TEST_LOAD_OHM * current * current
        if energy_per_s * width > limits[3]:
            hit |= ENERGY
            width = limits[3] / energy_per_s * _SHAVE
        if current * width > charges[i] + limits[4]:
            hit |= SLEW
            width = (charges[i] + limits[4]) / current * _SHAVE
        charges[i] = current * width
        pulses[i, 0], pulses[i, 1] = current, width
    return hit, pulses
