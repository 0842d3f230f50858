"""Clocks against exact rational arithmetic."""

from fractions import Fraction
from itertools import islice

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.loop.clock import (
    FOREVER,
    NS_PER_MS,
    NS_PER_S,
    RateClock,
    StampClock,
    duration_ns,
    parse_rate,
    ticks_from,
)

rates = st.fractions(Fraction(1, 1000), 10**6, max_denominator=10**6)
offsets = st.integers(0, 10**10)


@given(rates, offsets, st.integers(0, 10**12))
def test_tick_is_the_floor_of_the_exact_instant(rate, offset, index):
    exact = offset + index * NS_PER_S / rate
    assert RateClock.from_rate(rate, offset).tick(index) == exact.numerator // exact.denominator


@given(rates, offsets, st.integers(0, 10**14))
def test_first_and_last_are_inverse_to_tick(rate, offset, time):
    clock = RateClock.from_rate(rate, offset)
    first, last = clock.first_at_or_after(time), clock.last_at_or_before(time)
    assert clock.tick(first) >= time
    assert first == 0 or clock.tick(first - 1) < time
    assert last == -1 or clock.tick(last) <= time
    assert clock.tick(last + 1) > time


@given(rates, offsets, st.integers(0, 10**9))
@example(Fraction(1000), 0, 0)
@example(Fraction(2000, 7), 3, 10)
def test_counting_on_equals_each_tick(rate, offset, start):
    clock = RateClock.from_rate(rate, offset)
    following = ticks_from(clock, start)
    assert [following() for _ in range(20)] == [clock.tick(start + i) for i in range(20)]


@pytest.mark.parametrize(("text", "rate"), [
    ("60", Fraction(60)), ("285.714", Fraction(285714, 1000)), ("2000/7", Fraction(2000, 7)),
    (285.714, Fraction(285714, 1000)), (50, Fraction(50)), (0.1, Fraction(1, 10))])
def test_rates_are_read_through_their_decimal_text(text, rate):
    assert parse_rate(text) == rate


@pytest.mark.parametrize("bad", ["", "fast", "0", "-1", "1/0", "inf", "nan", True, None, [], "2e9", -3.0,
                                 "1e999999999", "1e-999999999", "1e99999999999999999999"])
def test_bad_rates_are_refused_in_one_line(bad):
    with pytest.raises(InputError) as caught:
        parse_rate(bad, "blocks.pid.rate")
    assert str(caught.value).startswith("blocks.pid.rate: ")
    assert "\n" not in str(caught.value)


@given(st.integers(0, 10**13))
def test_durations_are_read_through_their_decimal_text(ns):
    whole, rest = divmod(ns, NS_PER_MS)
    assert duration_ns(f"{whole}.{rest:06d}", NS_PER_MS, "x") == ns


@pytest.mark.parametrize(("bad", "told"), [
    ("-1", "'-1' is negative; allowed: zero or more"), (-5, "-5 is negative; allowed: zero or more"),
    ("nan", "'nan' is not a duration; allowed: a finite number, zero or more"),
    (float("inf"), "inf is not a duration; allowed: a finite number, zero or more"),
    ("x", "'x' is not a duration; allowed: a number"), (True, "True is not a duration; allowed: a number"),
    (1e300, "1e+300 is longer than any run; allowed: below 4.61e+12")])
def test_bad_durations_are_refused_with_what_may_stand_there(bad, told):
    with pytest.raises(InputError) as refused:
        duration_ns(bad, NS_PER_MS, "latency_ms")
    assert str(refused.value) == f"latency_ms: {told}"


@given(st.lists(st.integers(1, 10**9), min_size=1, max_size=30), st.integers(0, 10**6))
def test_stamps_tick_and_stop(steps, start):
    stamps = start + np.cumsum(np.array(steps)) - steps[0]
    clock = StampClock(stamps)
    assert [clock.tick(i) for i in range(len(steps))] == stamps.tolist()
    assert clock.tick(len(steps)) == FOREVER
    following = ticks_from(clock, 0)
    assert list(islice(iter(following, FOREVER), 100)) == stamps.tolist()
    for time in (0, int(stamps[0]), int(stamps[-1]), int(stamps[-1]) + 1):
        first = clock.first_at_or_after(time)
        assert clock.tick(first) >= time
        assert first == 0 or clock.tick(first - 1) < time
        assert clock.last_at_or_before(time) == np.count_nonzero(stamps <= time) - 1


@pytest.mark.parametrize("bad", [[], [3, 3], [5, 4], [-1, 2], [[1, 2]]])
def test_bad_stamps_are_refused(bad):
    with pytest.raises(InputError):
        StampClock(np.array(bad, dtype=np.int64))
