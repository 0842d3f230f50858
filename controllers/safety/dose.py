"""How much charge the safety block has let through, and its budgets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from controllers.safety import kernel
from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]


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
        if self.index >= 0 and pulses > kernel.ROUND_OFF * self.phases:
            self.given[self.index % len(self.given)] += pulses * charges
            self.total += pulses * charges
        self.time_ns = now_ns

    def limit(self, pulses: Array, charges: Array, index: int) -> int:
        """Shorten what the budgets do not hold, and book the rest; bits of what was limited."""
        ticks = len(self.given)
        for skipped in range(max(self.index + 1, index - ticks + 1), index + 1):
            self.given[skipped % ticks] = 0.0
        hit: int = kernel.limit_dose(pulses, charges, self.phases, self.given.sum(axis=0), self.total,
                                     self.budgets)
        self.given[index % ticks] = self.phases * charges
        self.index = index
        return hit
