import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from controllers.mpc.observer import Observer
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.models.linear_model import LinearModel

MS = 1_000_000
MODEL = LinearModel(
    a=np.array([[0.0, 1.0, 0.0], [-90.0, -12.0, 60.0], [0.0, 0.0, -9.0]]),
    b=np.array([[0.0, 0.0], [0.0, 0.0], [9.0, -4.0]]), c=np.array([[1.0, 0.0, 0.0]]),
    offset=np.array([0.3]), delay_ns=20 * MS)
DESIGN = {"period_ns": 25 * MS, "delay_ns": 27 * MS + 1, "reach_ns": 400 * MS, "drive_noise": 0.05,
          "disturbance_walk": 0.3, "measurement_noise": 0.01}


def exact_state(stamps_ns, drives, delay_ns, time_ns):
    """x at `time_ns` from rest, segment by segment with scipy's exponential."""
    stacked = np.zeros((5, 5))
    stacked[:3, :3], stacked[:3, 3:] = MODEL.a, MODEL.b
    x = np.zeros(3)
    edges = [*(stamp + delay_ns for stamp in stamps_ns), 2**62]
    for k, drive in enumerate(drives):
        start, stop = min(edges[k], time_ns), min(edges[k + 1], time_ns)
        x = (expm(stacked * (stop - start) * 1e-9) @ np.concatenate([x, drive]))[:3]
    return x


@pytest.mark.slow
@settings(deadline=None, max_examples=50)
@given(st.lists(st.integers(1, 60 * MS), max_size=9), st.integers(0, 900 * MS), st.integers(0, 2**32))
def test_looks_ahead_exactly_under_the_recorded_drives(gaps, later_ns, seed):
    observer = Observer.design(MODEL, **DESIGN)
    state = observer.init()
    stamps = np.cumsum([0, *gaps]).tolist()
    drives = list(np.random.default_rng(seed).uniform(size=(len(stamps), 2)))
    for stamp, drive in zip(stamps, drives, strict=True):
        observer.record(state, stamp, drive)
    now = stamps[-1] + later_ns
    expected = exact_state(stamps, drives, DESIGN["delay_ns"], now)
    np.testing.assert_allclose(observer.predict(state, now, 0), expected, rtol=1e-9, atol=1e-12)


def test_stored_drives_are_those_given_out_whole_periods_before():
    observer = Observer.design(MODEL, **DESIGN)
    state = observer.init()
    for k in (0, 1, 3, 4):
        observer.record(state, k * 25 * MS, np.array([k, -k], dtype=float))
    stored = observer.predict(state, 5 * 25 * MS, 4)[3:].reshape(4, 2)
    np.testing.assert_array_equal(stored[:, 0], [4.0, 3.0, 1.0, 1.0])


@settings(deadline=None, max_examples=50)
@given(st.fractions(5, 200, max_denominator=7), st.integers(0, 500),
       st.lists(st.floats(-0.24, 0.24), min_size=10, max_size=10))
def test_stored_drives_are_told_apart_at_any_rate_and_by_ticks_that_are_not_punctual(rate, first, late):
    """A period is rarely a whole number of ns, and a live stream's ticks come early and late."""
    clock = RateClock.from_rate(rate)
    period = round(clock.period_s * NS_PER_S)
    observer = Observer.design(MODEL, **DESIGN | {"period_ns": period, "reach_ns": 9 * period})
    for share in (0.0, 1.0):
        state = observer.init()
        ticks = [clock.tick(first + k) + round(share * late[k] * period) for k in range(10)]
        for k in range(9):
            observer.record(state, ticks[k], np.array([k, -k], dtype=float))
        stored = observer.predict(state, ticks[9], 9)[3:].reshape(9, 2)
        np.testing.assert_array_equal(stored[:, 0], np.arange(9)[::-1])


@pytest.mark.slow
def test_finds_state_and_disturbance_from_late_samples_of_changing_age():
    rng = np.random.default_rng(2)
    observer, unexplained = Observer.design(MODEL, **DESIGN), np.array([0.07])
    state, stamps, drives = observer.init(), [], []
    for k in range(200):
        now = k * 25 * MS
        captured = now - int(rng.integers(5 * MS, 24 * MS))
        if captured >= 0:
            measured = MODEL.c @ exact_state(stamps, drives, DESIGN["delay_ns"], captured)
            observer.correct(state, captured, measured + MODEL.offset + unexplained)
        stamps.append(now)
        drives.append(rng.uniform(size=2))
        observer.record(state, now, drives[-1])
    assert state.disturbance == pytest.approx(unexplained, abs=1e-6)
    expected = exact_state(stamps, drives, DESIGN["delay_ns"], 200 * 25 * MS)
    np.testing.assert_allclose(observer.predict(state, 200 * 25 * MS, 0), expected, atol=1e-5)


def test_a_sample_is_taken_in_once():
    observer = Observer.design(MODEL, **DESIGN)
    state = observer.init()
    observer.correct(state, 0, np.array([0.5]))
    once = state.x.copy(), state.disturbance.copy()
    observer.correct(state, 0, np.array([0.5]))
    np.testing.assert_array_equal(state.x, once[0])
    np.testing.assert_array_equal(state.disturbance, once[1])


def test_gain_is_the_stationary_one_of_the_covariance_recursion():
    observer = Observer.design(MODEL, **DESIGN)
    stacked = np.zeros((5, 5))
    stacked[:3, :3], stacked[:3, 3:] = MODEL.a, MODEL.b
    step = expm(stacked * 0.025)
    a, c = np.eye(4), np.array([[1.0, 0.0, 0.0, 1.0]])
    a[:3, :3] = step[:3, :3]
    noise = np.diag([1e-12, 1e-12, 1e-12, 0.3**2 * 0.025])
    noise[:3, :3] += 0.05**2 * step[:3, 3:] @ step[:3, 3:].T
    covariance = np.eye(4)
    for _ in range(5000):
        gain = covariance @ c.T / (c @ covariance @ c.T + 1e-4)
        covariance = a @ (np.eye(4) - gain @ c) @ covariance @ a.T + noise
    np.testing.assert_allclose(observer.gain, gain, rtol=1e-6)
