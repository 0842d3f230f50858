"""What a run in step with the wall clock goes by: which instants are waited for, and what blocks are told.

A plain kernel wakes a sleeper some ms late now and then, so instants are those of blocks of at most 200 Hz.
Plants and faster blocks catch up at each of them, in bursts.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from heapq import merge
from itertools import count

from fesloop.errors import InputError
from fesloop.loop.clock import FOREVER, NS_PER_S, Clock, RateClock, waits_for_arrivals
from fesloop.loop.wiring import Node

_MOST_HZ = 200
_IDLE = RateClock.from_rate("100")
"""Where no block has a pace of its own (chosen): plants and the recording go on while a stream is silent."""
_HIGHEST_PRIORITY = 98
"""Of SCHED_FIFO on Linux (`sched(7)`), one below the greatest, which is for what keeps watch over a run."""
POLICIES = ("catch-up", "skip", "stop")


@dataclass(frozen=True, slots=True, kw_only=True)
class Pacing:
    """How a run keeps in step with the wall clock.

    Attributes
    ----------
    late: what becomes of ticks that are late. "catch-up" runs every one as soon as it can; "skip" lets those
        pass that lie a whole period of their block or more in the past; "stop" ends the run as failed at the
        first missed deadline.
    lock_memory: whether to ask that no memory of the process is swapped out.
    priority: of the scheduling class SCHED_FIFO, 1 to 98; 0 asks for none. It is that of the loop and of
        Python's threads that its blocks have started in `init`. Above everything else on its core, a run that
        is always late leaves little of it to others. With a device, below what the user may have at most
        (`ulimit -r`): the device's keeper takes that.
    """

    late: str = "catch-up"
    lock_memory: bool = True
    priority: int = 0

    def __post_init__(self) -> None:
        if self.late not in POLICIES:
            raise InputError("--late", f"{self.late!r}", ", ".join(POLICIES))
        if not 0 <= self.priority <= _HIGHEST_PRIORITY:
            raise InputError("--priority", f"{self.priority}", f"1 to {_HIGHEST_PRIORITY}, or 0 for none")


@dataclass(frozen=True, slots=True)
class Present:
    """What a block that hears the world is told when a trial begins.

    Attributes
    ----------
    origin_ns: `time.monotonic_ns()` at t = 0 of the trial.
    bell: the loop sleeps on it; set it, from any thread, when something has arrived.
    """

    origin_ns: int
    bell: threading.Event


def is_live(node: Node) -> bool:
    """Whether a node has to do with the world as it is now, so that it needs a run that is paced."""
    return hasattr(node.part, "attach") or waits_for_arrivals(node.clock)


def paced_clocks(nodes: Iterable[Node]) -> tuple[Clock, ...]:
    """Clocks whose ticks are waited for: of blocks of at most 200 Hz, and 200 Hz where others are faster."""
    clocks: list[Clock] = []
    for node in nodes:
        clock = node.clock
        if clock is None or waits_for_arrivals(clock):
            continue
        if clock.period_s < 1 / _MOST_HZ:
            clock = RateClock.from_rate(_MOST_HZ)
        if clock not in clocks:
            clocks.append(clock)
    return tuple(clocks) or (_IDLE,)


def shortest_period_ns(nodes: Iterable[Node]) -> int:
    """The time that an instant's work may take: the shortest period that is waited for, nominal or not."""
    nodes = tuple(nodes)
    clocks = [*paced_clocks(nodes), *(clock for node in nodes if waits_for_arrivals(clock := node.clock))]
    return max(NS_PER_S // _MOST_HZ, min(round(clock.period_s * NS_PER_S) for clock in clocks))


def instants(clocks: Iterable[Clock]) -> Iterator[int]:
    """Every instant, ns, at which one of the clocks ticks, each once, ascending."""
    before = -1
    for instant in merge(*(_ticks(clock) for clock in clocks)):
        if instant > before:
            yield instant
            before = instant


def _ticks(clock: Clock) -> Iterator[int]:
    for index in count():
        instant = clock.tick(index)
        if instant >= FOREVER:
            return
        yield instant
