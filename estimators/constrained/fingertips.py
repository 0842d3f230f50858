"""Fingertips from the joints' relative orientations, and their sd with errors that joints share.

To first order a fingertip moves by L_k e_k for each segment k between it and the root, where e_k is the
error of the rotation of k relative to its parent, in k's frame, and L_k e = (R_k e) x r, r from k's joint
to the tip. A sensor's mounting error m_k enters at its own joint and, with the opposite sign, at the next
one, so that it rotates one bone and not all bones beyond it:

    e_k = A_k (m_k - R_k' m_parent) + f_k

where A_k removes a share of the part of an error that the joint forbids, and f_k is the filter's own error.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.body.body import UNSEEN_SD, Body, chain_up, place_tips
from estimators.body.joint_constraints import BALL, HINGE, JointTable
from estimators.constrained.posture import mounting_share
from estimators.constrained.vectors import components, cross, rotated
from fesloop.compiled import compiled
from fesloop.hand.quaternion_kernels import conjugate

Numbers = NDArray[np.int64]


def moving_joints(body: Body, table: JointTable) -> Numbers:
    """Number of the joint in `table` that moves each segment, (segments,), -1 for none; read-only."""
    joints = np.full(len(body.tree.segments), -1, dtype=np.int64)
    joints[body.sensed[table.ends[:, 1]]] = np.arange(len(table.ends))
    joints.flags.writeable = False
    return joints


@compiled
def fingertip_posture(
    layout: Any, geometry: Any, tips: Any, joint_of: Any, relative: Any, q: Any, covariance: Any, doubt: Any,
    kinds: Any, axes: Any, pair_sd: float, axis_sd: float
) -> Any:
    """Fingertips and their sds, (t, 3) each, m, in the root's frame.

    Parameters
    ----------
    layout, geometry: of the SegmentTree.
    tips: (t,), the segments that end in a fingertip.
    joint_of: (segments,), as returned by `moving_joints`.
    relative: (joints, 4), as returned by `posture`.
    q, covariance, doubt, kinds, axes, pair_sd, axis_sd: as in `posture`.
    """
    count = layout.shape[0]
    turns, orientations, positions = np.zeros((count, 4)), np.empty((count, 4)), np.zeros((count, 3))
    kept, own = np.zeros((count, 3, 3)), np.zeros((count, 3, 3))
    turns[:, 0] = 1.0
    for k in range(count):
        j = joint_of[k]
        if j >= 0 and q[j, 0] * 0.0 == 0.0:
            turns[k] = relative[j]
            _spread_of(relative[j], covariance[j], doubt[j], kinds[j], axes[j], pair_sd, axis_sd,
                       kept[k], own[k])
        else:
            _spread_unseen(geometry[k], layout[k, 1], own[k])
    chain_up(layout, turns, orientations)
    places, sd = np.empty((tips.size, 3)), np.empty((tips.size, 3))
    place_tips(layout, geometry, orientations, tips, positions, places)
    for i in range(tips.size):
        _spread_tip(layout, geometry, orientations, positions, turns, kept, own, tips[i],
                    0.5 * pair_sd ** 2, sd[i])
    return places, sd


@compiled
def _spread_of(
    relative: Any, covariance: Any, doubt: float, kind: int, axes: Any, pair_sd: float, axis_sd: float,
    kept: Any, own: Any
) -> None:
    """Write A_k into `kept` and the covariance of f_k into `own`, (3, 3) each, for a joint that is seen."""
    share = mounting_share(pair_sd, axis_sd)
    a = (axes[1, 0], axes[1, 1], axes[1, 2])
    if kind != HINGE:
        # The axis about which a saddle cannot rotate; a ball joint has none.
        parent = (axes[0, 0], axes[0, 1], axes[0, 2])
        a = cross(a, rotated(conjugate(components(relative)), parent))
    for i in range(3):
        for k in range(3):
            one = 1.0 if i == k else 0.0
            forbidden = 0.0 if kind == BALL else one - a[i] * a[k] if kind == HINGE else a[i] * a[k]
            kept[i, k] = one - share * forbidden
            own[i, k] = (share * axis_sd) ** 2 * forbidden + doubt ** 2 * one
    for i in range(3):
        for c in range(3):
            left = 0.0
            for b in range(3):
                left += kept[i, b] * covariance[b, c]
            for k in range(3):
                own[i, k] += left * kept[k, c]


@compiled
def _spread_unseen(geometry: Any, freedoms: int, own: Any) -> None:
    """Add the covariance of unknown angles of a joint's freedoms to `own`."""
    for f in range(freedoms):
        for i in range(3):
            for k in range(3):
                own[i, k] += UNSEEN_SD ** 2 * geometry[f, i] * geometry[f, k]


@compiled
def _spread_tip(
    layout: Any, geometry: Any, orientations: Any, positions: Any, turns: Any, kept: Any, own: Any, tip: int,
    mounted: float, sd: Any
) -> None:
    """Write `sd` (3,) of one tip; `mounted` is the variance of a sensor's mounting about each axis, rad^2."""
    lever, through, beyond = np.empty((3, 3)), np.empty((3, 3)), np.zeros((3, 3))
    variance = np.zeros(3)
    k = tip
    while True:
        root = layout[k, 0] < 0
        if not root:
            _lever(components(orientations[k]), positions[tip], positions[k], geometry[k, 4], lever)
        back = conjugate(components(turns[k]))
        for i in range(3):
            for a in range(3):
                through[i, a] = 0.0
                if not root:
                    for b in range(3):
                        through[i, a] += lever[i, b] * kept[k, b, a]
                        variance[i] += lever[i, a] * own[k, a, b] * lever[i, b]
                variance[i] += mounted * (through[i, a] - beyond[i, a]) ** 2
        if root:
            break
        forward = conjugate(back)
        for i in range(3):
            # A row times R_k' is the row rotated by R_k, into the parent's frame.
            row = rotated(forward, (through[i, 0], through[i, 1], through[i, 2]))
            beyond[i, 0], beyond[i, 1], beyond[i, 2] = row
        k = layout[k, 0]
    for i in range(3):
        sd[i] = math.sqrt(variance[i])


@compiled
def _lever(turn: Any, tip: Any, frame: Any, offset: Any, lever: Any) -> None:
    """Write L_k (3, 3): motion of the tip per small rotation of a segment about its joint, in its frame."""
    bone = rotated(turn, (offset[0], offset[1], offset[2]))
    r = (tip[0] - frame[0] + bone[0], tip[1] - frame[1] + bone[1], tip[2] - frame[2] + bone[2])
    for a in range(3):
        axis = rotated(turn, (1.0 if a == 0 else 0.0, 1.0 if a == 1 else 0.0, 1.0 if a == 2 else 0.0))
        lever[0, a], lever[1, a], lever[2, a] = cross(axis, r)
