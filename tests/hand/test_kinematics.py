"""Forward kinematics by three independent ways, Jacobians by differences, angles there and back."""

import homogeneous
import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mujoco_trees import mujoco_model

from fesloop.errors import InputError
from fesloop.hand import kinematics, quaternion
from fesloop.hand import kinematics_kernels as kernels
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.segments import Segment, SegmentTree
from fesloop.hand.skeleton import hand_tree

seeds = st.integers(0, 2**32 - 1)


def tilted_tree():
    """A tree that is no hand: tilted axes, off-axis bones, a branch, a rigid piece."""
    third, half = 1.0 / 3.0, np.sqrt(0.5)
    return SegmentTree((
        Segment(name="trunk"),
        Segment(name="arm", parent="trunk", joint="ball", base=(0.1, 0.2, -0.3), offset=(0.05, 0.3, 0.02),
                axes=((third, 2 * third, 2 * third), (2 * third, third, -2 * third),
                      (-2 * third, 2 * third, -third))),
        Segment(name="splint", parent="arm", offset=(0.0, 0.1, 0.1)),
        Segment(name="palm", parent="splint", joint="saddle", offset=(0.0, 0.1, 0.0),
                axes=((0.0, half, half), (1.0, 0.0, 0.0))),
        Segment(name="finger", parent="palm", joint="hinge", offset=(0.01, 0.05, 0.0),
                axes=((0.0, 0.6, 0.8),)),
        Segment(name="thumb", parent="palm", joint="hinge", base=(0.0, -0.05, 0.02), offset=(0.0, 0.03, 0.0),
                axes=((0.0, 0.0, -1.0),)),
    ))


TREES = {"left": hand_tree(HandSize(side="left")), "right": hand_tree(HandSize()), "tilted": tilted_tree()}


def random_postures(tree, count, seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(tree.ranges[:, 0], tree.ranges[:, 1], (count, len(tree.ranges)))


def random_roots(count, seed=1):
    rng = np.random.default_rng(seed)
    return kinematics.Poses(quaternion.normalized(rng.normal(size=(count, 4))), rng.normal(size=(count, 3)))


def rotation_error(a, b):
    """Angle, rad, between rotation matrices; exact to round-off near 0, unlike that from the trace."""
    difference = np.swapaxes(a, -1, -2) @ b
    skew = difference - np.swapaxes(difference, -1, -2)
    sine = np.linalg.norm(skew, axis=(-2, -1)) / np.sqrt(8.0)
    return np.arctan2(sine, 0.5 * (np.trace(difference, axis1=-2, axis2=-1) - 1.0))


def mujoco_poses(tree, roots, angles):
    """Positions (t, n, 3) and matrices (t, n, 3, 3) of all segments."""
    model = mujoco_model(tree)
    record = mujoco.MjData(model)
    places, turns = [], []
    for orientation, position, row in zip(*roots, angles, strict=True):
        record.qpos[:] = np.concatenate([position, orientation, row])
        mujoco.mj_kinematics(model, record)
        places.append(record.site_xpos.copy())
        turns.append(record.site_xmat.reshape(-1, 3, 3).copy())
    return np.array(places), np.array(turns)


@pytest.mark.parametrize("name", TREES)
def test_dual_quaternions_matrices_and_mujoco_agree(name):
    tree, roots = TREES[name], random_roots(1000)
    angles = random_postures(tree, 1000)
    ours = kinematics.segment_poses(tree, angles, roots)
    start = np.zeros((1000, 4, 4))
    start[:, :3, :3], start[:, :3, 3], start[:, 3, 3] = quaternion.to_matrix(roots.orientation), roots[1], 1.0
    matrices = homogeneous.segment_matrices(tree, angles, start)
    places, turns = mujoco_poses(tree, roots, angles)
    ours_turned = quaternion.to_matrix(ours.orientation)
    np.testing.assert_allclose(ours.position, matrices[..., :3, 3], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(ours.position, places, rtol=0.0, atol=1e-12)
    assert rotation_error(ours_turned, matrices[..., :3, :3]).max() < 1e-12
    assert rotation_error(ours_turned, turns).max() < 1e-12


@pytest.mark.parametrize("name", TREES)
def test_kernel_equals_batch(name):
    tree, roots = TREES[name], random_roots(20)
    angles = random_postures(tree, 20)
    batch = kinematics.segment_poses(tree, angles, roots)
    poses = np.empty((len(tree.segments), 7))
    for t in range(20):
        kernels.forward(tree.layout, tree.geometry, angles[t],
                        np.concatenate([roots.orientation[t], roots.position[t]]), poses)
        np.testing.assert_allclose(poses[:, :4], batch.orientation[t], rtol=0.0, atol=1e-14)
        np.testing.assert_allclose(poses[:, 4:], batch.position[t], rtol=0.0, atol=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("name", TREES)
def test_orientations_alone_place_the_segments(name):
    tree, roots = TREES[name], random_roots(20)
    poses = kinematics.segment_poses(tree, random_postures(tree, 20), roots)
    again = kinematics.placed(tree, poses.orientation, roots.position)
    np.testing.assert_allclose(again.position, poses.position, rtol=0.0, atol=1e-14)
    positions, rotations = np.zeros((len(tree.names), 3)), np.empty((len(tree.names), 3))
    positions[0] = roots.position[3]
    kernels.place(tree.layout, tree.geometry, poses.orientation[3], positions)
    np.testing.assert_allclose(positions, poses.position[3], rtol=0.0, atol=1e-14)
    kernels.joint_rotations(tree.layout, tree.geometry, poses.orientation[3], rotations)
    relative = kinematics.relative_of_segments(tree, poses.orientation[3])
    np.testing.assert_allclose(rotations, kinematics.joint_rotations(tree, relative), atol=1e-12)


def test_orientations_of_another_tree_are_refused():
    with pytest.raises(InputError, match=r"shape \(16, 4\); allowed: \(\.\.\., 17, 4\)"):
        kinematics.placed(TREES["left"], np.zeros((16, 4)))


@pytest.mark.parametrize("name", ["forward", "place", "joint_rotations", "joint_lines", "point_jacobian"])
def test_compiled_kernels_equal_plain_python(name):
    tree = TREES["tilted"]
    angles, root = random_postures(tree, 1)[0], np.concatenate([*(part[0] for part in random_roots(1))])
    poses, lines = np.empty((len(tree.segments), 7)), np.empty((len(angles), 6))
    kernels.forward(tree.layout, tree.geometry, angles, root, poses)
    kernels.joint_lines(tree.layout, tree.geometry, angles, poses, lines)
    arguments, shape = {
        "place": ((tree.layout, tree.geometry, poses[:, :4]), (len(poses), 3)),
        "joint_rotations": ((tree.layout, tree.geometry, poses[:, :4]), (len(poses), 3)),
        "forward": ((tree.layout, tree.geometry, angles, root), poses.shape),
        "joint_lines": ((tree.layout, tree.geometry, angles, poses), lines.shape),
        "point_jacobian": ((lines, tree.moved[4], np.array([0.1, 0.2, 0.3])), (6, len(angles))),
    }[name]
    compiled, plain = np.zeros(shape), np.zeros(shape)
    getattr(kernels, name)(*arguments, compiled)
    getattr(kernels, name).py_func(*arguments, plain)
    np.testing.assert_allclose(compiled, plain, rtol=0.0, atol=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("name", TREES)
@settings(deadline=None)  # the first example compiles
@given(seed=seeds)
def test_jacobian_equals_finite_differences(name, seed):
    tree = TREES[name]
    rng = np.random.default_rng(seed)
    segment, point, step = str(rng.choice(tree.names)), rng.normal(scale=0.03, size=3), 1e-6
    angles, root = random_postures(tree, 1, seed)[0], kinematics.Poses(*(p[0] for p in random_roots(1, seed)))
    ours = kinematics.jacobian(tree, angles, segment, point, root)
    moved = angles + step * np.concatenate([np.eye(angles.size), -np.eye(angles.size)])
    poses = kinematics.segment_poses(tree, moved, root)
    after, before = np.split(kinematics.points(tree, poses, segment, point), 2)
    np.testing.assert_allclose(ours[:3], (after - before).T / (2.0 * step), rtol=0.0, atol=1e-8)
    turned, back = np.split(poses.orientation[:, tree.index(segment)], 2)
    twist = quaternion.multiply(turned, quaternion.conjugate(back))
    np.testing.assert_allclose(ours[3:], (twist[:, 1:] * np.sign(twist[:, :1])).T / step, rtol=0.0, atol=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("name", TREES)
@settings(deadline=None)  # the first example compiles
@given(seed=seeds)
def test_joint_angles_come_back(name, seed):
    tree = TREES[name]
    angles = np.clip(random_postures(tree, 5, seed), -1.5, 1.5)
    relative = kinematics.relative_orientations(tree, angles)
    np.testing.assert_allclose(kinematics.joint_angles(tree, relative), angles, atol=1e-9)
    poses = kinematics.segment_poses(tree, angles, random_roots(5, seed))
    again = kinematics.relative_of_segments(tree, poses.orientation)
    np.testing.assert_allclose(kinematics.joint_angles(tree, again), angles, atol=1e-9)


def test_rotation_that_a_joint_does_not_allow_is_measured():
    tree = TREES["right"]
    relative = kinematics.relative_orientations(tree, np.zeros(23))
    pip = tree.index("F2m")
    relative[pip] = quaternion.from_euler_zxy(0.5, 0.1, -0.2)
    np.testing.assert_allclose(kinematics.joint_rotations(tree, relative)[pip], [0.5, 0.1, -0.2], atol=1e-12)
    angles = kinematics.joint_angles(tree, relative)
    assert angles[tree.freedom("F2_pip_flexion")] == pytest.approx(0.5)
    assert np.count_nonzero(np.abs(angles) > 1e-12) == 1


def test_time_axes_lead():
    tree = TREES["left"]
    angles = random_postures(tree, 6).reshape(2, 3, 23)
    poses, rows = kinematics.segment_poses(tree, angles), kinematics.jacobian(tree, angles, "F3d")
    assert poses.orientation.shape == (2, 3, 17, 4)
    assert poses.position.shape == (2, 3, 17, 3)
    one = kinematics.segment_poses(tree, angles[1, 2])
    np.testing.assert_allclose(poses.position[1, 2], one.position, atol=1e-15)
    np.testing.assert_allclose(rows[1, 2], kinematics.jacobian(tree, angles[1, 2], "F3d"), atol=1e-15)


def test_wrong_number_of_angles_and_unknown_segments_are_named():
    tree = TREES["left"]
    with pytest.raises(InputError, match=r"shape \(22,\); allowed: \(\.\.\., 23\): wrist_flexion"):
        kinematics.segment_poses(tree, np.zeros(22))
    with pytest.raises(InputError, match=r"'F6d'.*did you mean") as caught:
        kinematics.jacobian(tree, np.zeros(23), "F6d")
    assert "\n" not in str(caught.value)
