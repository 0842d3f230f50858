"""The arithmetic of the safety limits, channel by channel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
TEST_LOAD_OHM = 500.0
"""Load of IEC 60601-2-10 into which the energy of a pulse is reckoned."""
PHASES = 2.0
"""Both phases of a biphasic pulse deliver energy."""
SIGN, CURRENT, WIDTH, CHARGE, ENERGY, SLEW, RATE, TOTAL = 1, 2, 4, 8, 16, 32, 64, 128
"""Bits of what was limited."""
LIMITED = ((SIGN, "negative", "a negative current or width: no pulse"),
           (CURRENT, "current_limited", "current above its limit"),
           (WIDTH, "width_limited", "pulse width above its limit"),
           (CHARGE, "charge_limited", "charge per phase above its limit"),
           (ENERGY, "energy_limited", "energy per pulse above its limit"),
           (SLEW, "slew_limited", "charge rises faster than its limit"),
           (RATE, "charge_rate_limited", "the charge of one second is used up"),
           (TOTAL, "budget_spent", "the charge of the whole run is used up"))
"""Status and detail of each."""
ROUND_OFF = 1e-3
"""Of a period: ticks lie on whole ns."""
_SHAVE = 1.0 - 2.0**-51
"""Takes a rounded quotient below the limit that it was made for."""
_SHAVE_SUM = 1.0 - 2.0**-40
"""The same for sums of up to thousands of messages, in whatever order they are added."""


@compiled
def limit_pulses(wanted: Array, limits: Array, charges: Array) -> tuple[int, Array]:
    """(bits of what was limited, pulses (channels, 2) within the limits).

    Parameters
    ----------
    wanted: (channels, 2), finite, A and s.
    limits: (channels, 5): current A, width s, charge C, energy J, rise of charge C a tick.
    charges: (channels,), charge per phase of the tick before, C; updated in place.
    """
    hit = 0
    pulses = np.zeros((wanted.shape[0], 2))
    for i in range(wanted.shape[0]):
        current, width = wanted[i, 0], wanted[i, 1]
        if current < 0.0 or width < 0.0:
            hit |= SIGN
            current = 0.0
        if current > limits[i, 0]:
            hit |= CURRENT
            current = limits[i, 0]
        if width > limits[i, 1]:
            hit |= WIDTH
            width = limits[i, 1]
        if current <= 0.0 or width <= 0.0:
            charges[i] = 0.0
            continue
        if current * width > limits[i, 2]:
            hit |= CHARGE
            width = limits[i, 2] / current * _SHAVE
        energy_per_s = PHASES * TEST_LOAD_OHM * current * current
        if energy_per_s * width > limits[i, 3]:
            hit |= ENERGY
            width = limits[i, 3] / energy_per_s * _SHAVE
        if current * width > charges[i] + limits[i, 4]:
            hit |= SLEW
            width = (charges[i] + limits[i, 4]) / current * _SHAVE
        charges[i] = current * width
        pulses[i, 0], pulses[i, 1] = current, width
    return hit, pulses


@compiled
def limit_dose(pulses: Array, charges: Array, phases: float, second: Array, total: Array,
               budgets: Array) -> int:
    """Shorten pulses to what is left of the budgets; bits of what was limited.

    Parameters
    ----------
    pulses: (channels, 2), A and s; shortened in place.
    charges: (channels,), charge per phase of `pulses`, C; updated in place.
    phases: how many of a message's pulses are given before the next message.
    second: (channels,), what was given within the window that ends with this message, C.
    total: (channels,), what was given before this message, C; this message's is added.
    budgets: (channels, 2): in the window, in all, C.
    """
    hit = 0
    for i in range(pulses.shape[0]):
        left_now, left_ever = budgets[i, 0] - second[i], budgets[i, 1] - total[i]
        left = max(0.0, min(left_now, left_ever)) / phases * _SHAVE_SUM
        if charges[i] > left:
            hit |= RATE if left_now <= left_ever else TOTAL
            pulses[i, 1] = left / pulses[i, 0]
            if pulses[i, 1] == 0.0:
                pulses[i, 0] = 0.0
            charges[i] = pulses[i, 0] * pulses[i, 1]
        total[i] += phases * charges[i]
    return hit


@compiled
def fall(pulses: Array, charges: Array) -> None:
    """Shorten pulses (channels, 2) to the charge of the tick before, in place; `charges` becomes theirs."""
    for i in range(pulses.shape[0]):
        if pulses[i, 0] * pulses[i, 1] > charges[i]:
            pulses[i, 1] = charges[i] / pulses[i, 0] * _SHAVE
        charges[i] = pulses[i, 0] * pulses[i, 1]


@dataclass(slots=True, eq=False)
class Dose:
    """Charge given on each channel.

    Attributes
    ----------
    budgets: as `limit_dose` takes them; never written to.
    frequency_hz: of the device, which repeats each message at it.
    phases: pulses that the device gives of each message.
    given: (ticks of a second, channels), C of each message, by its number modulo their count.
    total: (channels,), C since the run began.
    index, time_ns: of the tick before, and its instant.
    """

    budgets: Array
    frequency_hz: float
    phases: float
    given: Array
    total: Array
    index: int = -1
    time_ns: int = 0

    def book_repeated(self, charges: Array, now_ns: int) -> None:
        """Add what the device gave of `charges` beyond the period of the tick before, if this one is late."""
        pulses = self.frequency_hz * (now_ns - self.time_ns) / NS_PER_S - self.phases
        if self.index >= 0 and pulses > ROUND_OFF * self.phases:
            self.given[self.index % len(self.given)] += pulses * charges
            self.total += pulses * charges
        self.time_ns = now_ns

    def limit(self, pulses: Array, charges: Array, index: int) -> int:
        """Shorten what the budgets do not hold, and book the rest; bits of what was limited."""
        ticks = len(self.given)
        for skipped in range(max(self.index + 1, index - ticks + 1), index + 1):
            self.given[skipped % ticks] = 0.0
        hit: int = limit_dose(pulses, charges, self.phases, self.given.sum(axis=0), self.total,
                                     self.budgets)
        self.given[index % ticks] = self.phases * charges
        self.index = index
        return hit
