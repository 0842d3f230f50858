"""The constrained tracker on known motions, on a recording, and under bad samples."""

import dataclasses
import math
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jointed_parts import Errors, Jointed, away
from tracker_parts import run_tracker
from worn_parts import EXACT, WornHand

from estimators.body.joint_constraints import HINGE, Joint, joint_table, joints_of
from estimators.constrained import ConstrainedTracker
from estimators.constrained.agreement import COLUMNS
from estimators.constrained.block import by_joint
from estimators.constrained.filter import truncated
from estimators.constrained.measurements import N
from estimators.constrained.posture import joint_angles, mounting_scale, posture
from fesloop.errors import InputError
from fesloop.experiment.metrics.orientation import score_recording
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.segments import Segment
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.signals import Sensors
from fesloop.streams.files import open_recording

X, Y, Z = np.eye(3).tolist()
EACH = (Joint(parent=0, child=1, kind="saddle", child_axis=(1.0, 0.0, 0.0)),
        Joint(parent=1, child=2, kind="hinge"), Joint(parent=0, child=3, kind="ball"))
TREE = hand_tree(HandSize())
HAND = tuple(dataclasses.replace(joint, ranges_deg=()) for joint in joints_of(TREE, TREE.names[1:]))
SENSORS = Errors(bias=math.radians(0.5), walk=1e-4)
OF_EACH = ConstrainedTracker(sensors=4, joints=EACH)
SADDLES = (Joint(parent=1, child=3, kind="saddle", parent_axis=tuple(X), child_axis=tuple(Y)),
           Joint(parent=2, child=4, kind="saddle", parent_axis=tuple(Y), child_axis=tuple(Z)))


def tracked(joints, motion, seconds, rate=50, **parameters):
    """(times, error of the angles, their sd, orientation, reports) of a tracker over a motion."""
    times = np.arange(int(seconds * rate)) / rate
    tracker = ConstrainedTracker(sensors=motion.sensors, joints=joints, **parameters)
    (orientation, angles, sd, *_), reports, _ = run_tracker(tracker, *motion.samples(times), rate=rate)
    return times, away(angles, motion.angles(times)), sd, orientation, reports


def rms_deg(errors):
    return np.degrees(np.sqrt(np.mean(np.square(errors), axis=0)))


@pytest.mark.parametrize("seed", range(3))
def test_exact_sensors_give_exact_angles(seed):
    times, error, _, orientation, _ = tracked(EACH, motion := Jointed(EACH, seed, Errors(noise=0.0)), 20)
    assert rms_deg(error[times > 10]).max() < 0.5
    q, _ = motion.poses(times[-1:])
    for joint in EACH:
        found, true = (quaternion.relative(each[-1, joint.parent], each[-1, joint.child])
                       for each in (orientation, q))
        assert np.degrees(quaternion.rotation_angle(quaternion.relative(found, true))) < 1.0


@pytest.mark.slow
def test_its_intervals_cover_the_truth_of_a_hand():
    """Errors drawn as the parameters say: mounting 5 deg, axes 5 deg, datasheet noise, bias."""
    stated = Errors(mounting=math.radians(5), axes=math.radians(5), bias=math.radians(0.5), walk=1e-4)
    inside = []
    for seed in range(10):
        times, error, sd, _, _ = tracked(HAND, Jointed(HAND, seed, stated), 15, rate=100)
        inside.append(np.abs(error[times > 5]) < 1.96 * sd[times > 5])
    covered = np.mean(inside)
    print(f"95 % intervals cover {100 * covered:.1f} %")
    assert 0.90 <= covered <= 0.99


@pytest.mark.slow
def test_an_hour_leaves_it_as_it_was():
    motion = Jointed(EACH, 0, Errors(bias=math.radians(0.3), walk=math.radians(0.003)), rest_s=60.0)
    times, error, _, _, _ = tracked(EACH, motion, 3600, rate=20)
    first, last = (rms_deg(error[(times > start) & (times <= start + 600)]) for start in (5, 3000))
    print(f"deg, first and last ten minutes: {first.round(2)}, {last.round(2)}")
    assert last.max() < 2.5
    assert last.mean() < 1.3 * first.mean()


@pytest.mark.slow
def test_a_heading_that_nothing_shows_stays_unsure_while_all_is_still():
    for seed in range(3):
        _, _, sd, _, reports = tracked(EACH, Jointed(EACH, seed, SENSORS, lively=0.0), 600, rate=20)
        assert reports[0] == ("uncertain", "joint 0-1, 1-2, 0-3")
        assert not any(status == "certain" and "0-3" in detail for status, detail in reports)
        assert np.degrees(sd[-1, 3:].max()) > 15.0


def test_uncertainty_grows_when_motion_ends():
    """A ball joint known from motion: in stillness its heading is integrated from there, no better."""
    times = np.arange(120 * 50) / 50
    gyr, acc = Jointed(EACH, 1, SENSORS).samples(times[:3000])
    gyr, acc = (np.concatenate([kind, np.repeat(still, 3000, axis=0)])
                for kind, still in ((gyr, 0.0 * gyr[-1:]), (acc, acc[-1:])))
    (_, _, sd, *_), _, _ = run_tracker(OF_EACH, gyr, acc, rate=50)
    assert sd[-1, 3:].max() > 1.2 * sd[2999, 3:].max()
    assert (np.diff(sd[3100::100, 3:].max(axis=1)) > 0).all()


def test_any_first_heading_is_left_within_seconds():
    """Hinges know theirs from the first sample; saddles and balls find it in motion."""
    late = []
    for seed in range(12):
        times, error, _, _, _ = tracked(EACH, Jointed(EACH, seed, SENSORS), 12)
        far = np.abs(error) > math.radians(10)
        late.append([times[rows].max(initial=0.0) for rows in far.T])
    print(f"s until within 10 deg, an angle: {np.median(late, axis=0)}, worst {np.max(late, axis=0)}")
    assert np.max(late, axis=0)[2] < 1.0
    assert np.median(late, axis=0).max() < 2.0


def test_a_hinge_that_begins_upright_is_unsure_until_its_axis_leans():
    hinge = (Joint(parent=0, child=1, kind="hinge"),)
    acc = np.tile([0.0, 0.0, 9.81], (400, 2, 1))
    lean = np.clip(np.arange(400) - 200, 0, 100) * 0.01
    gyr = np.zeros((400, 2, 3))
    # About the parent's x; the child is turned by 2 rad about z against it.
    gyr[200:300, 0, 0] = 0.5
    for i, turned in enumerate((0.0, 2.0)):
        about_z = quaternion.about_z(-turned)
        gyr[:, i] = quaternion.rotate(about_z, gyr[:, 0])
        up = np.stack([0.0 * lean, 9.81 * np.sin(lean), 9.81 * np.cos(lean)], axis=1)
        acc[:, i] = quaternion.rotate(about_z, up)
    tracker = ConstrainedTracker(sensors=2, joints=hinge)
    (_, angles, sd, *_), reports, _ = run_tracker(tracker, gyr, acc, rate=50)
    assert np.degrees(sd[:200].min()) > 90.0
    assert np.degrees(np.abs(away(angles[320:, 0], 2.0))).max() < 5.0
    assert np.degrees(sd[-1, 0]) < 10.0
    assert [status for status, _ in reports] == ["uncertain", "certain"]


def test_ranges_hold_a_joint_that_nothing_else_does():
    limited = (Joint(parent=0, child=1, kind="ball", ranges_deg=((-30.0, 30.0),) * 3),)
    gyr = np.zeros((5000, 2, 3))
    gyr[:, 1, 2] = 0.02
    acc = np.tile([0.0, 0.0, 9.81], (5000, 2, 1))
    (_, free, *_), _, _ = run_tracker(ConstrainedTracker(sensors=2, joints=(
        Joint(parent=0, child=1, kind="ball"),)), gyr, acc, rate=50)
    tracker = ConstrainedTracker(sensors=2, joints=limited)
    (_, held, sd, *_), reports, state = run_tracker(tracker, gyr, acc, rate=50)
    assert np.degrees(free.max()) > 90.0
    # First they decide between headings, then they hold, within twice their tolerance.
    assert not state.found.open
    tolerance = math.hypot(tracker.range_sd_deg, math.sqrt(2.0) * tracker.mounting_sd_deg)
    assert np.degrees(np.abs(held[-500:]).max()) < 30.0 + 2.0 * tolerance
    assert np.degrees(sd[-1].max()) > 15.0
    assert [status for status, _ in reports] == ["uncertain", "frozen_sample"]  # sensors without noise


@given(st.floats(-3.0, 3.0), st.floats(0.05, 2.0), st.floats(-1.5, 0.5), st.floats(0.1, 2.0))
@settings(deadline=None, max_examples=50)
def test_what_is_left_of_a_distribution_inside_a_range(mean, sd, low, width):
    from scipy.stats import truncnorm

    a, b = (low - mean) / sd, (low + width - mean) / sd
    found, variance = truncated(mean, sd * sd, low, low + width)
    if -5.0 < a < 5.0 or -5.0 < b < 5.0 or a < 0.0 < b:
        expected = truncnorm(a, b, loc=mean, scale=sd)
        assert found == pytest.approx(expected.mean(), abs=1e-4)
        assert variance == pytest.approx(expected.var(), abs=1e-4)
    else:
        assert low <= found <= low + width


def reversed_in_time(recording):
    """The recording played backwards."""
    reference, last = recording.reference, recording.stamps_ns[-1]
    kept = reference.stamps_ns <= last
    backwards = (last - reference.stamps_ns[kept])[::-1].copy()
    return dataclasses.replace(
        recording, gyr=-recording.gyr[::-1], acc=recording.acc[::-1].copy(), mag=None,
        reference=dataclasses.replace(reference, stamps_ns=backwards, scored=backwards >= 5_000_000_000,
                                      orientation=reference.orientation[kept][::-1].copy()))


def biased(recording):
    bias = np.radians(0.5) * np.random.default_rng(0).normal(size=(1, 5, 3))
    return dataclasses.replace(recording, gyr=recording.gyr + bias)


@pytest.mark.parametrize("changed", [lambda recording: recording, reversed_in_time, biased],
                         ids=["as_recorded", "reversed", "biased"])
@pytest.mark.parametrize(("sensor_set", "hinge_bar", "saddle_bar"),
                         [("rigid", 3.8, 5.5), ("nonrigid", 5.8, 8.5)])
def test_joints_of_the_chain(recordings, sensor_set, hinge_bar, saddle_bar, changed):
    recording = changed(open_recording(str(recordings / "chain5" / "trial1.npz"), sensor_set))
    for joints, apart, bar in (((), 1, hinge_bar), (SADDLES, 2, saddle_bar)):
        tracker = ConstrainedTracker(sensors=5, joints=joints)
        (orientation, *_), _, _ = run_tracker(tracker, recording.gyr, recording.acc, rate=40)
        score = score_recording(recording, recording.stamps_ns, orientation, "relative")
        names = [f"seg{i}-seg{i + apart}" for i in range(2, 6 - apart)]
        pairs = [score["orientation_rmse_deg"][name]["total"] for name in names]
        print(f"{sensor_set}: {np.round(pairs, 2)}, mean {np.mean(pairs):.2f} deg")
        assert np.mean(pairs) <= bar


def test_lost_and_clipped_samples_cost_certainty():
    times = np.arange(600) / 50
    gyr, acc = Jointed(EACH, 2, SENSORS).samples(times)
    clean, _, _ = run_tracker(OF_EACH, gyr, acc, rate=50)
    gyr[400:410, 2, 1], acc[450, 3] = np.nan, 0.0
    gyr[470, 2, 0] = math.radians(2000.0)
    (orientation, angles, sd, *_), reports, _ = run_tracker(OF_EACH, gyr, acc, rate=50)
    assert np.isfinite(orientation).all()
    assert np.isfinite(angles).all()
    np.testing.assert_array_equal(angles[:500, :2], clean[1][:500, :2])
    assert (np.diff(sd[399:410, 2]) > 0).all()
    assert sd[409, 2] > 2 * clean[2][409, 2]
    told = [(status, detail) for status, detail in reports if "sensor" in detail]
    assert [each for each in told if each[0] != "samples_valid"] == [
        ("lost_sample", "gyr of sensor 2"), ("lost_sample", "acc of sensor 3"),
        ("clipped_sample", "gyr of sensor 2")]


def test_events_and_angles_name_sensors_and_joints():
    names = ("base", "left", "end", "right")
    sources = dict.fromkeys(("gyr", "acc"), Sensors(names))
    tracker = OF_EACH.with_sensors(sources)
    gyr, acc = Jointed(EACH, 2, SENSORS).samples(np.arange(100) / 50)
    gyr[60, 2] = np.nan
    _, reports, _ = run_tracker(tracker, gyr, acc, rate=50)
    ends = [f"{names[joint.parent]}-{names[joint.child]}" for joint in EACH]
    assert reports[0] == ("uncertain", "joint " + ", ".join(ends))
    assert ("lost_sample", "gyr of sensor end") in reports
    parts = {"hinge": ("",), "saddle": (".parent_axis", ".child_axis"),
             "ball": (".flexion", ".abduction", ".pronation")}
    rows = tuple(end + part for end, joint in zip(ends, EACH, strict=True) for part in parts[joint.kind])
    assert {port.name: port.row_names for port in tracker.outputs} == {
        "orientation": names, "angles": rows, "angle_sd": rows, "angle_random_sd": rows, "aligned": ()}
    tips = {port.name: port.rows for port in ConstrainedTracker(sensors=17).outputs}
    assert tips["fingertips"] == tips["fingertip_sd"] == ("F1d", "F2d", "F3d", "F4d", "F5d")


def test_a_clipped_rate_still_moves_its_joint():
    gyr = np.zeros((100, 2, 3))
    gyr[50:60, 1, 2] = math.radians(2000.0)
    acc = np.tile([0.0, 9.81, 0.0], (100, 2, 1))
    turn = np.clip(np.arange(100) - 49, 0, 10) * math.radians(2000.0) / 500
    acc[:, 1] = 9.81 * np.stack([np.sin(turn), np.cos(turn), 0.0 * turn], axis=1)
    tracker = ConstrainedTracker(sensors=2, joints=(Joint(parent=0, child=1, kind="hinge"),))
    (_, angles, sd, *_), reports, _ = run_tracker(tracker, gyr, acc, rate=500)
    assert np.degrees(away(angles[60:, 0], turn[60:])).max() < 5.0
    assert sd[59, 0] > sd[49, 0]
    assert ("clipped_sample", "gyr of sensor 1") in reports


def test_a_sensor_that_never_speaks_leaves_its_joint_unknown():
    times = np.arange(200) / 50
    gyr, acc = Jointed(EACH, 2, SENSORS).samples(times)
    gyr[:, 2], acc[:, 2] = np.nan, np.nan
    (orientation, angles, sd, *_), reports, _ = run_tracker(OF_EACH, gyr, acc, rate=50)
    assert np.isfinite(orientation).all()
    assert (angles[:, 2] == 0.0).all()
    assert (sd[:, 2] == math.pi).all()
    assert not any(status == "certain" and "1-2" in detail for status, detail in reports)


@given(at=st.integers(0, 119))
@settings(deadline=None, max_examples=10)
def test_stop_save_restore_continue_equals_uninterrupted(at):
    kinds = Jointed(EACH, 3, SENSORS).samples(np.arange(120) / 50)
    whole, _, _ = run_tracker(OF_EACH, *kinds)
    _, _, state = run_tracker(OF_EACH, *kinds, last=at) if at else (None, None, None)
    rest, _, _ = run_tracker(OF_EACH, *kinds, state=pickle.loads(pickle.dumps(state)), first=at)
    for all_of_it, part in zip(whole, rest, strict=True):
        np.testing.assert_array_equal(all_of_it[at:], part)


@given(st.integers(0, 2**32 - 1), st.sampled_from(EACH))
@settings(deadline=None, max_examples=40)
def test_derivatives_of_joint_angles_are_those_of_differences(seed, joint):
    rng = np.random.default_rng(seed)
    table = joint_table((dataclasses.replace(joint, parent=0, child=1),), 2)
    turns = rng.uniform(-1.0, 1.0, joint.angles)
    axes = [*joint.axes] if joint.kind != "ball" else np.eye(3)[[2, 0, 1]]
    q = np.array([1.0, 0.0, 0.0, 0.0])
    for axis, turn in zip(axes, turns, strict=False):
        q = quaternion.multiply(q, quaternion.from_axis_angle(axis, turn))
    of = (table.kinds[0], table.axes[0], table.zero[0])
    angles, rows = joint_angles(q, *of)
    np.testing.assert_allclose(angles[:joint.angles], turns, atol=1e-9)
    for k in range(3):
        small = quaternion.from_axis_angle(np.eye(3)[k], 1e-6)
        ahead, _ = joint_angles(quaternion.multiply(q, small), *of)
        back, _ = joint_angles(quaternion.multiply(q, quaternion.conjugate(small)), *of)
        for i in range(joint.angles):
            assert rows[i][k] == pytest.approx((ahead[i] - back[i]) / 2e-6, abs=1e-4)


@pytest.mark.parametrize("true", [0.25, 1.0, 2.0])
def test_mounting_is_as_wrong_as_its_tilts_show(true):
    """40 hinges with tilts of `true` times the stated sd, half of them seen: 80 against two as stated."""
    rng, kinds = np.random.default_rng(1), np.full(40, HINGE)
    stated, left = math.radians(5.0) ** 2, 0.01
    rest, covariance = np.zeros((40, COLUMNS)), np.zeros((40, N, N))
    for j in range(40):
        share = 1.0 if j < 20 else left
        covariance[j, 12:, 12:] = 0.5 * stated * share * np.eye(4)
        rest[j, 13:17] = (0.0 if j < 20 else true) * math.sqrt(0.5 * stated) * rng.normal(size=4)
    expected = (2.0 + 80.0 * true ** 2) / 82.0
    assert mounting_scale(rest, covariance, kinds, stated) == pytest.approx(expected, rel=0.25)
    assert mounting_scale(rest[:20], covariance[:20], kinds[:20], stated) == pytest.approx(1.0)


@pytest.mark.slow
@pytest.mark.parametrize("sensor_set", ["rigid", "nonrigid"])
def test_sds_of_real_hinges_are_at_most_twice_their_errors(sensor_set, recordings):
    recording = open_recording(recordings / "chain5" / "trial1.npz", sensor_set)
    outputs = run_tracker(ConstrainedTracker(sensors=5), recording.gyr, recording.acc, rate=40)[0]
    reference, found = recording.reference, []
    for k, axis in zip((1, 2, 3), np.eye(3), strict=True):
        q = reference.orientation
        between = quaternion.multiply(quaternion.conjugate(q[:, k]), q[:, k + 1])
        true = 2.0 * np.arctan2(between[:, 1:] @ axis, between[:, 0])
        angle, sd, random_sd = (np.interp(reference.stamps_ns, recording.stamps_ns, np.unwrap(each[:, 2 + k]))
                                for each in (outputs[1], outputs[2], outputs[4]))
        error = away(angle, true)
        known = np.isfinite(error) & reference.scored
        changing = error - np.mean(error[known])
        found.append([each[known] for each in (error, sd, changing, random_sd)])
    error, sd, changing, random_sd = (np.concatenate(each) for each in zip(*found, strict=True))
    assert np.mean(np.abs(error) <= 2.0 * sd) >= 0.97
    assert np.median(sd) <= 2.0 * math.sqrt(np.mean(error ** 2))
    share, rms = np.mean(np.abs(changing) <= 2.0 * random_sd), math.sqrt(np.mean(changing ** 2))
    print(sensor_set, share, np.degrees([np.median(random_sd), rms]))
    # Hinges that are not quite hinges err by posture, which is neither constant nor random.
    assert 0.88 <= share <= 0.99
    assert 0.8 * rms <= np.median(random_sd) <= 1.25 * rms


@pytest.mark.slow
@pytest.mark.parametrize(("sensor_set", "most_deg"), [("rigid", 0.6), ("nonrigid", 2.5)])
def test_errors_of_real_hinges_are_a_constant_and_a_delay(sensor_set, most_deg, recordings):
    """Mounting is the constant; cameras and sensors have clocks of their own."""
    recording = open_recording(recordings / "chain5" / "trial1.npz", sensor_set)
    _, angles, *_ = run_tracker(ConstrainedTracker(sensors=5), recording.gyr, recording.acc, rate=40)[0]
    reference, late_ms = recording.reference, []
    for k, axis in zip((1, 2, 3), np.eye(3), strict=True):
        between = quaternion.relative(reference.orientation[:, k], reference.orientation[:, k + 1])
        true = 2.0 * np.arctan2(between[:, 1:] @ axis, between[:, 0])
        error = away(np.interp(reference.stamps_ns, recording.stamps_ns, np.unwrap(angles[:, 2 + k])), true)
        rate = away(true[2:], true[:-2]) / (reference.stamps_ns[2:] - reference.stamps_ns[:-2])
        known = np.isfinite(error[1:-1]) & np.isfinite(rate) & reference.scored[1:-1]
        parts = np.column_stack([np.ones(known.sum()), rate[known]])
        found = np.linalg.lstsq(parts, error[1:-1][known])[0]
        left = error[1:-1][known] - parts @ found
        late_ms.append(1e-6 * found[1])
        assert np.degrees(left.std()) < most_deg
    assert np.ptp(late_ms) < 3.0


@pytest.mark.slow
def test_what_a_hinge_forbids_is_shared_by_the_sds():
    table = joint_table((Joint(parent=0, child=1, kind="hinge"),), 2)
    q = quaternion.multiply(quaternion.about_z(0.4), quaternion.from_axis_angle([1.0, 0.0, 0.0], 0.2))
    for mounting, axis, left in ((5.0, 5.0, 0.1), (1.0, 3.0, 0.18), (3.0, 1.0, 0.02)):
        orientation, angles, _, _, _ = posture(
            np.array([[1.0, 0.0, 0.0, 0.0]]), q[np.newaxis], np.zeros((1, 12, 12)), np.zeros(1), table.roots,
            table.ends, table.kinds, table.axes, table.zero, table.first_angle, 1, mounting, axis,
            np.zeros(1), np.zeros(1), 1.0)
        assert quaternion.tilt_z(orientation[1]) == pytest.approx(left, abs=1e-9)
        assert angles[0] == pytest.approx(0.4, abs=1e-9)


@pytest.mark.parametrize("wrong", [
    {"sensors": -1}, {"axis_sd_deg": 0.0}, {"force_sd": float("nan")}, {"sensors": 4, "sensed": ()},
    {"sensors": 2, "sensed": ("hand", "F2q")}, {"sensors": 4, "hand": HandSize(side="left"), "joints": EACH},
    {"sensors": 3, "joints": (Joint(parent=0, child=4, kind="ball"),)}])
def test_impossible_parameters_are_refused(wrong):
    with pytest.raises(InputError, match="F2q" if "F2q" in wrong.get("sensed", ()) else list(wrong)[-1]):
        ConstrainedTracker(**wrong)


NAMES = TREE.names


def hand_samples(sensed, ticks, seed=0):
    """(gyr, acc) of a hand in motion, (ticks, n, 3), of the named segments at 100 Hz, and the true angles."""
    hand = WornHand(seed, EXACT)
    gyr, acc, angles, _ = hand.chunk(400, ticks)
    rows = [NAMES.index(name) for name in sensed]
    return np.ascontiguousarray(gyr[:, rows]), np.ascontiguousarray(acc[:, rows]), angles


@pytest.mark.slow
def test_a_strip_left_off_is_unseen_and_the_other_fingers_are_as_before():
    strip = tuple(name for name in NAMES if not name.startswith("F3"))
    whole, _, _ = run_tracker(ConstrainedTracker(sensors=17), *hand_samples(NAMES, 300)[:2])
    gyr, acc, _ = hand_samples(strip, 300)
    (orientation, angles, sd, tips, tip_sd, *_), reports, _ = run_tracker(
        ConstrainedTracker(sensors=14, sensed=strip), gyr, acc)
    assert reports[0] == ("untracked", "joint F3_mcp, F3_pip, F3_dip")
    of_strip = np.array([name.startswith("F3") for name in TREE.freedoms])
    assert (angles[:, of_strip] == 0.0).all()
    assert (sd[:, of_strip] == math.pi).all()
    # Joints are measured by turns, which a missing one shifts.
    np.testing.assert_allclose(angles[-100:, ~of_strip], whole[1][-100:, ~of_strip], atol=0.02)
    np.testing.assert_allclose(tips[-100:, [0, 1, 3, 4]], whole[3][-100:, [0, 1, 3, 4]], atol=2e-3)
    assert orientation.shape == (300, 14, 4)
    assert tip_sd[-1, 2].max() > 0.1


def test_without_a_forearm_the_wrist_is_unseen_and_neutral():
    gyr, acc, _ = hand_samples(NAMES[1:], 200)
    (_, angles, sd, tips, *_), reports, _ = run_tracker(ConstrainedTracker(sensors=16), gyr, acc)
    assert reports[0] == ("untracked", "joint wrist")
    assert (angles[:, :2] == 0.0).all()
    assert (sd[:, :2] == math.pi).all()
    np.testing.assert_allclose(tips[-1], segment_poses(TREE, angles[-1]).position[
        [TREE.index(f"F{finger}d") for finger in range(1, 6)]], atol=3e-3)


def test_a_sensor_that_is_silent_for_long_is_unseen_and_begins_anew():
    sensed = ("hand", "F2p", "F2m", "F2d")
    gyr, acc, true = hand_samples(sensed, 1200)
    gyr[300:600, 2] = np.nan
    tracker = ConstrainedTracker(sensors=4, sensed=sensed)
    (_, angles, sd, *_), reports, _ = run_tracker(tracker, gyr, acc)
    pip = TREE.freedom("F2_pip_flexion")
    # At `untracked_deg_s` it takes 1.5 s until nothing is known.
    assert (np.diff(sd[300:440, pip]) > 0.0).all()
    assert (angles[460:600, pip] == 0.0).all()
    assert (sd[460:600, pip] == math.pi).all()
    assert np.abs(angles[1100:, pip] - true[1100:, pip]).max() < math.radians(3.0)
    told = [each for each in reports if each[0] in ("untracked", "tracked") and "F2_pip" in each[1]]
    assert told == [("untracked", "joint F2_pip, F2_dip"), ("tracked", "joint F2_pip, F2_dip")]


def test_another_tree_and_a_left_hand_are_followed_as_well():
    rod = (Segment(name="base"), Segment(name="rod", parent="base", joint="hinge", joint_name="elbow",
                                         offset=(0.06, 0.0, 0.0), axes=((0.0, 1.0, 0.0),)))
    body = ConstrainedTracker(sensors=2, segments=rod)
    assert [port.shape for port in body.outputs] == [(2, 4), (1,), (1,), (1, 3), (1, 3), (1,), (1,)]
    motion = Jointed((Joint(parent=0, child=1, kind="hinge", parent_axis=(0.0, 1.0, 0.0),
                            child_axis=(0.0, 1.0, 0.0)),), 1, Errors(noise=0.0))
    times = np.arange(500) / 50
    (_, angles, _, tips, *_), _, _ = run_tracker(body, *motion.samples(times), rate=50)
    np.testing.assert_allclose(tips[:, 0], 0.06 * np.stack(
        [np.cos(angles[:, 0]), 0.0 * times, -np.sin(angles[:, 0])], axis=1), atol=1e-3)
    assert np.degrees(np.abs(away(angles[250:], motion.angles(times)[250:])).max()) < 1.0
    left = ConstrainedTracker(sensors=17, hand=HandSize(side="left"))
    assert left.outputs[3].shape == (5, 3)


def test_joints_without_lengths_have_no_fingertips():
    for tracker in (ConstrainedTracker(sensors=5), OF_EACH):
        assert [port.name for port in tracker.outputs] == [
            "orientation", "angles", "angle_sd", "aligned", "angle_random_sd"]


@given(st.lists(st.integers(0, 3), min_size=1, max_size=6), st.integers(0, 2**31))
def test_the_rotation_of_each_joint_has_its_greatest_sd(freedoms, seed):
    rng, first = np.random.default_rng(seed), np.cumsum([0, *freedoms])[:-1]
    angles, sd = rng.normal(size=sum(freedoms)), rng.uniform(0.0, 3.0, sum(freedoms))
    sd[rng.random(sd.size) < 0.1] = np.nan
    layout = np.stack([np.zeros_like(first), freedoms, first], axis=1).astype(np.int64)
    rotations, variance = by_joint(layout, angles, sd)
    for k, (count, begin) in enumerate(zip(freedoms, first, strict=True)):
        np.testing.assert_array_equal(rotations[k], [*angles[begin:begin + count], *[0.0] * (3 - count)])
        np.testing.assert_array_equal(variance[k], np.max([0.0, *sd[begin:begin + count]]) ** 2)
