"""A hand on a given path, compiled: posture, fingertips and what sensor sites go through, at any instants."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.hand.kinematics_kernels import forward, turned
from fesloop.hand.motion import STANDARD_GRAVITY, motions, sense
from fesloop.hand.quaternion_kernels import conjugate, multiply

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
_AT_REFERENCE = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])


@compiled
def follow(knots: Array, knot_ns: int, time_ns: int, columns: Array) -> None:
    """Fill `columns` (3, c): value, rate, acceleration at an instant of quintic pieces between knots.

    `knots` (k, 3, c) hold the same at the knots, per second. After the last one the path stands still.
    """
    last = knots.shape[0] - 1
    k = min(time_ns // knot_ns, last)
    if k == last:
        columns[0] = knots[last, 0]
        columns[1:] = 0.0
        return
    h = 1e-9 * knot_ns
    u = (time_ns - k * knot_ns) / knot_ns
    for c in range(knots.shape[2]):
        q0, v0, a0 = knots[k, 0, c], h * knots[k, 1, c], h * h * knots[k, 2, c]
        gap = knots[k + 1, 0, c] - q0 - v0 - 0.5 * a0
        slope = h * knots[k + 1, 1, c] - v0 - a0
        bend = h * h * knots[k + 1, 2, c] - a0
        c3 = 10.0 * gap - 4.0 * slope + 0.5 * bend
        c4 = -15.0 * gap + 7.0 * slope - bend
        c5 = 6.0 * gap - 3.0 * slope + 0.5 * bend
        columns[0, c] = q0 + u * (v0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5))))
        columns[1, c] = (v0 + u * (a0 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h
        columns[2, c] = (a0 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / (h * h)


@compiled
def observe_rows(
    layout: Numbers, geometry: Array, knots: Array, knot_ns: int, room: Array, segments: Numbers,
    places: Array, tips: Numbers, times_ns: Numbers, postures: Array, fingertips: Array, orientations: Array,
    positions: Array, samples: Array,
) -> None:
    """Fill rows for each of `times_ns` (t,).

    Parameters
    ----------
    layout, geometry: of the tree whose segments 0 and 1 are room and forearm, joined by a ball.
    room: (4,), orientation of the room's frame, in which the forearm's turn is 0, to the global one.
    segments, places: (m,) and (m, 3), of the sites. tips: (f,), segments of the fingertips.
    postures: (t, 3, d), angles, rates, accelerations of the hand's freedoms.
    fingertips: (t, f, 3), m, in the forearm's frame.
    orientations, positions: (t, m, 4) and (t, m, 3), m, of the sites, to and in the global frame.
    samples: (t, 2, m, 3), angular velocity and specific force in the segments' frames.
    """
    count, wide = layout.shape[0], knots.shape[2]
    columns, poses = np.empty((3, wide)), np.empty((count, 7))
    chain, work, root = np.empty((count, 3, 3)), np.empty((3, 3)), np.zeros((3, 3))
    to_global = (room[0], room[1], room[2], room[3])
    for t in range(times_ns.size):
        follow(knots, knot_ns, times_ns[t], columns)
        moving = columns[:, :wide - 3]
        root[2, 0], root[2, 1], root[2, 2] = turned(
            conjugate(to_global), columns[2, wide - 3], columns[2, wide - 2],
            columns[2, wide - 1] + STANDARD_GRAVITY)
        motions(layout, geometry, moving[0], moving[1], moving[2], root, chain)
        sense(chain, segments, places, work, samples[t])
        forward(layout, geometry, moving[0], _AT_REFERENCE, poses)
        postures[t] = moving[:, 3:]
        _place_sites(poses, to_global, columns[0, wide - 3:], segments, places, orientations[t], positions[t])
        wrist = poses[1]
        back = conjugate((wrist[0], wrist[1], wrist[2], wrist[3]))
        for i in range(tips.size):
            tip = poses[tips[i]]
            fingertips[t, i, 0], fingertips[t, i, 1], fingertips[t, i, 2] = turned(
                back, tip[4] - wrist[4], tip[5] - wrist[5], tip[6] - wrist[6])


@compiled
def _place_sites(
    poses: Array, to_global: tuple[float, float, float, float], shift: Array, segments: Numbers,
    places: Array, orientations: Array, positions: Array
) -> None:
    for i in range(segments.size):
        pose, place = poses[segments[i]], places[i]
        q = (pose[0], pose[1], pose[2], pose[3])
        whole = multiply(to_global, q)
        size = 1.0 / math.sqrt(whole[0] ** 2 + whole[1] ** 2 + whole[2] ** 2 + whole[3] ** 2)
        for j in range(4):
            orientations[i, j] = size * whole[j]
        x, y, z = turned(q, place[0], place[1], place[2])
        x, y, z = turned(to_global, pose[4] + x, pose[5] + y, pose[6] + z)
        positions[i, 0], positions[i, 1], positions[i, 2] = x + shift[0], y + shift[1], z + shift[2]
