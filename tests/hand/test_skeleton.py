"""The hand: its count of parts, and its signs on both sides in postures that anyone can check by eye."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fesloop.errors import InputError
from fesloop.hand import kinematics, quaternion
from fesloop.hand.anthropometry import FINGERS, HandSize
from fesloop.hand.skeleton import CONTACTS, RANGES, contact_point, contact_points, dorsal_points, hand_tree

LONG = FINGERS[1:]
NORTH, EAST, UP = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])

# Forearms on a table, palms down, fingers to the north: columns are the frame's x, y, z in the world.
ROOTS = {"left": np.array([UP, NORTH, -EAST]).T, "right": np.array([-UP, -NORTH, -EAST]).T}
# The thumbs point at each other.
RADIAL = {"left": EAST, "right": -EAST}


def quaternion_of(matrix):
    return Rotation.from_matrix(matrix).as_quat(scalar_first=True)


def tips(side, **degrees):
    """Fingertips, m from the wrist's centre in the world (east, north, up), at the angles given."""
    size = HandSize(side=side)
    tree = hand_tree(size)
    angles = np.zeros(23)
    for name, value in degrees.items():
        angles[tree.freedom(name)] = np.deg2rad(value)
    root = kinematics.Poses(quaternion_of(ROOTS[side]), np.zeros(3))
    poses = kinematics.segment_poses(tree, angles, root)
    return {finger: kinematics.points(tree, poses, f"{finger}d") for finger in FINGERS}, size


@pytest.mark.parametrize("side", ["left", "right"])
def test_root_frames_are_right_handed(side):
    assert np.linalg.det(ROOTS[side]) == pytest.approx(1.0)


def test_23_freedoms_17_segments():
    tree = hand_tree(HandSize())
    assert tree.names == ("forearm", "hand", "F1m", "F1p", "F1d", "F2p", "F2m", "F2d", "F3p", "F3m", "F3d",
                          "F4p", "F4m", "F4d", "F5p", "F5m", "F5d")
    assert len(tree.freedoms) == len(set(tree.freedoms)) == 23
    kinds = [segment.joint for segment in tree.segments]
    assert [kinds.count(kind) for kind in ("fixed", "ball", "saddle", "hinge")] == [1, 1, 5, 10]


@pytest.mark.parametrize("side", ["left", "right"])
def test_flat_hand_lies_on_the_table_thumb_inside(side):
    where, size = tips(side)
    ray = size.first_joints[2, 0] + size.segments[2].sum()
    np.testing.assert_allclose(where["F3"], ray * NORTH, atol=1e-12)
    for tip in where.values():
        assert tip @ UP == pytest.approx(0.0, abs=1e-12)
    radial = [where[finger] @ RADIAL[side] for finger in FINGERS[:1] + LONG]
    assert radial[1] > radial[2] > radial[3] > radial[4]
    assert radial[0] > 0.0
    cmc = where["F1"] - size.segments[0].sum() * NORTH
    assert np.degrees(np.arctan2(cmc @ RADIAL[side], cmc @ NORTH)) == pytest.approx(58.0)


@pytest.mark.parametrize("side", ["left", "right"])
def test_flexed_wrist_points_the_fingers_down(side):
    where, size = tips(side, wrist_flexion=75.0)
    ray = size.first_joints[2, 0] + size.segments[2].sum()
    expected = ray * (np.cos(np.deg2rad(75.0)) * NORTH - np.sin(np.deg2rad(75.0)) * UP)
    np.testing.assert_allclose(where["F3"], expected, atol=1e-12)


@pytest.mark.parametrize("side", ["left", "right"])
def test_right_angles_fold_a_finger_into_a_square(side):
    where, size = tips(side, F2_mcp_flexion=90.0, F2_pip_flexion=90.0, F2_dip_flexion=90.0)
    proximal, middle, distal = size.segments[1]
    forward, across = size.first_joints[1]
    expected = (forward - middle) * NORTH - across * RADIAL[side] + (distal - proximal) * UP
    np.testing.assert_allclose(where["F2"], expected, atol=1e-12)


@pytest.mark.parametrize("side", ["left", "right"])
def test_deviation_is_towards_the_little_finger(side):
    for joint, finger in (("wrist_abduction", "F3"), ("F2_mcp_abduction", "F2"), ("F5_mcp_abduction", "F5")):
        straight, turned = tips(side)[0][finger], tips(side, **{joint: 20.0})[0][finger]
        assert (turned - straight) @ RADIAL[side] < -0.02
        assert (turned - straight) @ UP == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("side", ["left", "right"])
def test_thumb_held_out_points_inwards_and_pronation_turns_its_flexion_under_the_palm(side):
    where, size = tips(side, F1_cmc_abduction=-60.0)
    metacarpal, proximal, distal = size.segments[0]
    cmc = size.first_joints[0, 0] * NORTH - size.first_joints[0, 1] * RADIAL[side]
    out = np.cos(np.deg2rad(60.0)) * NORTH + np.sin(np.deg2rad(60.0)) * RADIAL[side]
    np.testing.assert_allclose(where["F1"], cmc + (metacarpal + proximal + distal) * out, atol=1e-12)
    # Its nail towards the other hand's thumb, the bent thumb lies in the palm's plane and reaches for F5.
    bent, _ = tips(side, F1_cmc_pronation=90.0, F1_ip_flexion=80.0)
    tip = bent["F1"] - tips(side, F1_cmc_pronation=90.0)[0]["F1"]
    np.testing.assert_allclose(
        tip, distal * ((np.cos(np.deg2rad(80.0)) - 1.0) * NORTH - np.sin(np.deg2rad(80.0)) * RADIAL[side]),
        atol=1e-12)


@pytest.mark.parametrize("side", ["left", "right"])
def test_points_of_contact_lie_around_the_tip(side):
    where, size = tips(side)
    root = quaternion_of(ROOTS[side])
    tissue, thick, wide = size.tips.T
    west = -EAST
    for i in range(5):
        world = quaternion.rotate(root, contact_points(size)[i])
        expected = np.array([0.0 * UP, -0.5 * thick[i] * UP, 0.5 * thick[i] * UP, 0.5 * wide[i] * west,
                             -0.5 * wide[i] * west, tissue[i] * NORTH])
        np.testing.assert_allclose(world, expected, atol=1e-12)
    assert len(CONTACTS) == 6
    np.testing.assert_array_equal(contact_point(size, "F3", "left"), contact_points(size)[2, 3])
    # With its soft tissue the middle finger reaches the length that was given for the hand, 190 mm.
    reach = (where["F3"] + quaternion.rotate(root, contact_point(size, "F3", "distal"))) @ NORTH
    assert reach == pytest.approx(0.19, abs=0.003)


@pytest.mark.parametrize("side", ["left", "right"])
def test_sensors_lie_on_the_back_of_the_hand(side):
    size = HandSize(side=side)
    tree = hand_tree(size)
    root = kinematics.Poses(quaternion_of(ROOTS[side]), np.zeros(3))
    poses = kinematics.segment_poses(tree, np.zeros(23), root)
    middles = []
    for name, place in zip(tree.names, dorsal_points(size), strict=True):
        where = kinematics.points(tree, poses, name, place)
        assert 0.003 < where @ UP < 0.01
        middles.append(where @ NORTH)
    assert middles[0] == pytest.approx(-0.5 * size.forearm)
    assert middles[1] == pytest.approx(0.5 * size.first_joints[2, 0])
    assert middles[10] == pytest.approx(poses.position[10] @ NORTH - 0.5 * size.segments[2, 2])


def test_ranges_of_the_table_reach_the_tree():
    tree = hand_tree(HandSize())
    for finger in LONG:
        for joint in ("pip", "dip"):
            low, high = tree.ranges[tree.freedom(f"{finger}_{joint}_flexion")]
            assert (np.degrees(low), np.degrees(high)) == pytest.approx((-20.0, 100.0))
    for rows in RANGES.values():
        for row in rows:
            assert row.low_deg < 0.0 < row.high_deg
            assert row.source


def test_unknown_points_are_named():
    for finger, contact, said in (("F6", "tip", "'F6'; allowed: F1"),
                                  ("F1", "buttom", "did you mean 'bottom'")):
        with pytest.raises(InputError, match=said):
            contact_point(HandSize(), finger, contact)
