"""Covariance of joint angles and fingertips due to sensors' mounting and tilted joint axes.

Both are constant while the sensors are worn: no motion averages them out, so they are added to the covariance
of a filter's own errors. With R the rotation of a joint, child to parent, v the vector part of its quaternion
and d the small rotation in R (I + [d]x), in the child's frame:

    mounting m of the sensors:  d = m_child - R' m_parent
    tilt t of the joint's axes (the true rotation T R T' instead of R):  d = (R' - I) t

A mounting error that the sensors of a strip have in common acts like a tilt. With (R' - I)(R' - I)' =
4 (v.v I - v v'), the covariance of d is

    2 (1 - c) m^2 I + 4 (c m^2 + t^2) (v.v I - v v')

with sds m and t about each axis, and c the share of m^2 that parent and child have in common.
"""

from __future__ import annotations

import math
import re
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.body.body import fill_lever
from fesloop.compiled import compiled
from fesloop.hand.kinematics_kernels import turned
from fesloop.hand.segments import SegmentTree

Array = NDArray[np.float64]
STRIP_SHARE = 0.5
"""Share of the mounting's variance that the sensors of a finger's strip have in common (chosen)."""


class Misalignment(NamedTuple):
    """Constant errors of sensors and joints; read-only.

    Attributes
    ----------
    pair: (segments,), variance about each axis of a sensor's mounting relative to its parent's, rad^2.
    growing: (segments,), variance of the errors that grow with the joint's rotation, rad^2.
    common: (segments,), variance about each axis of a sensor's mounting that is common to a strip, rad^2.
    own: (segments,), the rest of that variance, rad^2.
    fused: variance about each axis that `pair` has from fused orientations in motion, which is not constant,
        rad^2.
    """

    pair: Array
    growing: Array
    common: Array
    own: Array
    fused: float


def misalignment(
    tree: SegmentTree, mounting_sd_deg: float, axis_sd_deg: float, fusion_sd_deg: float = 0.0
) -> Misalignment:
    """Misalignment of sensors and joints with these sds about each axis, deg.

    `fusion_sd_deg` is that of errors of single sensors' orientations that are not constant. A strip has the
    sensors of one finger of a hand (segments named as `F2p`).
    """
    mounting, axis = math.radians(mounting_sd_deg) ** 2, math.radians(axis_sd_deg) ** 2
    worn = np.array([re.fullmatch(r"F\d.", name) is not None for name in tree.names])
    inside = np.array([segment.parent is not None and strip and segment.parent[:2] == segment.name[:2]
                       for segment, strip in zip(tree.segments, worn, strict=True)])
    fusion = math.radians(fusion_sd_deg) ** 2
    common, shared = STRIP_SHARE * mounting * worn, STRIP_SHARE * mounting * inside
    found = Misalignment(
        2.0 * (mounting - shared + fusion), shared + axis, common, mounting - common + fusion, 2.0 * fusion)
    for array in found[:4]:
        array.flags.writeable = False
    return found


_STATED = 2.0
"""Angles that must be seen for them to count as much as what is stated (chosen)."""


@compiled
def evidence_scale(squares: float, seen: float) -> float:
    """Scale of the stated variance of misalignment that estimated angles of misalignment show.

    Sensors that motion shows to be worn with care are so about the axes, too, about which none shows. The
    scale has the greatest evidence (MacKay 1992, doi 10.1162/neco.1992.4.3.415) with the stated variance as
    prior.

    Parameters
    ----------
    squares: sum of the squares of the estimates, each divided by its variance before any motion.
    seen: number of angles that motion shows: the sum of 1 less the share of that variance which is left.
    """
    return (_STATED + squares) / (_STATED + seen)


@compiled
def scaled(variance: float, fused: float, scale: float) -> float:
    """Variance whose constant part, all but `fused`, is multiplied by `scale`."""
    return fused + scale * (variance - fused)


@compiled
def add_misalignment(q: Any, pair: float, growing: float, covariance: Any) -> None:
    """Add to `covariance` (3, 3) that of the rotation q (4,) of a joint, child to parent, in q's frame."""
    x, y, z = q[1], q[2], q[3]
    square = x * x + y * y + z * z
    for i in range(3):
        for j in range(3):
            covariance[i, j] -= 4.0 * growing * q[1 + i] * q[1 + j]
        covariance[i, i] += pair + 4.0 * growing * square


@compiled
def add_to_tips(
    layout: Any, geometry: Any, orientations: Any, positions: Any, tips: Any, sensors: Any,
    wrong: Misalignment, scale: float, variance: Any
) -> None:
    """Add to `variance` (t, 3), m^2, that of fingertips in the root's frame due to the sensors' mounting.

    A sensor's mounting turns its own bone, that of the innermost one everything beyond its segment the other
    way. Tilted axes do not move a tip, as orientations are measured.

    Parameters
    ----------
    orientations, positions: (n, 4) and (n, 3), segments in the root's frame.
    sensors: (n,), sensor of each segment, -1 for none: its joint and those before it are left out.
    scale: of the constant part of the mounting's variance.
    """
    lever, strip, point, joint = np.empty((3, 3)), np.zeros((3, 3)), np.empty(3), np.empty(3)
    fused = 0.5 * wrong.fused  # `own` is of one sensor
    for t in range(tips.size):
        tip, k = tips[t], tips[t]
        strip[:] = 0.0
        point[:] = positions[tip]
        while layout[k, 0] >= 0 and sensors[k] >= 0 and sensors[layout[k, 0]] >= 0:
            q, offset = orientations[k], geometry[k, 4]
            fill_lever(q, offset, positions[k], point, lever)
            own, shared = scaled(wrong.own[k], fused, scale), wrong.common[k] > 0.0
            for x in range(3):
                for a in range(3):
                    strip[x, a] += lever[x, a] if shared else 0.0
                    variance[t, x] += own * lever[x, a] ** 2
            joint[0], joint[1], joint[2] = turned((q[0], q[1], q[2], q[3]), offset[0], offset[1], offset[2])
            for x in range(3):
                point[x] = positions[k, x] - joint[x]
            k = layout[k, 0]
        if k == tip:
            continue
        for x in range(3):
            point[x] = positions[tip, x] - point[x]
        square = point[0] ** 2 + point[1] ** 2 + point[2] ** 2
        own = scaled(wrong.own[k], fused, scale) + scale * wrong.common[k]
        for x in range(3):
            variance[t, x] += own * (square - point[x] ** 2)
            for a in range(3):
                variance[t, x] += scale * wrong.common[tip] * strip[x, a] ** 2
