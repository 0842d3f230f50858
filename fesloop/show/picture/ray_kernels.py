"""Rays against flesh and solids: sphere tracing of signed distances, compiled.

A ray advances by its distance to the nearest surface until there is none left (Hart 1996,
doi 10.1007/s003710050084).
"""

from __future__ import annotations

import math

import numpy as np

from fesloop.compiled import compiled
from fesloop.show.picture.distance_kernels import (
    FAR,
    Array,
    Numbers,
    Vector,
    bar_distance,
    find_about,
    find_near,
    moved,
    nearest,
)

NEAR_ENOUGH_M, CAUTION, MOST_STEPS = 1e-4, 0.9, 200
"""A surface is met within this; bars that taper are a little nearer than their distance says."""
_TILE = 8
"""Pixels of a side of the squares that rays are begun for together."""
_ALIKE_M = 1e-3
"""Of two by two pixels those that lie no deeper apart share their light: it changes slowly."""
_NUDGE = 2e-4
"""Half the base, m, over which a surface's slope is taken."""
_SHADE_M = 0.02
"""Within this of a point, flesh takes ambient light from it (chosen)."""
_SHADOW_M, _PENUMBRA_M = 0.35, 0.03
"""How far shadows are thrown, and how far from what throws them they are half-shadows (chosen)."""
_SOFTNESS = 14.0
"""Distance over gap at which a light that is passed close by is in full (chosen: a large lamp)."""


@compiled
def march(
    start: Vector, along: Vector, begin: float, length: float, room: float, keep: float, bars: Array,
    groups: Numbers, blends: Array, solids: Array, near: Numbers, count: int,
) -> tuple[float, int]:
    """How far a ray gets from `begin` on until a surface is within `room`, and which; -1 for none.

    It comes no nearer to a surface than `keep`, which is less than `room`.
    """
    if not count and not solids.size:
        return length, -1
    far = begin
    for _ in range(MOST_STEPS):
        gap, surface = nearest(moved(start, along, far), bars, groups, blends, solids, near, count)
        if gap < room:
            return far, surface
        far += CAUTION * (gap - keep)
        if far > length:
            break
    return length, -1


@compiled
def lit_share(
    start: Vector, light: Vector, bars: Array, groups: Numbers, blends: Array, solids: Array,
    near: Numbers, count: int,
) -> float:
    """Share of a large lamp's light that comes through, by how closely the ray to it passes what is there."""
    if not count and not solids.size:
        return 1.0
    share, far = 1.0, 2e-3
    for _ in range(48):
        gap, _ = nearest(moved(start, light, far), bars, groups, blends, solids, near, count)
        share = min(share, 0.5 + 0.5 * _SOFTNESS * gap / far)
        if share <= 0.0 or far > _SHADOW_M:
            break
        far += min(0.06, max(2e-3, gap))
    share = max(share, 0.0)
    return share * share * (3.0 - 2.0 * share)


@compiled
def find_normal(
    p: Vector, bars: Array, groups: Numbers, blends: Array, solids: Array, near: Numbers, count: int
) -> Vector:
    """Outward normal of the surface at a point, by differences along the corners of a tetrahedron."""
    x = y = z = 0.0
    for way in ((1.0, -1.0, -1.0), (-1.0, -1.0, 1.0), (-1.0, 1.0, -1.0), (1.0, 1.0, 1.0)):
        gap, _ = nearest(moved(p, way, _NUDGE), bars, groups, blends, solids, near, count)
        x, y, z = x + way[0] * gap, y + way[1] * gap, z + way[2] * gap
    size = max(math.sqrt(x * x + y * y + z * z), 1e-12)
    return x / size, y / size, z / size


@compiled
def ambient_share(
    p: Vector, normal: Vector, bars: Array, groups: Numbers, blends: Array, solids: Array, near: Numbers,
    count: int,
) -> float:
    """Share of ambient light that reaches a point: less in creases."""
    taken = 0.0
    for i in range(1, 5):
        out = 0.25 * i * _SHADE_M
        gap, _ = nearest(moved(p, normal, out), bars, groups, blends, solids, near, count)
        taken += (out - gap) / out * 0.5**i
    return min(1.0, max(0.0, 1.0 - 1.1 * taken))


@compiled
def nearest_bar(p: Vector, bars: Array, near: Numbers, count: int) -> int:
    """The bar whose skin is nearest; -1 for none."""
    least, found = FAR, -1
    for i in range(count):
        distance = bar_distance(p, bars[near[i]])
        if distance < least:
            least, found = distance, near[i]
    return found


@compiled
def shade(
    p: Vector, lamp: Vector, bars: Array, groups: Numbers, blends: Array, bounds: Array,
    solids: Array, near: Numbers, pixel: Array,
) -> None:
    """Fill a pixel's ambient light and share of the lamp's light from its normal; changes `near`."""
    normal = (pixel[1], pixel[2], pixel[3])
    reach = 0.002 + blends.max()
    count = find_about(p, bounds, reach + 2.0 * _SHADE_M, near)
    pixel[4] = ambient_share(p, normal, bars, groups, blends, solids, near, count)
    if normal[0] * lamp[0] + normal[1] * lamp[1] + normal[2] * lamp[2] > 0.0:
        above = moved(p, normal, 1e-3)
        count = find_near(above, lamp, bounds, reach + _PENUMBRA_M, True, near)
        pixel[5] = lit_share(above, lamp, bars, groups, blends, solids, near, count)


@compiled
def trace_pixel(
    start: Vector, way: Vector, lamp: Vector, begin: float, length: float, bars: Array, groups: Numbers,
    blends: Array, bounds: Array, solids: Array, near: Numbers, count: int, like: Array, like_surface: int,
    about: Numbers, pixel: Array, surfaces: Numbers,
) -> None:
    """Fill one pixel, see `trace`; its light is that of a neighbour of the same surface and depth, if any."""
    far, surface = march(start, way, begin, length, NEAR_ENOUGH_M, 0.0, bars, groups, blends, solids, near,
                         count)
    pixel[0], surfaces[0] = far, surface
    if surface < 0:
        return
    p = moved(start, way, far)
    if surface == 0:
        surfaces[1] = nearest_bar(p, bars, near, count)
    if about.size:
        pixel[1], pixel[2], pixel[3] = find_normal(p, bars, groups, blends, solids, near, count)
        if like_surface == surface and abs(like[0] - far) < _ALIKE_M:
            pixel[4], pixel[5] = like[4], like[5]
        else:
            shade(p, lamp, bars, groups, blends, bounds, solids, about, pixel)


@compiled
def trace(
    origin: Array, right: Array, down: Array, along: Array, light: Array, length: float, bars: Array,
    groups: Numbers, blends: Array, bounds: Array, solids: Array, shading: bool, seen: Array,
    surfaces: Numbers,
) -> None:
    """Fill a picture's pixels by parallel rays.

    Tile by tile: a tile's middle ray goes as far as nothing is within the tile, and all begin there.

    Parameters
    ----------
    origin, right, down: (3,), m: of the pixel at the top left, and to its neighbours.
    along, light: (3,), unit vectors: of the rays, and towards the light. length: of the rays, m.
    bars, groups, blends: see `fesloop.show.picture.flesh`. bounds: (n, 4), balls about them. solids: (m, 16).
    shading: whether more is wanted than distances and surfaces.
    seen: (height, width, 6) to fill: distance, normal (3), ambient light, share of the lamp's light.
    surfaces: (height, width, 2) to fill: 0 flesh, 1 on the solids, -1 nothing; the nearest bar.
    """
    near, about = np.empty(bars.shape[0], np.int64), np.empty(bars.shape[0] if shading else 0, np.int64)
    way, lamp = (along[0], along[1], along[2]), (light[0], light[1], light[2])
    corner, across = (origin[0], origin[1], origin[2]), (right[0], right[1], right[2])
    below = (down[0], down[1], down[2])
    wide = 0.9 * _TILE * math.sqrt((right * right).sum())
    seen[:, :, 0], surfaces[:, :, :] = length, -1
    for top in range(0, seen.shape[0], _TILE):
        for left in range(0, seen.shape[1], _TILE):
            middle = moved(moved(corner, across, left + 0.5 * _TILE - 0.5), below, top + 0.5 * _TILE - 0.5)
            count = find_near(middle, way, bounds, 0.002 + blends.max() + wide, False, near)
            begin, met = march(middle, way, 0.0, length, wide, 0.8 * wide, bars, groups, blends, solids, near,
                               count)
            if met < 0:
                continue
            for row in range(top, min(top + _TILE, seen.shape[0])):
                for column in range(left, min(left + _TILE, seen.shape[1])):
                    first = row - row % 2, column - column % 2
                    known = surfaces[first[0], first[1], 0] if first != (row, column) else -1
                    start = moved(moved(corner, across, column), below, row)
                    trace_pixel(start, way, lamp, begin, length, bars, groups, blends, bounds, solids, near,
                                count, seen[first[0], first[1]], known, about, seen[row, column],
                                surfaces[row, column])
