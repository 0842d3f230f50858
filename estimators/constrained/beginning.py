"""Start of a joint's filter: one hypothesis for every relative orientation that its first samples allow.

Each joint has up to `ANY` equal filters, hypotheses of its heading, the likeliest first. A hypothesis is
dropped when the measurements are too unlikely under it, or when it coincides with a likelier one; with one
left, the joint costs one filter. (A single linearised filter that starts at the wrong one of a saddle's two
headings may stay there.)
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.body.joint_constraints import HINGE, SADDLE, JointTable
from estimators.constrained.agreement import COLUMNS
from estimators.constrained.measurements import N
from estimators.constrained.vectors import components
from fesloop.compiled import compiled
from fesloop.hand import quaternion
from fesloop.hand.quaternion_kernels import conjugate, multiply, rotation_angle

Array = NDArray[np.float64]
ANY = 4
"""Number of hypotheses for an unknown heading: a filter converges from an eighth of a turn away (chosen)."""
ANY_SD = math.pi / 4.0
"""Sd of each of them, rad, so that neighbours overlap (chosen)."""
_KNOWN = 0.5
"""Sd of a heading, rad, below which axes determine it (chosen)."""


def first_orientations(kind: int, axes: Array, up: Array, axis_sd: float) -> tuple[Array, float]:
    """Orientations child to parent, (h, 4), nearest to the joint's zero first, and their headings' sd, rad.

    h is 1 for a hinge, 2 for a saddle, `ANY` where the heading is unknown.

    Parameters
    ----------
    kind: HINGE, SADDLE or BALL.
    axes: (2, 3), in the parent's and in the child's frame.
    up: (2, 3), the specific force of parent and child, each in its own frame, not zero.
    axis_sd: sd of the axes' directions, rad.
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
    """Orientation child to parent, (4,), with the inclination of one sample each and a known pose's heading.

    Parameters
    ----------
    pose: (4,), known orientation child to parent.
    up: (2, 3), the specific force of parent and child, each in its own frame, not zero.
    """
    up = up / np.linalg.norm(up, axis=1, keepdims=True)
    parent, child = (_level(each) for each in up)
    told = quaternion.multiply(quaternion.multiply(parent, pose), quaternion.conjugate(child))
    turned = quaternion.multiply(quaternion.about_z(quaternion.twist_z(told)), child)
    return quaternion.multiply(quaternion.conjugate(parent), turned)


def _headings(kind: int, axes: list[Array], axis_sd: float) -> tuple[list[float], float]:
    """Headings of the child relative to the parent, rad, from their axes in level frames, and their sd."""
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
    """Least rotation, (4,), of a frame that makes `up` (3,), unit, its z."""
    if up[2] < -1.0 + 1e-9:
        return np.array([0.0, 1.0, 0.0, 0.0])
    return quaternion.normalized(np.array([1.0 + up[2], up[1], -up[0], 0.0]))


_DECISIVE = 2.0 * np.log(1000.0)
"""Twice the log of the odds at which a hypothesis is dropped (chosen: one wrong in a thousand)."""
_WORTH = 0.2
"""Weight of the log likelihood: errors of mounting, axes and lever arms last as long as a movement, half a
second, five times `force_time_s` (chosen)."""
_MET = np.radians(10.0)
"""Distance below which two hypotheses are one, rad (chosen: well within the convergence of a filter)."""
_FIRST_TILT = 0.3
"""Sd of the first sample's vertical, rad: 3 m/s^2 of acceleration against gravity (chosen)."""


class Unknown(NamedTuple):
    """Initial uncertainty of a joint.

    axis_sd: sd of its axes in the sensors' frames, rad, both together; bias_sd: sd of a gyroscope's bias,
        rad/s;
    levers, lever_sd: (joints, 6), expected lever arms of parent and child in their frames, and the sd of each
        component, m.
    pose: (joints, 4), child to parent in the initial pose, or None; pose_sd: sd of its headings, rad.
    """

    axis_sd: float
    bias_sd: float
    levers: Array
    lever_sd: Array
    pose: Array | None = None
    pose_sd: float = 0.0


@dataclass(slots=True, eq=False)
class Hypotheses:
    """Filters of all joints: arrays (ANY, joints, ...), the likeliest hypothesis first.

    Attributes
    ----------
    q: (ANY, joints, 4), child to parent; NaN where there is no hypothesis.
    rest: (ANY, joints, COLUMNS); covariance: (ANY, joints, 16, 16), as in `constrained.filter.advance`.
    surprise: (ANY, joints), minus twice the log likelihood of all measurements since the beginning.
    doubt: (joints,), rad, rms distance of the hypotheses from the first one, weighted by likelihood.
    open: whether any joint has more than one.
    """

    q: Array
    rest: Array
    covariance: Array
    surprise: Array
    doubt: Array
    open: bool = False

    @classmethod
    def none(cls, joints: int) -> Hypotheses:
        """Filters without any hypothesis."""
        return cls(np.full((ANY, joints, 4), np.nan), np.zeros((ANY, joints, COLUMNS)),
                   np.zeros((ANY, joints, N, N)), np.zeros((ANY, joints)), np.zeros(joints))


def begin_missing(
    found: Hypotheses, table: JointTable, acc: Array, sound: NDArray[np.bool_], unknown: Unknown,
    in_pose: bool
) -> None:
    """Start the filters of unknown joints whose axes are known where both sensors' samples are sound.

    Parameters
    ----------
    acc: (n, 3), m/s^2, newest samples.
    sound: (n,), mask of the sound ones.
    unknown: initial uncertainty.
    in_pose: whether the initial pose lasts.
    """
    both = sound[table.ends].all(axis=1)
    for j in np.flatnonzero(both & table.known & np.isnan(found.q[0, :, 0])):
        _begin(found, int(j), table, acc[table.ends[j]], unknown, in_pose)


def _begin(
    found: Hypotheses, j: int, table: JointTable, up: Array, unknown: Unknown, in_pose: bool
) -> None:
    axis_sd, bias_sd, levers, lever_sd, pose, pose_sd = unknown
    kind, told_sd = int(table.kinds[j]), math.hypot(axis_sd, _FIRST_TILT)
    upright_sd = _FIRST_TILT
    if in_pose and pose is not None:
        orientations, heading_sd = orientation_in_pose(pose[j], up)[np.newaxis], pose_sd
        upright_sd = 0.0
    else:
        orientations, heading_sd = first_orientations(kind, table.axes[j], up, told_sd)
    count = len(orientations)
    vertical = up[1] / np.linalg.norm(up[1])
    found.q[:, j] = np.nan
    found.q[:count, j] = orientations
    found.rest[:, j] = 0.0
    found.rest[:, j, 3:9], found.rest[:, j, 9:12] = levers[j], up[1]
    variances = np.concatenate([np.repeat([0.0, 2.0 * bias_sd ** 2], 3), lever_sd[j] ** 2,
                                np.full(4, 0.5 * axis_sd ** 2)])
    found.covariance[:, j] = np.diag(variances)
    about = np.outer(vertical, vertical)
    found.covariance[:, j, :3, :3] = (
        _FIRST_TILT ** 2 * (np.eye(3) - about) + (heading_sd ** 2 + upright_sd ** 2) * about)
    found.surprise[:, j] = 0.0
    found.open |= count > 1


@compiled
def weigh(q: Any, rest: Any, covariance: Any, surprise: Any, doubt: Any) -> bool:
    """Sort hypotheses by likelihood, drop unlikely ones, fill `doubt`; return whether any joint is open.

    The arrays are those of Hypotheses.
    """
    undecided = False
    for j in range(q.shape[1]):
        doubt[j] = 0.0
        best = 0
        for h in range(1, ANY):
            # 0 x is 0 for finite x alone.
            if q[h, j, 0] * 0.0 == 0.0 and surprise[h, j] < surprise[best, j]:
                best = h
        if best > 0:
            _exchange(q[0, j], q[best, j])
            _exchange(rest[0, j], rest[best, j])
            for a in range(N):
                _exchange(covariance[0, j, a], covariance[best, j, a])
            surprise[0, j], surprise[best, j] = surprise[best, j], surprise[0, j]
        total, apart = 1.0, 0.0
        for h in range(1, ANY):
            if q[h, j, 0] * 0.0 != 0.0:
                continue
            worse = _WORTH * (surprise[h, j] - surprise[0, j])
            angle = rotation_angle(multiply(conjugate(components(q[0, j])), components(q[h, j])))
            if worse > _DECISIVE or angle < _MET:
                q[h, j, :] = np.nan
                continue
            weight = np.exp(-0.5 * worse)
            total += weight
            apart += weight * angle ** 2
            undecided = True
        doubt[j] = np.sqrt(apart / total)
    return undecided


@compiled
def _exchange(a: Any, b: Any) -> None:
    for i in range(a.size):
        a[i], b[i] = b[i], a[i]
