"""Clocks that differ by a known time, and motions that do not show by how much."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimators.calibration.time_offset import time_offset
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.streams.blocks.replay import Replay

BROAD = ["02_undisturbed_slow_rotation_B", "21_undisturbed_fast_combined", "24_disturbed_tapping_A",
         "30_disturbed_stationary_magnet_C"]


def finger(times):
    """Angle of a finger, rad, that beats three times, unevenly, and then moves on slowly."""
    beats = sum(size * np.exp(-((times - at) / width) ** 2)
                for at, width, size in ((2.0, 0.12, 1.0), (2.9, 0.15, 1.2), (4.6, 0.2, 0.9)))
    return beats + 0.15 * np.sin(0.8 * times + 0.3)


def rates(times):
    """Angular rates (m, 3), rad/s, of the same finger about a fixed axis of its sensor."""
    step = 1e-5
    return np.outer((finger(times + step) - finger(times - step)) / (2 * step), [0.48, -0.6, 0.64])


@settings(deadline=None, max_examples=40)
@given(st.floats(-1.5, 1.5), st.sampled_from([100.0, 2000 / 7]), st.sampled_from([60.0, 100.0, 125.0]))
def test_the_offset_is_right_to_a_tenth_of_a_millisecond(offset, rate, other_rate):
    first, second = np.arange(0, 10, 1 / rate), np.arange(0, 9, 1 / other_rate)
    found = time_offset(first, finger(first), second, finger(second + offset))
    assert abs(found.offset_s - offset) < 1e-4
    assert found.peak > 0.999
    assert found.second_peak < 0.9


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_noise_uneven_stamps_and_gaps_cost_less_than_a_millisecond(seed):
    rng = np.random.default_rng(seed)
    offset = rng.uniform(-1.5, 1.5)
    first = np.cumsum(rng.uniform(0.007, 0.013, 1000))
    second = np.arange(0, 9, 1 / 120)
    a = finger(first) + 0.01 * rng.normal(size=first.size)
    b = finger(second + offset) + 0.01 * rng.normal(size=second.size)
    b[rng.choice(second.size, 30, replace=False)] = np.nan
    b[700:760] = np.nan
    found = time_offset(first, a, second, b)
    assert abs(found.offset_s - offset) < 1e-3
    assert found.overlap_s < 9.0


def test_sizes_of_rates_need_no_common_frame_and_no_common_unit():
    first, second = np.arange(0, 10, 0.01), np.arange(0, 10, 0.005)
    other = np.degrees(rates(second - 0.7)) @ np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    found = time_offset(first, rates(first), second, other)
    assert abs(found.offset_s + 0.7) < 1e-3


@pytest.mark.parametrize("trial", BROAD)
@pytest.mark.parametrize("shift_s", [-3.21098, 0.4567])
def test_a_recording_against_itself_on_another_clock(recordings, trial, shift_s):
    # Every third sample of another stretch, on a clock that is off.
    recording = Replay(recording=str(recordings / "broad" / f"{trial}.mat")).source
    times, gyr = 1e-9 * recording.stamps_ns, recording.gyr[:, 0]
    half = slice(len(times) // 5, None, 3)
    found = time_offset(times, gyr, times[half] - shift_s, gyr[half])
    assert abs(found.offset_s - shift_s) < 1e-3
    assert found.peak > 0.99


def test_optics_against_inertial_sensors(recordings):
    # 40 Hz gyroscopes, 30 Hz poses: five segments in motions of their own show the offset of two clocks.
    recording = Replay(recording=str(recordings / "chain5" / "trial1.npz"), sensor_set="rigid").source
    reference = recording.reference
    middle = 0.5e-9 * (reference.stamps_ns[:-1] + reference.stamps_ns[1:])
    turned = quaternion.relative(reference.orientation[:-1], reference.orientation[1:])
    speeds = quaternion.rotation_angle(turned) * 30.0
    found = [time_offset(1e-9 * recording.stamps_ns, recording.gyr[:, i], middle, speeds[:, i])
             for i in range(5)]
    assert np.ptp([one.offset_s for one in found]) < 1e-3
    assert min(one.peak for one in found) > 0.97
    assert abs(found[0].offset_s) < 1 / 40


@pytest.mark.parametrize(("a", "b", "found"), [
    (lambda t: np.sin(6 * t), lambda t: np.sin(6 * t), "fit as well at .*does not repeat itself"),
    (finger, lambda t: np.random.default_rng(0).normal(size=t.size), "correlate by 0.* at most"),
    (lambda t: 0 * t, finger, "first: does not vary"),
    (finger, lambda t: np.full(t.size, np.nan), "second: 0 samples are known"),
    (finger, lambda t: np.zeros((3, 3)), "second: shapes"),
])
def test_what_shows_no_offset_is_refused(a, b, found):
    times = np.arange(0, 10, 0.01)
    with pytest.raises(InputError, match=found):
        time_offset(times, a(times), times, b(times))


def test_limits_are_named():
    times = np.arange(0, 10, 0.01)
    with pytest.raises(InputError, match="second times: do not increase"):
        time_offset(times, finger(times), times[::-1], finger(times))
    with pytest.raises(InputError, match="at the end of what was searched"):
        time_offset(times, finger(times), times, finger(times + 0.1), within_s=0.05)
    with pytest.raises(InputError, match="20 s in common"):
        time_offset(times, finger(times), times, finger(times), least_overlap_s=20.0)
