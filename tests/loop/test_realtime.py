"""The pacer, on a wall clock that the test moves."""

import pytest
from loop_parts import Source

from fesloop.loop.clock import RateClock
from fesloop.loop.realtime import Pacer, pace_of
from fesloop.loop.wiring import Node


class Wall:
    """A wall clock that stands still but for sleeping (a little too long) and working."""

    def __init__(self):
        self.now = 1_000_000_000

    def clock(self):
        return self.now

    def sleep(self, seconds):
        self.now += round(seconds * 1e9) + 80_000


def paced(work_ns, stretches=100, rate="100"):
    wall = Wall()
    pacer = Pacer(RateClock.from_rate(rate), wall.clock, wall.sleep)
    pacer.restart()
    begun = []
    for number in range(stretches):
        pacer.wait_for(pacer.period.tick(number))
        begun.append(wall.now - 1_000_000_000)
        wall.now += work_ns(number)
        pacer.check(pacer.period.tick(number + 1))
    return pacer, begun


def test_a_stretch_never_begins_early_and_sleep_never_adds_up():
    pacer, begun = paced(lambda number: 1_000_000)
    assert all(0 <= at - number * 10_000_000 <= 80_000 for number, at in enumerate(begun))
    assert (pacer.deadlines, pacer.missed) == (100, 0)


def test_one_long_stretch_is_one_missed_deadline_and_is_made_up_for():
    pacer, begun = paced(lambda number: 25_000_000 if number == 10 else 2_000_000)
    assert pacer.missed == 2, "its own, and that of the one that began 15 ms late and took 2"
    assert pacer.worst_late_ns == pytest.approx(15_000_000, abs=100_000)
    assert begun[14] - 140_000_000 <= 80_000


def test_what_is_always_too_slow_misses_every_deadline():
    pacer, _ = paced(lambda number: 12_000_000, stretches=50)
    assert pacer.missed == 50


def test_the_pace_is_that_of_the_fastest_block_within_reason():
    nodes = tuple(Node(f"n{i}", Source(), rate) for i, rate in enumerate(("50", "60")))
    assert pace_of(nodes).rate == 60
    assert pace_of((*nodes, Node("fast", Source(), "1000"))).rate == 200
    assert pace_of(()).rate == 100
