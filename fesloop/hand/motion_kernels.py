"""What inertial sensors on a segment tree feel, by recursion from the root outwards, compiled.

`layout` and `geometry` are those of a `SegmentTree`. A motion (3, 3) has the rows angular velocity, rad/s,
angular acceleration, rad/s^2, and specific force (acceleration less gravity), m/s^2, all in the coordinates
of the segment it belongs to. Arrays that are filled come last.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled

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
