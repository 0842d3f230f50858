"""Which instants a run in step with the wall clock waits for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from live_parts import Stream, Wall
from loop_parts import ImpulseProbe, Source

from fesloop.errors import InputError
from fesloop.loop.clock import RateClock, StampClock, waits_for_arrivals
from fesloop.loop.nodes import Node
from fesloop.loop.realtime import Pacing, instants, is_live, paced_clocks, shortest_period_ns


def rates(*rates):
    return tuple(Node(f"n{i}", Source(), rate) for i, rate in enumerate(rates))


@pytest.mark.parametrize(("nodes", "paced", "period_ns"), [
    (rates("50", "60"), ["50", "60"], 16_666_667), (rates("60", "60"), ["60"], 16_666_667),
    (rates("50", "1000"), ["50", "200"], 5_000_000), (rates("200"), ["200"], 5_000_000),
    ((), ["100"], 10_000_000), ((Node("plant", ImpulseProbe()),), ["100"], 10_000_000)])
def test_blocks_are_waited_for_up_to_what_a_kernel_keeps(nodes, paced, period_ns):
    assert paced_clocks(nodes) == tuple(RateClock.from_rate(rate) for rate in paced)
    assert shortest_period_ns(nodes) == period_ns


def test_stamps_are_waited_for_as_they_are_and_messages_are_not_but_count():
    stamps = StampClock(np.array([3, 9_000_000, 21_000_000]))
    stream = Node("glove", Stream(wall=Wall(), arrivals_ns=()))
    follower = Node("follower", Source(), stream.clock)
    assert waits_for_arrivals(follower.clock)
    assert paced_clocks((stream, follower, Node("slow", Source(), "10"))) == (RateClock.from_rate("10"),)
    assert shortest_period_ns((stream, Node("slow", Source(), "10"))) == 10_000_000
    swift = Node("swift", Source(), RateClock.from_rate("1000", arrivals="emg"))
    assert shortest_period_ns((swift, stream)) == 5_000_000
    assert paced_clocks((Node("stamps", Source(), stamps), stream)) == (stamps,)
    assert list(instants((stamps,))) == [3, 9_000_000, 21_000_000]
    assert [is_live(node) for node in (stream, follower, *rates("10"))] == [True, True, False]


@given(st.lists(st.tuples(st.integers(1, 7), st.integers(0, 20)), min_size=1, max_size=4))
def test_every_instant_of_any_clock_comes_once_and_in_order(periods):
    clocks = [RateClock(period, 1, offset) for period, offset in periods]
    expected = sorted({offset + k * period for period, offset in periods for k in range(200)})[:100]
    found = instants(clocks)
    assert [next(found) for _ in range(100)] == expected


def test_a_policy_that_is_none_is_refused():
    with pytest.raises(InputError, match="catch-up, skip, stop"):
        Pacing(late="hurry")
