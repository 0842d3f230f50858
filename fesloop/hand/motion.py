"""Angular velocity and specific force at any points of a moving segment tree, without differencing.

Arrays lead with any axes (...), time among them; n segments, d degrees of freedom, m sensors. At rate, the
kernels `motion_kernels.motions` and `sense` do it for one instant.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.errors import InputError
from fesloop.hand import motion_kernels, quaternion
from fesloop.hand.kinematics import AT_REFERENCE, checked_angles
from fesloop.hand.segments import SegmentTree

Array = NDArray[np.float64]

STANDARD_GRAVITY = 9.80665
"""m/s^2 (CGPM 1901)."""
UPWARDS = (0.0, 0.0, STANDARD_GRAVITY)
"""What an accelerometer at rest reads in the global frame (ENU), m/s^2."""


class SensorPoints(NamedTuple):
    """Where sensors sit: index of the segment (m,), and place in the segment's frame (m, 3), m."""

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
    """Motion (..., 3, 3) of the root, in its own coordinates: what the recursion starts from.

    Parameters
    ----------
    orientation: (..., 4), from the root's to the global frame.
    angular_velocity, angular_acceleration: (..., 3), rad/s and rad/s^2, in the root's coordinates.
    acceleration: (..., 3), m/s^2, of the root's origin, in global ones.
    upwards: (3,), m/s^2, what an accelerometer at rest reads, in global ones.
    """
    force = np.asarray(acceleration, dtype=np.float64) + np.asarray(upwards, dtype=np.float64)
    force = quaternion.rotate(quaternion.conjugate(orientation), force)
    turning = (np.asarray(row, dtype=np.float64) for row in (angular_velocity, angular_acceleration))
    return np.stack(np.broadcast_arrays(*turning, force), axis=-2)


def sensed(
    tree: SegmentTree, sensors: SensorPoints, angles: ArrayLike, rates: ArrayLike, accelerations: ArrayLike,
    root: Array | None = None,
) -> Samples:
    """What ideal gyroscopes and accelerometers at these points read.

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
    motion_kernels.sensed_rows(
        tree.layout, tree.geometry, angle, rate, acceleration,
        np.ascontiguousarray(start).reshape(-1, 3, 3), sensors.segments, sensors.places,
        rows.reshape(-1, *rows.shape[-3:]))
    return Samples(rows[..., 0, :, :], rows[..., 1, :, :])
