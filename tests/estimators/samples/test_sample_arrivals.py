"""Samples as they arrive: which are new, which are held for too long, and what is wrong with them."""

import numpy as np
import pytest

from estimators.arrivals import CLIPPED, LOST, Arrivals, compare, inspect_kinds
from fesloop.loop.block import Tick
from fesloop.loop.signals import NEVER, Sample

LIMITS = (30.0, 100.0, np.inf)
PERIOD_NS = 5_000_000
PERIOD = 5e-3


def noisy(seed=0, sensors=3):
    """One sample of each kind."""
    gyr, acc, mag = np.random.default_rng(seed).normal(size=(3, sensors, 3))
    return gyr, acc + np.array([0.0, 0.0, 9.8]), mag + np.array([0.0, 20.0, -40.0])


def noted(arrivals, rows, captured, now=None):
    """Which kinds are new with these captures, and what is reported."""
    tick = Tick()
    tick.time_ns = max(captured) if now is None else now
    samples = [Sample(kind, at, at, at) for kind, at in zip(rows, captured, strict=True)]
    return arrivals.note(samples, tick), tick.reports


def test_kinds_are_new_by_their_own_stamps_and_only_a_held_rate_is_a_repetition():
    arrivals = Arrivals(3, LIMITS, PERIOD)
    ms = 1_000_000
    first = noisy()
    assert noted(arrivals, first, (0, 0, 0)) == (pytest.approx([PERIOD] * 3), [])
    assert noted(arrivals, noisy(1), (5 * ms, 0, 0))[0] == pytest.approx([5e-3, 0.0, 0.0])
    last = noisy(2)
    assert noted(arrivals, last, (10 * ms, 10 * ms, 0)) == (pytest.approx([5e-3, 1e-2, 0.0]), [])
    new, reports = noted(arrivals, last, (10 * ms, 10 * ms, 0), 15 * ms)
    assert not any(new)
    assert [status for status, _ in reports] == ["repeated_sample"]
    assert noted(arrivals, noisy(3), (20 * ms, 10 * ms, 20 * ms))[1][0][0] == "samples_valid"


def test_held_samples_behind_the_stamps_of_faster_gyroscopes_are_taken_once():
    arrivals, elapsed = Arrivals(3, LIMITS, PERIOD), []
    for k in range(9):
        gyr, acc, mag = noisy(k)[0], *noisy(k - k % 2)[1:]
        elapsed.append(noted(arrivals, (gyr, acc, mag), (k * PERIOD_NS,) * 3)[0][1])
    assert elapsed == pytest.approx([5e-3, 0.0, 1e-2, 0.0, 1e-2, 0.0, 1e-2, 0.0, 1e-2])


def test_equal_samples_are_new_where_nothing_moves_and_where_stamps_say_so():
    arrivals, (_, acc, mag) = Arrivals(3, LIMITS, PERIOD), noisy()
    still = (np.zeros((3, 3)), acc, mag)
    assert [noted(arrivals, still, (k * PERIOD_NS,) * 3)[0][1] for k in range(3)] == pytest.approx([5e-3] * 3)
    arrivals = Arrivals(3, LIMITS, PERIOD)
    told = [noted(arrivals, (noisy(k)[0], acc, mag), (k * PERIOD_NS, stamp, 0))[0][1]
            for k, stamp in enumerate([0, 7_000_000, 14_000_000])]
    assert told == pytest.approx([5e-3, 7e-3, 7e-3])


def test_nothing_has_come_before_the_first_message():
    arrivals = Arrivals(3, LIMITS, PERIOD)
    elapsed, reports = noted(arrivals, (np.zeros((3, 3)),) * 2, (NEVER, NEVER), 0)
    assert elapsed == (0.0, 0.0, 0.0)
    assert (arrivals.codes[:2] == LOST).all()
    assert [status for status, _ in reports] == ["lost_sample", "repeated_sample"]
    assert not arrivals.sound
    assert not arrivals.usable().any()


@pytest.mark.parametrize("later", [0, 20])
def test_rates_held_for_too_long_are_lost_and_their_time_goes_on_just_once(later):
    """The link falls silent for 20 periods and comes back, perhaps with a latency of so many more."""
    arrivals, rows = Arrivals(3, LIMITS, PERIOD), noisy()
    passed, lost = 0.0, []
    for k in range(60):
        silent = 20 <= k < 40
        at = 19 if silent else k - later * (k >= 40)
        rows = rows if silent else noisy(k)
        elapsed, _ = noted(arrivals, rows, (at * PERIOD_NS,) * 3, k * PERIOD_NS)
        passed += elapsed[0]
        lost.append(bool(arrivals.codes[0].any()))
    assert lost == [25 <= k < 40 for k in range(60)]
    assert passed == pytest.approx(60 * PERIOD)


def test_an_accelerometer_that_stays_behind_is_lost_in_the_end():
    arrivals, (_, acc, mag) = Arrivals(3, LIMITS, PERIOD), noisy()
    codes = []
    for k in range(150):
        noted(arrivals, (noisy(k)[0], acc, mag), (k * PERIOD_NS, 0, k * PERIOD_NS))
        codes.append(arrivals.codes[1, 0])
    assert codes == [LOST if k > 100 else 0 for k in range(150)]


@pytest.mark.parametrize(("rate", "status", "lost"), [
    (0.0, None, False), (1e-9, None, False), (0.05, "frozen_sample", False), (2.0, "frozen_sample", True)])
def test_a_sensor_that_repeats_itself_is_frozen(rate, status, lost):
    arrivals, told = Arrivals(3, LIMITS, PERIOD), []
    for k in range(60):
        rows = noisy(k)
        if 10 <= k < 50:
            for kind, row in zip(rows, ([rate, 0.0, 0.0], [0.0, 9.8, 0.0], [1.0, 0.0, 0.0]), strict=True):
                kind[1] = row
        told += [(k, name, detail) for name, detail in noted(arrivals, rows, (k * PERIOD_NS,) * 3)[1]]
        assert bool(arrivals.codes[:, 1].any()) == (lost and 30 <= k < 50)
        assert not arrivals.codes[:, [0, 2]].any()
    expected = [(30, status, "sensor 1: the same numbers over and over"),
                (50, "samples_valid", "every sensor gives sound samples again")]
    assert told == (expected if status else [])


def test_codes_tell_kinds_apart_and_plain_python_agrees():
    gyr, acc, mag = noisy()
    gyr[0], acc[1], mag[2, 0], acc[2, 1], gyr[1] = np.nan, 0.0, np.inf, 120.0, 0.0
    found = []
    for kernel in (inspect_kinds, inspect_kinds.py_func):
        codes, nothing = np.zeros((3, 3), dtype=np.uint8), np.zeros(3, dtype=np.int64)
        samples, read = np.stack([gyr, acc, mag]), np.ones(3, dtype=bool)
        assert kernel(samples, 3, 0, np.array(LIMITS), read, nothing, 9, codes)
        found.append(codes.tolist())
    # Zeros of gyroscope and accelerometer together are what stands in a port before the first message.
    assert found[0] == found[1] == [[LOST, LOST, 0], [0, LOST, CLIPPED], [0, 0, LOST]]
    for kernel in (compare, compare.py_func):
        before, stuck = np.zeros((3, 3, 3)), np.ones(3, dtype=np.int64)
        assert kernel(*noisy(), True, before, stuck) == 7
        np.testing.assert_array_equal(before, noisy())
        assert kernel(noisy()[0], noisy()[1], noisy(1)[2], True, before, stuck) == 4
        assert stuck.tolist() == [1, 1, 1]


def test_magnetometers_that_are_not_read_are_not_told_of():
    gyr, acc, mag = noisy()
    mag[:2] = np.nan
    arrivals = Arrivals(3, LIMITS, PERIOD, np.array([True, False, True]))
    assert noted(arrivals, (gyr, acc, mag), (0, 0, 0))[1] == [("lost_sample", "mag of sensor 0")]
    assert arrivals.usable().tolist() == [False, True, True]
