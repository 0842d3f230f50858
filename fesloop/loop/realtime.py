"""Keeping simulated time in step with the wall clock: the only place where a run looks at one."""

from __future__ import annotations

import time
from collections.abc import Callable
from fractions import Fraction

from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.loop.wiring import Node

_MOST_HZ = 200
"""A plain kernel wakes a sleeper some ms late now and then: above this rate ticks are run in bursts."""


class Pacer:
    """Lets each stretch of simulated time begin when the wall clock gets there, and no earlier.

    A deadline is missed where a stretch ends after the next one should have begun.

    Parameters
    ----------
    period: length of a stretch.
    clock, sleep: wall clock in ns, and how to wait for some seconds.

    Attributes
    ----------
    deadlines, missed: how many there were, and how many were missed.
    worst_late_ns: by how much the worst was.
    """

    def __init__(self, period: RateClock, clock: Callable[[], int] = time.monotonic_ns,
                 sleep: Callable[[float], None] = time.sleep) -> None:
        self.period = period
        self.deadlines = self.missed = self.worst_late_ns = 0
        self._clock, self._sleep = clock, sleep
        self._origin_ns = clock()

    def restart(self) -> None:
        """Simulated time starts anew at 0, now."""
        self._origin_ns = self._clock()

    def wait_for(self, time_ns: int) -> None:
        """Return when the wall clock has reached simulated time `time_ns`."""
        while (ahead := self._origin_ns + time_ns - self._clock()) > 0:
            self._sleep(ahead / NS_PER_S)

    def check(self, time_ns: int) -> None:
        """Count the deadline `time_ns` of the stretch that has just been run."""
        late = self._clock() - self._origin_ns - time_ns
        self.deadlines += 1
        if late > 0:
            self.missed += 1
            self.worst_late_ns = max(self.worst_late_ns, late)


def pace_of(nodes: tuple[Node, ...]) -> RateClock:
    """How often to look at the wall clock: at the rate of the fastest block, within what a kernel keeps."""
    rates = [clock.rate for node in nodes if isinstance(clock := node.clock, RateClock)]
    return RateClock.from_rate(min(max(rates, default=Fraction(100)), Fraction(_MOST_HZ)))
