"""Which of several first headings a joint keeps: simulated, and on a recording from many instants."""

import math

import numpy as np
import pytest
from jointed_parts import Errors, Jointed, away
from tracker_parts import run_tracker

from estimators.body.joint_constraints import Joint
from estimators.constrained import ConstrainedTracker
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.streams.files import open_recording

SADDLE = (Joint(parent=0, child=1, kind="saddle", child_axis=(1.0, 0.0, 0.0)),)
SENSORS = Errors(mounting=math.radians(3), bias=math.radians(0.5))
CHAIN_SADDLES = (
    Joint(parent=1, child=3, kind="saddle", parent_axis=(1.0, 0.0, 0.0), child_axis=(0.0, 1.0, 0.0)),
    Joint(parent=2, child=4, kind="saddle", parent_axis=(0.0, 1.0, 0.0), child_axis=(0.0, 0.0, 1.0)))
FAR = math.radians(30)


def still_then_moving(seed, still_s=5, rate=50):
    """(gyr, acc, true angles) of a saddle that may stand anywhere at the start, far from its zero too."""
    motion = Jointed(SADDLE, seed, SENSORS)
    motion.middle[0] = motion.rng.uniform([-3.0, -1.2], [3.0, 1.2])
    times = np.arange(15 * rate) / rate
    gyr, acc = motion.samples(times)
    still = still_s * rate
    noise = motion.rng.normal(size=(2, still, 2, 3)) * np.array([1e-3, 2e-2])[:, None, None, None]
    # At rest in the first pose: gravity alone, in each sensor's frame.
    up = quaternion.rotate(quaternion.conjugate(motion.poses(times[:1])[0]), [0.0, 0.0, 9.81])
    up = np.stack([quaternion.rotate(quaternion.conjugate(mounted), up[0, i])
                   for i, mounted in enumerate(motion.mounting)])
    angles = motion.angles(times)
    return (np.concatenate([noise[0], gyr]), np.concatenate([up + noise[1], acc]),
            np.concatenate([np.repeat(angles[:1], still, axis=0), angles]))


@pytest.mark.slow
def test_stillness_leaves_both_headings_open_and_motion_finds_the_true_one():
    wrong_first = 0
    for seed in range(40):
        gyr, acc, true = still_then_moving(seed)
        tracker = ConstrainedTracker(sensors=2, joints=SADDLE)
        (_, angles, sd, *_), reports, state = run_tracker(tracker, gyr, acc, rate=50)
        error = np.abs(away(angles, true)).max(axis=1)
        far = error > FAR
        wrong_first += far[100]
        # Wherever it is far off it says so; at the end it is neither.
        assert (sd[far].max(axis=1) > math.radians(15)).all()
        assert not far[-250:].any()
        assert not state.found.open
        assert {status for status, _ in reports} <= {"uncertain", "certain"}
    assert wrong_first >= 8


@pytest.mark.parametrize("sensor_set", ["rigid", "nonrigid"])
def test_saddles_of_the_chain_are_found_or_unsure_whenever_one_begins(recordings, sensor_set):
    recording = open_recording(str(recordings / "chain5" / "trial1.npz"), sensor_set)
    true = quaternion.interpolate(
        recording.reference.stamps_ns, recording.reference.orientation, recording.stamps_ns)
    tracker = ConstrainedTracker(sensors=5, joints=CHAIN_SADDLES)
    silent = []
    for start in range(0, 2200, 110):
        span = slice(start, start + 400)
        (orientation, _, sd, *_), _, _ = run_tracker(
            tracker, recording.gyr[span], recording.acc[span], rate=40)
        for j, (p, c) in enumerate(((1, 3), (2, 4))):
            found, reference = (quaternion.relative(q[:, p], q[:, c]) for q in (orientation, true[span]))
            error = quaternion.rotation_angle(quaternion.relative(reference, found))
            sure = sd[:, 2 * j:2 * j + 2].max(axis=1) < math.radians(15)
            silent.append((error > FAR) & sure)
            assert not (error[200:] > FAR).any()
    assert np.mean(silent) < 0.01


def test_a_known_pose_gives_the_first_headings():
    """A thumb abducted by 45 deg and palm down, where no axis tells a heading: told, all is there at once."""
    from fesloop.hand.anthropometry import HandSize
    from fesloop.hand.kinematics import segment_poses
    from fesloop.hand.skeleton import hand_tree
    from fesloop.loop.block import Context, Tick
    from fesloop.loop.clock import RateClock
    from fesloop.loop.signals import Sample

    size = HandSize(side="left")
    tree, angles = hand_tree(size), np.zeros(23)
    angles[tree.freedom("F1_cmc_abduction")] = np.radians(-45.0)
    upwards = np.array([9.80665, 0.0, 0.0])
    acc = np.tile(upwards, (17, 1))
    tips = segment_poses(tree, angles).position[[tree.index(f"F{i}d") for i in range(1, 6)]]
    off = {}
    for pose_s in (0.0, 1.0):
        told = {"F1_cmc_abduction": -45.0} if pose_s else {}
        tracker = ConstrainedTracker(sensors=17, hand=size, initial_pose_s=pose_s, initial_angles_deg=told)
        state, tick = tracker.init(Context("tracker", clock=RateClock.from_rate(100))), Tick()
        for k in range(20):
            tick.index, tick.time_ns = k, k * 10**7
            inputs = [Sample(np.zeros((17, 3)), *[tick.time_ns] * 3), Sample(acc, *[tick.time_ns] * 3)]
            _, found, sd, places, _, aligned, _ = tracker.step(state, inputs, tick)
            assert aligned == float(not pose_s), "20 of 100 samples of the pose"
        off[pose_s] = (np.abs(places - tips).max(), np.degrees(np.abs(found - angles)).max(),
                       np.degrees(sd.max()))
    assert off[1.0][0] < 1e-3
    assert off[1.0][1] < 0.5
    assert off[1.0][2] < 15.0
    assert off[0.0][2] > 30.0


def test_a_pose_needs_a_body_and_a_time():
    with pytest.raises(InputError, match="initial_pose_s"):
        ConstrainedTracker(sensors=17, initial_angles_deg={"F2_pip_flexion": 10.0})
    with pytest.raises(InputError, match="body"):
        ConstrainedTracker(sensors=5, initial_pose_s=1.0)
    with pytest.raises(InputError, match="F2_pip_flexion"):
        ConstrainedTracker(sensors=17, initial_pose_s=1.0, initial_angles_deg={"F2_pip_flexon": 10.0})
