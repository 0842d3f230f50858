"""Trackers against a finger in closed form, against bare VQF, and under bad samples."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tracker_parts import RATE, planar_finger, run_tracker, sample, swing
from vqf import VQF

from estimators.arrivals import CLIPPED, LOST, inspect
from estimators.body.body import flexion_angles, turned_angle
from estimators.fusion import SeelRuppinTracker, Vqf9Tracker, VqfTracker
from estimators.fusion.front_end import SeelRuppinBank
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from plants.imus import FingerImus

TIMES = np.arange(4 * RATE) / RATE
START_DEG = (20.0, 30.0, 10.0)
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
PALM_DOWN = quaternion.from_axis_angle([0.0, 1.0, 0.0], np.pi / 2)


def finger(base=PALM_DOWN, start_deg=START_DEG, depth_deg=(50.0, 60.0, 30.0)):
    return planar_finger(TIMES, np.radians(start_deg), np.radians(depth_deg), base)


def noisy(count, sensors, seed=0):
    rng = np.random.default_rng(seed)
    gyr, acc, mag = rng.normal(size=(3, count, sensors, 3))
    return gyr, acc + np.array([0.0, 0.0, 9.81]), mag + 2.0


@given(st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=15)
def test_joint_angles_of_a_finger_whatever_the_hands_attitude(seed):
    base = quaternion.normalized(np.random.default_rng(seed).normal(size=4))
    gyr, acc, true = finger(base)
    (_, angles, _), _, _ = run_tracker(VqfTracker(sensors=4, initial_angles_deg=START_DEG), gyr, acc)
    # A rate held over 10 ms lags by 5 ms, and accelerometers feel the swing as well as gravity.
    assert np.degrees(np.abs(angles - true)).max() < 2.0
    assert np.degrees(np.sqrt(np.mean((angles - true) ** 2))) < 1.0


@pytest.mark.parametrize("base", [PALM_DOWN, quaternion.from_axis_angle([1.0, 1.0, 0.0], 1.2)])
def test_joint_angles_from_modelled_sensors_with_noise_and_bias(base):
    imus = FingerImus(hand_orientation=tuple(base))
    motion = swing(TIMES, np.radians(START_DEG), np.radians([50.0, 60.0, 30.0]))
    (gyr, acc), _, _ = run_tracker(imus, *motion)
    (_, angles, _), _, _ = run_tracker(VqfTracker(sensors=4, initial_angles_deg=START_DEG), gyr, acc)
    assert np.degrees(np.sqrt(np.mean((angles - motion[0]) ** 2, axis=0))).max() < 1.5


def test_headings_are_wrong_without_the_initial_pose():
    gyr, acc, true = finger(quaternion.from_axis_angle([1.0, 1.0, 0.0], 1.2))
    (_, angles, _), _, _ = run_tracker(VqfTracker(sensors=4), gyr, acc)
    assert np.degrees(np.abs(angles - true).max()) > 5.0


def test_the_initial_pose_stands_until_the_alignment_ends():
    gyr, acc, true = finger()
    tracker = VqfTracker(sensors=4, initial_angles_deg=START_DEG, align_s=0.3)
    (_, angles, _), reports, _ = run_tracker(tracker, gyr, acc)
    np.testing.assert_array_equal(angles[:30], np.tile(np.radians(START_DEG), (30, 1)))
    assert reports == [("aligning", "initial pose until 0.3 s")]
    assert np.abs(angles[30] - true[30]).max() < 1e-3


def test_pairs_choose_the_joints():
    gyr, acc, true = finger()
    tracker = VqfTracker(sensors=4, pairs=((0, 3), (2, 1)), initial_angles_deg=(60.0, -30.0))
    (_, angles, _), _, _ = run_tracker(tracker, gyr, acc)
    expected = np.stack([true.sum(axis=1), -true[:, 1]], axis=1)
    assert np.degrees(np.abs(np.angle(np.exp(1j * (angles - expected)))).max()) < 4.0


def test_a_single_sensor_gives_the_angle_it_has_turned():
    turn = 0.5 * TIMES
    gyr = np.tile([0.5, 0.0, 0.0], (len(TIMES), 1, 1))
    acc = np.stack([0 * turn, 9.81 * np.sin(turn), 9.81 * np.cos(turn)], axis=1)[:, np.newaxis]
    (_, angles, _), _, _ = run_tracker(VqfTracker(sensors=1), gyr, acc)
    assert angles.shape == (len(TIMES), 1)
    np.testing.assert_allclose(angles[:, 0], turn, atol=0.02)


@pytest.mark.parametrize(("tracker", "key"), [(VqfTracker(sensors=3), "quat6D"),
                                              (Vqf9Tracker(sensors=3), "quat9D")])
def test_orientations_equal_a_bare_batch_run(tracker, key):
    gyr, acc, mag = noisy(500, 3)
    (orientation, _, _), _, _ = run_tracker(tracker, *(gyr, acc, mag)[:len(tracker.inputs)])
    for i in range(3):
        batch = VQF(1 / RATE).updateBatch(*(np.ascontiguousarray(kind[:, i]) for kind in (gyr, acc, mag)))
        np.testing.assert_array_equal(orientation[:, i], batch[key])


def test_seel_and_ruppins_fusion_is_a_tracker_of_its_own():
    gyr, acc, mag = noisy(500, 3)
    tracker = SeelRuppinTracker(sensors=3, pairs=((0, 1), (0, 2)), tau_mag_s=2.0)
    (orientation, angles, aligned), reports, _ = run_tracker(tracker, gyr, acc, mag)
    bank = SeelRuppinBank(3, 1 / RATE, True, tau_mag_s=2.0)
    for k in range(500):
        bank.update(gyr[k], acc[k], mag[k])
        np.testing.assert_array_equal(orientation[k], bank.orientation())
    np.testing.assert_array_equal(
        angles[-1], flexion_angles(orientation[-1], np.array(tracker.pairs), np.tile([1.0, 0.0], (2, 1))))
    assert (aligned == 1.0).all()
    assert reports == []


@given(at=st.integers(0, 299))
@settings(deadline=None, max_examples=15)
@pytest.mark.parametrize("tracker", [VqfTracker(sensors=3, initial_angles_deg=(5.0, 5.0)),
                                     Vqf9Tracker(sensors=3), SeelRuppinTracker(sensors=3)])
def test_stop_save_restore_continue_equals_uninterrupted(tracker, at):
    kinds = noisy(300, 3)[:len(tracker.inputs)]
    whole, _, _ = run_tracker(tracker, *kinds)
    _, _, state = run_tracker(tracker, *kinds, last=at) if at else (None, None, None)
    restored = pickle.loads(pickle.dumps(state))
    rest, _, _ = run_tracker(tracker, *kinds, state=restored, first=at)
    for all_of_it, part in zip(whole, rest, strict=True):
        np.testing.assert_array_equal(all_of_it[at:], part)


def test_lost_samples_concern_only_their_sensor_and_are_reported_once():
    gyr, acc, _ = noisy(60, 2)
    spoilt = acc.copy()
    spoilt[20:25, 1] = np.nan
    spoilt[40:42, 1] = 0.0
    clean, _, _ = run_tracker(VqfTracker(sensors=2), gyr, acc)
    (orientation, angles, _), reports, _ = run_tracker(VqfTracker(sensors=2), gyr, spoilt)
    np.testing.assert_array_equal(orientation[:, 0], clean[0][:, 0])
    # Without an acceleration the rates turn it all the same.
    turned = quaternion.rotation_angle(quaternion.relative(orientation[19:24, 1], orientation[20:25, 1]))
    np.testing.assert_allclose(turned, np.linalg.norm(gyr[20:25, 1], axis=1) / RATE, rtol=0.1)
    assert np.isfinite(angles).all()
    told = [each for each in reports if each[0] != "no_initial_pose"]
    assert [status for status, _ in told] == ["lost_sample", "samples_valid"] * 2
    assert told[0] == ("lost_sample", "acc of sensor 1")


def test_clipped_and_repeated_samples_are_used_and_reported():
    gyr, acc, _ = noisy(30, 2)
    gyr[10, 0, 1] = np.radians(2000.0)
    (orientation, *_), reports, state = run_tracker(VqfTracker(sensors=2), gyr, acc)
    assert reports[1:] == [("clipped_sample", "gyr of sensor 0"),
                           ("samples_valid", "every sensor gives sound samples again")]
    batch = VQF(1 / RATE).updateBatch(np.ascontiguousarray(gyr[:, 0]), np.ascontiguousarray(acc[:, 0]))
    np.testing.assert_array_equal(orientation[:, 0], batch["quat6D"])
    tick = Tick()
    tick.index, tick.time_ns = 30, 300_000_000
    VqfTracker(sensors=2).step(state, [sample(gyr[29], 290_000_000), sample(acc[29], 290_000_000)], tick)
    assert [status for status, _ in tick.reports] == ["repeated_sample"]


def test_ticks_skipped_while_busy_are_made_good():
    rate = np.zeros((1, 3))
    rate[0, 2] = 1.0
    acc = np.array([[0.0, 0.0, 9.81]])
    tracker = VqfTracker(sensors=1)
    state = tracker.init(Context("tracker", clock=RateClock.from_rate(100)))
    tick = Tick()
    for k in (0, 1, 5, 9):
        tick.index, tick.time_ns = k, k * 10_000_000
        orientation, *_ = tracker.step(state, [sample(rate, tick.time_ns), sample(acc, tick.time_ns)], tick)
    # Rates between samples tend to zero a little.
    assert quaternion.rotation_angle(orientation[0]) == pytest.approx(0.1, rel=2e-3)


def test_sizes_come_from_the_wire():
    tracker = VqfTracker(initial_angles_deg=(0.0, 0.0)).resolve({"gyr": (3, 3), "acc": (3, 3)})
    assert [port.shape for port in tracker.inputs + tracker.outputs] == [(3, 3), (3, 3), (3, 4), (2,), (1,)]
    with pytest.raises(InputError, match="initial_angles_deg"):
        VqfTracker(initial_angles_deg=(0.0, 0.0)).resolve({"gyr": (4, 3), "acc": (4, 3)})


@pytest.mark.parametrize("wrong", [
    {"sensors": -1}, {"sensors": 2, "pairs": ((0, 2),)}, {"sensors": 2, "pairs": ((1, 1),)},
    {"align_s": -0.1}, {"tau_acc_s": 0.0}, {"gyr_range_deg_s": float("nan")},
    {"sensors": 2, "initial_angles_deg": (200.0,)}, {"sensors": 1, "initial_angles_deg": ()}])
def test_impossible_parameters_are_refused(wrong):
    with pytest.raises(InputError, match=list(wrong)[-1]):
        VqfTracker(**wrong)


@pytest.mark.slow
def test_compiled_kernels_equal_plain_python():
    rng = np.random.default_rng(2)
    orientation = quaternion.normalized(rng.normal(size=(4, 4)))
    pairs, heading = np.array([[0, 1], [3, 2]]), quaternion.about_z(rng.normal(size=2))[:, ::3].copy()
    for kernel, arguments in ((flexion_angles, (orientation, pairs, heading)),
                              (turned_angle, (orientation[:1], orientation[1:2]))):
        np.testing.assert_allclose(kernel(*arguments), kernel.py_func(*arguments), rtol=1e-13)
    vectors = rng.normal(size=(7, 3))
    vectors[1], vectors[2, 0], vectors[3], vectors[5, 1], vectors[6, 2] = 0.0, np.nan, 50.0, -4000.0, 4000.1
    codes = np.zeros((2, 7), dtype=np.uint8)
    assert inspect(vectors, 40.0, True, codes[0]) == inspect.py_func(vectors, 40.0, True, codes[1])
    assert codes[0].tolist() == codes[1].tolist() == [0, LOST, LOST, CLIPPED, 0, CLIPPED, LOST]


@pytest.mark.parametrize(("given_deg", "told"), [(None, 1), ((20.0,), 0)])
def test_vqf_without_a_pose_says_what_its_angles_count_from(given_deg, told):
    gyr, acc, _ = noisy(30, 2)
    _, reports, _ = run_tracker(VqfTracker(sensors=2, initial_angles_deg=given_deg, align_s=0.0), gyr, acc)
    assert [status for status, _ in reports].count("no_initial_pose") == told
