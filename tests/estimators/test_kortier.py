"""The `kortier` tracker: a finger and a hand with known motion, samples late, lost, clipped and missing."""

import pickle

import numpy as np
import pytest
from tracker_parts import RATE, planar_finger, run_tracker

from estimators.kortier import KortierTracker
from estimators.kortier_tree import HAND, Chain
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import NEVER, Sample

START_DEG = (20.0, 30.0, 10.0)
FINGER = (Chain(sensors=(0, 1, 2, 3), joints=("saddle", "hinge", "hinge"), initial_angles_deg=START_DEG),)
FLEXION = [0, 2, 3]
FIELD = np.array([0.0, 20e-6, -44e-6])
TIMES = np.arange(6 * RATE) / RATE
PALM_DOWN = quaternion.from_axis_angle([0.0, 1.0, 0.0], np.pi / 2)
TILTED = quaternion.from_axis_angle([1.0, 1.0, 0.0], 1.2)


def finger(base=TILTED, depth_deg=(50.0, 60.0, 30.0), seed=0):
    """gyr, acc, mag (ticks, 4, 3) with noise and bias; flexion (ticks, 3), attitudes (ticks, 4, 4)."""
    gyr, acc, true = planar_finger(TIMES, np.radians(START_DEG), np.radians(depth_deg), base)
    whole = np.cumsum(np.hstack([np.zeros((len(TIMES), 1)), true]), axis=1)
    attitude = quaternion.multiply(base, quaternion.about_z(whole))
    rng = np.random.default_rng(seed)
    gyr = gyr + 5e-4 * rng.normal(size=gyr.shape) + 0.005 * rng.normal(size=(4, 3))
    mag = quaternion.rotate(quaternion.conjugate(attitude), FIELD) + 3e-7 * rng.normal(size=gyr.shape)
    return gyr, acc + 4e-2 * rng.normal(size=acc.shape), mag, true, attitude


def tracker(**changed):
    return KortierTracker(sensors=4, chains=FINGER, **changed)


@pytest.mark.parametrize("base", [TILTED, PALM_DOWN])
def test_joint_angles_of_a_swinging_finger(base):
    gyr, acc, mag, true, _ = finger(base)
    (_, angles, sd, _, _), reports, _ = run_tracker(tracker(), gyr, acc, mag)
    error = angles[:, FLEXION] - true
    assert reports == []
    assert np.degrees(np.sqrt(np.mean(error ** 2, axis=0))).max() < 3.0
    assert np.degrees(np.sqrt(np.mean(angles[:, 1] ** 2))) < 1.5
    assert np.sqrt(np.mean((error / sd[:, FLEXION]) ** 2)) < 2.0


def test_where_flexion_is_about_the_vertical_the_uncertainty_says_so():
    """Neither gravity nor a constraint shows such flexion, and one magnetometer pair not its share."""
    gyr, acc, mag, true, _ = finger(np.array([1.0, 0.0, 0.0, 0.0]))
    (_, angles, sd, _, _), _, _ = run_tracker(tracker(), gyr, acc, mag)
    assert np.degrees(sd[-1, FLEXION]).min() > 3.0
    assert np.sqrt(np.mean(((angles[:, FLEXION] - true) / sd[:, FLEXION]) ** 2)) < 2.0


def test_a_wrong_start_is_corrected_and_its_uncertainty_covers_it():
    gyr, acc, mag, true, _ = finger(depth_deg=(0.0, 0.0, 0.0))
    straight = (Chain(sensors=(0, 1, 2, 3), joints=("saddle", "hinge", "hinge")),)
    (_, angles, _, _, _), _, _ = run_tracker(
        KortierTracker(sensors=4, chains=straight, angle_sd_deg=20.0), gyr, acc, mag)
    assert np.degrees(np.abs(angles[0, FLEXION] - true[0])).max() > 0.05
    assert np.degrees(np.abs(angles[-1, FLEXION] - true[-1])).max() < 1.5


def test_orientations_are_to_the_earth_and_north():
    gyr, acc, mag, _, attitude = finger()
    (orientation, *_), _, _ = run_tracker(tracker(), gyr, acc, mag)
    off = quaternion.rotation_angle(quaternion.multiply(orientation, quaternion.conjugate(attitude)))
    assert np.degrees(np.sqrt(np.mean(off[100:] ** 2))) < 3.0


def test_a_still_hand_stays_where_it_is():
    gyr, acc, mag, _, _ = finger(depth_deg=(0.0, 0.0, 0.0))
    (_, _, _, position, velocity), _, _ = run_tracker(tracker(), gyr, acc, mag)
    assert np.abs(position).max() < 0.02
    assert np.abs(velocity[-1]).max() < 0.01


def test_position_follows_a_short_move():
    """10 cm along x in half a second, minimum jerk, from rest to rest."""
    times = np.arange(300) / RATE
    s = np.clip((times - 1.0) / 0.5, 0.0, 1.0)
    along = 0.1 / 0.25 * (60 * s - 180 * s**2 + 120 * s**3)
    acc = np.tile([0.0, 0.0, 9.81], (300, 4, 1))
    acc[..., 0] = along[:, None]
    gyr, mag = np.zeros((300, 4, 3)), np.tile(FIELD, (300, 4, 1))
    (_, _, _, position, velocity), _, _ = run_tracker(tracker(), gyr, acc, mag)
    np.testing.assert_allclose(position[-1], [0.1, 0.0, 0.0], atol=0.01)
    np.testing.assert_allclose(velocity[-1], 0.0, atol=0.01)


def run_at_200_hz(block, gyr, acc, mag, held):
    """Gyroscopes at 200 Hz; accelerometers and magnetometers new at every second tick, or said to be so."""
    clock = RateClock.from_rate(200)
    state, tick, outputs = block.init(Context("tracker", clock=clock)), Tick(), []
    for k in range(len(gyr)):
        tick.index, tick.time_ns = k, clock.tick(k)
        captured = clock.tick(k - k % 2) if held else tick.time_ns
        slow = [Sample(kind[k - k % 2], captured, captured, captured) for kind in (acc, mag)]
        outputs.append(block.step(state, [Sample(gyr[k], *[tick.time_ns] * 3), *slow], tick))
    return [np.array(port) for port in zip(*outputs, strict=True)], tick.reports


def test_slower_accelerometers_are_taken_once_a_sample():
    still = [kind[:40] for kind in finger(PALM_DOWN, (0.0, 0.0, 0.0))[:3]]
    block = tracker(angle_sd_deg=20.0, lever_m=0.0, error_time_s=0.0)
    (_, _, once, _, _), reports = run_at_200_hz(block, *still, held=True)
    (_, _, twice, _, _), _ = run_at_200_hz(block, *still, held=False)
    assert reports == []
    # Of twice the samples the sd would be smaller by the root of two, before the biases come to matter.
    np.testing.assert_allclose((once / twice)[3:16:2, 2:], np.sqrt(2.0), rtol=0.12)


def test_joint_angles_with_slower_accelerometers():
    gyr, acc, mag, true, _ = finger()
    # The same motion in half the time, under the accelerations of the slow one.
    (_, angles, _, _, _), _ = run_at_200_hz(tracker(), 2.0 * gyr, acc, mag, held=True)
    assert np.degrees(np.sqrt(np.mean((angles[:, FLEXION] - true) ** 2, axis=0))).max() < 4.0


def test_without_a_magnetometer_wired():
    gyr, acc, _, true, _ = finger()
    nothing = Sample(np.zeros((4, 3)), NEVER, NEVER, NEVER)
    clock, block = RateClock.from_rate(RATE), tracker()
    state, tick, angles = block.init(Context("tracker", clock=clock)), Tick(), []
    for k in range(len(gyr)):
        tick.index, tick.time_ns = k, clock.tick(k)
        now = [Sample(kind[k], *[tick.time_ns] * 3) for kind in (gyr, acc)]
        angles.append(block.step(state, [*now, nothing], tick)[1][FLEXION])
    assert tick.reports == []
    assert np.degrees(np.sqrt(np.mean((np.array(angles) - true) ** 2))) < 4.0


def test_short_losses_and_clipping_are_flagged_and_widen_the_uncertainty():
    gyr, acc, mag, true, _ = finger()
    clean = run_tracker(tracker(), gyr, acc, mag)[0]
    spoilt, full = gyr.copy(), gyr.copy()
    spoilt[300:304, 2] = np.nan
    full[300:304, 2, 2] = np.radians(2000.0)
    for wrong, status in ((spoilt, "lost_sample"), (full, "clipped_sample")):
        (_, angles, sd, _, _), reports, _ = run_tracker(tracker(), wrong, acc, mag)
        assert reports == [(status, "gyr of sensor 2"),
                           ("samples_sound", "every sensor gives sound samples again")]
        assert (sd[303, 2:] > 1.2 * clean[2][303, 2:]).all()
        assert np.isfinite(angles).all()
    (_, angles, _, _, _), _, _ = run_tracker(tracker(), spoilt, acc, mag)
    assert np.degrees(np.abs(angles[-1, FLEXION] - true[-1])).max() < 6.0


def test_a_strip_left_off_is_unseen_and_comes_back():
    gyr, acc, mag, true, _ = finger(depth_deg=(0.0, 0.0, 0.0))
    for kind in (gyr, acc, mag):
        kind[:300, 2:] = 0.0
    (_, angles, sd, _, _), reports, _ = run_tracker(tracker(), gyr, acc, mag)
    assert ("unseen", "joint 1-2, 2-3") in reports
    assert reports[-1] == ("seen", "joint 1-2, 2-3")
    assert (sd[:300, 2:] == np.pi).all()
    np.testing.assert_allclose(angles[:300, 2:], np.tile(np.radians(START_DEG[1:]), (300, 1)), atol=1e-12)
    assert np.degrees(np.abs(angles[250, 0] - true[250, 0])) < 1.5
    assert np.degrees(sd[-1]).max() < 10.0
    assert np.degrees(np.abs(angles[-1, FLEXION] - true[-1])).max() < 2.0


def test_a_whole_hand_and_its_snapshot():
    rng = np.random.default_rng(3)
    gyr, acc, mag = rng.normal(size=(3, 80, 16, 3))
    acc += np.array([0.0, 0.0, 9.81])
    mag = 1e-6 * mag + FIELD
    block = KortierTracker().resolve({"gyr": (16, 3), "acc": (16, 3), "mag": (16, 3)})
    whole, _, _ = run_tracker(block, gyr, acc, mag)
    assert [part.shape[1:] for part in whole] == [(16, 4), (21,), (21,), (3,), (3,)]
    _, _, state = run_tracker(block, gyr, acc, mag, last=37)
    rest, _, _ = run_tracker(block, gyr, acc, mag, state=pickle.loads(pickle.dumps(state)), first=37)
    for all_of_it, part in zip(whole, rest, strict=True):
        np.testing.assert_array_equal(all_of_it[37:], part)
    np.testing.assert_allclose(np.linalg.norm(whole[0], axis=2), 1.0, atol=1e-12)


@pytest.mark.parametrize(("wrong", "key"), [
    ({"gyr_sd": 0.0}, "gyr_sd"), ({"lever_m": -1.0}, "lever_m"), ({"still_window": 1}, "still_window"),
    ({"sensors": -1}, "sensors"), ({"sensors": 15, "chains": HAND}, "chains"),
    ({"sensors": 17, "chains": HAND}, "chains"), ({"sensors": 17}, "16"),
    ({"sensors": 4, "chains": (*FINGER, *FINGER)}, "given twice"),
    ({"sensors": 8, "chains": (*FINGER, Chain(sensors=(5, 6), joints=("hinge",)))}, "base 5")])
def test_impossible_parameters_are_refused(wrong, key):
    with pytest.raises(InputError, match=key):
        KortierTracker(**wrong)


@pytest.mark.parametrize("wrong", [
    {"sensors": (0,), "joints": ()}, {"sensors": (0, 0), "joints": ("hinge",)},
    {"sensors": (0, 1), "joints": ("rope",)}, {"sensors": (0, 1), "joints": ("hinge", "hinge")},
    {"sensors": (0, 1), "joints": ("hinge",), "initial_angles_deg": (1.0, 2.0)}])
def test_impossible_chains_are_refused(wrong):
    with pytest.raises(InputError, match="chains"):
        Chain(**wrong)
