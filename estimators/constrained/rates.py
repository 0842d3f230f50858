"""Sensors that are sampled less often than others: found from when their samples change.

A table or a radio packet with the samples of all sensors has nothing new, or nothing at all, for a slow one
in most of its rows. That is no fault, and what lies between can be interpolated once the next sample is here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
SLOWEST = 5
"""Most ticks between two samples of a slow sensor (chosen: a rate a fifth of the others')."""
_COUNTED = 24
"""Number of intervals that tell a rate (chosen: losses at random are not as regular for so long)."""
_SLOW = 1.4
"""Least mean interval of a slow sensor, ticks (chosen: below it, losses look alike)."""
_WHOLE = 0.6
"""Least share of a slow sensor's intervals without a lost sample (chosen: a fifth lost passes)."""
_UNEVEN = 1.6
"""Range of its ticks about a line of constant rate, ticks (1 by rounding, at most .54 by the line's fit)."""


@dataclass(slots=True, eq=False)
class Rates:
    """When the sensors' samples change.

    Attributes
    ----------
    every: (n,), most ticks between two samples of a sensor; 1 for those of the tracker's rate.
    before: (2, n, 3), newest rates and accelerations.
    since: (n,), ticks since they changed; ended: (n,), ticks of the interval that ends with the newest
        samples, else 0.
    intervals: (intervals, n), ticks between changes, a ring; counted: (n,), number of them.
    """

    every: Numbers
    before: Array
    since: Numbers
    ended: Numbers
    intervals: Numbers
    counted: Numbers

    @classmethod
    def unknown(cls, sensors: int) -> Rates:
        """All sensors at the tracker's rate."""
        since, ended, counted = np.zeros((3, sensors), dtype=np.int64)
        return cls(np.ones(sensors, dtype=np.int64), np.full((2, sensors, 3), np.nan), since, ended,
                   np.zeros((_COUNTED, sensors), dtype=np.int64), counted)

    def note(self, gyr: Array, acc: Array, ticks: int) -> None:
        """Add new samples (n, 3) that came `ticks` ticks after the ones before."""
        note_changes(gyr, acc, ticks, self.before, self.since, self.ended, self.intervals,
                     self.counted)

    def found(self) -> Numbers:
        """`every` as the newest intervals tell it; a slow sensor stays slow until samples come more often."""
        every = np.ones_like(self.every)
        for i in np.flatnonzero(self.counted >= _COUNTED):
            ring = np.roll(self.intervals[:, i], -(self.counted[i] % _COUNTED))
            if ring.mean() <= _SLOW:
                continue
            every[i] = self.every[i]
            usual = ring <= ring.min() + 1
            # At every second tick or less often, a few longer intervals have lost samples between their ends.
            if ring[usual].max() > SLOWEST or usual.mean() < (_WHOLE if ring.min() > 1 else 1.0):
                continue
            # Ticks at which a clock of another rate has ticked lie within one of a line.
            at = np.cumsum(ring)
            number = np.cumsum(np.maximum(1.0, np.round(ring / ring[usual].mean())))
            uneven = at - np.polyval(np.polyfit(number, at, 1), number)
            if np.ptp(uneven) <= _UNEVEN:
                # A clock that is a little slower than that has a longer interval now and then.
                every[i] = max(ring[usual].max(), self.every[i])
        return every


@compiled
def note_changes(
    gyr: Any, acc: Any, ticks: int, before: Any, since: Any, ended: Any, intervals: Any, counted: Any
) -> None:
    """Count which samples (n, 3) are new; arguments as in Rates, updated."""
    for i in range(since.size):
        since[i] += ticks
        ended[i] = 0
        new, whole = False, 0.0
        for a in range(3):
            new |= gyr[i, a] != before[0, i, a] or acc[i, a] != before[1, i, a]
            whole += gyr[i, a] + acc[i, a]
        if new and whole * 0.0 == 0.0:
            intervals[counted[i] % intervals.shape[0], i] = since[i]
            counted[i] += 1
            ended[i], since[i] = since[i], 0
            for a in range(3):
                before[0, i, a], before[1, i, a] = gyr[i, a], acc[i, a]
