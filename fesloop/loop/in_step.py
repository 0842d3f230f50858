"""Python's collector of reference cycles, which stops everything for some ms, kept out of deadlines' way."""

from __future__ import annotations

import gc
import time
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.machine import Granted, asked_of_machine
from fesloop.loop.realtime import Pacer, Pacing
from fesloop.loop.run import Loop

_OFTEN_NS = NS_PER_S
_AT_LAST_NS = 30 * NS_PER_S
"""How often to collect where there is leisure, and where there is none (chosen): what waits meanwhile is
the cycles alone, as all else is freed at once, and the loop makes none."""
_AT_FIRST_NS = 2 * NS_PER_MS
"""What a collection is expected to take before one has been timed."""


class Garbage:
    """The collector during a run in real time: a context.

    What exists when the run begins is collected once, then frozen: no later collection looks at it. The
    collector is off from then on, and asked to work where nothing is due for twice as long as it has ever
    worked (not counting what else the machine did meanwhile), or else every half minute. All of it is undone
    at the end.

    Attributes
    ----------
    collections, worst_ns: how many there were during the run, and how long the longest took.
    """

    def __init__(self) -> None:
        self.collections = self.worst_ns = 0
        self._last_ns = 0
        self._expected_ns = _AT_FIRST_NS
        self._enabled = self._frozen = False

    def __enter__(self) -> Self:
        self._enabled, self._frozen = gc.isenabled(), gc.get_freeze_count() == 0
        gc.collect()
        if self._frozen:
            gc.freeze()
        gc.disable()
        self._last_ns = time.monotonic_ns()
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None,
                 trace: TracebackType | None) -> None:
        if self._frozen:
            gc.unfreeze()
        if self._enabled:
            gc.enable()

    def collect_in(self, leisure_ns: int) -> None:
        """Collect if it is time, and nothing is due for so long."""
        began = time.monotonic_ns()
        since = began - self._last_ns
        if since < _OFTEN_NS or (leisure_ns < 2 * self._expected_ns and since < _AT_LAST_NS):
            return
        worked_ns = time.thread_time_ns()
        gc.collect()
        self._expected_ns = max(self._expected_ns, time.thread_time_ns() - worked_ns)
        self._last_ns = time.monotonic_ns()
        self.collections += 1
        self.worst_ns = max(self.worst_ns, self._last_ns - began)


@dataclass(frozen=True, slots=True)
class InStep:
    """What a run in real time goes by.

    Attributes
    ----------
    pacing, pacer: how it is to keep time, and what does.
    garbage: Python's collector, held back.
    granted: what the operating system gave.
    """

    pacing: Pacing
    pacer: Pacer
    garbage: Garbage
    granted: Granted

    def advance(self, stop_ns: int) -> int:
        """The pacer's; then a collection where there is leisure for one."""
        done = self.pacer.advance(stop_ns)
        self.garbage.collect_in(self.pacer.slack_ns())
        return done

    @property
    def facts(self) -> dict[str, str | float]:
        """What a recording says of it from the start."""
        return {"policy": self.pacing.late, "period_ms": self.pacer.period_ns / NS_PER_MS,
                "memory": self.granted.memory, "scheduling": self.granted.scheduling}

    @property
    def outcome(self) -> dict[str, int | float]:
        """What a recording says of it in the end."""
        return {"deadlines": self.pacer.deadlines, "missed_deadlines": self.pacer.missed,
                "worst_late_s": self.pacer.worst_late_ns / NS_PER_S,
                "collections": self.garbage.collections,
                "worst_collection_ms": self.garbage.worst_ns / NS_PER_MS}


@contextmanager
def in_step_with_wall(loop: Loop, pacing: Pacing | None, beside: Collection[int]) -> Iterator[InStep | None]:
    """What a run of the loop goes by, with the threads beside it; None where it need not keep time."""
    if pacing is None:
        yield None
        return
    with asked_of_machine(pacing.lock_memory, pacing.priority, beside) as granted:
        yield InStep(pacing, Pacer(loop, pacing), Garbage(), granted)
