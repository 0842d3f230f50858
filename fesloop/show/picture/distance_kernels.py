"""Signed distances to a hand's flesh and to solids, compiled.

Blending is Quilez's quadratic smooth minimum.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
Vector = tuple[float, float, float]
FAR = 1e3
BOX, CYLINDER, BALL = 0, 1, 2
"""Kinds of solids."""


@compiled
def bar_distance(p: Vector, bar: Array) -> float:
    """From a point to a bar's skin, m, negative inside."""
    ax, ay, az = p[0] - bar[0], p[1] - bar[1], p[2] - bar[2]
    bx, by, bz = bar[3] - bar[0], bar[4] - bar[1], bar[5] - bar[2]
    square = bx * bx + by * by + bz * bz
    share = min(1.0, max(0.0, (ax * bx + ay * by + az * bz) / square)) if square > 0.0 else 0.0
    x, y, z = ax - share * bx, ay - share * by, az - share * bz
    return float(math.sqrt(x * x + y * y + z * z) - bar[6] - share * (bar[7] - bar[6]))


@compiled
def blended(a: float, b: float, reach: float) -> float:
    """The smaller of two distances, rounded where they differ by less than `reach`."""
    overlap = max(reach - abs(a - b), 0.0) / reach
    return min(a, b) - 0.25 * reach * overlap * overlap


@compiled
def flesh_distance(
    p: Vector, bars: Array, groups: Numbers, blends: Array, near: Numbers, count: int
) -> float:
    """From a point to the flesh of the bars that `near` lists, m."""
    least, of_group, group = FAR, FAR, -1
    for i in range(count):
        bar = near[i]
        distance = bar_distance(p, bars[bar])
        if groups[bar] == group:
            of_group = blended(of_group, distance, blends[group])
        else:
            least = min(least, of_group)
            group, of_group = groups[bar], distance
    return min(least, of_group)


@compiled
def solid_distance(p: Vector, solid: Array) -> float:
    """From a point to a solid: kind, position, rotation matrix to the global frame, half sizes; m."""
    dx, dy, dz = p[0] - solid[1], p[1] - solid[2], p[2] - solid[3]
    x = solid[4] * dx + solid[7] * dy + solid[10] * dz
    y = solid[5] * dx + solid[8] * dy + solid[11] * dz
    z = solid[6] * dx + solid[9] * dy + solid[12] * dz
    if solid[0] == BALL:
        return float(math.sqrt(x * x + y * y + z * z) - solid[13])
    if solid[0] == CYLINDER:
        u, v = math.sqrt(x * x + y * y) - solid[13], abs(z) - solid[14]
        return float(min(max(u, v), 0.0) + math.sqrt(max(u, 0.0) ** 2 + max(v, 0.0) ** 2))
    u, v, w = abs(x) - solid[13], abs(y) - solid[14], abs(z) - solid[15]
    outside = math.sqrt(max(u, 0.0) ** 2 + max(v, 0.0) ** 2 + max(w, 0.0) ** 2)
    return float(min(max(u, v, w), 0.0) + outside)


@compiled
def nearest(
    p: Vector, bars: Array, groups: Numbers, blends: Array, solids: Array, near: Numbers, count: int
) -> tuple[float, int]:
    """Distance to what is nearest, and what that is: 0 flesh, 1 on the solids."""
    least, surface = flesh_distance(p, bars, groups, blends, near, count), 0
    for i in range(solids.shape[0]):
        distance = solid_distance(p, solids[i])
        if distance < least:
            least, surface = distance, i + 1
    return least, surface


@compiled
def find_near(start: Vector, along: Vector, bounds: Array, reach: float, ahead: bool, near: Numbers) -> int:
    """List bars whose bounding ball (x, y, z, radius) a ray comes within `reach` of; how many."""
    count = 0
    for i in range(bounds.shape[0]):
        x, y, z = bounds[i, 0] - start[0], bounds[i, 1] - start[1], bounds[i, 2] - start[2]
        on_ray = x * along[0] + y * along[1] + z * along[2]
        radius = bounds[i, 3] + reach
        if x * x + y * y + z * z - on_ray * on_ray < radius * radius and (not ahead or on_ray > -radius):
            near[count] = i
            count += 1
    return count


@compiled
def find_about(p: Vector, bounds: Array, reach: float, near: Numbers) -> int:
    """List bars whose bounding ball is within `reach` of a point; how many."""
    count = 0
    for i in range(bounds.shape[0]):
        x, y, z = bounds[i, 0] - p[0], bounds[i, 1] - p[1], bounds[i, 2] - p[2]
        if x * x + y * y + z * z < (bounds[i, 3] + reach) ** 2:
            near[count] = i
            count += 1
    return count


@compiled
def moved(p: Vector, along: Vector, far: float) -> Vector:
    """The point `far` along a direction."""
    return p[0] + far * along[0], p[1] + far * along[1], p[2] + far * along[2]


def bounding_balls(bars: Array) -> Array:
    """(n, 4): middle and radius of a ball about each bar, m."""
    middle = 0.5 * (bars[:, :3] + bars[:, 3:6])
    half = 0.5 * np.linalg.norm(bars[:, 3:6] - bars[:, :3], axis=1)
    return np.concatenate([middle, (half + bars[:, 6:].max(axis=1))[:, np.newaxis]], axis=1)


@compiled
def flesh_distances(points: Array, bars: Array, groups: Numbers, blends: Array) -> Array:
    """From points (n, 3) to the flesh of all bars, (n,), m."""
    every = np.arange(bars.shape[0])
    distances = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        p = (points[i, 0], points[i, 1], points[i, 2])
        distances[i] = flesh_distance(p, bars, groups, blends, every, bars.shape[0])
    return distances
