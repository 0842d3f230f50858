"""The ideal tracker: exact by default, and with errors of the declared size."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tracker_parts import RATE, run_tracker

from estimators.ideal import IdealTracker, with_error
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.signals import NEVER, Sample

TRUTH = np.cumsum(np.random.default_rng(1).normal(scale=0.01, size=(4000, 3)), axis=0)


def error_deg(**parameters):
    (angles,), _, _ = run_tracker(IdealTracker(joints=3, **parameters), TRUTH)
    return np.degrees(angles - TRUTH)


def test_it_is_exact_by_default():
    np.testing.assert_array_equal(error_deg(), 0.0)


def test_bias_and_drift_are_exact():
    times = np.arange(len(TRUTH))[:, np.newaxis] / RATE
    np.testing.assert_allclose(error_deg(bias_deg=(1.0, -2.0, 0.5), drift_deg_s=0.1),
                               [1.0, -2.0, 0.5] + 0.1 * times, atol=1e-12)


def test_white_noise_has_its_sd_and_is_white():
    error = error_deg(noise_deg=(1.0, 2.0, 0.0))
    np.testing.assert_allclose(error.std(axis=0), [1.0, 2.0, 0.0], rtol=0.05)
    assert abs(np.corrcoef(error[1:, 0], error[:-1, 0])[0, 1]) < 0.05


def test_random_walk_grows_with_the_root_of_time():
    steps = np.diff(error_deg(walk_deg=3.0), axis=0)
    np.testing.assert_allclose(steps.std(axis=0), 3.0 / np.sqrt(RATE), rtol=0.05)
    assert abs(np.corrcoef(steps[1:, 0], steps[:-1, 0])[0, 1]) < 0.05


@given(st.integers(0, 95_000_000))
def test_delay_is_rounded_up_to_ticks(delay_ns):
    (angles,), _, _ = run_tracker(IdealTracker(joints=3, delay_ms=delay_ns / 1e6), TRUTH[:40])
    ticks = -(-delay_ns // 10_000_000)
    np.testing.assert_array_equal(angles, TRUTH[np.maximum(np.arange(40) - ticks, 0)])


def test_quantisation_rounds_to_its_step():
    (angles,), _, _ = run_tracker(IdealTracker(joints=3, quantisation_deg=0.5), TRUTH)
    steps = np.degrees(angles) / 0.5
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-9)
    assert np.abs(np.degrees(angles - TRUTH)).max() <= 0.25 + 1e-9


def test_a_missing_truth_is_reported_once():
    tracker = IdealTracker(joints=1)
    state, tick = tracker.init(Context("tracker")), Tick()
    for _ in range(3):
        assert tracker.step(state, [Sample(np.zeros(1), NEVER, NEVER, NEVER)], tick) == ()
    assert [status for status, _ in tick.reports] == ["no_sample"]


def test_the_compiled_kernel_equals_plain_python():
    rng = np.random.default_rng(0)
    errors, row = rng.random((4, 3)), rng.normal(size=6)
    walks = [np.ones(3), np.ones(3)]
    for step in (0.0, 0.3):
        compiled = with_error(TRUTH[7], errors, walks[0], row, 1.5, 0.01, step)
        plain = with_error.py_func(TRUTH[7], errors, walks[1], row, 1.5, 0.01, step)
        np.testing.assert_allclose(compiled, plain, rtol=1e-14)
    np.testing.assert_allclose(walks[0], walks[1], rtol=1e-14)


@pytest.mark.parametrize("wrong", [{"noise_deg": -1.0}, {"bias_deg": float("nan")}, {"delay_ms": -1.0},
                                   {"quantisation_deg": -0.1}, {"joints": 3, "walk_deg": (1.0, 2.0)},
                                   {"joints": -1}, {"noise_deg": ()}])
def test_impossible_parameters_are_refused(wrong):
    with pytest.raises(InputError, match=list(wrong)[-1]):
        IdealTracker(**wrong)


def test_a_number_of_joints_takes_no_memory_before_it_is_held_against_the_wires():
    tracker = IdealTracker(joints=2**62, noise_deg=1.0, delay_ms=10.0)
    assert [port.shape for port in tracker.inputs] == [(2**62,)]


@given(st.integers(0, 4))
def test_fingertips_are_exact_and_as_late_as_angles(ticks):
    tips = np.random.default_rng(2).normal(size=(20, 5, 3))
    tracker = IdealTracker(joints=3, delay_ms=10.0 * ticks, fingertips=True, bias_deg=1.0)
    state, tick, found = tracker.init(Context("tracker")), Tick(), []
    for i in range(20):
        tick.index, tick.time_ns = i, (now := i * 10_000_000)
        samples = [Sample(value, now, now, now) for value in (TRUTH[i], tips[i])]
        found.append(tracker.step(state, samples, tick))
    angles, places, sd = (np.array(each) for each in zip(*found, strict=True))
    read = np.maximum(np.arange(20) - ticks, 0)
    np.testing.assert_allclose(np.degrees(angles - TRUTH[read]), 1.0)
    np.testing.assert_array_equal(places, tips[read])
    assert not sd.any()


def test_without_fingertips_there_is_no_output():
    tracker = IdealTracker(joints=3, fingertips=True)
    samples = [Sample(TRUTH[0], 0, 0, 0), Sample(np.zeros((5, 3)), NEVER, NEVER, NEVER)]
    tick = Tick()
    assert tracker.step(tracker.init(Context("tracker")), samples, tick) == ()
    assert tick.reports == [("no_sample", "no angles or fingertips have arrived yet: no output")]
