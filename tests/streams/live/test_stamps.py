"""Stamps that can be believed increase and are never later than the arrival, whatever a sender says."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.streams.live.reader import PATIENCE_NS, CaptureStamps, RateWatch

PERIOD = 10 * NS_PER_MS
START = 1000 * NS_PER_S
TRANSIT = 400_000


def judged(stamps, arrivals):
    judge = CaptureStamps(PERIOD).judge
    return [judge(int(stamp), int(arrived)) for stamp, arrived in zip(stamps, arrivals, strict=True)]


def steady(count, start=START):
    return start + PERIOD * np.arange(count)


def test_samples_in_order_keep_their_stamps():
    stamps = steady(50)
    verdicts = judged(stamps, stamps + TRANSIT)
    assert [v.captured_ns for v in verdicts] == stamps.tolist()
    assert {v.status for v in verdicts} == {""}


@st.composite
def lying_senders(draw):
    """(stamp, arrival) of samples of a sender that stalls, jumps, repeats, reorders and lies, at random."""
    steps = draw(st.lists(st.integers(0, 5 * NS_PER_S) | st.just(PERIOD), min_size=1, max_size=60))
    arrivals = START + np.cumsum(steps)
    lies = st.integers(-NS_PER_S, NS_PER_S) | st.just(0) | st.integers(-2**60, 2**60) | st.just(-(2**62))
    stamps = [int(arrived) - TRANSIT + draw(lies) for arrived in arrivals]
    return stamps, arrivals.tolist()


@pytest.mark.slow
@given(lying_senders())
@example(([-1, 2**62, 0], [START, START, START]))
def test_no_lie_gets_through(sender):
    stamps, arrivals = sender
    verdicts = judged(stamps, arrivals)
    captures = [v.captured_ns for v in verdicts if v.captured_ns is not None]
    assert all(0 <= v.captured_ns <= arrived for v, arrived in zip(verdicts, arrivals, strict=True)
               if v.captured_ns is not None)
    assert all(later > earlier for earlier, later in pairwise(captures))
    assert all(v.status for v in verdicts if v.captured_ns is None)


def test_a_reordered_pair_loses_the_older_one():
    stamps = steady(10)
    order = [0, 1, 2, 4, 3, 5, 6, 7, 8, 9]
    verdicts = judged(stamps[order], stamps + TRANSIT + PERIOD)
    assert [v.status for v in verdicts] == [""] * 4 + ["stamp_behind"] + [""] * 5
    assert verdicts[4].captured_ns is None


def test_repetitions_are_left_out_for_ever():
    stamps = np.full(500, START)
    verdicts = judged(stamps, START + TRANSIT + PERIOD * np.arange(500))
    assert {v.status for v in verdicts[1:]} == {"stamp_repeated"}
    assert all(v.captured_ns is None for v in verdicts[1:])


def test_a_stamp_just_ahead_counts_as_now_and_one_far_ahead_not_at_all():
    judge, ahead = CaptureStamps(PERIOD).judge, 2 * NS_PER_MS
    assert judge(START + ahead, START) == (START, "", "")
    assert judge(START + PERIOD + ahead + 1, START + PERIOD).status == "stamp_ahead"


def test_a_clock_set_back_is_followed_after_a_second_and_told():
    arrivals = steady(300)
    stamps = arrivals - TRANSIT - np.where(np.arange(300) >= 100, 600 * NS_PER_S, 0)
    verdicts = judged(stamps, arrivals)
    left_out = [k for k, v in enumerate(verdicts) if v.captured_ns is None]
    assert left_out == list(range(100, 200))
    assert verdicts[100].status == "stamp_behind"
    assert verdicts[200].status == "clock_reset"
    assert verdicts[200].captured_ns == arrivals[200]
    assert [v.captured_ns for v in verdicts[201:]] == arrivals[201:].tolist()
    assert arrivals[200] - arrivals[100] >= PATIENCE_NS


def test_stamps_that_leap_on_and_on_are_no_clock_set_anew():
    arrivals = steady(300)
    stamps = arrivals - TRANSIT
    stamps[100:] += 2 * NS_PER_S * np.arange(1, 201)
    assert {v.status for v in judged(stamps, arrivals)[100:]} == {"stamp_ahead"}


def test_a_clock_set_anew_twice_is_doubted_twice():
    arrivals = steady(400)
    stamps = arrivals - TRANSIT
    stamps[100:] -= 600 * NS_PER_S
    stamps[201:] += NS_PER_S // 2
    verdicts = judged(stamps, arrivals)
    assert [k for k, v in enumerate(verdicts) if v.status == "clock_reset"] == [200, 301]
    assert all(v.captured_ns is None for v in verdicts[201:301])


def test_what_is_missing_is_told_with_its_length():
    stamps = np.delete(steady(20), [8, 9, 10])
    verdicts = judged(stamps, stamps + TRANSIT)
    assert [v.status for v in verdicts if v.status] == ["samples_missing"]
    assert "40 ms" in verdicts[8].detail


@given(st.floats(0.2, 5.0))
def test_another_rate_is_told_once_and_so_is_the_return(factor):
    watch = RateWatch(PERIOD)
    changed = np.rint(PERIOD / factor * np.ones(1000)).astype(np.int64)
    usual = np.full(200, PERIOD)
    told = [watch.note(int(stamp)) for stamp in START + np.cumsum(np.concatenate([usual, changed, usual]))]
    found = [status for status, _ in told if status]
    if 0.85 < factor < 1.2:
        assert found == []
    elif factor < 0.8 or factor > 1.4:
        assert found == ["rate_changed", "rate_restored"]


@given(st.integers(0, 40), st.integers(0, 30))
def test_a_sender_may_make_up_for_a_stall(stalled, after):
    watch = RateWatch(PERIOD)
    sent = [START + k * PERIOD for k in range(100 + after)]
    burst = [sent[-1] + (stalled + 1) * PERIOD + k * 50_000 for k in range(stalled)]
    later = [sent[-1] + (stalled + 2 + k) * PERIOD for k in range(200)]
    assert not any(watch.note(stamp)[0] for stamp in [*sent, *burst, *later])


def test_twice_the_rate_is_told_soon_however_long_the_rate_was_right():
    watch = RateWatch(PERIOD)
    for k in range(5000):
        watch.note(START + k * PERIOD)
    last = START + 4999 * PERIOD
    told = [watch.note(last + k * PERIOD // 2)[0] for k in range(1, 201)]
    assert [status for status in told if status] == ["rate_changed"]


def test_arrivals_that_are_a_little_too_close_are_told():
    watch = RateWatch(PERIOD, by_sender=False)
    told = [watch.note(START + k * PERIOD * 3 // 4)[0] for k in range(150)]
    assert [status for status in told if status] == ["rate_changed"]


def test_a_wrong_rate_is_named():
    watch = RateWatch(PERIOD)
    told = [watch.note(int(stamp)) for stamp in START + 2 * PERIOD * np.arange(60)]
    assert "50 Hz, 100 Hz were said" in next(detail for status, detail in told if status)


@given(st.integers(1, 20))
def test_arrivals_in_bursts_are_no_change_of_rate(burst):
    watch = RateWatch(PERIOD, by_sender=False)
    arrivals = [START + (k // burst) * burst * PERIOD + (k % burst) * 50_000 for k in range(400)]
    assert not any(watch.note(arrived)[0] for arrived in arrivals)


@given(st.lists(st.integers(0, 199), max_size=60, unique=True))
def test_single_losses_are_no_change_of_rate(lost):
    watch = RateWatch(PERIOD)
    kept = [k for k in range(200) if k not in lost or k - 1 in lost or k - 2 in lost]
    assert not any(watch.note(START + k * PERIOD)[0] for k in kept)
