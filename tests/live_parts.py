"""A wall clock that tests move, blocks that take their time on it, and a stream that goes by a plan."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from fesloop.loop.clock import RateClock
from fesloop.loop.signals import Port


class Wall:
    """A wall clock that stands still but for sleeping (a little too long) and working."""

    def __init__(self, oversleeps_ns=(80_000,)):
        self.now = self.origin = 1_000_000_000
        self._over, self.sleeps = oversleeps_ns, 0

    def clock(self):
        return self.now

    def sleep(self, seconds):
        self.now += round(seconds * 1e9) + self._over[self.sleeps % len(self._over)]
        self.sleeps += 1

    @property
    def trial_ns(self):
        return self.now - self.origin


@dataclass
class Log:
    """What a part did: (tick index, instant, where the wall clock stood)."""

    steps: list[tuple[int, int, int]] = field(default_factory=list)
    present: Any = None
    taken: int = 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Worker:
    """A block whose k-th step takes works[k] ns of the wall clock, and puts out its tick number."""

    wall: Wall
    works: tuple[int, ...] = (1_000_000,)
    inputs = ()
    outputs = (Port("y"),)

    def init(self, context):
        return Log()

    def step(self, state, inputs, tick):
        state.steps.append((tick.index, tick.time_ns, self.wall.trial_ns))
        self.wall.now += self.works[(len(state.steps) - 1) % len(self.works)]
        return (float(tick.index),)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stream:
    """A live block: message k arrives at arrivals_ns[k], captured `age_ns` before, and holds k."""

    wall: Any
    arrivals_ns: tuple[int, ...]
    age_ns: int = 0
    clock: RateClock = field(default_factory=lambda: RateClock.from_rate("100", arrivals="glove"))
    inputs = ()
    outputs = (Port("y"),)

    def init(self, context):
        return Log()

    def attach(self, state, present):
        state.present = present

    def waiting(self, state):
        if state.taken < len(self.arrivals_ns) and self.arrivals_ns[state.taken] <= self.wall.trial_ns:
            return self.arrivals_ns[state.taken]
        return None

    def step(self, state, inputs, tick):
        arrived = self.arrivals_ns[state.taken]
        state.steps.append((tick.index, tick.time_ns, self.wall.trial_ns))
        state.taken += 1
        tick.captured_ns = max(0, arrived - self.age_ns)
        return (float(state.taken - 1),)

    def stand_in(self):
        return StandIn(clock=replace(self.clock, arrivals=""))

    def close(self, state):
        state.present = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StandIn:
    """In place of the stream."""

    clock: RateClock
    inputs = ()
    outputs = (Port("y"),)

    def init(self, context):
        return Log()

    def step(self, state, inputs, tick):
        return (0.0,)
