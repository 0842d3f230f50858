"""Spread of fingertips against finite differences through the dual-quaternion kinematics."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimators.body.body import body_of
from estimators.body.joint_constraints import body_table
from estimators.constrained.fingertips import fingertip_posture, moving_joints
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import placed, relative_orientations, segment_poses

PAIR_SD, AXIS_SD = 0.1, 0.05
STEP = 1e-5


def tips_of(body, relative):
    """Fingertips, (5, 3), of relative orientations (17, 4), whatever they are."""
    orientation = [relative[0]]
    for k in range(1, 17):
        orientation.append(quaternion.multiply(orientation[body.tree.layout[k, 0]], relative[k]))
    return placed(body.tree, np.array(orientation)).position[body.tips]


def moved(body, relative, turns):
    """How fingertips move for each unit of small turns {segment: (3,)}, in each segment's own frame."""
    turned = relative.copy()
    for k, vector in turns.items():
        size = max(np.linalg.norm(vector), 1e-12)
        turned[k] = quaternion.multiply(relative[k], quaternion.from_axis_angle(vector + 1e-15, STEP * size))
    return (tips_of(body, turned) - tips_of(body, relative)) / STEP


def left_over(body, relative):
    """{segment: (A, forbidden)}: matrices of what a joint's correction leaves, and of what it forbids."""
    share = PAIR_SD ** 2 / (PAIR_SD ** 2 + AXIS_SD ** 2)
    parts = {}
    for k in range(1, 17):
        freedoms, (first, second) = body.tree.layout[k, 1], body.tree.geometry[k, :2]
        across = np.cross(second, quaternion.rotate(quaternion.conjugate(relative[k]), first))
        forbidden = {1: np.eye(3) - np.outer(first, first), 2: np.outer(across, across), 3: np.zeros((3, 3))}
        parts[k] = np.eye(3) - share * forbidden[freedoms], share * forbidden[freedoms]
    return parts


def put_out(body, angles, covariance):
    """(tips, sd) of the kernel with every joint at its true angles, and the relative orientations."""
    table = body_table(body)
    relative = relative_orientations(body.tree, angles)
    of_joints = relative[body.sensed[table.ends[:, 1]]]
    doubt = np.zeros(len(of_joints))
    tips, sd = fingertip_posture(
        body.tree.layout, body.tree.geometry, body.tips, moving_joints(body, table), of_joints, of_joints,
        covariance, doubt, table.kinds, table.axes, PAIR_SD, AXIS_SD)
    return tips, sd, relative


@pytest.mark.slow
@settings(deadline=None, max_examples=5)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["left", "right"]))
def test_each_source_moves_the_fingertips_as_the_kinematics_say(seed, side):
    rng = np.random.default_rng(seed)
    body = body_of(17, HandSize(side=side), (), ())
    angles = rng.uniform(-0.5, 0.8, 23)
    roots = 0.05 * rng.normal(size=(16, 12, 12))
    covariance = roots @ roots.transpose(0, 2, 1)
    tips, sd, relative = put_out(body, angles, covariance)
    np.testing.assert_allclose(tips, segment_poses(body.tree, angles).position[body.tips], atol=1e-13)
    parts = left_over(body, relative)
    variance = np.zeros((5, 3))
    for k in range(17):
        for axis in np.eye(3):
            # The mounting of the sensor on k, seen by k's own joint and by those of its children.
            turns = {k: parts[k][0] @ axis} if k else {}
            for child in np.flatnonzero(body.tree.layout[:, 0] == k):
                into = quaternion.rotate(quaternion.conjugate(relative[child]), axis)
                turns[child] = -parts[child][0] @ into
            variance += 0.5 * PAIR_SD ** 2 * moved(body, relative, turns) ** 2
    for k in range(1, 17):
        kept, tilt = parts[k]
        own = kept @ covariance[k - 1, :3, :3] @ kept.T + AXIS_SD ** 2 * tilt @ tilt.T
        rows = np.array([moved(body, relative, {k: axis}) for axis in np.eye(3)])
        variance += np.einsum("atx,ab,btx->tx", rows, own, rows)
    np.testing.assert_allclose(sd, np.sqrt(variance), rtol=1e-3)


def test_an_unseen_joint_stands_straight_and_leaves_its_fingertip_unknown():
    names = tuple(n for n in body_of(17, HandSize(), (), ()).tree.names if n != "F3m")
    body = body_of(16, HandSize(), (), names)
    angles = np.zeros(23)
    angles[body.tree.freedom("F2_mcp_flexion")] = 0.5
    tips, sd, _ = put_out(body, angles, np.zeros((14, 12, 12)))
    np.testing.assert_allclose(tips, segment_poses(body.tree, angles).position[body.tips], atol=1e-13)
    # Both of its last joints may have turned anyhow: pi, over the lengths that each of them moves.
    k = body.tree.index("F3d")
    last, middle = np.linalg.norm(body.tree.geometry[[k, k - 1], 4], axis=1)
    assert sd[2, 0] > math.pi * math.hypot(last, last + middle)
    assert sd[1].max() < 0.05
