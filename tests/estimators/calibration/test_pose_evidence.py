"""What sensors show of an initial pose: contradicted where it is wrong and they can show it, else not."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm
from tracker_parts import run_tracker

from estimators.body.body import body_of
from estimators.calibration.initial_pose import Rest, known_angles, ties_of
from estimators.calibration.pose_evidence import (
    PoseEvidence,
    ReleaseWatch,
    against_gravity,
    inclinations,
    not_shown,
)
from estimators.constrained import ConstrainedTracker
from estimators.salchow import SalchowM1, SalchowM2
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.motion import UPWARDS
from fesloop.hand.segments import Segment
from fesloop.loop.clock import NS_PER_S

BODY = body_of(17, HandSize(), (), ())
TREE = BODY.tree
STATED_DEG = {"F1_cmc_flexion": 40.0, "F1_cmc_abduction": -15.0, "F1_cmc_pronation": 60.0}
STATED = known_angles(TREE, STATED_DEG)
EVERY = np.ones(17, dtype=np.bool_)
TIES = ties_of(BODY, STATED, EVERY)
FINGERS = ("F2", "F3", "F4", "F5")
FLEXIONS = [name for name in TREE.freedoms if name[:2] in FINGERS and name.endswith("flexion")]
BENT = np.isin(TREE.freedoms, FLEXIONS)
PALM_DOWN = np.array([0.0, math.sqrt(0.5), 0.0, -math.sqrt(0.5)])
THUMB_UP = np.array([0.0, 0.0, 0.0, 1.0])
PERSONS = 100


def mounted(rng, sd_deg, orientation):
    """Orientations of sensors that are mounted with errors on segments (..., 17, 4)."""
    turn = np.radians(sd_deg) * rng.normal(size=(17, 3)) + 1e-12
    return quaternion.multiply(orientation, quaternion.from_axis_angle(turn, np.linalg.norm(turn, axis=1)))


def at_rest(angles, base, rng=None, mounting_deg=0.0):
    """Readings of a hand that keeps a pose (d,) at `base`, of crookedly mounted noisy sensors."""
    own = quaternion.multiply(base, segment_poses(TREE, angles).orientation)
    noise = 0.0
    if rng is not None:
        own, noise = mounted(rng, mounting_deg, own), 0.04 * rng.normal(size=(17, 3))
    acc = quaternion.rotate(quaternion.conjugate(own), UPWARDS) + noise
    return Rest(np.zeros((17, 3)), acc, None, EVERY)


def any_way_up(rng):
    return quaternion.normalized(rng.normal(size=4))


def contradiction(rest, mounting_deg, pose_deg):
    gravity = inclinations(BODY, TIES, rest, np.radians(mounting_deg), np.radians(pose_deg))
    return against_gravity(BODY, gravity, PoseEvidence())


def careful(rng, pose_deg, wrong_deg=0.0):
    """A pose within its sd, with wrong flexion of the fingers."""
    return STATED + np.radians(pose_deg) * rng.normal(size=len(STATED)) + np.radians(wrong_deg) * BENT


@pytest.mark.parametrize(("mounting_deg", "pose_deg"), [(2.0, 3.0), (2.0, 10.0), (5.0, 5.0), (10.0, 5.0)])
def test_poses_within_their_sd_are_hardly_ever_refused(mounting_deg, pose_deg):
    rng = np.random.default_rng(0)
    refused = sum(contradiction(at_rest(careful(rng, pose_deg), any_way_up(rng), rng, mounting_deg),
                                mounting_deg, pose_deg) is not None
                  for _ in range(PERSONS))
    assert refused <= 0.03 * PERSONS


@pytest.mark.parametrize(("mounting_deg", "pose_deg"), [(2.0, 3.0), (2.0, 5.0), (5.0, 5.0)])
def test_fingers_wrong_by_20_deg_are_always_refused_where_gravity_shows_them(mounting_deg, pose_deg):
    rng = np.random.default_rng(1)
    for _ in range(PERSONS):
        rest = at_rest(careful(rng, pose_deg, 20.0), PALM_DOWN, rng, mounting_deg)
        assert contradiction(rest, mounting_deg, pose_deg) is not None


def test_gravity_is_blind_to_flexion_about_the_vertical_and_says_so():
    rng = np.random.default_rng(2)
    refused = sum(contradiction(at_rest(careful(rng, 5.0, 40.0), THUMB_UP, rng, 5.0), 5.0, 5.0) is not None
                  for _ in range(PERSONS))
    assert refused <= 0.05 * PERSONS
    hidden = not_shown(BODY, STATED, at_rest(STATED, THUMB_UP))
    assert set(FLEXIONS) <= set(hidden)
    assert "wrist_abduction" not in hidden
    shown = not_shown(BODY, STATED, at_rest(STATED, PALM_DOWN))
    assert not set(FLEXIONS) & set(shown)
    assert "F2_mcp_abduction" in shown


@given(st.integers(0, 2**32 - 1), st.sampled_from(FLEXIONS), st.floats(5.0, 90.0))
def test_one_wrong_joint_is_named_exactly_where_its_rotation_turns_the_vertical(seed, freedom, wrong_deg):
    base = any_way_up(np.random.default_rng(seed))
    angles = STATED.copy()
    angles[TREE.freedom(freedom)] += np.radians(wrong_deg)
    rest = at_rest(angles, base)
    found = contradiction(rest, 2.0, 3.0)
    # Two verticals, one turned from the other by an angle about an axis: a spherical isosceles triangle.
    up = quaternion.rotate(quaternion.conjugate(base), UPWARDS)
    away = np.degrees(2.0 * np.arcsin(np.sin(np.radians(wrong_deg) / 2.0)
                                      * np.hypot(up[0], up[1]) / np.linalg.norm(up)))
    if away > 20.0:
        assert found is not None
        assert f"{away:.0f} deg at {freedom.removesuffix('_flexion')} (" in found.text
        worst = TREE.names[int(np.argmax(found.sizes))]
        assert np.degrees(found.sizes.max()) == pytest.approx(away, abs=0.01)
        assert BODY.joints[TREE.index(worst)] == freedom.removesuffix("_flexion")
    elif away < 8.0:
        assert found is None


def test_a_sensor_without_samples_leaves_its_neighbours_compared_with_each_other():
    present = EVERY.copy()
    present[TREE.index("F2m")] = False
    angles = STATED + np.radians(30.0) * (np.arange(len(STATED)) == TREE.freedom("F2_pip_flexion"))
    rest = at_rest(angles, PALM_DOWN)._replace(present=present)
    gravity = inclinations(BODY, ties_of(BODY, STATED, present), rest, np.radians(2.0), np.radians(3.0))
    found = against_gravity(BODY, gravity, PoseEvidence())
    assert found is not None
    assert "30 deg at F2_dip (sensor 7, F2d)" in found.text


def turned(angles, rng, mounting_deg, by_deg=90.0):
    """gyr, acc (600, 17, 3) at 100 Hz of a hand that keeps a pose while the forearm pronates after 2 s."""
    share = np.clip((np.arange(600) / 100.0 - 2.0) / 1.5, 0.0, 1.0)
    turn = quaternion.from_axis_angle([0.0, 1.0, 0.0], np.radians(by_deg) * share**2 * (3.0 - 2.0 * share))
    own = mounted(rng, mounting_deg, quaternion.multiply(quaternion.multiply(THUMB_UP, turn)[:, np.newaxis],
                                                        segment_poses(TREE, angles).orientation))
    step = quaternion.relative(own[:-1], own[1:])
    gyr = np.zeros((600, 17, 3))
    gyr[1:] = 200.0 * step[..., 1:] * np.sign(step[..., :1])
    gyr += np.radians(0.5) * rng.normal(size=(17, 3)) + 5e-4 * rng.normal(size=gyr.shape)
    acc = quaternion.rotate(quaternion.conjugate(own), UPWARDS)
    return gyr, acc + 0.04 * rng.normal(size=acc.shape)


def tracked(kind, gyr, acc, **parameters):
    """Outputs by name, and the texts of contradictions, of a tracker that is told the stated pose."""
    tracker = kind(sensors=17, initial_pose_s=1.0, initial_angles_deg=STATED_DEG, pose_sd_deg=5.0,
                   **parameters)
    field = np.broadcast_to([2e-5, 0.0, -4e-5], gyr.shape)
    outputs, reports, _ = run_tracker(tracker, *(gyr, acc, field)[:len(tracker.inputs)])
    return ({port.name: rows for port, rows in zip(tracker.outputs, outputs, strict=True)},
            [detail for status, detail in reports if status == "pose_contradicted"])


@pytest.mark.parametrize(("wrong_deg", "persons"), [(0.0, 8), (45.0, 3)])
def test_a_turn_of_the_forearm_shows_what_gravity_did_not_show_in_the_pose(wrong_deg, persons):
    for seed in range(persons):
        rng = np.random.default_rng(seed)
        outputs, found = tracked(SalchowM2, *turned(careful(rng, 5.0, wrong_deg), rng, 5.0))
        aligned, sd = outputs["aligned"][:, 0], outputs["angle_sd"][:, BENT]
        assert aligned[150] == 1.0  # the pose itself does not contradict it
        assert aligned[-1] == (0.0 if wrong_deg else 1.0)
        if wrong_deg:
            assert "pronation" in found[0]
            assert np.degrees(np.median(sd[-1])) > 0.5 * wrong_deg > 2.0 * np.degrees(np.median(sd[150]))
        else:
            assert not found


def palm_down(wrong_deg):
    """gyr, acc (200, 17, 3) of a still hand, palm down, whose fingers are bent more than stated."""
    rng = np.random.default_rng(5)
    rest = at_rest(careful(rng, 2.0, wrong_deg), PALM_DOWN, rng, 2.0)
    noise = rng.normal(size=(200, 17, 3))
    return 5e-4 * noise, rest.acc + 0.04 * noise[::-1]


@pytest.mark.parametrize("kind", [SalchowM1, SalchowM2, ConstrainedTracker])
def test_a_tracker_whose_pose_gravity_contradicts_is_not_aligned_and_not_sure(kind):
    rows = [TREE.freedom(f"F{i}_pip_flexion") for i in range(2, 6)]
    sure = math.inf
    for wrong_deg in (0.0, 50.0):
        outputs, found = tracked(kind, *palm_down(wrong_deg))
        assert outputs["aligned"][-1] == (0.0 if wrong_deg else 1.0)
        worst = np.degrees(outputs["angle_sd"][-1, rows].max())
        tips = np.median(outputs["fingertip_sd"][-1, 1:])
        if wrong_deg:
            assert "gravity shows" in found[0]
            assert worst > 40.0
            assert tips > 1.5 * sure
        else:
            assert not found
            assert worst < 20.0
            sure = tips


WATCH_S = 0.9


def relaxing(closures_deg):
    """Text after fingers F2 to F5 have closed by so many deg (4,)."""
    watch = ReleaseWatch(BODY, STATED, PoseEvidence(relaxed_s=WATCH_S))
    rotations = np.zeros((17, 3))
    watch.begin(rotations, 0)
    for finger, closure in zip(FINGERS, closures_deg, strict=True):
        for segment, share in zip("pmd", (0.35, 0.45, 0.2), strict=True):
            rotations[TREE.index(f"{finger}{segment}"), 0] = np.radians(share * closure)
    seen, variance = BODY.seen(), np.full(17, np.radians(9.0)**2)
    assert watch.note(rotations, variance, seen, round(0.5 * WATCH_S * NS_PER_S)) == ""
    text = watch.note(rotations, variance, seen, round(WATCH_S * NS_PER_S))
    assert watch.note(rotations, variance, seen, round((WATCH_S + 0.1) * NS_PER_S)) == ""
    return text, watch.sizes


@given(st.floats(60.0, 180.0), st.lists(st.floats(-20.0, 20.0), min_size=4, max_size=4))
def test_hands_that_close_when_let_go_were_held(closure, apart):
    assert relaxing(np.clip(closure + np.array(apart), 0.0, 190.0))[0] == ""


@given(st.floats(-20.0, 10.0), st.lists(st.floats(-5.0, 5.0), min_size=4, max_size=4))
def test_a_hand_that_does_not_close_when_let_go_was_not_held(closure, apart):
    text, sizes = relaxing(closure + np.array(apart))
    assert "let go, F2, F3, F4, F5 closed by" in text
    assert (np.degrees(sizes[[TREE.index(f"F{i}p") for i in range(2, 6)]]) > 15.0).all()


def test_a_hand_that_is_held_halfway_is_found_as_rarely_as_its_stated_spread_implies():
    """Closing by half as much, in persons of the stated spread; the rate by the normal distribution."""
    rng, found = np.random.default_rng(3), 0
    for _ in range(300):
        rests = 84.0 + 20.0 * rng.normal() + 15.0 * rng.normal(size=4)
        found += "let go, F2, F3, F4, F5" in relaxing(0.5 * rests)[0]
    sd = np.hypot(20.0, 15.0 / 2.0)
    least = norm.isf(0.005) * sd
    expected = norm.cdf((84.0 - least - 42.0) / (0.5 * sd))
    assert found / 300 == pytest.approx(expected, abs=0.06)
    assert expected < 0.2


def test_a_finger_that_does_not_close_with_the_others_is_named():
    text, sizes = relaxing([90.0, 95.0, 0.0, 95.0])
    assert "let go, F4 closed by 0 deg" in text
    assert set(np.flatnonzero(sizes)) == {TREE.index(f"F4{segment}") for segment in "pmd"}


def test_joints_are_watched_for_as_long_as_stated_and_short_excess_does_not_count():
    for wrong_deg, until_s, expected in ((60.0, 1.0, True), (60.0, 0.3, False), (20.0, 1.0, False)):
        watch = ReleaseWatch(BODY, STATED, PoseEvidence(watch_s=2.0))
        rotations, variance = np.zeros((17, 3)), np.full(17, np.radians(9.0)**2)
        watch.begin(rotations, 0)
        found = []
        for k in range(100):
            rotations[TREE.index("F3m"), 0] = np.radians(-20.0 - wrong_deg) * (k < 100 * until_s)
            found.append(watch.note(rotations, variance, BODY.seen(), k * NS_PER_S // 100))
        assert any(found) == expected
        if expected:
            assert "F3_pip at -80 deg of flexion (60 more than the joint has)" in next(filter(None, found))


@pytest.mark.parametrize(("parameters", "words"), [
    ({"false_alarm": 0.0}, "false_alarm"), ({"false_alarm": 1.0}, "false_alarm"),
    ({"watch_s": -1.0}, "watch_s"), ({"relaxed_s": math.inf}, "relaxed_s"),
    ({"range_sd_deg": math.nan}, "range_sd_deg")])
def test_impossible_parameters_are_refused(parameters, words):
    with pytest.raises(InputError, match=words):
        PoseEvidence(**parameters)


def test_relaxation_is_known_of_hands_alone():
    pair = (Segment(name="a"), Segment(name="b", parent="a", joint="hinge", joint_name="ab"))
    with pytest.raises(InputError, match="relaxed_s"):
        ReleaseWatch(body_of(2, HandSize(), pair, ()), np.zeros(1), PoseEvidence(relaxed_s=1.0))


@pytest.mark.parametrize("kind", [SalchowM1, SalchowM2, ConstrainedTracker])
def test_angles_that_rest_on_the_pose_alone_have_its_sd(kind):
    gyr, acc = turned(STATED, np.random.default_rng(3), 0.0)
    outputs, _ = tracked(kind, gyr[:150], acc[:150], mounting_sd_deg=1.0)
    # The pose is known to 5 deg.
    assert np.degrees(outputs["angle_sd"][-1, BENT].min()) > 4.9


@pytest.mark.parametrize(("fingers", "contradicted"), [(FINGERS, True), (FINGERS[:2], False)])
def test_many_joints_contradict_a_pose_together_that_none_contradicts_alone(fingers, contradicted):
    watch = ReleaseWatch(BODY, STATED, PoseEvidence())
    rotations, variance = np.zeros((17, 3)), np.full(17, np.radians(9.0)**2)
    watch.begin(rotations, 0)
    for finger in fingers:
        for segment in "pmd":
            rotations[TREE.index(f"{finger}{segment}"), 2] = np.radians(34.0)
    found = [watch.note(rotations, variance, BODY.seen(), k * NS_PER_S // 100) for k in range(100)]
    assert any(found) == contradicted
    assert (np.degrees(watch.sizes) > 30.0).sum() == (12 if contradicted else 0)
