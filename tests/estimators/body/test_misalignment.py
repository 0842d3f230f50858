"""Covariance of misaligned sensors and joints against matrices, and against each sensor turned in turn."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from estimators.body.body import body_of
from estimators.body.misalignment import (
    STRIP_SHARE,
    add_misalignment,
    add_to_tips,
    evidence_scale,
    misalignment,
)
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import placed, segment_poses
from fesloop.hand.segments import Segment, SegmentTree

SEEDS = st.integers(0, 2**32 - 1)
HAND = body_of(17, HandSize(), (), ())


def joint_sds(seed, mounting, axis, segment="F2m"):
    """Covariance of a joint's rotation, and the matrix R of that rotation."""
    rotation = Rotation.random(random_state=seed)
    wrong, k, found = misalignment(HAND.tree, mounting, axis), HAND.tree.index(segment), np.zeros((3, 3))
    add_misalignment(rotation.as_quat(scalar_first=True), wrong.pair[k], wrong.growing[k], found)
    return found, rotation.as_matrix()


@given(SEEDS, st.floats(0.1, 20.0), st.floats(0.1, 20.0))
@settings(deadline=None, max_examples=50)
def test_a_joint_has_the_covariance_of_both_sensors_and_of_its_tilt(seed, mounting, axis):
    m, t = np.radians(mounting) ** 2, np.radians(axis) ** 2
    for segment, share in (("F2m", STRIP_SHARE), ("F2p", 0.0), ("hand", 0.0)):
        found, matrix = joint_sds(seed, mounting, axis, segment)
        turned = (matrix.T - np.eye(3)) @ (matrix.T - np.eye(3)).T
        # Both sensors' own parts, the part in common, and the tilt: d = m_c - R' m_p, (I - R') m, (R' - I) t.
        expected = 2.0 * (1.0 - share) * m * np.eye(3) + (share * m + t) * turned
        np.testing.assert_allclose(found, expected, atol=1e-12)


@given(SEEDS, st.floats(0.1, 20.0), st.floats(1.05, 3.0))
@settings(deadline=None, max_examples=50)
def test_sds_grow_with_the_prior_and_are_never_zero(seed, mounting, times):
    few, more = (joint_sds(seed, mounting * factor, 5.0)[0] for factor in (1.0, times))
    assert np.isfinite(more).all()
    assert np.linalg.eigvalsh(few)[0] > 0.0
    assert np.linalg.eigvalsh(more - few)[0] > 0.0


@given(SEEDS)
@settings(deadline=None, max_examples=20)
def test_fingertips_move_as_turned_sensors_say(seed):
    rng = np.random.default_rng(seed)
    tree = HAND.tree
    angles = rng.uniform(-0.6, 0.6, len(tree.ranges))
    poses = segment_poses(tree, angles)
    wrong, variance = misalignment(tree, 5.0, 5.0), np.zeros((5, 3))
    add_to_tips(tree.layout, tree.geometry, poses.orientation, poses.position, HAND.tips, HAND.sensors, wrong,
                1.0, variance)

    def moved(turns):
        """Tips per rad, with each segment's sensor turned in its own frame, seen from the turned forearm."""
        step = 1e-5
        ends = []
        for sign in (step, -step):
            small = np.array([quaternion.normalized(np.r_[1.0, 0.5 * sign * turn]) for turn in turns])
            q = quaternion.multiply(poses.orientation, small)
            relative = quaternion.multiply(quaternion.conjugate(q[0]), q)
            ends.append(placed(tree, relative).position[HAND.tips])
        return (ends[0] - ends[1]) / (2.0 * step)

    expected, count = np.zeros((5, 3)), len(tree.segments)
    for axis in np.eye(3):
        for k in range(count):
            expected += wrong.own[k] * moved(np.outer(np.arange(count) == k, axis)) ** 2
        for finger in "12345":
            strip = np.array([name.startswith(f"F{finger}") for name in tree.names])
            expected += STRIP_SHARE * np.radians(5.0) ** 2 * moved(np.outer(strip, axis)) ** 2
    np.testing.assert_allclose(variance, expected, rtol=1e-5, atol=1e-12)


def test_other_trees_have_no_strips():
    tree = SegmentTree((Segment(name="seg1"), Segment(name="seg2", parent="seg1", joint="hinge")))
    assert not misalignment(tree, 5.0, 5.0).common.any()


@pytest.mark.parametrize("true", [0.25, 1.0, 2.0])
def test_the_scale_is_that_of_the_angles_that_motion_shows(true):
    rng = np.random.default_rng(1)
    assert evidence_scale(0.0, 0.0) == 1.0
    angles = true * rng.normal(size=4000)
    assert evidence_scale(np.sum(angles ** 2), 4000.0) == pytest.approx(true ** 2, rel=0.1)
    # One hinge shows four angles; what is stated counts as two.
    assert evidence_scale(4.0 * true ** 2, 4.0) == pytest.approx((2.0 + 4.0 * true ** 2) / 6.0)
    # Angles as stated, with noise as large: their posterior mean is half of the sum, and half is seen.
    found = 0.5 * (rng.normal(size=4000) + rng.normal(size=4000))
    assert evidence_scale(np.sum(found ** 2), 0.5 * 4000) == pytest.approx(1.0, rel=0.1)
