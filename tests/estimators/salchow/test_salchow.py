"""The trackers of Salchow-Hoemmen et al. on a hand in closed form: accuracy, poses, bad samples."""

import pickle

import numpy as np
import pytest
from hand_parts import FIELD, moving_hand
from hypothesis import given, settings
from hypothesis import strategies as st
from tracker_parts import run_tracker, sample

from estimators.body.body import UNSEEN_SD
from estimators.calibration.initial_pose import InitialPoseLimits, known_angles
from estimators.salchow import SalchowB, SalchowM1, SalchowM2
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock

RATE = 100
LEFT, RIGHT = HandSize(side="left"), HandSize()
THUMB = {"F1_cmc_abduction": -40.0, "F1_cmc_pronation": 30.0}
TRACKERS = [SalchowB, SalchowM1, SalchowM2]
FRONT_ENDS = ["vqf", "seel_ruppin"]
MOVING = 350
"""Tick from which on the hand of `moving_hand` moves; the initial pose has ended at 300."""


def fed(tracker, motion):
    """What a tracker reads of a motion."""
    kinds = (motion.gyr, motion.acc, motion.mag)
    return kinds[:len(tracker.inputs)]


def run(tracker, motion, **spoilt):
    """Outputs by name, reports, and the last state, of a tracker fed with a motion, parts of it spoilt."""
    outputs, reports, state = run_tracker(tracker, *fed(tracker, motion._replace(**spoilt)), rate=RATE)
    return {port.name: rows for port, rows in zip(tracker.outputs, outputs, strict=True)}, reports, state


def start_of(tree, angles_deg=THUMB):
    return known_angles(tree, angles_deg)


def with_pose(kind, **parameters):
    """A tracker told of the thumb in its initial pose, if it takes one."""
    return kind(**parameters) if kind is SalchowB else kind(initial_angles_deg=THUMB, **parameters)


@pytest.mark.parametrize("front_end", FRONT_ENDS)
@pytest.mark.parametrize("kind", TRACKERS)
@given(seed=st.integers(0, 2**32 - 1), hand=st.sampled_from([LEFT, RIGHT]))
@settings(deadline=None, max_examples=8)
def test_ideal_sensors_give_the_posture_and_the_fingertips(kind, front_end, seed, hand):
    tree = hand_tree(hand)
    motion = moving_hand(tree, RATE, 8.0, seed, start=start_of(tree), inertia=False)
    outputs, reports, _ = run(with_pose(kind, sensors=17, hand=hand, front_end=front_end), motion)
    error = np.abs(outputs["angles"] - motion.angles)[MOVING:]
    # VQF takes the slow beginning of a motion for bias, and B is still on its way from its first orientation.
    exact = front_end == "seel_ruppin" and kind is not SalchowB
    assert error.max() < (1e-9 if exact else 0.1)
    assert np.median(error) < 1e-3
    tips = np.linalg.norm(outputs["fingertips"] - motion.tips, axis=2)[MOVING:]
    assert tips.max() < (1e-9 if exact else 1e-2)
    assert np.median(tips) < 1e-3
    relative = quaternion.relative(outputs["orientation"][:, :1], outputs["orientation"])[MOVING:]
    true = quaternion.relative(motion.orientation[:, :1], motion.orientation)[MOVING:]
    apart = quaternion.rotation_angle(quaternion.relative(relative, true))
    assert apart.max() < (1e-6 if exact else 0.1)
    assert [status for status, _ in reports] == ([] if kind is SalchowB else ["aligning", "aligned"])


@pytest.mark.parametrize("kind", TRACKERS)
def test_fast_motion_and_biased_noisy_sensors(kind):
    tree, rng = hand_tree(LEFT), np.random.default_rng(0)
    motion = moving_hand(tree, RATE, 12.0, 4, start=start_of(tree), share=0.5)
    bias = np.radians(0.5) * rng.normal(size=(17, 3))
    gyr = motion.gyr + bias + 5e-4 * rng.normal(size=motion.gyr.shape)
    acc = motion.acc + 4e-2 * rng.normal(size=motion.acc.shape)
    outputs, _, _ = run(with_pose(kind, sensors=17, hand=LEFT), motion, gyr=gyr, acc=acc)
    rms = np.degrees(np.sqrt(np.mean((outputs["angles"] - motion.angles)[MOVING:] ** 2, axis=0)))
    assert rms.max() < (8.0 if kind is SalchowB else 4.0)


@pytest.mark.parametrize("front_end", FRONT_ENDS)
def test_the_pose_takes_the_gyroscopes_bias(front_end):
    tree = hand_tree(LEFT)
    motion = moving_hand(tree, RATE, 30.0, 5, start=start_of(tree), inertia=False)
    bias = np.radians(0.5) * np.random.default_rng(1).normal(size=(17, 3))
    tracker = SalchowM2(sensors=17, hand=LEFT, front_end=front_end, initial_angles_deg=THUMB)
    outputs, _, _ = run(tracker, motion, gyr=motion.gyr + bias)
    error = np.degrees(np.abs(outputs["angles"] - motion.angles))[MOVING:]
    # Left in, half a degree a second makes ten degrees of heading in this time.
    assert error.max() < 1.0


def test_a_heading_of_its_own_is_removed_from_each_sensor_and_b_keeps_it():
    tree = hand_tree(LEFT)
    motion = moving_hand(tree, RATE, 6.0, 6, start=start_of(tree), inertia=False)
    # A field of another direction at each sensor: what furniture does to it.
    turns = quaternion.about_z(np.random.default_rng(2).uniform(-0.6, 0.6, 17))
    bent = quaternion.rotate(turns, FIELD)
    mag = quaternion.rotate(quaternion.conjugate(motion.orientation), bent)
    worst = {}
    for kind in (SalchowB, SalchowM1):
        outputs, _, _ = run(with_pose(kind, sensors=17, hand=LEFT), motion, mag=mag)
        worst[kind] = np.abs(outputs["angles"] - motion.angles)[MOVING:].max()
    assert worst[SalchowM1] < 0.02 < 0.1 < worst[SalchowB]


def test_joint_constraints_take_off_what_mounting_makes_joints_do():
    tree = hand_tree(LEFT)
    motion = moving_hand(tree, RATE, 6.0, 7, start=start_of(tree), inertia=False)
    middle = tree.index("F2m")
    twist = quaternion.from_axis_angle([0.0, 1.0, 0.0], np.radians(8.0))
    spoilt = {name: getattr(motion, name).copy() for name in ("gyr", "acc", "mag")}
    for samples in spoilt.values():
        samples[:, middle] = quaternion.rotate(twist, samples[:, middle])
    free, _, _ = run(SalchowB(sensors=17, hand=LEFT), motion, **spoilt)
    held, _, _ = run(with_pose(SalchowM1, sensors=17, hand=LEFT), motion, **spoilt)
    between = {name: quaternion.relative(outputs["orientation"][MOVING:, middle - 1],
                                         outputs["orientation"][MOVING:, middle])
               for name, outputs in (("free", free), ("held", held))}
    forbidden = {name: np.abs(quaternion.euler_zxy(q)[:, 1:]).max() for name, q in between.items()}
    assert forbidden["free"] > np.radians(7.0)
    assert forbidden["held"] < 1e-7


@pytest.mark.parametrize("kind", [SalchowM1, SalchowM2])
def test_the_known_pose_stands_until_it_is_over(kind):
    tree = hand_tree(RIGHT)
    motion = moving_hand(tree, RATE, 4.0, 8, start=start_of(tree))
    outputs, reports, _ = run(with_pose(kind, sensors=17), motion)
    np.testing.assert_allclose(outputs["angles"][:299], np.tile(start_of(tree), (299, 1)), atol=1e-12)
    np.testing.assert_allclose(outputs["fingertips"][:299], motion.tips[:299], atol=1e-12)
    np.testing.assert_array_equal(outputs["aligned"][:, 0], np.arange(400) >= 299)
    assert reports == [("aligning", "keep still in the known pose for 3 s"),
                       ("aligned", "initial pose taken")]


def test_a_pose_that_moved_is_named_and_the_next_still_one_is_taken():
    tree = hand_tree(RIGHT)
    motion = moving_hand(tree, RATE, 7.0, 9, still_s=6.0, start=start_of(tree), inertia=False)
    gyr = motion.gyr.copy()
    gyr[100, 5, 1], gyr[140, 6, 2] = 2.0, 3.0
    outputs, reports, _ = run(with_pose(SalchowM2, sensors=17), motion, gyr=gyr)
    assert [status for status, _ in reports] == ["aligning", "initial_pose_failed", "aligned"]
    assert reports[1][1].startswith("sensor 5 (F2p) moved: 115 deg/s: keep still in the known pose for 3 s")
    # From the last motion on, three seconds.
    assert (outputs["angle_sd"][100:440] == UNSEEN_SD).all()
    assert (outputs["angle_sd"][441:] < 0.25).all()
    assert not outputs["aligned"][:440].any()
    assert outputs["aligned"][441:].all()
    assert np.abs(outputs["angles"] - motion.angles)[600:].max() < 1e-3


def test_a_tracker_without_a_sample_waits_and_its_pose_has_not_failed():
    """Its sensors begin after the time of a pose, as behind a calibration."""
    tree = hand_tree(RIGHT)
    motion = moving_hand(tree, RATE, 8.0, 9, still_s=7.5, start=start_of(tree), inertia=False)
    gyr, acc = motion.gyr.copy(), motion.acc.copy()
    gyr[:310], acc[:310] = np.nan, np.nan
    outputs, reports, _ = run(with_pose(SalchowM2, sensors=17), motion, gyr=gyr, acc=acc)
    told = [(status, detail) for status, detail in reports if status in ("waiting", "initial_pose_failed")]
    assert [status for status, _ in told] == ["waiting"]
    assert told[0][1].startswith("no sensor has given a sample: keep still")
    assert outputs["aligned"][-1, 0] == 1.0
    assert not outputs["aligned"][:310].any()


@pytest.mark.parametrize(("sensor", "factor", "words"), [(3, 0.8, "calibrate"), (9, 1.2, "sensor 9 (F3m)")])
def test_a_pose_that_gravity_contradicts_is_refused(sensor, factor, words):
    tree = hand_tree(RIGHT)
    motion = moving_hand(tree, RATE, 4.0, 10, start=start_of(tree))
    acc = motion.acc.copy()
    acc[:, sensor] *= factor
    outputs, reports, _ = run(with_pose(SalchowM2, sensors=17), motion, acc=acc)
    assert [status for status, _ in reports][:2] == ["aligning", "initial_pose_failed"]
    assert words in reports[1][1]
    assert (outputs["angle_sd"][300:] == UNSEEN_SD).all()


def test_a_thumb_that_is_not_as_told_is_refused():
    tree = hand_tree(RIGHT)
    upright = quaternion.from_axis_angle([1.0, 0.0, 0.0], np.pi / 2)
    motion = moving_hand(tree, RATE, 4.0, 11, start=start_of(tree, {"F2_mcp_flexion": 60.0}), base=upright)
    _, reports, _ = run(SalchowM2(sensors=17), motion)
    assert reports[1][0] == "pose_contradicted"
    assert "60 deg at F2_mcp (sensor 5, F2p)" in reports[1][1]


def test_a_silent_sensor_is_left_out_of_the_pose_for_good():
    tree = hand_tree(RIGHT)
    motion = moving_hand(tree, RATE, 5.0, 12, start=start_of(tree), inertia=False)
    gyr, acc = motion.gyr.copy(), motion.acc.copy()
    gyr[:400, 16], acc[:400, 16] = np.nan, np.nan
    outputs, reports, _ = run(with_pose(SalchowM2, sensors=17), motion, gyr=gyr, acc=acc)
    assert ("aligned", "without sensor 16 (F5d): no sample") in reports
    assert ("untracked", "joint F5_dip") in reports
    assert (outputs["angle_sd"][:, -1] == UNSEEN_SD).all()
    assert np.abs(outputs["angles"] - motion.angles)[MOVING:, :-1].max() < 1e-3
    assert (outputs["angles"][:, -1] == 0.0).all()


@pytest.mark.parametrize("kind", TRACKERS)
def test_sixteen_sensors_do_not_see_the_wrist_and_a_strip_left_off_its_finger(kind):
    tree = hand_tree(RIGHT)
    names = tuple(n for n in tree.names if n != "forearm" and not n.startswith("F3"))
    goal = moving_hand(tree, RATE, 6.0, 13, start=start_of(tree), names=names, inertia=False)
    outputs, reports, _ = run(with_pose(kind, sensors=13, sensed=names), goal)
    assert ("untracked", "joint wrist, F3_mcp, F3_pip, F3_dip") in reports
    unseen = np.array([name.startswith(("wrist", "F3")) for name in tree.freedoms])
    assert (outputs["angles"][:, unseen] == 0.0).all()
    assert (outputs["angle_sd"][:, unseen] == UNSEEN_SD).all()
    assert np.abs(outputs["angles"] - goal.angles)[MOVING:, ~unseen].max() < 2e-3
    sd = outputs["fingertip_sd"][-1].max(axis=1)
    # Of the finger without sensors nothing is known; a wrist that no sensor was meant for is not counted.
    assert sd[2] > 0.2
    assert np.delete(sd, 2).max() < 0.05


def lost_for(motion, sensor, first, last):
    gyr, acc = motion.gyr.copy(), motion.acc.copy()
    gyr[first:last, sensor], acc[first:last, sensor] = np.nan, np.nan
    return {"gyr": gyr, "acc": acc}


def test_a_long_gap_makes_joints_unseen_and_leaves_its_doubt():
    tree = hand_tree(RIGHT)
    motion = moving_hand(tree, RATE, 10.0, 14, start=start_of(tree), inertia=False)
    spoilt = lost_for(motion, 6, 500, 550)
    outputs, reports, _ = run(with_pose(SalchowM2, sensors=17), motion, **spoilt)
    told = [report for report in reports
            if report[0] in ("untracked", "tracked", "lost_sample", "samples_valid")]
    assert told == [("lost_sample", "gyr of sensor F2m; acc of sensor F2m"),
                    ("untracked", "joint F2_pip, F2_dip"),
                    ("samples_valid", "every sensor gives sound samples again"),
                    ("tracked", "joint F2_pip, F2_dip")]
    number = tree.freedom("F2_pip_flexion")
    sd = outputs["angle_sd"][:, number]
    assert (sd[512:550] == UNSEEN_SD).all()
    assert (sd[:505] < 0.2).all()
    assert sd[551] > np.radians(25.0)
    assert abs(outputs["angles"] - motion.angles)[551, number] < 2.0 * sd[551]
    with_field, _, _ = run(with_pose(SalchowM1, sensors=17), motion, **spoilt)
    assert np.abs(with_field["angles"] - motion.angles)[-1, number] < 0.2
    assert with_field["angle_sd"][-1, number] < with_field["angle_sd"][551, number]
    others = np.delete(np.arange(23), [number, number + 1])
    assert np.abs(outputs["angles"] - motion.angles)[MOVING:, others].max() < 1e-3


def test_short_gaps_clipped_and_lost_accelerations_are_told_and_stood():
    tree = hand_tree(RIGHT)
    motion = moving_hand(tree, RATE, 6.0, 15, start=start_of(tree), inertia=False)
    gyr, acc, mag = motion.gyr.copy(), motion.acc.copy(), motion.mag.copy()
    gyr[400, 3, 0] = np.radians(2500.0)
    acc[430:433, 4], mag[440, 5], gyr[450:453, 7] = np.nan, 0.0, np.inf
    outputs, reports, _ = run(with_pose(SalchowM1, sensors=17), motion, gyr=gyr, acc=acc, mag=mag)
    told = [report for report in reports[2:] if report[0] != "samples_valid"]
    assert told == [("clipped_sample", "gyr of sensor F1p"), ("lost_sample", "acc of sensor F1d"),
                    ("lost_sample", "mag of sensor F2p"), ("lost_sample", "gyr of sensor F2d")]
    assert all(np.isfinite(rows).all() for rows in outputs.values())
    untouched = [k for k, name in enumerate(tree.freedoms) if name.startswith(("F4", "F5", "wrist"))]
    assert np.abs(outputs["angles"] - motion.angles)[MOVING:, untouched].max() < 2e-3


@pytest.mark.parametrize("front_end", FRONT_ENDS)
@pytest.mark.parametrize("kind", TRACKERS)
def test_slower_accelerometers_and_magnetometers_are_no_repetition(kind, front_end):
    tree, rate = hand_tree(RIGHT), 200
    motion = moving_hand(tree, rate, 6.0, 16, start=start_of(tree), inertia=False)
    every = {"acc_every": 2} if kind is SalchowM2 else {"acc_every": 2, "mag_every": 2}
    tracker = with_pose(kind, sensors=17, front_end=front_end, **every)
    clock = RateClock.from_rate(rate)
    state, tick, angles = tracker.init(Context("tracker", clock=clock)), Tick(), []
    for k in range(len(motion.gyr)):
        tick.index, tick.time_ns = k, clock.tick(k)
        held = k - k % 2
        samples = [sample(motion.gyr[k], clock.tick(k))]
        samples += [sample(rows[held], clock.tick(held)) for rows in fed(tracker, motion)[1:]]
        angles.append(tracker.step(state, samples, tick)[1])
    assert [status for status, _ in tick.reports] == ([] if kind is SalchowB else ["aligning", "aligned"])
    assert np.abs(np.array(angles) - motion.angles)[700:].max() < 5e-3


def test_a_repeated_rate_is_held_and_told():
    tree = hand_tree(RIGHT)
    motion = moving_hand(tree, RATE, 1.0, 17)
    tracker = SalchowB(sensors=17)
    _, reports, state = run_tracker(tracker, *fed(tracker, motion), rate=RATE)
    tick = Tick()
    tick.index, tick.time_ns = 100, 1_000_000_000
    tracker.step(state, [sample(rows[99], 990_000_000) for rows in fed(tracker, motion)], tick)
    assert [status for status, _ in tick.reports] == ["repeated_sample"]
    assert reports == []


def test_the_sd_of_m2_grows_with_time_and_that_of_m1_does_not():
    tree = hand_tree(RIGHT)
    motion = moving_hand(tree, RATE, 63.0, 18, still_s=100.0, base=np.array([1.0, 0.0, 0.0, 0.0]))
    sds = {}
    for kind, parameters in ((SalchowM1, {}), (SalchowM2, {"drift_deg_s": 0.1})):
        outputs, _, _ = run(kind(sensors=17, **parameters), motion)
        sds[kind] = np.degrees(outputs["angle_sd"][[300, -1]])
    assert np.allclose(sds[SalchowM1][0], sds[SalchowM1][1])
    # The hand lies such that flexion is about the vertical: 0.1 deg/s for 60 s beside 5 deg of mounting,
    # 5 deg of the pose, and 2 deg of fusion of each sensor.
    flexion = tree.freedom("F2_pip_flexion")
    constant = np.sqrt(5.0**2 + 5.0**2 + 2.0 * 2.0**2)
    assert sds[SalchowM2][0, flexion] == pytest.approx(constant, rel=1e-3)
    assert sds[SalchowM2][1, flexion] == pytest.approx(np.hypot(constant, 6.0), rel=1e-3)


@pytest.mark.parametrize("front_end", FRONT_ENDS)
@pytest.mark.parametrize("kind", TRACKERS)
@pytest.mark.parametrize("at", [0, 40, 61, 99])
def test_stop_save_restore_continue_equals_uninterrupted(kind, front_end, at):
    tree = hand_tree(LEFT)
    motion = moving_hand(tree, RATE, 1.2, 19, still_s=0.7, start=start_of(tree))
    pose = {} if kind is SalchowB else {"initial_pose_s": 0.6}
    tracker = with_pose(kind, sensors=17, hand=LEFT, front_end=front_end, **pose)
    kinds = fed(tracker, motion)
    whole, _, _ = run_tracker(tracker, *kinds, rate=RATE)
    state = run_tracker(tracker, *kinds, rate=RATE, last=at)[2] if at else None
    rest, _, _ = run_tracker(tracker, *kinds, rate=RATE, state=pickle.loads(pickle.dumps(state)), first=at)
    for all_of_it, part in zip(whole, rest, strict=True):
        np.testing.assert_array_equal(all_of_it[at:], part)


def test_ticks_skipped_while_busy_are_made_good():
    tracker = SalchowB(sensors=2, sensed=("hand", "F2p"))
    state, tick = tracker.init(Context("tracker", clock=RateClock.from_rate(100))), Tick()
    rate, up = np.zeros((2, 3)), np.tile([0.0, 0.0, 9.81], (2, 1))
    rate[1, 2] = 1.0
    for k in (0, 1, 5, 9):
        tick.index, tick.time_ns = k, k * 10_000_000
        samples = [sample(rows, tick.time_ns) for rows in (rate, up, np.zeros((2, 3)))]
        orientation = tracker.step(state, samples, tick)[0]
    # Without a field nothing corrects the heading; rates between samples tend to zero a little.
    assert quaternion.rotation_angle(quaternion.relative(*orientation)) == pytest.approx(0.1, rel=2e-3)


def test_sizes_come_from_the_wire():
    tracker = SalchowM2().resolve({"gyr": (16, 3), "acc": (16, 3)})
    assert [port.shape for port in tracker.outputs] == [(16, 4), (23,), (23,), (5, 3), (5, 3), (1,), (23,)]
    with pytest.raises(InputError, match="name the sensors' segments"):
        SalchowM2().resolve({"gyr": (5, 3), "acc": (5, 3)})
    with pytest.raises(InputError, match="sensors"):
        SalchowM2().init(Context("tracker", clock=RateClock.from_rate(100)))
    with pytest.raises(InputError, match="rate"):
        SalchowM2(sensors=16).init(Context("tracker"))


@pytest.mark.parametrize("wrong", [
    {"sensors": -1}, {"front_end": "madgwick"}, {"tau_acc_s": 0.0}, {"acc_every": 0}, {"gap_ms": -1.0},
    {"initial_pose_s": 0.0}, {"sensors": 16, "initial_angles_deg": {"F9_mcp": 1.0}},
    {"sensors": 2, "sensed": ("hand", "F9d")}, {"drift_deg_s": float("nan")}])
def test_impossible_parameters_are_refused(wrong):
    with pytest.raises(InputError):
        SalchowM2(**wrong)
    assert SalchowM2(pose_limits=InitialPoseLimits(turned_deg=10.0)).body is None
