"""Joints and trees of them: what is refused, and where angles begin."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimators.body.body import body_of
from estimators.body.joint_constraints import CHAIN5, Joint, body_table, joint_table, joints_of
from estimators.constrained.posture import joint_angles
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.skeleton import hand_tree


@pytest.mark.parametrize(("wrong", "match"), [
    ({"child": 0}, "child"), ({"parent": -1}, "child"), ({"kind": "hnge"}, "hinge"),
    ({"parent_axis": (0.0, 0.0, 0.0)}, "parent_axis"),
    ({"child_axis": (0.0, float("nan"), 1.0)}, "child_axis"),
    ({"kind": "saddle"}, "perpendicular"), ({"ranges_deg": ((0.0, 1.0), (0.0, 1.0))}, "ranges_deg"),
    ({"ranges_deg": ((50.0, 10.0),)}, "ranges_deg"), ({"ranges_deg": ((-190.0, 10.0),)}, "ranges_deg")])
def test_impossible_joints_are_refused(wrong, match):
    with pytest.raises(InputError, match=match):
        Joint(**{"parent": 0, "child": 1, "kind": "hinge", **wrong})


@pytest.mark.parametrize(("ends", "match"), [
    (((0, 3),), "0 to 2"), (((0, 1), (2, 1)), "one joint a child"), (((1, 2), (2, 1)), "ring"),
    (((1, 2), (0, 1)), "child of no earlier joint")])
def test_joints_that_form_no_tree_are_refused(ends, match):
    with pytest.raises(InputError, match=match):
        joint_table(tuple(Joint(parent=p, child=c, kind="ball") for p, c in ends), 3)


def test_trees_may_be_several_and_a_sensor_alone():
    joints = Joint(parent=1, child=3, kind="ball"), Joint(parent=2, child=4, kind="hinge")
    table = joint_table(joints, 6)
    assert table.roots.tolist() == [0, 1, 2, 5]
    assert table.first_angle.tolist() == [0, 3]
    assert table.angles == 4


@given(st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=30)
def test_a_hinge_at_zero_lays_its_axes_together(seed):
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(2, 3))
    table = joint_table((Joint(parent=0, child=1, kind="hinge", parent_axis=tuple(axes[0]),
                               child_axis=tuple(axes[1])),), 2)
    parent, child = axes / np.linalg.norm(axes, axis=1, keepdims=True)
    np.testing.assert_allclose(quaternion.rotate(table.zero[0], child), parent, atol=1e-9)
    assert quaternion.rotation_angle(table.zero[0]) == pytest.approx(np.arccos(parent @ child), abs=1e-7)


def test_opposite_axes_are_a_half_turn_apart():
    table = joint_table((Joint(parent=0, child=1, kind="hinge", child_axis=(0.0, 0.0, -1.0)),), 2)
    turned = quaternion.rotate(table.zero[0], [0.0, 0.0, -1.0])
    np.testing.assert_allclose(turned, [0.0, 0.0, 1.0], atol=1e-12)


def test_the_hand_has_the_joints_of_its_tree():
    segments = hand_tree(HandSize())
    table = body_table(body_of(17, HandSize(), (), ()))
    assert table.roots.tolist() == [0]
    assert table.angles == len(segments.freedoms) == 23  # doi 10.3390/s19010208, section 2.2
    assert table.unsensed == ()
    limits = np.concatenate([ranges[:kind + 1]
                             for ranges, kind in zip(table.ranges, table.kinds, strict=True)])
    np.testing.assert_allclose(limits, segments.ranges, atol=1e-12)


def test_angles_stand_where_the_tree_has_them_whatever_is_sensed():
    segments = hand_tree(HandSize())
    table = body_table(body_of(5, HandSize(), (), ("F2d", "hand", "F3p", "F2m", "F2p")))
    of_joint = [[segments.freedoms[first + i] for i in range(kind + 1)]
                for first, kind in zip(table.first_angle, table.kinds, strict=True)]
    assert dict(zip(table.names, of_joint, strict=True)) == {
        "F2_mcp": ["F2_mcp_flexion", "F2_mcp_abduction"], "F2_pip": ["F2_pip_flexion"],
        "F2_dip": ["F2_dip_flexion"], "F3_mcp": ["F3_mcp_flexion", "F3_mcp_abduction"]}
    assert table.angles == 23
    assert set(table.names) | set(table.unsensed) == {s.joint_name for s in segments.segments} - {""}


@given(st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=20)
def test_joint_angles_are_those_of_the_kinematics(seed):
    segments = hand_tree(HandSize())
    angles = np.random.default_rng(seed).uniform(-1.0, 1.0, 23)
    orientation, _ = segment_poses(segments, angles)
    table = joint_table(joints_of(segments, segments.names), 17)
    found = []
    for (p, c), kind, axes, zero in zip(table.ends, table.kinds, table.axes, table.zero, strict=True):
        q = quaternion.relative(orientation[p], orientation[c])
        found += joint_angles(q, kind, axes, zero)[0][:kind + 1]
    np.testing.assert_allclose(found, angles, atol=1e-9)


def test_a_strip_left_off_leaves_its_joints_out():
    names = [name for name in hand_tree(HandSize()).names if not name.startswith("F3")]
    joints = joints_of(hand_tree(HandSize()), names)
    assert len(joints) == len(names) - 1
    assert joint_table(joints, len(names)).roots.tolist() == [0]
    without_middle = joints_of(hand_tree(HandSize()), ["hand", "F2p", "F2d"])
    assert [(joint.parent, joint.child) for joint in without_middle] == [(0, 1)]
    with pytest.raises(InputError, match="F9p"):
        joints_of(hand_tree(HandSize()), ["hand", "F9p"])


def test_the_chain_is_one_tree():
    table = joint_table(CHAIN5, 5)
    assert (table.roots.tolist(), table.angles) == ([0], 6)
