"""State and timetable of a point search."""

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
"""Phases: before the search; rest; observation at the end of a rest; rising charge; movement; observation
under the query; after the search."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Timetable:
    """Durations of the phases of a query, s; each is rounded up to ticks of the block.

    The phases of a held query are rest, ramp, settle, measure; without rest there is no ramp. Those of a
    stair are settle and measure, half of it each, after a rest only if it begins a staircase.

    Attributes
    ----------
    begin_s: time before the first rest (chosen: for putting on sensors and initial poses of trackers).
    rest_s: rest between queries, with the observation of the resting hand (doi 10.1186/s12984-018-0460-1).
    ramp_s: rise of the pulse width from half to all of it (chosen: without a jolt).
    settle_s: time from then until the observation (chosen: 95 % of a wrist's movement).
    measure_s: duration of an observation, at rest and at the end of a query (chosen: 8 ticks at 40 Hz).
    stair_s: duration of a stair (the same source).
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
        """Phase after one of `query`."""
        if phase == BASELINE and query.stair:
            return SETTLE
        return phase + 1

    def first(self, query: Query) -> int:
        """First phase of a query."""
        return REST if query.rested else SETTLE

    def lasts_ns(self, phase: int, query: Query) -> int:
        """Duration of a phase of a query, ns."""
        half_s = 0.5 * self.stair_s
        seconds = {
            REST: self.rest_s - self.measure_s, BASELINE: self.measure_s, RAMP: self.ramp_s,
            SETTLE: half_s if query.stair else self.settle_s,
            MEASURE: half_s if query.stair else self.measure_s}[phase]
        return duration_ns(seconds, NS_PER_S, "timetable")

    def width_share(self, phase: int, since_ns: int) -> float:
        """Share of the pulse width at a time after the start of a phase; 0 in phases without pulses."""
        if phase == RAMP:
            return 0.5 + 0.5 * min(since_ns / duration_ns(self.ramp_s, NS_PER_S, "timetable"), 1.0)
        return 1.0 if phase in (SETTLE, MEASURE) else 0.0


Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class Look:
    """Mean of the postures during an observation.

    Attributes
    ----------
    total: (23,), rad, sum of each freedom over the postures that show it.
    seen: (23,), number of these.
    count: number of postures.
    newest_ns: arrival of the last one.
    """

    total: Array
    seen: Array
    count: int = 0
    newest_ns: int = NEVER

    def take(self, angles: Array, unseen: NDArray[np.bool_], arrived_ns: int) -> None:
        """Add a posture, unless it was added before, without its unseen freedoms (23,)."""
        if arrived_ns > self.newest_ns:
            self.newest_ns = arrived_ns
            self.total = self.total + np.where(unseen, 0.0, angles)
            self.seen = self.seen + ~unseen
            self.count += 1

    def end(self) -> Array | None:
        """Return the mean, NaN for unseen freedoms, None without postures, and reset."""
        mean = np.full(self.total.size, np.nan) if self.count else None
        if mean is not None:
            np.divide(self.total, self.seen, out=mean, where=self.seen > 0.0)
        self.total, self.seen, self.count = np.zeros_like(self.total), np.zeros_like(self.seen), 0
        return mean


@dataclass(slots=True, eq=False)
class PointSearchState:
    """State of the search.

    Attributes
    ----------
    strategy: the strategy's own state.
    look: present observation of the hand.
    query: present query; None before the first and after the last.
    number: its number from 0; -1 before the first.
    repeats: number of its repetitions.
    phase, since_ns, until_ns: phase of the timetable, its start and its end.
    rest: (23,), rad, posture of the last rest, NaN for unseen freedoms; None without a posture.
    quality: quality of the last response.
    best: recommendation.
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
