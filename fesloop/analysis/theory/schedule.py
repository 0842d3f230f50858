"""The events of a linear loop within one period of all its clocks, in the order of a run.

Times are whole nanoseconds, so that ticks, arrivals between ticks and ties are those of a run (`loop.run`):
at one instant messages reach the plant, then blocks step in their order, then the recorder reads.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.theory.loop import LinearLoop, arrived, clock_of, latency_ns, most_ns, varies
from fesloop.loop.clock import NS_PER_MS, RateClock
from fesloop.loop.nodes import Connection, Node
from fesloop.loop.order import Sampling
from fesloop.models.linear_form import uncovered

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """One tick of a wire's reader.

    Attributes
    ----------
    time_ns, before_ns: instants of this tick and of the one before.
    sent, sent_before: numbers of messages sent by then.
    """

    time_ns: int
    before_ns: int
    sent: int
    sent_before: int


def oldest_age(connection: Connection, looks: list[Look]) -> int:
    """Greatest age, in messages, that can arrive between two looks; older messages are all "old"."""
    clock, most = clock_of(connection), most_ns(connection)
    return max(look.sent - clock.first_at_or_after(look.before_ns - most + 1) for look in looks)


def transition(connection: Connection, look: Look, oldest: int) -> Array:
    """Probabilities of age j at this look given age i at the one before, (oldest + 1, oldest + 1)."""
    hazards = [_hazard(connection, look, age) for age in range(oldest)]
    chances = np.zeros((oldest + 1, oldest + 1))
    for before in range(oldest + 1):
        aged = min(before + look.sent - look.sent_before, oldest)
        nothing_newer = 1.0
        for age in range(aged):
            chances[before, age] = nothing_newer * hazards[age]
            nothing_newer *= 1.0 - hazards[age]
        chances[before, aged] += nothing_newer
    return chances


def _hazard(connection: Connection, look: Look, age: int) -> float:
    """Probability that the message of an age arrives between the look before and this one."""
    clock: RateClock = clock_of(connection)
    made_ns = clock.tick(look.sent - 1 - age)
    by_then = arrived(connection, look.before_ns - made_ns)
    by_now = arrived(connection, look.time_ns - made_ns)
    return (by_now - by_then) / (1.0 - by_then) if by_then < 1.0 else 0.0


def stationary(transitions: list[Array]) -> Array:
    """Stationary probabilities of the ages before the first of a cycle of transitions, (ages,)."""
    cycle = np.linalg.multi_dot(transitions) if len(transitions) > 1 else transitions[0]
    ages = len(cycle)
    # pi (cycle - 1) = 0 and the sum is 1: as many equations as unknowns and one more, all consistent.
    equations = np.vstack([(cycle - np.eye(ages)).T, np.ones(ages)])
    constant = np.zeros(ages + 1)
    constant[-1] = 1.0
    found = np.linalg.lstsq(equations, constant, rcond=None)[0]
    return np.asarray(np.maximum(found, 0.0) / np.maximum(found, 0.0).sum())


_MOST_EVENTS = 5000
"""Most events in a period (chosen: a second of a loop that is read at 1 kHz has fewer; rates with a long
common period have more)."""
_FIRST, _LAST = -1.0, math.inf
"""Ranks at an instant of arrivals at the plant and of the recorder; the loop's order lies between them."""


@dataclass(frozen=True, slots=True, eq=False)
class Delivery:
    """Messages that a port may receive at an instant.

    Attributes
    ----------
    connection: the wire.
    ages: of the messages, newest first, counted back from the newest sent; each arrives unless it is lost.
    look: for a wire with jitter, the reader's tick, on which the ages depend.
    """

    connection: Connection
    ages: tuple[int, ...]
    look: Look | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Event:
    """An event of a period.

    Attributes
    ----------
    time_ns: since the beginning of the period.
    what: a node that steps, or a plant that is sampled; None for a reading, or an arrival at the plant.
    deliveries: messages that arrive before that.
    """

    time_ns: int
    what: Node | Sampling | None
    deliveries: tuple[Delivery, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Schedule:
    """The events of one period.

    Attributes
    ----------
    period_ns: its length.
    events: in order.
    readings: number of the recorder's readings.
    """

    period_ns: int
    events: tuple[Event, ...]
    readings: int


def schedule(loop: LinearLoop, read: bool) -> Schedule:
    """The schedule of one period long after the start, with the recorder's readings where `read`.

    Raises InputError for rates without a common period of at most a few thousand events.
    """
    clocks = (*loop.clocks, loop.reading) if read else loop.clocks
    period = math.lcm(*(clock.period_num for clock in clocks))
    if sum(period * clock.period_den // clock.period_num for clock in clocks) > _MOST_EVENTS:
        rates = ", ".join(dict.fromkeys(str(clock) for clock in clocks))
        raise uncovered(loop.name, f"{rates} have a common period of {period / NS_PER_MS:g} ms",
                        "rates with a short common period")
    slowest = max(clock.period_num for clock in clocks) + max(clock.offset_ns for clock in clocks)
    longest = max(most_ns(c) for c in loop.connections) + loop.plant_form.delay_ns
    start = (-(-(longest + slowest) // period) + 2) * period
    span = _Span(loop, start, period)
    found = [*span.steps(), *span.arrivals_at_the_plant()]
    readings = [(at, _LAST, Event(at - start, None)) for at in span.ticks(loop.reading)] if read else []
    ordered = sorted(found + readings, key=lambda each: each[:2])
    return Schedule(period, tuple(event for _, _, event in ordered), len(readings))


_Ranked = tuple[int, float, Event]


class _Span:
    """Events of a period that begins at `start`, with their instants and ranks."""

    def __init__(self, loop: LinearLoop, start: int, period: int) -> None:
        self.loop, self.start, self.period = loop, start, period
        self.order = loop.order
        self._ranks: dict[int, int] = {}
        for rank, item in enumerate(self.order):
            sent = item.connections if isinstance(item, Sampling) else [
                c for c in loop.connections if c.source is item]
            self._ranks |= {id(connection): rank for connection in sent}

    def ticks(self, clock: RateClock) -> Iterator[int]:
        """Instants of a clock within the period."""
        index = clock.first_at_or_after(self.start)
        while (instant := clock.tick(index)) < self.start + self.period:
            yield instant
            index += 1

    def steps(self) -> Iterator[_Ranked]:
        """Steps of blocks, and samplings of the plant."""
        for rank, item in enumerate(self.order):
            clock = item.clock
            assert isinstance(clock, RateClock)
            incoming = [] if isinstance(item, Sampling) else [
                c for c in self.loop.connections if c.target is item]
            for instant in self.ticks(clock):
                given = [self._read(c, clock, instant, rank) for c in incoming]
                yield instant, rank, Event(instant - self.start, item,
                                           tuple(each for each in given if each.ages or each.look))

    def arrivals_at_the_plant(self) -> Iterator[_Ranked]:
        """Arrivals of messages that act on the plant, its own delay included."""
        for connection in self.loop.connections:
            if connection.target is not self.loop.plant:
                continue
            clock = clock_of(connection)
            transport = latency_ns(connection) + self.loop.plant_form.delay_ns
            # Without any transport a message acts as soon as it is sent, else before blocks step.
            rank = self._ranks[id(connection)] + 0.5 if transport == 0 else _FIRST
            index = clock.first_at_or_after(self.start - transport)
            while (instant := clock.tick(index) + transport) < self.start + self.period:
                age = self._sent(connection, instant, rank) - 1 - index
                yield instant, rank, Event(instant - self.start, None, (Delivery(connection, (age,)),))
                index += 1

    def _sent(self, connection: Connection, instant: int, rank: float) -> int:
        """Number of messages sent before an event of a rank at an instant."""
        clock = clock_of(connection)
        return clock.last_at_or_before(instant if self._ranks[id(connection)] < rank else instant - 1) + 1

    def _read(self, connection: Connection, reader: RateClock, instant: int, rank: int) -> Delivery:
        """Messages that reach a block's port between its tick before and this one."""
        clock, latency = clock_of(connection), latency_ns(connection)
        before = reader.tick(reader.first_at_or_after(instant) - 1)
        sent = self._sent(connection, instant, rank)
        if varies(connection):
            look = Look(instant, before, sent, self._sent(connection, before, rank))
            return Delivery(connection, (), look)
        newest, known = clock.last_at_or_before(instant - latency), clock.last_at_or_before(before - latency)
        return Delivery(connection, tuple(sent - 1 - index for index in range(newest, known, -1)))
