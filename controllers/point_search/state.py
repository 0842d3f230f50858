"""What a point search remembers between ticks."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from controllers.point_search.contract import Found, Query
from controllers.point_search.timetable import BEGIN
from fesloop.loop.signals import NEVER
from fesloop.loop.status import StatusLatch

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class Look:
    """Mean of the postures that a tracker tells while the hand is looked at.

    Attributes
    ----------
    total: (23,), rad, sum of them. count: how many. newest_ns: arrival of the newest that was read.
    """

    total: Array
    count: int = 0
    newest_ns: int = NEVER

    def take(self, angles: Array, arrived_ns: int) -> None:
        """Count a posture once."""
        if arrived_ns > self.newest_ns:
            self.newest_ns = arrived_ns
            self.total = self.total + angles
            self.count += 1

    def end(self) -> Array | None:
        """The mean, None of nothing; from here on all is counted anew."""
        mean = self.total / self.count if self.count else None
        self.total, self.count = np.zeros_like(self.total), 0
        return mean


@dataclass(slots=True, eq=False)
class PointSearchState:
    """Where the search stands.

    Attributes
    ----------
    strategy: the strategy's own state.
    look: at the hand.
    query: under way; None before the first and after the last.
    number: of that query, from 0 on; -1 before the first.
    repeats: how often it has been asked anew.
    phase, since_ns, until_ns: of the timetable, and from when to when.
    rest: (23,), rad, the posture of the last rest; None if it was not seen.
    quality: of the last response; best: what is recommended.
    """

    strategy: Any
    look: Look
    until_ns: int
    query: Query | None = None
    number: int = -1
    repeats: int = 0
    phase: int = BEGIN
    since_ns: int = 0
    rest: Array | None = None
    quality: float = 0.0
    best: Found | None = None
    latch: StatusLatch = field(default_factory=StatusLatch)
