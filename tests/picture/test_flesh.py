"""The drawn hand is where kinematics says that the hand is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import Poses, points, segment_poses
from fesloop.hand.skeleton import contact_points, hand_tree
from fesloop.show.picture.flesh import blended, bone_ends, flesh, flesh_distances

SHARES = st.lists(st.floats(0.0, 1.0), min_size=23, max_size=23)
AT_HOME = Poses(np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3))


def posture(size, shares, root=AT_HOME):
    """(tree, poses) at these shares of every range."""
    tree = hand_tree(size)
    low, high = tree.ranges.T
    return tree, segment_poses(tree, low + np.array(shares) * (high - low), root)


def to_skin(drawn, point):
    """Signed distance of a point to the drawn skin."""
    return flesh_distances(np.array([point]), drawn)[0]


def test_blending_rounds_inwards_only_where_surfaces_are_near_each_other():
    assert blended(0.01, 0.05, 0.004) == 0.01
    assert blended(0.01, 0.01, 0.004) == pytest.approx(0.009)
    assert blended(0.01, 0.012, 0.004) == pytest.approx(0.01 - 0.25 * 0.004 * 0.5**2)


@settings(max_examples=25, deadline=None)
@given(shares=SHARES, side=st.sampled_from(["left", "right"]), hand_mm=st.floats(150.0, 220.0))
def test_bones_begin_where_their_joints_are_and_end_where_kinematics_says(shares, side, hand_mm):
    size = HandSize(side=side, hand_mm=hand_mm)
    tree, poses = posture(size, shares)
    proximal, distal = bone_ends(size, poses)
    np.testing.assert_allclose(distal, poses.position, atol=1e-12)
    for k, (segment, parent) in enumerate(zip(tree.segments, tree.layout[:, 0], strict=True)):
        if parent >= 0:
            joint = points(tree, poses, tree.names[parent], segment.base)
            np.testing.assert_allclose(proximal[k], joint, atol=1e-12)
    assert np.linalg.norm(proximal[0] - distal[0]) == pytest.approx(size.forearm)


@settings(max_examples=25, deadline=None)
@given(shares=SHARES)
def test_every_joint_and_bone_end_is_inside_the_flesh(shares):
    size = HandSize()
    _, poses = posture(size, shares)
    drawn = flesh(size, poses)
    proximal, distal = bone_ends(size, poses)
    # The thumb's CMC joint lies in front of the carpus, under the skin of its ball.
    for point in (*proximal[1:], *distal):
        assert to_skin(drawn, point) < -0.003


def test_the_skin_of_a_fingertip_is_as_far_beyond_the_bone_as_its_soft_tissue():
    size = HandSize()
    tree, poses = posture(size, [0.5] * 23)
    drawn = flesh(size, poses)
    for i, finger in enumerate(("F1d", "F2d", "F3d", "F4d", "F5d")):
        end = points(tree, poses, finger, contact_points(size)[i, -1])
        assert abs(to_skin(drawn, end)) < 5e-4


@settings(max_examples=20, deadline=None)
@given(shares=SHARES)
def test_a_left_hand_is_the_mirror_image_of_a_right_one(shares):
    # Behind a mirror the same anatomy stands at the other sign of one axis: here of the left hand's z, ulnar.
    drawn = {}
    for side, turn in (("left", (1.0, 0.0, 0.0, 0.0)), ("right", (0.0, 0.0, 0.0, 1.0))):
        size = HandSize(side=side)
        _, poses = posture(size, shares, Poses(np.array(turn), np.zeros(3)))
        drawn[side] = flesh(size, poses).bars
    # The half turn about z takes the right's palmar, proximal to dorsal, distal; its z is radial.
    flip = np.array([1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0, 1.0])
    np.testing.assert_allclose(drawn["right"], flip * drawn["left"], atol=1e-12)


def test_the_hand_goes_where_its_root_goes():
    size, shares = HandSize(), [0.3] * 23
    turn, shift = quaternion.normalized([0.3, -0.5, 0.7, 0.2]), np.array([0.1, -0.4, 2.0])
    drawn = flesh(size, posture(size, shares)[1]).bars
    moved = flesh(size, posture(size, shares, Poses(turn, shift))[1]).bars
    for ends in (slice(0, 3), slice(3, 6)):
        expected = shift + quaternion.rotate(turn, drawn[:, ends])
        np.testing.assert_allclose(moved[:, ends], expected, atol=1e-12)
    np.testing.assert_allclose(moved[:, 6:], drawn[:, 6:])


def test_without_its_forearm_a_hand_has_none():
    size = HandSize()
    _, poses = posture(size, [0.5] * 23)
    assert 0 in flesh(size, poses).segments
    assert 0 not in flesh(size, poses, forearm=False).segments
    assert set(flesh(size, poses, forearm=False).segments) == set(range(1, 17))
