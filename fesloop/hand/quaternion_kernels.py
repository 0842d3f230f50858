"""Quaternion formulas on tuples of four components (w, x, y, z), Hamilton, compiled.

Each formula stands here once. A kernel takes and gives tuples of scalars, so that other kernels can call it
without allocating; its plain Python form (`.py_func`) takes components that are arrays just as well, and
that is what `fesloop.hand.quaternion` applies to whole recordings.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fesloop.compiled import compiled

Components = tuple[Any, Any, Any, Any]
"""w, x, y, z: floats in a kernel, arrays of one shape in plain Python."""


@compiled(inline="always")
def multiply(a: Components, b: Components) -> Components:
    """Product a b: first b's rotation, then a's."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


@compiled(inline="always")
def conjugate(q: Components) -> Components:
    """The inverse rotation of a unit quaternion."""
    return q[0], -q[1], -q[2], -q[3]


@compiled
def about_z(angle: Any) -> Components:
    """Rotation by `angle` (rad) about z."""
    zero = 0.0 * angle
    return np.cos(0.5 * angle), zero, zero, np.sin(0.5 * angle)


@compiled
def rotation_angle(q: Components) -> Any:
    """Angle of the whole rotation, rad in [0, pi]; well conditioned at both ends."""
    return 2.0 * np.arctan2(np.sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]), np.abs(q[0]))


@compiled
def twist_z(q: Components) -> Any:
    """Angle, rad in [-pi, pi], of the rotation about z in q = tilt twist, the tilt's axis normal to z.

    For an error between two orientations in a frame with z up this is the heading error.
    """
    sign = np.where(q[0] < 0.0, -1.0, 1.0)
    return 2.0 * np.arctan2(sign * q[3], sign * q[0])


@compiled
def tilt_z(q: Components) -> Any:
    """Angle, rad in [0, pi], by which q tilts the z axis: the inclination error where z is up."""
    tilt = np.sqrt(q[1] * q[1] + q[2] * q[2])
    return 2.0 * np.arctan2(tilt, np.sqrt(q[0] * q[0] + q[3] * q[3]))


@compiled
def euler_z_of_zxy(q: Components) -> Any:
    """First of the intrinsic z-x-y Euler angles, rad: flexion (doi 10.3390/s19010208, eq. 20-22)."""
    w, x, y, z = q
    return np.arctan2(2.0 * (w * z - x * y), 1.0 - 2.0 * (x * x + z * z))


@compiled
def euler_x_of_zxy(q: Components) -> Any:
    """Second of the intrinsic z-x-y Euler angles, rad in [-pi/2, pi/2]: abduction."""
    w, x, y, z = q
    return np.arcsin(np.minimum(1.0, np.maximum(-1.0, 2.0 * (w * x + y * z))))


@compiled
def euler_y_of_zxy(q: Components) -> Any:
    """Third of the intrinsic z-x-y Euler angles, rad: pronation."""
    w, x, y, z = q
    return np.arctan2(2.0 * (w * y - x * z), 1.0 - 2.0 * (x * x + y * y))
