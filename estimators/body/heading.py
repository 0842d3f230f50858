"""First relative orientations of two jointed segments from one sample of each: all that it allows.

Both accelerometers see the same vertical, as far as nothing accelerates; that leaves the heading of one
sensor against the other. A hinge's axis gives it. A saddle's axes allow two headings. Where axes stand too
upright to tell, and for a ball joint, four headings stand for all.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from estimators.body.joint_constraints import HINGE, SADDLE
from fesloop.hand import quaternion

Array = NDArray[np.float64]
ANY = 4
"""How many headings stand for all: a filter finds its way from an eighth of a turn away (chosen)."""
ANY_SD = math.pi / 4.0
"""Sd of each of them, rad: a share that overlaps with its neighbours' (chosen)."""
_KNOWN = 0.5
"""Sd of a heading, rad, below which axes are believed to tell it (chosen)."""


def first_orientations(kind: int, axes: Array, up: Array, axis_sd: float) -> tuple[Array, float]:
    """Child to parent, (h, 4), the nearest to the joint's zero first, and the sd of each's heading, rad.

    h is 1 for a hinge, 2 for a saddle, `ANY` where the heading cannot be told.

    Parameters
    ----------
    kind: HINGE, SADDLE or BALL.
    axes: (2, 3), in the parent's and in the child's frame.
    up: (2, 3), the specific force of parent and child, each in its own frame, not zero.
    axis_sd: of the axes' directions, rad.
    """
    up = up / np.linalg.norm(up, axis=1, keepdims=True)
    level = [_level(each) for each in up]
    levelled = [quaternion.rotate(q, axis) for q, axis in zip(level, axes, strict=True)]
    headings, sd = _headings(kind, levelled, axis_sd)
    found = [quaternion.multiply(quaternion.conjugate(level[0]),
                                 quaternion.multiply(quaternion.about_z(h), level[1])) for h in headings]
    found.sort(key=lambda q: float(quaternion.rotation_angle(q)))
    return np.array(found), sd


def orientation_in_pose(pose: Array, up: Array) -> Array:
    """Child to parent, (4,), inclined as one sample of each shows, its heading that of a known pose.

    Parameters
    ----------
    pose: (4,), child to parent as the joint is known to stand.
    up: (2, 3), the specific force of parent and child, each in its own frame, not zero.
    """
    up = up / np.linalg.norm(up, axis=1, keepdims=True)
    parent, child = (_level(each) for each in up)
    told = quaternion.multiply(quaternion.multiply(parent, pose), quaternion.conjugate(child))
    turned = quaternion.multiply(quaternion.about_z(quaternion.twist_z(told)), child)
    return quaternion.multiply(quaternion.conjugate(parent), turned)


def _headings(kind: int, axes: list[Array], axis_sd: float) -> tuple[list[float], float]:
    """Headings of the child against the parent, rad, from their axes in level frames, and their sd."""
    (x, y, up), (child_x, child_y, child_up) = (axis.tolist() for axis in axes)
    first = math.atan2(y, x) - math.atan2(child_y, child_x)
    lengths = math.hypot(x, y), math.hypot(child_x, child_y)
    if kind == HINGE and axis_sd < _KNOWN * min(lengths):
        return [first], axis_sd / min(lengths)
    if kind == SADDLE:
        # With the child turned by h the product of the axes is l0 l1 cos(h - first) + z0 z1 = 0.
        across = lengths[0] * lengths[1]
        cosine = min(1.0, max(-1.0, -up * child_up / max(across, 1e-9)))
        slope = across * math.sqrt(1.0 - cosine ** 2)
        if axis_sd < _KNOWN * slope:
            away = math.acos(cosine)
            return [first + away, first - away], axis_sd / slope
    return [first + 2.0 * math.pi * i / ANY for i in range(ANY)], ANY_SD


def _level(up: Array) -> Array:
    """The least rotation of a frame that makes `up` (3,), unit, its z, (4,)."""
    if up[2] < -1.0 + 1e-9:
        return np.array([0.0, 1.0, 0.0, 0.0])
    return quaternion.normalized(np.array([1.0 + up[2], up[1], -up[0], 0.0]))
