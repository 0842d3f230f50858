"""What a point search remembers between ticks."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from controllers.point_search.contract import Found, Query
from controllers.point_search.timetable import BEGIN
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import NEVER

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class Look:
    """Mean of the postures that a tracker tells while the hand is looked at.

    Attributes
    ----------
    total: (23,), rad, sum of each freedom while it was seen. seen: (23,), how often that was.
    count: of postures. newest_ns: arrival of the newest that was read.
    """

    total: Array
    seen: Array
    count: int = 0
    newest_ns: int = NEVER

    def take(self, angles: Array, unseen: NDArray[np.bool_], arrived_ns: int) -> None:
        """Count a posture once, but for its freedoms that are unseen, (23,)."""
        if arrived_ns > self.newest_ns:
            self.newest_ns = arrived_ns
            self.total = self.total + np.where(unseen, 0.0, angles)
            self.seen = self.seen + ~unseen
            self.count += 1

    def end(self) -> Array | None:
        """The mean, NaN of a freedom never seen, None of nothing; from here on all is counted anew."""
        mean = np.full(self.total.size, np.nan) if self.count else None
        if mean is not None:
            np.divide(self.total, self.seen, out=mean, where=self.seen > 0.0)
        self.total, self.seen, self.count = np.zeros_like(self.total), np.zeros_like(self.seen), 0
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
    rest: (23,), rad, the posture of the last rest, NaN of what was not seen of it; None if nothing was.
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
