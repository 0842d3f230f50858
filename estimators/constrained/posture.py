"""Outputs of the tracker from its joint filters: orientations, joint angles and their sd."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from estimators.body.joint_constraints import BALL, HINGE, SADDLE
from estimators.body.misalignment import add_misalignment, evidence_scale
from estimators.constrained.agreement import TILTS
from estimators.constrained.vectors import components, cross, dot, rotated, store, turn_by
from fesloop.compiled import compiled
from fesloop.hand.quaternion_kernels import (
    conjugate,
    euler_x_of_zxy,
    euler_y_of_zxy,
    euler_z_of_zxy,
    multiply,
)


@compiled
def joint_angles(q: Any, kind: int, axes: Any, zero: Any) -> Any:
    """Angles of a joint, rad, and their derivatives by the rotation t: three each, the free ones first."""
    quat = components(q)
    nothing = (0.0, 0.0, 0.0)
    if kind == HINGE:
        a = (axes[0, 0], axes[0, 1], axes[0, 2])
        r = multiply(quat, conjugate(components(zero)))
        about = dot(a, (r[1], r[2], r[3]))
        sign = 1.0 if r[0] >= 0.0 else -1.0
        angle = 2.0 * math.atan2(sign * about, sign * r[0])
        return (angle, 0.0, 0.0), (rotated(conjugate(quat), a), nothing, nothing)
    if kind == SADDLE:
        a, b = (axes[0, 0], axes[0, 1], axes[0, 2]), (axes[1, 0], axes[1, 1], axes[1, 2])
        n = cross(a, b)
        u, v = rotated(quat, b), rotated(conjugate(quat), a)
        first, second = math.atan2(dot(u, n), dot(u, b)), math.atan2(dot(v, n), dot(v, a))
        return (first, second, 0.0), (v, b, nothing)
    flexion, abduction, pronation = euler_z_of_zxy(quat), euler_x_of_zxy(quat), euler_y_of_zxy(quat)
    by_z = rotated(conjugate(quat), (0.0, 0.0, 1.0))
    by_x = (math.cos(pronation), 0.0, math.sin(pronation))
    by_y = (0.0, 1.0, 0.0)
    r_z, r_x, r_y = cross(by_x, by_y), cross(by_y, by_z), cross(by_z, by_x)
    volume = dot(by_z, r_z)
    # At the pole flexion and pronation are undefined; there the derivative is large, not infinite.
    scale = volume / (volume * volume + 1e-6)
    return (flexion, abduction, pronation), (
        (scale * r_z[0], scale * r_z[1], scale * r_z[2]),
        (scale * r_x[0], scale * r_x[1], scale * r_x[2]),
        (scale * r_y[0], scale * r_y[1], scale * r_y[2]))


@compiled
def _allowed(q: Any, kind: int, axes: Any, share: float) -> Any:
    """Remove `share` of the forbidden part of q by the smallest rotation that does so."""
    if kind == BALL:
        return q
    a = (axes[0, 0], axes[0, 1], axes[0, 2])
    u = rotated(q, (axes[1, 0], axes[1, 1], axes[1, 2]))
    cosine = dot(a, u)
    across = cross(u, a)
    sine = math.sqrt(dot(across, across))
    if sine < 1e-9:
        return q
    away = math.atan2(sine, cosine) - (0.0 if kind == HINGE else 0.5 * math.pi)
    scale = share * away / sine
    return multiply(turn_by(scale * across[0], scale * across[1], scale * across[2]), q)


@compiled
def posture(
    roots: Any, q: Any, covariance: Any, doubt: Any, root_of: Any, ends: Any, kinds: Any, axes: Any,
    zero: Any, first_angle: Any, angles: int, pair_sd: float, axis_sd: float, pair: Any, growing: Any,
    scale: float
) -> Any:
    """Posture of the whole tree from its joint filters.

    Returns orientations (n, 4); angles (angles,), and their sds and those of random errors only, (2, angles),
    rad, zero and pi for angles without a joint; relative orientations (joints, 4), without their forbidden
    part; and the largest sd of each joint (joints,), rad, infinite for an unknown one.

    Parameters
    ----------
    roots: (roots, 4), orientation of the sensors `root_of` (roots,).
    q, covariance: of the joints' filters; q is NaN for a joint that has not begun.
    doubt: (joints,), rad, sd of a heading that is undecided.
    ends, kinds, axes, zero, first_angle: as in JointTable. angles: number of all angles.
    pair_sd, axis_sd: sds about each axis of one sensor's mounting relative to the other's, and of the joint's
        axes, rad.
    pair, growing: (joints,), variances of misalignment, as in `estimators.body.misalignment`, rad^2.
    scale: of these, as motion shows.
    """
    whole = np.empty((3, 3))
    orientation, relative = np.empty((roots.shape[0] + ends.shape[0], 4)), np.empty((ends.shape[0], 4))
    values, sds = np.zeros(angles), np.full((2, angles), math.pi)
    worst = np.zeros(ends.shape[0])
    for i in range(roots.shape[0]):
        orientation[root_of[i]] = roots[i]
    share = mounting_share(pair_sd, axis_sd)
    for j in range(ends.shape[0]):
        begun = q[j, 0] * 0.0 == 0.0
        between = _allowed(components(q[j]), kinds[j], axes[j], share) if begun else components(zero[j])
        store(relative[j], between)
        store(orientation[ends[j, 1]], multiply(components(orientation[ends[j, 0]]), between))
        if not begun:
            worst[j] = math.inf
            continue
        found, rows = joint_angles(between, kinds[j], axes[j], zero[j])
        whole[:] = covariance[j, :3, :3]
        add_misalignment(between, scale * pair[j], scale * growing[j], whole)
        for i in range(kinds[j] + 1):
            row = rows[i]
            random, variance = doubt[j] ** 2, doubt[j] ** 2
            for a in range(3):
                for b in range(3):
                    random += row[a] * covariance[j, a, b] * row[b]
                    variance += row[a] * whole[a, b] * row[b]
            sd = min(math.sqrt(variance), math.pi)
            values[first_angle[j] + i] = found[i]
            sds[0, first_angle[j] + i] = sd
            sds[1, first_angle[j] + i] = min(math.sqrt(random), math.pi)
            worst[j] = max(worst[j], sd)
    return orientation, values, sds, relative, worst


@compiled
def mounting_scale(rest: Any, covariance: Any, kinds: Any, axis_variance: float) -> float:
    """Scale of the misalignment's variance that the tilts of the axes show (`evidence_scale`).

    `axis_variance` is that of an axis before any motion, rad^2, both sensors together.
    """
    squares, seen, before = 0.0, 0.0, 0.5 * axis_variance
    for j in range(kinds.size):
        if kinds[j] != BALL:
            for i in range(4):
                squares += rest[j, 13 + i] ** 2 / before
                seen += max(0.0, 1.0 - covariance[j, TILTS + i, TILTS + i] / before)
    return evidence_scale(squares, seen)


@compiled
def mounting_share(pair_sd: float, axis_sd: float) -> float:
    """Share of a forbidden rotation that is due to the sensors' mounting, not to tilted axes."""
    return pair_sd ** 2 / (pair_sd ** 2 + axis_sd ** 2)
