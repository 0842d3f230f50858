"""Joint angles from the orientations of neighbouring segments, and the initial pose that aligns them.

Without magnetometers the heading of each sensor is arbitrary. In a known initial pose the heading of each
child relative to its parent is known, and the offset found then is removed from there on (initial-pose
alignment, Salchow-Hoemmen et al. 2019, doi 10.3390/s19010208, section 2.4.2).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.quaternion_kernels import conjugate, euler_z_of_zxy, multiply, rotation_angle
from fesloop.loop.signals import Port

Array = NDArray[np.float64]
Pairs = tuple[tuple[int, int], ...]


@compiled
def flexion_angles(orientation: Any, pairs: Any, heading: Any) -> Any:
    """Flexion of each joint, (pairs,), rad: first of the z-x-y Euler angles of child to parent.

    Parameters
    ----------
    orientation: (n, 4), segment to earth.
    pairs: (pairs, 2), parent and child.
    heading: (pairs, 2), cosine and sine of half the heading by which the child is to be turned.
    """
    angles = np.empty(pairs.shape[0])
    for k in range(pairs.shape[0]):
        p, c = orientation[pairs[k, 0]], orientation[pairs[k, 1]]
        turn = (heading[k, 0], 0.0, 0.0, heading[k, 1])
        child = multiply(turn, (c[0], c[1], c[2], c[3]))
        angles[k] = euler_z_of_zxy(multiply(conjugate((p[0], p[1], p[2], p[3])), child))
    return angles


@compiled
def turned_angle(origin: Any, orientation: Any) -> Any:
    """Angle between two orientations, each (1, 4), as (1,), rad in [0, pi]."""
    a, b = origin[0], orientation[0]
    angles = np.empty(1)
    angles[0] = rotation_angle(multiply(conjugate((a[0], a[1], a[2], a[3])), (b[0], b[1], b[2], b[3])))
    return angles


def heading_offsets(orientation: Array, pairs: NDArray[np.int64], flexion: Array) -> Array:
    """Headings that turn each child into the known pose, for `flexion_angles`: (pairs, 2).

    Parameters
    ----------
    orientation: (n, 4), segment to earth, in the known pose.
    pairs: (pairs, 2), parent and child.
    flexion: (pairs,), rad, flexion in that pose; abduction and pronation are zero.
    """
    wanted = quaternion.multiply(orientation[pairs[:, 0]], quaternion.about_z(flexion))
    error = quaternion.multiply(wanted, quaternion.conjugate(orientation[pairs[:, 1]]))
    turn = quaternion.about_z(quaternion.twist_z(error))
    return np.ascontiguousarray(turn[:, ::3])


def no_offsets(pairs: int) -> Array:
    """Headings that turn nothing, (pairs, 2)."""
    return np.tile([1.0, 0.0], (pairs, 1))


def resolve_pairs(pairs: Pairs, sensors: int) -> Pairs:
    """The pairs, or each sensor with its successor where none are given.

    Raises InputError for a pair that names no two of the sensors.
    """
    for pair in pairs:
        if not all(0 <= end < sensors for end in pair) or pair[0] == pair[1]:
            raise InputError("pairs", f"{list(pair)} is no pair of {sensors} sensors",
                             f"two different numbers from 0 to {sensors - 1}")
    return pairs or tuple((i, i + 1) for i in range(sensors - 1))


def initial_flexion(initial_angles_deg: tuple[float, ...] | None, joints: int) -> Array | None:
    """The initial pose in rad, (joints,), or None. Raises InputError for a wrong number of angles."""
    if initial_angles_deg is None:
        return None
    if len(initial_angles_deg) != joints or not joints:
        raise InputError("initial_angles_deg", f"has {len(initial_angles_deg)} angles",
                         f"{joints}, one a joint" if joints else "none: a single sensor has no joint")
    if not all(math.isfinite(angle) and abs(angle) <= 180.0 for angle in initial_angles_deg):
        raise InputError("initial_angles_deg", f"{initial_angles_deg}", "finite angles from -180 to 180 deg")
    flexion = np.radians(initial_angles_deg)
    flexion.flags.writeable = False
    return flexion


ALIGNED_PORT = Port("aligned", (1,), "1")
"""0 while the wearer keeps still in the initial pose, 1 afterwards and for trackers that need none."""


def aligned_value(aligned: bool) -> NDArray[np.float64]:
    """The value of `aligned`, (1,); read-only."""
    return _ALIGNED if aligned else _ALIGNING


def _constant(value: float) -> NDArray[np.float64]:
    array = np.array([value])
    array.flags.writeable = False
    return array


_ALIGNED, _ALIGNING = _constant(1.0), _constant(0.0)
