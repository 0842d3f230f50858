"""Inertial sensors: against differentiated positions, statistics of their errors, and their contract."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import Sample
from plants.imus import FingerImus
from plants.imus import finger_imus as imu_kinematics

CLOCK = RateClock.from_rate("100")
CLEAN = {"gyroscope_noise_sd": 0.0, "accelerometer_noise_sd": 0.0, "gyroscope_walk": 0.0,
         "gyroscope_bias_sd": 0.0, "accelerometer_bias_sd": 0.0}


def context(trial: int = 0, seed: int = 0, name: str = "imus") -> Context:
    return Context(name, seed=seed, trial=trial, clock=CLOCK)


def posture(angles=(0.0, 0.0, 0.0), rates=(0.0, 0.0, 0.0), accelerations=(0.0, 0.0, 0.0)) -> list[Sample]:
    return [Sample(np.array(values, dtype=float), 0, 0, 0) for values in (angles, rates, accelerations)]


def step(imus: FingerImus, state, inputs, index: int = 0):
    tick = Tick()
    tick.index = index
    return *imus.step(state, inputs, tick), tick.reports


def turned(angle: float) -> np.ndarray:
    """Segment to parent: flexion about +z."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])


ROOM = {"phase": st.floats(0.0, 6.0), "speed": st.floats(0.5, 8.0)}


@given(**ROOM)
@settings(max_examples=25, deadline=None)
def test_samples_are_those_of_differentiated_positions(phase: float, speed: float) -> None:
    """A hand in some attitude, joints swinging: positions in the room, differentiated twice."""
    lengths, attitude = np.array([0.05, 0.03, 0.02]), np.array([0.5, -0.1, 0.7, 0.5])
    attitude /= np.linalg.norm(attitude)
    w, x, y, z = attitude
    hand = np.array([[1 - 2 * (y*y + z*z), 2 * (x*y - w*z), 2 * (x*z + w*y)],
                     [2 * (x*y + w*z), 1 - 2 * (x*x + z*z), 2 * (y*z - w*x)],
                     [2 * (x*z - w*y), 2 * (y*z + w*x), 1 - 2 * (x*x + y*y)]])
    swing, shift = np.array([0.7, 0.9, 0.5]), np.array([0.0, 0.6, 1.9]) + phase

    def angles(t):
        return 0.4 + swing * np.sin(speed * t + shift)

    def segments(t):
        attitude, origin, found = hand, np.zeros(3), []
        for k in range(3):
            attitude = attitude @ turned(angles(t)[k])
            found.append((attitude, origin + attitude @ [0, -lengths[k] / 2, 0]))
            origin = origin + attitude @ [0, -lengths[k], 0]
        return found

    imus = FingerImus(**CLEAN, lengths_mm=tuple(1e3 * lengths), hand_orientation=tuple(attitude))
    gyr, acc, _ = step(imus, imus.init(context()), posture(
        angles(0.0), speed * swing * np.cos(shift), -speed**2 * swing * np.sin(shift)))
    h = 2e-4
    before, now, after = segments(-h), segments(0.0), segments(h)
    up = np.array([0, 0, STANDARD_GRAVITY])
    for k in range(3):
        to_body = now[k][0].T
        spin = to_body @ (after[k][0] - before[k][0]) / (2 * h)
        np.testing.assert_allclose(gyr[k + 1], [spin[2, 1], spin[0, 2], spin[1, 0]], atol=1e-4)
        moved = (after[k][1] - 2 * now[k][1] + before[k][1]) / h**2
        np.testing.assert_allclose(acc[k + 1], to_body @ (moved + up), atol=1e-4)
    np.testing.assert_allclose(acc[0], hand.T @ up, atol=1e-12)
    assert not gyr[0].any()


def test_flexing_a_finger_of_a_palm_down_hand_points_its_tip_down() -> None:
    """By eye: straight, the dorsal axis points up; MCP flexed 90 deg, the bone (-y) points down."""
    imus = FingerImus(**CLEAN)
    _, acc, _ = step(imus, imus.init(context()), posture())
    np.testing.assert_allclose(acc, np.tile([-STANDARD_GRAVITY, 0, 0], (4, 1)), atol=1e-12)
    gyr, acc, _ = step(imus, imus.init(context()), posture((math.pi / 2, 0, 0), (2.0, 0, 0)))
    assert acc[1, 1] == pytest.approx(STANDARD_GRAVITY + 4.0 * 0.0466 / 2)
    np.testing.assert_allclose(gyr, [[0, 0, 0], [0, 0, 2], [0, 0, 2], [0, 0, 2]])


def test_errors_have_the_declared_size() -> None:
    imus = FingerImus(gyroscope_bias_sd=0.0, accelerometer_bias_sd=0.0, gyroscope_walk=0.0)
    state = imus.init(context(seed=3))
    samples = np.array([step(imus, state, posture(), k)[:2] for k in range(3000)])
    np.testing.assert_allclose(samples[:, 0].std(axis=0), 5e-4, rtol=0.06)
    np.testing.assert_allclose(samples[:, 1].std(axis=0), 4e-2, rtol=0.06)
    np.testing.assert_allclose(samples[:, 0].mean(axis=0), 0.0, atol=5e-5)


def test_the_bias_walks_with_the_square_root_of_time() -> None:
    imus = FingerImus(**{**CLEAN, "gyroscope_walk": 1e-2})
    ends = []
    for seed in range(40):
        state = imus.init(context(seed=seed))
        for k in range(99):
            step(imus, state, posture(), k)
        gyr, acc, _ = step(imus, state, posture(), 99)
        ends.append(gyr)
    assert np.std(ends) == pytest.approx(1e-2, rel=0.1)
    np.testing.assert_allclose(acc[0], [-STANDARD_GRAVITY, 0, 0], atol=1e-12)


def test_the_bias_walks_on_while_ticks_are_skipped() -> None:
    """A sensor whose block is busy for four ticks of five is as far off after a second as any other."""
    imus = FingerImus(**{**CLEAN, "gyroscope_walk": 1e-2})
    ends = []
    for seed in range(120):
        state = imus.init(context(seed=seed))
        ends += [step(imus, state, posture(), k)[0] for k in range(4, 100, 5)][-1:]
    assert np.std(ends) == pytest.approx(1e-2, rel=0.06)


def test_bias_and_mounting_belong_to_the_run_and_noise_to_the_trial() -> None:
    quiet = {**CLEAN, "gyroscope_bias_sd": 1e-2, "accelerometer_bias_sd": 0.1, "misalignment_deg": 5.0}
    imus = FingerImus(**quiet)
    first, second, other, renamed = (step(imus, imus.init(c), posture())[:2] for c in (
        context(), context(trial=1), context(seed=1), context(name="more")))
    np.testing.assert_array_equal(first, second)
    assert (np.array(first) != np.array(other)).all()
    assert (np.array(first) != np.array(renamed)).all()
    noisy = FingerImus()
    trials = [step(noisy, noisy.init(context(trial)), posture())[0] for trial in (0, 1)]
    assert (trials[0] != trials[1]).all()


def test_a_mounting_error_turns_samples_without_stretching_them() -> None:
    imus = FingerImus(**CLEAN, misalignment_deg=8.0)
    _, acc, _ = step(imus, imus.init(context()), posture())
    np.testing.assert_allclose(np.linalg.norm(acc, axis=1), STANDARD_GRAVITY, rtol=1e-12)
    tilt_deg = np.degrees(np.arccos(-acc[:, 0] / STANDARD_GRAVITY))
    assert (tilt_deg > 0.5).all()
    assert (tilt_deg < 40.0).all()


def test_samples_clip_at_the_range_and_say_which_sensor() -> None:
    imus = FingerImus(**CLEAN)
    gyr, acc, reports = step(imus, imus.init(context()), posture(rates=(20.0, -100.0, 30.0)))
    assert gyr[2, 2] == -math.radians(2000.0)
    assert gyr[3, 2] == pytest.approx(-math.radians(2000.0))
    assert gyr[1, 2] == 20.0
    assert acc.max() <= 16 * STANDARD_GRAVITY
    assert reports == [("clipped", "out of range: middle, distal")]


def test_resolution_rounds_to_digits() -> None:
    imus = FingerImus(**CLEAN, gyroscope_resolution=0.25, accelerometer_resolution=0.5)
    gyr, acc, _ = step(imus, imus.init(context()), posture(rates=(1.1, 0.0, 0.0)))
    assert gyr[1, 2] == 1.0
    np.testing.assert_allclose(acc % 0.5, 0.0, atol=1e-12)


@pytest.mark.slow
def test_missing_posture_is_reported() -> None:
    imus = FingerImus()
    empty = [Sample(port.initial_value(), -1, -1, -1) for port in imus.inputs]
    assert step(imus, imus.init(context()), empty)[2][0][0] == "waiting"


def test_a_pickled_state_goes_on_with_the_same_bits_and_values_are_fresh() -> None:
    imus = FingerImus()
    state = imus.init(context())
    first = step(imus, state, posture(), 0)[0]
    kept = first.copy()
    again = pickle.loads(pickle.dumps(state))
    for index in range(1, 200):
        one, other = step(imus, state, posture(), index), step(imus, again, posture(), index)
        np.testing.assert_array_equal(one[:2], other[:2])
    np.testing.assert_array_equal(first, kept)


def test_compiled_kernels_equal_plain_python() -> None:
    values = [np.array(v) for v in ((0.3, 0.5, 0.2), (2.0, -3.0, 1.0), (9.0, 8.0, -7.0), (0.05, 0.03, 0.02),
                                    (1.0, -9.0, 3.0))]
    ideal, plain = np.empty((2, 4, 3)), np.empty((2, 4, 3))
    imu_kinematics.chain_samples(*values, ideal)
    imu_kinematics.chain_samples.py_func(*values, plain)
    np.testing.assert_allclose(ideal, plain, rtol=1e-13)
    rng = np.random.default_rng(0)
    errors = (rng.normal(size=(4, 3, 3)), rng.normal(size=(2, 4, 3)), rng.normal(size=36),
              imu_kinematics.Errors(np.array([0.1, 0.2]), np.array([1.5, 2.0]), np.array([0.0, 0.25]), 0.0))
    samples = rng.normal(size=(2, 4, 3))
    plain = samples.copy()
    mask = imu_kinematics.corrupt(samples, *errors)
    assert mask == imu_kinematics.corrupt.py_func(plain, *errors) > 0
    np.testing.assert_allclose(samples, plain, rtol=1e-13)


@pytest.mark.parametrize(("change", "named"), [
    ({"hand_orientation": (1.0, 1.0, 0.0, 0.0)}, "hand_orientation"),
    ({"lengths_mm": (1.0, 2.0)}, "lengths_mm"), ({"gyroscope_noise_sd": -1.0}, "gyroscope_noise_sd"),
    ({"misalignment_deg": math.nan}, "misalignment_deg"),
    ({"accelerometer_range_g": 0.0}, "accelerometer_range_g")])
def test_bad_parameters_are_named(change: dict, named: str) -> None:
    with pytest.raises(InputError, match=rf"finger_imus\.{named}"):
        FingerImus(**change)


def test_sensors_want_a_rate() -> None:
    with pytest.raises(InputError, match="rate"):
        FingerImus().init(Context("imus"))
