"""Pacing of a run by the wall clock.

The pacer waits for the instants of blocks of at most 200 Hz, since a plain kernel wakes a sleeper some ms
late now and then. Plants and faster blocks catch up at each of these instants, in bursts.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from heapq import merge
from itertools import count
from threading import Event
from typing import Any

from fesloop.errors import InputError
from fesloop.loop.abilities import Attaches, AwaitsArrivals, Listens, Present, offers
from fesloop.loop.clock import FOREVER, NS_PER_MS, NS_PER_S, Clock, RateClock, waits_for_arrivals
from fesloop.loop.nodes import Node
from fesloop.loop.run import Loop

_MOST_HZ = 200
_IDLE = RateClock.from_rate("100")
"""Pace where no block has one (chosen): plants and the recording continue while a stream is silent."""
_HIGHEST_PRIORITY = 98
"""Highest priority of SCHED_FIFO on Linux (`sched(7)`) less one, which is left to supervisors of a run."""
POLICIES = ("catch-up", "skip", "stop")


@dataclass(frozen=True, slots=True, kw_only=True)
class Pacing:
    """Settings of a run in step with the wall clock.

    Attributes
    ----------
    late: treatment of late ticks. "catch-up" runs every one as soon as it can; "skip" omits ticks that are
        late by a whole period of their block or more; "stop" ends the run as failed at the first missed
        deadline.
    lock_memory: request that no memory of the process is swapped out.
    priority: of the scheduling class SCHED_FIFO, 1 to 98; 0 requests none. It holds for the loop and for
        Python threads that its blocks have started in `init`. Above everything else on its core, a run that
        is always late leaves little of the core to others. With a device, it must be below the greatest that
        the user may have (`ulimit -r`), which the device's keeper takes.
    """

    late: str = "catch-up"
    lock_memory: bool = True
    priority: int = 0

    def __post_init__(self) -> None:
        if self.late not in POLICIES:
            raise InputError("--late", f"{self.late!r}", ", ".join(POLICIES))
        if not 0 <= self.priority <= _HIGHEST_PRIORITY:
            raise InputError("--priority", f"{self.priority}", f"1 to {_HIGHEST_PRIORITY}, or 0 for none")


def is_live(node: Node) -> bool:
    """True for a node that works with the outside world as it is now, and so needs a paced run."""
    return offers(node.part, Attaches) or waits_for_arrivals(node.clock)


def paced_clocks(nodes: Iterable[Node]) -> tuple[Clock, ...]:
    """Clocks that the pacer waits for: of blocks of at most 200 Hz, and 200 Hz where others are faster."""
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
    """Time that an instant's work may take: the shortest period that the pacer waits for, nominal or not."""
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


KEPT, LATE, SKIPPED, STOPPED = "kept", "run late", "skipped", "stopped"
WallRow = tuple[int, int, int, str]
"""(instant, lateness at the start of its work, duration of the work, action); times in ns."""
_NAP_NS = NS_PER_S // 20
"""Longest sleep (chosen): interrupts are handled, and the recording is written, between two sleeps."""


class Pacer:
    """Runs a loop in step with the wall clock.

    A deadline is missed where the work of an instant ends more than the shortest paced period after it.

    Parameters
    ----------
    loop: what runs; one trial after the other.
    pacing: settings.
    clock, sleep: wall clock in ns, and a wait for some seconds; by default on the bell of blocks that have
        one.

    Attributes
    ----------
    deadlines, missed: their numbers.
    worst_late_ns: greatest lateness of an instant.
    rows, origins: a row an instant; of each trial's t = 0, the wall clock and the time (ns since 1970, UTC).
        The writer of the recording removes them.
    """

    def __init__(self, loop: Loop, pacing: Pacing, clock: Callable[[], int] = time.monotonic_ns,
                 sleep: Callable[[float], Any] | None = None) -> None:
        nodes = loop.wiring.nodes
        self._loop, self._pacing, self._clock = loop, pacing, clock
        self._clocks = paced_clocks(nodes)
        self.period_ns = shortest_period_ns(nodes)
        self._live = tuple(node for node in nodes if is_live(node))
        self._hearing = tuple(
            (node.name, node.part, ticks) for node in nodes
            if waits_for_arrivals(ticks := node.clock) and offers(node.part, AwaitsArrivals))
        self._listening = tuple((node.name, node.part) for node in nodes if offers(node.part, Listens))
        self._expected: dict[RateClock, int] = {}
        self._bell = Event()
        self._sleep = sleep or (self._bell.wait if self._live else time.sleep)
        self.deadlines = self.missed = self.worst_late_ns = 0
        self.rows: list[WallRow] = []
        self.origins: list[tuple[int, int]] = []
        self._states: dict[str, Any] = {}
        self._instants: Iterator[int] = iter(())
        self._next = self._origin_ns = 0
        self._skipped: set[int] = set()

    def begin_trial(self) -> None:
        """Make now t = 0 of the next trial."""
        self._states = self._loop.states()
        self._instants = instants(self._clocks)
        self._next = next(self._instants, FOREVER)
        self._skipped.clear()
        self._expected.clear()
        self._origin_ns = self._clock()
        self.origins.append((self._origin_ns, time.time_ns()))
        present = Present(self._origin_ns, self._bell)
        for node in self._live:
            if offers(node.part, Attaches):
                node.part.attach(self._states[node.name], present)

    def now_ns(self) -> int:
        """Time on the wall clock since t = 0 of the trial."""
        return self._clock() - self._origin_ns

    def slack_ns(self) -> int:
        """Time until something is due; a message of a live stream is, one period after the one before."""
        now = self.now_ns()
        return min([self._next, *(instant for instant in self._expected.values() if instant > now)]) - now

    def advance(self, stop_ns: int) -> int:
        """Run the instant that has come, or sleep towards the next for a moment.

        Returns the end (exclusive) of what has been run; nothing at or after `stop_ns` is. Raises
        RunError as the loop does, and for a missed deadline where the policy is to stop.
        """
        self._bell.clear()
        arrivals = self._arrivals()
        due = min([self._next, *(instant for instant, _ in arrivals)])
        ahead = min(due, stop_ns) - self.now_ns()
        if ahead > 0:
            self._sleep(min(ahead, _NAP_NS) / NS_PER_S)
        elif due >= stop_ns:
            self._loop.run_until(stop_ns - 1)
        else:
            self._run(due, [clock for instant, clock in arrivals if instant == due], stop_ns)
        return self._loop.now + 1

    def _arrivals(self) -> list[tuple[int, RateClock]]:
        """Instant at which each live block reads its oldest waiting message, and the block's clock."""
        found = []
        for name, part, clock in self._hearing:
            arrived = part.waiting(self._states[name])
            if arrived is not None:
                found.append((max(arrived, self._loop.now + 1), clock))
        return found

    def _run(self, due: int, arrivals: list[RateClock], stop_ns: int) -> None:
        """Run everything due at or before `due`, when these clocks of arrivals tick; note the lateness."""
        began = self.now_ns()
        known = len(self._loop.recorder.events) if self._loop.recorder is not None else 0
        for clock in arrivals:
            self._let_arrive(clock, due, began)
        if self._pacing.late == "skip" and began - due >= self.period_ns:
            self._skipped |= self._loop.skip_until(min(began, stop_ns - 1), self._clocks)
        try:
            self._loop.run_until(due)
        finally:
            self._pass_on_events(known)
        ended = self.now_ns()
        skipped = due in self._skipped
        self._skipped.discard(due)
        if due >= self._next:
            self._next = next(self._instants, FOREVER)
        self._note(due, began - due, ended - began, skipped)

    def _pass_on_events(self, number: int) -> None:
        """Give events from `number` on to the blocks that listen."""
        recorder = self._loop.recorder
        if recorder is not None and len(recorder.events) > number:
            for name, part in self._listening:
                part.heed(self._states[name], recorder.events[number:])

    def _let_arrive(self, clock: RateClock, due: int, now: int) -> None:
        """Let a clock of arrivals tick; a late message that is skipped is read by its own block alone."""
        skipping: list[str] = []
        if self._pacing.late == "skip" and now - due >= clock.period_s * NS_PER_S:
            skipping = [node.name for node in self._loop.wiring.nodes
                        if node.clock == clock and not offers(node.part, AwaitsArrivals)]
        self._loop.arrive(clock, due, skipping)
        self._expected[clock] = due + round(clock.period_s * NS_PER_S)
        if skipping:
            self._skipped.add(due)

    def _note(self, due: int, late_ns: int, took_ns: int, skipped: bool) -> None:
        """Count the deadline and add its row; stop where that is the policy."""
        missed = skipped or late_ns + took_ns > self.period_ns
        stopped = missed and self._pacing.late == "stop"
        self.deadlines += 1
        self.missed += missed
        self.worst_late_ns = max(self.worst_late_ns, late_ns)
        action = STOPPED if stopped else SKIPPED if skipped else LATE if missed else KEPT
        self.rows.append((due, late_ns, took_ns, action))
        if stopped:
            raise self._loop.fail(
                f"real time: what was due at {due / NS_PER_MS:.3f} ms began {late_ns / NS_PER_MS:.3f} ms "
                f"late and took {took_ns / NS_PER_MS:.3f} ms, beyond the period of "
                f"{self.period_ns / NS_PER_MS:g} ms (--late stop)")
