"""A run in step with the wall clock: its pacer, and what is held back or asked for so that it keeps time."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.pacer import Pacer
from fesloop.loop.realtime import Pacing
from fesloop.loop.run import Loop
from fesloop.realtime.garbage import Garbage
from fesloop.realtime.machine import Granted, asked_of_machine


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
