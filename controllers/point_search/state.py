"""What a point search remembers between ticks."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from controllers.point_search.contract import Found, Query
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S, duration_ns
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import NEVER

BEGIN, REST, BASELINE, RAMP, SETTLE, MEASURE, ENDED = range(7)
"""Phases: before anything; between queries; the last of a rest, in which the hand is looked at; the charge
rises; the hand moves; it is looked at again; the search is over."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Timetable:
    """How long each phase of a query lasts, s; the loop rounds each up to ticks of the block.

    A query that is held: rest, ramp, settle, measure; without rest, no ramp. A stair: the first half of it
    settle, the second measure, rested only if it begins a staircase.

    Attributes
    ----------
    begin_s: before the first rest (chosen: sensors are put on; trackers that need a pose get it here).
    rest_s: between queries, the look at the resting hand included (doi 10.1186/s12984-018-0460-1).
    ramp_s: in which the pulse width rises from half to all of it (chosen: not a jolt).
    settle_s: from then until the hand is looked at (chosen: 95 % of a wrist's movement).
    measure_s: for how long it is looked at, at rest and at the end of a query (chosen: 8 ticks at 40 Hz).
    stair_s: of a staircase (the same source).
    """

    begin_s: float = 2.0
    rest_s: float = 1.5
    ramp_s: float = 0.3
    settle_s: float = 0.8
    measure_s: float = 0.2
    stair_s: float = 0.12

    def __post_init__(self) -> None:
        for key in ("begin_s", "rest_s", "ramp_s", "settle_s", "measure_s", "stair_s"):
            duration_ns(getattr(self, key), NS_PER_S, f"timetable.{key}")
        if self.measure_s == 0.0 or self.stair_s == 0.0:
            raise InputError("timetable", f"measure_s {self.measure_s:g}, stair_s {self.stair_s:g}",
                             "above 0")
        if self.rest_s < self.measure_s:
            raise InputError("timetable.rest_s", f"{self.rest_s:g}",
                             f"at least measure_s, {self.measure_s:g}")

    def after(self, phase: int, query: Query) -> int:
        """The phase that follows one in which `query` is under way."""
        if phase == BASELINE and query.stair:
            return SETTLE
        return phase + 1

    def first(self, query: Query) -> int:
        """The phase that a query begins with."""
        return REST if query.rested else SETTLE

    def lasts_ns(self, phase: int, query: Query) -> int:
        """How long a phase of a query lasts."""
        half_s = 0.5 * self.stair_s
        seconds = {
            REST: self.rest_s - self.measure_s, BASELINE: self.measure_s, RAMP: self.ramp_s,
            SETTLE: half_s if query.stair else self.settle_s,
            MEASURE: half_s if query.stair else self.measure_s}[phase]
        return duration_ns(seconds, NS_PER_S, "timetable")

    def width_share(self, phase: int, since_ns: int) -> float:
        """Share of the pulse width that is given so long after a phase began; 0 in those without pulses."""
        if phase == RAMP:
            return 0.5 + 0.5 * min(since_ns / duration_ns(self.ramp_s, NS_PER_S, "timetable"), 1.0)
        return 1.0 if phase in (SETTLE, MEASURE) else 0.0


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
