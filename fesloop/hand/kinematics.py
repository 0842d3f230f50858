"""Forward kinematics of a segment tree over time: poses, points, Jacobians, joint angles.

Arrays lead with any axes (...), time among them; n segments, d degrees of freedom. "Reference frame" is
the one in which the root's pose is given; of a hand whose root is left out, the wrist coordinate system.
For one posture at rate there are the kernels of `kinematics_kernels`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.errors import InputError
from fesloop.hand import dual_quaternion, kinematics_kernels, quaternion
from fesloop.hand.segments import SegmentTree

Array = NDArray[np.float64]


class Poses(NamedTuple):
    """Orientation (..., 4), quaternions from own to reference frame, and position (..., 3), m."""

    orientation: Array
    position: Array


AT_REFERENCE = Poses(np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3))
"""The pose of the reference frame itself."""


def checked_angles(tree: SegmentTree, angles: ArrayLike) -> Array:
    """Angles (..., d) as an array; raises InputError for another number of columns."""
    array = np.asarray(angles, dtype=np.float64)
    count = len(tree.ranges)
    if array.ndim == 0 or array.shape[-1] != count:
        raise InputError("angles", f"shape {array.shape}", f"(..., {count}): {', '.join(tree.freedoms)}")
    return array


def segment_poses(tree: SegmentTree, angles: ArrayLike, root: Poses = AT_REFERENCE) -> Poses:
    """Poses (..., n) of all segments by dual quaternions (doi 10.3390/s19010208, eq. 23-27)."""
    angle = checked_angles(tree, angles)
    pose = dual_quaternion.multiply(dual_quaternion.translation(root.position),
                                    dual_quaternion.rotation(root.orientation))
    chain: list[Array] = []
    relative = relative_orientations(tree, angle)
    for k, (parent, _, _) in enumerate(tree.layout):
        if parent < 0:
            chain.append(np.broadcast_to(pose, (*angle.shape[:-1], 8)))
            continue
        base, offset = (dual_quaternion.translation(vector) for vector in tree.geometry[k, 3:])
        turn = dual_quaternion.rotation(relative[..., k, :])
        joint = dual_quaternion.multiply(dual_quaternion.multiply(base, turn), offset)
        chain.append(dual_quaternion.multiply(chain[parent], joint))
    stacked = np.stack(chain, axis=-2)
    return Poses(dual_quaternion.orientation(stacked), dual_quaternion.position(stacked))


def placed(tree: SegmentTree, orientation: ArrayLike, root_position: ArrayLike = (0.0, 0.0, 0.0)) -> Poses:
    """Poses of all segments from their orientations (..., n, 4), whatever their joints allow.

    So a tracker that knows each segment's orientation, but no joint angles, finds its fingertips.
    """
    q = np.asarray(orientation, dtype=np.float64)
    if q.shape[-2:] != (len(tree.segments), 4):
        raise InputError("orientation", f"shape {q.shape}", f"(..., {len(tree.segments)}, 4)")
    positions: list[Array] = []
    for k, (parent, _, _) in enumerate(tree.layout):
        if parent < 0:
            positions.append(np.broadcast_to(np.asarray(root_position, dtype=np.float64), (*q.shape[:-2], 3)))
            continue
        to_joint = quaternion.rotate(q[..., parent, :], tree.geometry[k, 3])
        positions.append(positions[parent] + to_joint + quaternion.rotate(q[..., k, :], tree.geometry[k, 4]))
    return Poses(q, np.stack(positions, axis=-2))


def points(tree: SegmentTree, poses: Poses, segment: str, point: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Position (..., 3), m, in the reference frame, of a point (3,) or (..., 3) in a segment's frame."""
    k = tree.index(segment)
    return poses.position[..., k, :] + quaternion.rotate(poses.orientation[..., k, :], point)


def relative_orientations(tree: SegmentTree, angles: ArrayLike) -> Array:
    """Quaternions (..., n, 4) from each segment's frame to its parent's; the root's is the identity."""
    angle = checked_angles(tree, angles)
    turns: list[Array] = []
    for (_, freedoms, first), geometry in zip(tree.layout, tree.geometry, strict=True):
        turn = np.broadcast_to(AT_REFERENCE.orientation, (*angle.shape[:-1], 4))
        for i in range(freedoms):
            turn = quaternion.multiply(turn, quaternion.from_axis_angle(geometry[i], angle[..., first + i]))
        turns.append(turn)
    return np.stack(turns, axis=-2)


def relative_of_segments(tree: SegmentTree, orientation: ArrayLike) -> Array:
    """Quaternions (..., n, 4) to each parent's frame, from those to the reference frame (eq. 19)."""
    q = np.asarray(orientation, dtype=np.float64)
    parents = np.where(tree.layout[:, 0] < 0, 0, tree.layout[:, 0])
    return quaternion.relative(q[..., parents, :], q)


def joint_rotations(tree: SegmentTree, relative: ArrayLike) -> Array:
    """All three angles (..., n, 3) about each joint's axes: flexion, abduction, pronation, rad.

    Intrinsic, as `quaternion.euler_zxy` (eq. 20-22), of relative quaternions (..., n, 4). What a joint
    has no freedom for comes out as well: it measures how far the rotation is from what the joint allows.
    """
    q = np.asarray(relative, dtype=np.float64)
    # In the coordinates of its own frame every joint turns about z, x, y.
    frames = tree.geometry[:, [1, 2, 0]]
    vector = np.einsum("nij,...nj->...ni", frames, q[..., 1:])
    return quaternion.euler_zxy(np.concatenate([q[..., :1], vector], axis=-1))


def joint_angles(tree: SegmentTree, relative: ArrayLike) -> Array:
    """Angles (..., d) of the freedoms that the joints have; other rotation is left out."""
    rotations = joint_rotations(tree, relative)
    has = np.arange(3) < tree.layout[:, 1:2]
    return rotations[..., has]


def jacobian(
    tree: SegmentTree, angles: ArrayLike, segment: str, point: ArrayLike = (0.0, 0.0, 0.0),
    root: Poses = AT_REFERENCE,
) -> Array:
    """Jacobian (..., 6, d) of a point given in a segment's frame, (3,), with respect to the angles.

    Rows 0-2: position, m/rad; rows 3-5: rotation vector, rad/rad; both in the reference frame.
    """
    angle = checked_angles(tree, angles)
    k, lead = tree.index(segment), angle.shape[:-1]
    pose = np.empty((*lead, 7))
    pose[..., :4], pose[..., 4:] = root.orientation, root.position
    rows = np.empty((*lead, 6, angle.shape[-1]))
    kinematics_kernels.jacobians(
        tree.layout, tree.geometry, tree.moved, np.ascontiguousarray(angle).reshape(-1, angle.shape[-1]),
        pose.reshape(-1, 7), k, np.array(point, dtype=np.float64), rows.reshape(-1, *rows.shape[-2:]))
    return rows
