"""Where in a recording that is being written its viewer is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fesloop.loop.clock import NS_PER_MS, NS_PER_S

Instant = tuple[int, int]
"""Trial, and time in it, ns."""
_LAG_NS = 900 * NS_PER_MS
"""How far behind what is written it begins (chosen: a run writes every .4 to .8 s; nothing has to
stand still until more comes)."""
_FARTHEST_NS = 5 * NS_PER_S // 2
"""Farther behind it leaps ahead (chosen): a run that is not in step with the wall clock may be faster."""


@dataclass(slots=True)
class Head:
    """It goes on as the wall clock does, through trial after trial, and stops where nothing is known."""

    trial: int = -1
    time_ns: int = 0
    _moved_ns: int = 0

    def move(self, now_ns: int, newest: Instant, end_of: Callable[[int], int | None]) -> None:
        """To where it is now, by the wall clock.

        Parameters
        ----------
        newest: up to where the recording is known.
        end_of: up to where a trial is known, ns; None where it is forgotten.
        """
        elapsed, self._moved_ns = now_ns - self._moved_ns, now_ns
        trial, end = newest
        if self.trial != trial:
            last = end_of(self.trial) if self.trial >= 0 else None
            left = 0 if last is None else last - self.time_ns
            if left <= elapsed or left + end > _FARTHEST_NS:
                self.trial, self.time_ns = trial, max(0, end - _LAG_NS)
            else:
                self.time_ns += elapsed
        elif end - self.time_ns > _FARTHEST_NS:
            self.time_ns = end - _LAG_NS
        else:
            self.time_ns = min(self.time_ns + elapsed, end)
