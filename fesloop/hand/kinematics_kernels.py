"""Compiled kinematics of a segment tree, for one posture at rate and for rows of postures.

`layout` (n, 3) and `geometry` (n, 5, 3) are those of a `SegmentTree`; `root` (7,) and rows of `poses` (n, 7)
hold a quaternion (w, x, y, z) from the segment's frame to the reference frame, and the position of its
origin there, m. Angles are (d,), rad. Arrays that are filled come last.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.hand.quaternion_kernels import (
    Components,
    conjugate,
    euler_x_of_zxy,
    euler_y_of_zxy,
    euler_z_of_zxy,
    multiply,
)

Array = NDArray[np.float64]
Layout = NDArray[np.int64]
Triple = tuple[float, float, float]


@compiled(inline="always")
def turned(q: Components, x: float, y: float, z: float) -> Triple:
    """The vector (x, y, z) turned by q: v + w t + u x t with t = 2 u x v and q = (w, u)."""
    w, a, b, c = q
    tx, ty, tz = 2.0 * (b * z - c * y), 2.0 * (c * x - a * z), 2.0 * (a * y - b * x)
    return (x + w * tx + b * tz - c * ty, y + w * ty + c * tx - a * tz, z + w * tz + a * ty - b * tx)


@compiled(inline="always")
def about(axis: Array, angle: float) -> Components:
    """Rotation by `angle` about a unit vector (3,)."""
    sine = math.sin(0.5 * angle)
    return math.cos(0.5 * angle), sine * axis[0], sine * axis[1], sine * axis[2]


@compiled(inline="always")
def moved(real: Components, dual: Components, vector: Array) -> Components:
    """Dual part of (real + eps dual) (1 + eps (0, vector) / 2): a translation along the turned axes."""
    bw, bx, by, bz = multiply(real, (0.0, 0.5 * vector[0], 0.5 * vector[1], 0.5 * vector[2]))
    return dual[0] + bw, dual[1] + bx, dual[2] + by, dual[3] + bz


@compiled
def forward(layout: Layout, geometry: Array, angles: Array, root: Array, poses: Array) -> None:
    """Fill `poses` (n, 7) by dual quaternions, doi 10.3390/s19010208, eq. 23-27."""
    count = layout.shape[0]
    chain = np.empty((count, 8))
    for k in range(count):
        parent = layout[k, 0]
        if parent < 0:
            real = (root[0], root[1], root[2], root[3])
            dual = multiply((0.0, 0.5 * root[4], 0.5 * root[5], 0.5 * root[6]), real)
        else:
            above = chain[parent]
            real = (above[0], above[1], above[2], above[3])
            dual = moved(real, (above[4], above[5], above[6], above[7]), geometry[k, 3])
            for i in range(layout[k, 1]):
                turn = about(geometry[k, i], angles[layout[k, 2] + i])
                real, dual = multiply(real, turn), multiply(dual, turn)
            dual = moved(real, dual, geometry[k, 4])
        chain[k, 0], chain[k, 1], chain[k, 2], chain[k, 3] = real
        chain[k, 4], chain[k, 5], chain[k, 6], chain[k, 7] = dual
        poses[k, 0], poses[k, 1], poses[k, 2], poses[k, 3] = real
        _, x, y, z = multiply(dual, conjugate(real))
        poses[k, 4], poses[k, 5], poses[k, 6] = 2.0 * x, 2.0 * y, 2.0 * z


@compiled
def place(layout: Layout, geometry: Array, orientations: Array, positions: Array) -> None:
    """Fill `positions` (n, 3) of segments whose orientations (n, 4) are known; the root's stays as it is."""
    for k in range(layout.shape[0]):
        parent = layout[k, 0]
        if parent < 0:
            continue
        above, own, base, offset = orientations[parent], orientations[k], geometry[k, 3], geometry[k, 4]
        x, y, z = turned((above[0], above[1], above[2], above[3]), base[0], base[1], base[2])
        a, b, c = turned((own[0], own[1], own[2], own[3]), offset[0], offset[1], offset[2])
        positions[k, 0] = positions[parent, 0] + x + a
        positions[k, 1] = positions[parent, 1] + y + b
        positions[k, 2] = positions[parent, 2] + z + c


@compiled
def joint_rotations(layout: Layout, geometry: Array, orientations: Array, rotations: Array) -> None:
    """Fill `rotations` (n, 3): each joint's flexion, abduction, pronation (`kinematics.joint_rotations`)."""
    for k in range(layout.shape[0]):
        parent = layout[k, 0]
        if parent < 0:
            rotations[k] = 0.0
            continue
        above, own, axes = orientations[parent], orientations[k], geometry[k]
        w, x, y, z = multiply(conjugate((above[0], above[1], above[2], above[3])),
                              (own[0], own[1], own[2], own[3]))
        q = (w, x * axes[1, 0] + y * axes[1, 1] + z * axes[1, 2],
             x * axes[2, 0] + y * axes[2, 1] + z * axes[2, 2],
             x * axes[0, 0] + y * axes[0, 1] + z * axes[0, 2])
        rotations[k, 0] = euler_z_of_zxy(q)
        rotations[k, 1] = euler_x_of_zxy(q)
        rotations[k, 2] = euler_y_of_zxy(q)


@compiled
def joint_lines(layout: Layout, geometry: Array, angles: Array, poses: Array, lines: Array) -> None:
    """Fill `lines` (d, 6): unit vector of each freedom's axis, then its joint's centre, in `poses`' frame."""
    for k in range(layout.shape[0]):
        parent = layout[k, 0]
        if parent < 0:
            continue
        above, base = poses[parent], geometry[k, 3]
        turn = (above[0], above[1], above[2], above[3])
        centre = turned(turn, base[0], base[1], base[2])
        for i in range(layout[k, 1]):
            axis, freedom = geometry[k, i], layout[k, 2] + i
            lines[freedom, 0], lines[freedom, 1], lines[freedom, 2] = turned(turn, axis[0], axis[1], axis[2])
            for j in range(3):
                lines[freedom, 3 + j] = above[4 + j] + centre[j]
            turn = multiply(turn, about(axis, angles[freedom]))


@compiled
def point_jacobian(lines: Array, acts: NDArray[np.bool_], point: Array, jacobian: Array) -> None:
    """Fill `jacobian` (6, d): change of a point's place (m/rad, rows 0-2) and of its segment's orientation.

    `lines` (d, 6) as `joint_lines` gives them, `acts` (d,) the freedoms that move the segment, `point` (3,)
    in the frame of `lines`. A rotation about an axis a through c moves p by a x (p - c).
    """
    for j in range(lines.shape[0]):
        if not acts[j]:
            jacobian[:, j] = 0.0
            continue
        a, b, c = lines[j, 0], lines[j, 1], lines[j, 2]
        x, y, z = point[0] - lines[j, 3], point[1] - lines[j, 4], point[2] - lines[j, 5]
        jacobian[0, j], jacobian[1, j], jacobian[2, j] = b * z - c * y, c * x - a * z, a * y - b * x
        jacobian[3, j], jacobian[4, j], jacobian[5, j] = a, b, c


@compiled
def jacobians(
    layout: Layout, geometry: Array, moves: NDArray[np.bool_], angles: Array, root: Array, segment: int,
    point: Array, rows: Array,
) -> None:
    """Fill `rows` (t, 6, d) for a point (3,) in a segment's frame; `angles` (t, d), `root` (t, 7)."""
    poses, lines, place = np.empty((layout.shape[0], 7)), np.empty((angles.shape[1], 6)), np.empty(3)
    for t in range(angles.shape[0]):
        forward(layout, geometry, angles[t], root[t], poses)
        joint_lines(layout, geometry, angles[t], poses, lines)
        pose = poses[segment]
        arm = turned((pose[0], pose[1], pose[2], pose[3]), point[0], point[1], point[2])
        for i in range(3):
            place[i] = pose[4 + i] + arm[i]
        point_jacobian(lines, moves[segment], place, rows[t])
