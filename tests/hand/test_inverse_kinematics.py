"""Inverse kinematics against forward kinematics, closed forms and scipy's bounded least squares."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares, minimize

from fesloop.errors import InputError
from fesloop.hand import inverse_kinematics as kernels
from fesloop.hand.anthropometry import FINGERS, HandSize
from fesloop.hand.inverse_kinematics import DIP_OF_PIP, InverseKinematics, of_hand
from fesloop.hand.kinematics import points, segment_poses
from fesloop.hand.segments import Segment, SegmentTree
from fesloop.hand.skeleton import RESTING_DEG, contact_point, hand_tree

REST = np.radians(list(RESTING_DEG.values()))
SIZE = HandSize()
TREE = hand_tree(SIZE)
REACHED_M = 1e-4
seeds = st.integers(0, 2**32 - 1)


def reachable(solver, seed):
    """A posture of the coordinates' whole box, and its tips."""
    z = np.random.default_rng(seed).uniform(solver.low, solver.high)
    return z, solver.tips(solver.posture(z))


@pytest.mark.slow
@settings(max_examples=100, deadline=None)
@given(seeds, st.sampled_from(["left", "right"]), st.floats(140.0, 220.0))
def test_every_reachable_fingertip_is_reached_within_a_tenth_of_a_millimetre(seed, side, length):
    size = HandSize(side=side, hand_mm=length)
    solver = of_hand(size, FINGERS, REST)
    _, tips = reachable(solver, seed)
    found = solver.nearest(tips)
    assert found.distances.max() < REACHED_M
    # By dual quaternions and along the whole tree, as everybody else finds fingertips.
    tree = hand_tree(size)
    poses = segment_poses(tree, found.angles)
    there = np.stack([points(tree, poses, f"{finger}d") for finger in FINGERS])
    np.testing.assert_allclose(np.linalg.norm(there - tips, axis=-1), found.distances, atol=1e-12)
    assert (found.angles >= tree.ranges[:, 0] - 1e-9).all()
    assert (found.angles <= tree.ranges[:, 1] + 1e-9).all()
    for finger in FINGERS[1:]:
        pip, dip = (found.angles[tree.freedom(f"{finger}_{joint}_flexion")] for joint in ("pip", "dip"))
        assert dip == pytest.approx(DIP_OF_PIP * pip, abs=1e-12)
    assert found.angles[:2] == pytest.approx(REST[:2])


@settings(max_examples=25, deadline=None)
@given(seeds)
def test_a_wrist_that_may_move_serves_all_fingers_at_once(seed):
    solver = of_hand(SIZE, FINGERS, REST, moving=TREE.freedoms)
    assert solver.nearest(reachable(solver, seed)[1]).distances.max() < REACHED_M


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(seeds, st.sampled_from(FINGERS))
def test_out_of_reach_the_nearest_point_remains_as_scipy_finds_it(seed, finger):
    solver = of_hand(SIZE, (finger,), REST)
    rng = np.random.default_rng(seed)
    target = reachable(solver, seed)[1] + rng.normal(0.0, 0.04, (1, 3))
    mine = solver.nearest(target)
    inside = solver.low + 1e-6, solver.high - 1e-6
    best = min(least_squares(lambda z: (solver.tips(solver.posture(z)) - target).ravel(), start,
                             bounds=(solver.low, solver.high), xtol=1e-12, ftol=1e-12, gtol=1e-12).cost
               for start in (np.clip(solver.preferred, *inside), *rng.uniform(*inside, (3, solver.low.size))))
    assert mine.distances[0] <= math.sqrt(2.0 * best) + 1e-5  # m


def test_a_finger_of_two_bones_is_solved_in_closed_form():
    a, b = 0.05, 0.03
    tree = SegmentTree((
        Segment(name="palm"),
        Segment(name="near", parent="palm", joint="hinge", joint_name="near", offset=(0.0, a, 0.0),
                ranges=((-2.0, 2.0),)),
        Segment(name="far", parent="near", joint="hinge", joint_name="far", offset=(0.0, b, 0.0),
                ranges=((0.0, 2.5),))))
    solver = InverseKinematics(tree, ["far"], [(0.0, 0.0, 0.0)], preferred=(0.0, 1.0), moving=tree.freedoms)
    for target in ((-0.03, 0.05), (0.02, 0.05), (-0.04, -0.02)):
        x, y = target
        second = math.acos((x * x + y * y - a * a - b * b) / (2.0 * a * b))
        first = math.atan2(-x, y) - math.atan2(b * math.sin(second), a + b * math.cos(second))
        found = solver.nearest([(x, y, 0.0)])
        np.testing.assert_allclose(found.angles, [first, second], atol=1e-5)
    # Straight on, beyond its reach: stretched towards the target; off the plane: its nearest point in it.
    np.testing.assert_allclose(solver.nearest([(0.0, 0.2, 0.0)]).distances, [0.2 - a - b], atol=1e-9)
    np.testing.assert_allclose(solver.nearest([(0.0, 0.06, 0.01)]).distances, [0.01], atol=1e-9)


@settings(max_examples=20, deadline=None)
@given(seeds)
def test_of_many_thumb_postures_it_is_one_that_none_around_betters(seed):
    solver = of_hand(SIZE, ("F1",), REST)
    target = reachable(solver, seed)[1]
    mine = solver.nearest(target).angles[2:7]
    aside = minimize(lambda z: np.sum((z - solver.preferred) ** 2), mine, method="SLSQP",
                     bounds=list(zip(solver.low, solver.high, strict=True)),
                     constraints={"type": "eq", "fun": lambda z: 1e2 * (
                         solver.tips(solver.posture(z)) - target).ravel()})
    assert np.abs(solver.tips(solver.posture(aside.x)) - target).max() < REACHED_M
    assert np.linalg.norm(mine - solver.preferred) < np.linalg.norm(aside.x - solver.preferred) + 1e-3


@given(seeds)
@settings(max_examples=20, deadline=None)
def test_slopes_are_those_of_differences(seed):
    solver = of_hand(SIZE, ("F1", "F3"), REST, moving=TREE.freedoms[:11])
    rng = np.random.default_rng(seed)
    basis, angles = rng.normal(size=(23, 4)), rng.uniform(TREE.ranges[:, 0], TREE.ranges[:, 1])
    segments, places = np.array([TREE.index("F1d"), TREE.index("F3d")]), rng.normal(0.0, 0.01, (2, 3))
    root = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])

    def tips(at):
        found = np.empty((2, 3))
        kernels.place_tips(TREE.layout, TREE.geometry, root, at, segments, places, np.empty((17, 7)), found)
        return found

    poses, here, slopes = np.empty((17, 7)), np.empty((2, 3)), np.empty((6, 4))
    kernels.place_tips(TREE.layout, TREE.geometry, root, angles, segments, places, poses, here)
    kernels.slopes_of_tips(TREE.layout, TREE.geometry, TREE.moved, angles, poses, segments, here, basis,
                           np.empty((23, 6)), np.empty((6, 23)), slopes)
    by_differences = [(tips(angles + 1e-6 * row) - tips(angles - 1e-6 * row)).ravel() / 2e-6
                      for row in basis.T]
    np.testing.assert_allclose(slopes, np.transpose(by_differences), atol=1e-8)
    assert solver.low.size == 10  # the eleventh freedom, F2's DIP, follows


def test_along_a_path_postures_follow_each_other():
    solver = of_hand(SIZE, ("F1", "F2"), REST)
    share = np.linspace(0.0, 1.0, 101)[:, np.newaxis]
    ends = solver.low + np.array([[0.4], [0.7]]) * (solver.high - solver.low)
    path = solver.tips(solver.posture(ends[0] + share * (ends[1] - ends[0])))
    found = solver.along(path)
    assert found.distances.max() < REACHED_M
    assert np.abs(np.diff(found.angles, axis=0)).max() < math.radians(5.0)
    np.testing.assert_allclose(found.angles[-1], solver.nearest(path[-1]).angles, atol=1e-4)


def test_a_path_that_leaves_the_reach_comes_back_to_it():
    solver = of_hand(SIZE, ("F2",), REST)
    start = solver.tips(REST)
    out = 0.08 * np.sin(np.linspace(0.0, np.pi, 81))[:, np.newaxis, np.newaxis] * [0.0, -1.0, 0.0]
    found = solver.along(start + out)
    assert found.distances[40, 0] > 0.02
    assert found.distances[[0, -1]].max() < REACHED_M


def test_other_points_of_a_fingertip():
    solver = of_hand(SIZE, ("F2",), REST, contact="bottom")
    poses = segment_poses(TREE, REST)
    expected = points(TREE, poses, "F2d", contact_point(SIZE, "F2", "bottom"))
    np.testing.assert_allclose(solver.tips(REST)[0], expected, atol=1e-12)


@pytest.mark.parametrize(("build", "named"), [
    (lambda: of_hand(SIZE, ("F6",), REST), "F6"),
    (lambda: of_hand(SIZE, ("F2",), REST, moving=("F2_pip",)), "did you mean"),
    (lambda: of_hand(SIZE, ("F2",), REST + 3.0), "preferred.wrist_flexion: .*; allowed: -70 to 75 deg"),
    (lambda: of_hand(SIZE, ("F2",), REST[:5]), "angles"),
    (lambda: InverseKinematics(TREE, ["F2d"], np.zeros((2, 3)), preferred=REST, moving=()), "places: 2"),
    (lambda: of_hand(SIZE, ("F2",), REST).nearest(np.zeros((2, 3))), r"targets: shape .* \(1, 3\)"),
    (lambda: of_hand(SIZE, ("F2",), REST).along(np.zeros((1, 3))), r"targets: shape .* \(n, 1, 3\)"),
    (lambda: of_hand(SIZE, ("F2",), REST).nearest([[np.nan, 0.0, 0.0]]), "targets: not finite"),
])
def test_names_what_cannot_be(build, named):
    with pytest.raises(InputError, match=named):
        build()
