"""Angular velocity and specific force at any points of a moving segment tree, without differencing.

Arrays lead with any axes (...), time among them; n segments, d degrees of freedom, m sensors. At rate, the
kernels `motions` and `sense` compute it for one instant.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.kinematics import AT_REFERENCE, checked_angles
from fesloop.hand.segments import SegmentTree

Array = NDArray[np.float64]
Layout = NDArray[np.int64]


@compiled(inline="always")
def carry(motion: Array, lever: Array) -> None:
    """Move a motion's specific force to a point at `lever` (3,): it gains alpha x r + omega x (omega x r)."""
    wx, wy, wz = motion[0, 0], motion[0, 1], motion[0, 2]
    ax, ay, az = motion[1, 0], motion[1, 1], motion[1, 2]
    x, y, z = lever[0], lever[1], lever[2]
    vx, vy, vz = wy * z - wz * y, wz * x - wx * z, wx * y - wy * x
    motion[2, 0] += ay * z - az * y + wy * vz - wz * vy
    motion[2, 1] += az * x - ax * z + wz * vx - wx * vz
    motion[2, 2] += ax * y - ay * x + wx * vy - wy * vx


@compiled(inline="always")
def turn(motion: Array, axis: Array, angle: float, rate: float, acceleration: float) -> None:
    """Pass a motion over a hinge about a unit vector: into the turned frame, with the hinge's own rates."""
    cosine, sine = math.cos(angle), math.sin(angle)
    a, b, c = axis[0], axis[1], axis[2]
    for i in range(3):
        x, y, z = motion[i, 0], motion[i, 1], motion[i, 2]
        along = (1.0 - cosine) * (a * x + b * y + c * z)
        motion[i, 0] = cosine * x + along * a - sine * (b * z - c * y)
        motion[i, 1] = cosine * y + along * b - sine * (c * x - a * z)
        motion[i, 2] = cosine * z + along * c - sine * (a * y - b * x)
    x, y, z = motion[0, 0], motion[0, 1], motion[0, 2]
    # The hinge's axis is itself carried round by what lies before it.
    motion[1, 0] += acceleration * a + rate * (y * c - z * b)
    motion[1, 1] += acceleration * b + rate * (z * a - x * c)
    motion[1, 2] += acceleration * c + rate * (x * b - y * a)
    motion[0, 0] += rate * a
    motion[0, 1] += rate * b
    motion[0, 2] += rate * c


@compiled
def motions(
    layout: Layout, geometry: Array, angles: Array, rates: Array, accelerations: Array, root: Array,
    chain: Array,
) -> None:
    """Fill `chain` (n, 3, 3), motions of all segments at their frames' origins; angles and the like (d,)."""
    for k in range(layout.shape[0]):
        parent = layout[k, 0]
        if parent < 0:
            chain[k] = root
            continue
        chain[k] = chain[parent]
        carry(chain[k], geometry[k, 3])
        for i in range(layout[k, 1]):
            j = layout[k, 2] + i
            turn(chain[k], geometry[k, i], angles[j], rates[j], accelerations[j])
        carry(chain[k], geometry[k, 4])


@compiled
def sense(chain: Array, segments: NDArray[np.int64], places: Array, work: Array, samples: Array) -> None:
    """Fill `samples` (2, m, 3): angular velocity and specific force at `places` (m, 3) of `segments` (m,).

    In the coordinates of their segments; `work` (3, 3) is scratch.
    """
    for i in range(segments.shape[0]):
        work[:] = chain[segments[i]]
        carry(work, places[i])
        samples[0, i] = work[0]
        samples[1, i] = work[2]


@compiled
def sensed_rows(
    layout: Layout, geometry: Array, angles: Array, rates: Array, accelerations: Array, root: Array,
    segments: NDArray[np.int64], places: Array, rows: Array,
) -> None:
    """Fill `rows` (t, 2, m, 3) with `sense` of each row of angles (t, d) and of `root` (t, 3, 3)."""
    chain, work = np.empty((layout.shape[0], 3, 3)), np.empty((3, 3))
    for t in range(angles.shape[0]):
        motions(layout, geometry, angles[t], rates[t], accelerations[t], root[t], chain)
        sense(chain, segments, places, work, rows[t])


STANDARD_GRAVITY = 9.80665
"""m/s^2 (CGPM 1901)."""
UPWARDS = (0.0, 0.0, STANDARD_GRAVITY)
"""Specific force at rest in the global frame (ENU), m/s^2."""


class SensorPoints(NamedTuple):
    """Places of sensors: index of the segment (m,), and position in the segment's frame (m, 3), m."""

    segments: NDArray[np.int64]
    places: Array


class Samples(NamedTuple):
    """Angular velocity, rad/s, and specific force, m/s^2, (..., m, 3) each, in the segments' coordinates."""

    gyr: Array
    acc: Array


def sensor_points(tree: SegmentTree, segments: Sequence[str], places: ArrayLike) -> SensorPoints:
    """Sensors on segments by name, at places (m, 3), m; raises InputError for unknown names, other shapes."""
    indices = np.array([tree.index(name) for name in segments], dtype=np.int64)
    where = np.array(places, dtype=np.float64)
    if where.shape != (len(indices), 3):
        raise InputError("sensor places", f"shape {where.shape}",
                         f"({len(indices)}, 3): one for each segment")
    return SensorPoints(indices, where)


def root_motion(
    orientation: ArrayLike = AT_REFERENCE.orientation,
    angular_velocity: ArrayLike = (0.0, 0.0, 0.0),
    angular_acceleration: ArrayLike = (0.0, 0.0, 0.0),
    acceleration: ArrayLike = (0.0, 0.0, 0.0),
    upwards: ArrayLike = UPWARDS,
) -> Array:
    """Motion (..., 3, 3) of the root, in its own coordinates: the start of the recursion.

    Parameters
    ----------
    orientation: (..., 4), from the root's to the global frame.
    angular_velocity, angular_acceleration: (..., 3), rad/s and rad/s^2, in the root's coordinates.
    acceleration: (..., 3), m/s^2, of the root's origin, in global ones.
    upwards: (3,), m/s^2, specific force at rest, in global ones.
    """
    force = np.asarray(acceleration, dtype=np.float64) + np.asarray(upwards, dtype=np.float64)
    force = quaternion.rotate(quaternion.conjugate(orientation), force)
    turning = (np.asarray(row, dtype=np.float64) for row in (angular_velocity, angular_acceleration))
    return np.stack(np.broadcast_arrays(*turning, force), axis=-2)


def sensed(
    tree: SegmentTree, sensors: SensorPoints, angles: ArrayLike, rates: ArrayLike, accelerations: ArrayLike,
    root: Array | None = None,
) -> Samples:
    """Samples of ideal gyroscopes and accelerometers at these points.

    Parameters
    ----------
    angles, rates, accelerations: (..., d), rad, rad/s, rad/s^2.
    root: (..., 3, 3) as `root_motion` gives it; by default at rest, its axes the global ones.
    """
    shaped = [checked_angles(tree, rows) for rows in (angles, rates, accelerations)]
    whole = np.ascontiguousarray(np.broadcast_arrays(*shaped))
    lead, count = whole.shape[1:-1], whole.shape[-1]
    angle, rate, acceleration = whole.reshape(3, -1, count)
    start = np.broadcast_to(root_motion() if root is None else root, (*lead, 3, 3))
    rows = np.empty((*lead, 2, len(sensors.segments), 3))
    sensed_rows(
        tree.layout, tree.geometry, angle, rate, acceleration,
        np.ascontiguousarray(start).reshape(-1, 3, 3), sensors.segments, sensors.places,
        rows.reshape(-1, *rows.shape[-3:]))
    return Samples(rows[..., 0, :, :], rows[..., 1, :, :])
