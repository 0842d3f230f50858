"""Joints and trees of them: what is refused, and where angles begin."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimators.joint_constraints import TREES, Joint, joint_table, tree
from fesloop.errors import InputError
from fesloop.hand import quaternion


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
    (((1, 2), (0, 1)), "before")])
def test_joints_that_form_no_tree_are_refused(ends, match):
    with pytest.raises(InputError, match=match):
        joint_table(tuple(Joint(parent=p, child=c, kind="ball") for p, c in ends), 3)


def test_trees_may_be_several_and_a_sensor_alone():
    table = joint_table((Joint(parent=1, child=3, kind="ball"), Joint(parent=2, child=4, kind="hinge")), 6)
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


def test_the_hand_has_one_joint_a_finger_segment():
    joints = tree("hand16")
    table = joint_table(joints, 16)
    assert table.roots.tolist() == [0]
    assert table.angles == 21  # 23 of the hand without the wrist's two (doi 10.3390/s19010208)
    assert sorted(joint.child for joint in joints) == list(range(1, 16))


def test_unknown_trees_are_named():
    with pytest.raises(InputError, match="did you mean 'hand16'"):
        tree("hand6")
    assert all(joint_table(tree(name), 16).angles for name in TREES)
