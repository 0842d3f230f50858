"""First relative orientation of two jointed segments from one sample of each, and how well it is known.

Both accelerometers see the same vertical, as far as nothing accelerates; that leaves the heading of one
sensor against the other. A hinge's axis gives it. A saddle's axes allow two headings, of which the one
nearer to the joint's zero is taken; a ball joint gives none.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from estimators.joint_constraints import HINGE, SADDLE
from fesloop.hand import quaternion

Array = NDArray[np.float64]
UNKNOWN = math.pi / math.sqrt(3.0)
"""Sd of a heading of which nothing is known: that of a uniform one, rad."""


def first_orientation(kind: int, axes: Array, up: Array, axis_sd: float) -> tuple[Array, float]:
    """Child to parent, (4,), and the sd of its heading, rad.

    Parameters
    ----------
    kind: HINGE, SADDLE or BALL.
    axes: (2, 3), in the parent's and in the child's frame.
    up: (2, 3), the specific force of parent and child, each in its own frame, not zero.
    axis_sd: of the axes' directions, rad.
    """
    up = up / np.linalg.norm(up, axis=1, keepdims=True)
    level = [_level(each) for each in up]
    flat = [quaternion.rotate(q, axis) for q, axis in zip(level, axes, strict=True)]
    lengths = [math.hypot(axis[0], axis[1]) for axis in flat]
    bearings = [math.atan2(axis[1], axis[0]) for axis in flat]
    if kind == HINGE:
        headings = [bearings[0] - bearings[1]]
    elif kind == SADDLE and min(lengths) > 0.0:
        # With the child turned by h the product of the axes is l0 l1 cos(b1 + h - b0) + z0 z1 = 0.
        cosine = -flat[0][2] * flat[1][2] / (lengths[0] * lengths[1])
        away = math.acos(min(1.0, max(-1.0, cosine)))
        headings = [bearings[0] - bearings[1] + away, bearings[0] - bearings[1] - away]
    else:
        headings = [0.0]
    found = [quaternion.multiply(quaternion.conjugate(level[0]),
                                 quaternion.multiply(quaternion.about_z(h), level[1])) for h in headings]
    nearest = min(found, key=lambda q: float(quaternion.rotation_angle(q)))
    known = axis_sd / max(min(lengths), 1e-6) if kind == HINGE else UNKNOWN
    return nearest, min(known, UNKNOWN)


def _level(up: Array) -> Array:
    """The least rotation of a frame that makes `up` (3,), unit, its z, (4,)."""
    if up[2] < -1.0 + 1e-9:
        return np.array([0.0, 1.0, 0.0, 0.0])
    return quaternion.normalized(np.array([1.0 + up[2], up[1], -up[0], 0.0]))
