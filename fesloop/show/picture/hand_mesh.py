"""Meshes of the hand in pictures: the whole hand in one posture, or one rigid mesh per segment.

Both are the zero level of the distances of `fesloop.show.picture.flesh`, found by surface nets. Neighbouring
segments end in balls of one size about the joint between them, so that their meshes stay closed at any angle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import AT_REFERENCE, Poses
from fesloop.hand.skeleton import hand_tree
from fesloop.show.picture.flesh import Flesh, flesh, flesh_distances

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
Distances = Callable[[Array], Array]
"""Function from points (n, 3) to signed distances (n,) from a surface, m, negative inside; its slope near the
surface is at most 1."""
_CORNERS = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)])
_EDGES = np.array([(a, b) for a in range(8) for b in range(a + 1, 8)
                   if np.abs(_CORNERS[a] - _CORNERS[b]).sum() == 1])
"""Corners of a cell, and the pairs of corners that its 12 edges join."""
_STEPS = 3
"""Newton steps towards the surface (chosen: the error left is below a micrometre)."""
_DIFFERENCE_M = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mesh:
    """Triangles: `vertices` (v, 3), m; `faces` (f, 3), numbers of vertices, counterclockwise from outside."""

    vertices: Array
    faces: NDArray[np.int32]


def surface_net(distances: Distances, low: Array, high: Array, cell_m: float) -> Mesh:
    """Mesh of the surface between the corners `low` and `high` (3,), m, inside by a cell or more."""
    counts = np.ceil((high - low) / cell_m).astype(int) + 1
    grid = np.stack(np.meshgrid(*(np.arange(count) for count in counts), indexing="ij"), axis=-1)
    values = distances((low + cell_m * grid).reshape(-1, 3)).reshape(counts)
    cells = np.argwhere(_crossed(values < 0.0))
    vertices = low + cell_m * (cells + _middles(values, cells))
    for _ in range(_STEPS):
        vertices = vertices - _to_surface(distances, vertices)
    numbers = np.full(counts, -1, dtype=np.int64)
    numbers[tuple(cells.T)] = np.arange(len(cells))
    return Mesh(vertices=vertices, faces=_triangles(vertices, _quadrangles(values < 0.0, numbers)))


def _crossed(inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Mask of the cells that the surface crosses: some but not all corners are inside."""
    sizes = np.array(inside.shape) - 1
    corners = np.stack([inside[tuple(slice(first, first + size) for first, size in zip(corner, sizes,
                                                                                        strict=True))]
                        for corner in _CORNERS])
    return np.asarray(corners.any(axis=0) & ~corners.all(axis=0))


def _middles(values: Array, cells: Numbers) -> Array:
    """Mean crossing (n, 3) of the surface with the edges of each cell, in cells from its first corner."""
    corners = values[tuple((cells[:, np.newaxis] + _CORNERS).transpose(2, 0, 1))]
    start, end = corners[:, _EDGES[:, 0]], corners[:, _EDGES[:, 1]]
    crosses = (start < 0.0) != (end < 0.0)
    share = np.divide(start, start - end, out=np.zeros_like(start), where=crosses)
    first, along = _CORNERS[_EDGES[:, 0]], _CORNERS[_EDGES[:, 1]] - _CORNERS[_EDGES[:, 0]]
    places = (first + share[..., np.newaxis] * along) * crosses[..., np.newaxis]
    return np.asarray(places.sum(axis=1) / crosses.sum(axis=1)[:, np.newaxis])


def _to_surface(distances: Distances, points: Array) -> Array:
    """Newton step (n, 3) away from the surface along the distance's gradient."""
    gradient = slope(distances, points, _DIFFERENCE_M)
    square = np.square(gradient).sum(axis=-1, keepdims=True)
    return np.asarray(distances(points)[:, np.newaxis] * gradient / np.maximum(square, 0.25))


def slope(distances: Distances, points: Array, half_m: float) -> Array:
    """Gradient (n, 3) of the distance at points, by central differences over twice `half_m`."""
    ahead, behind = (np.stack([distances(points + way * half_m * axis) for axis in np.eye(3)], axis=-1)
                     for way in (1.0, -1.0))
    return np.asarray((ahead - behind) / (2.0 * half_m))


def _quadrangles(inside: NDArray[np.bool_], numbers: Numbers) -> Numbers:
    """Vertices (q, 4) of the cells about each crossed edge, counterclockwise from outside."""
    found = []
    for axis in range(3):
        first, second = np.roll(np.eye(3, dtype=np.int64), -axis, axis=0)[1:]
        here, there = np.moveaxis(inside, axis, 0)[:-1], np.moveaxis(inside, axis, 0)[1:]
        edges = np.argwhere(np.moveaxis(here != there, 0, axis))
        about = [numbers[tuple((edges - i * first - j * second).T)]
                 for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
        quadrangles = np.stack(about, axis=-1)
        leaves = inside[tuple(edges.T)]
        found.append(np.where(leaves[:, np.newaxis], quadrangles, quadrangles[:, ::-1]))
    return np.concatenate(found)


def _triangles(vertices: Array, quadrangles: Numbers) -> NDArray[np.int32]:
    """Two triangles (2 q, 3) of each quadrangle, cut along the shorter diagonal."""
    a, b, c, d = quadrangles.T
    across = (np.linalg.norm(vertices[a] - vertices[c], axis=-1)
              <= np.linalg.norm(vertices[b] - vertices[d], axis=-1))
    first = np.where(across, [a, b, c], [a, b, d])
    second = np.where(across, [a, c, d], [b, c, d])
    return np.concatenate([first.T, second.T]).astype(np.int32)


FOREARM_SHOWN = 0.4
"""Share of the forearm that is shown, measured from the wrist."""
_CELLS_M = (0.0105, 0.0075)
"""Distance between vertices on forearm and palm of a hand of `_HAND_MM` (chosen: thousands of triangles)."""
_DIGIT_CELL_M = 0.004
"""Distance between vertices on thumb and fingers (chosen: a dozen around the thinnest)."""
_HAND_MM = 190.0
NOTHING = Mesh(vertices=np.empty((0, 3)), faces=np.empty((0, 3), dtype=np.int32))
"""Mesh of a segment that is not shown."""


def hand_surface(shape: Flesh, cell_m: float) -> Mesh:
    """Mesh of a whole hand, with vertices about `cell_m` apart."""
    ends = shape.bars[:, :6].reshape(-1, 3)
    # Blending adds at most a quarter of its reach.
    margin = shape.bars[:, 6:].max() + 0.25 * shape.blends.max() + 2.0 * cell_m
    return surface_net(lambda points: flesh_distances(points, shape),
                       ends.min(axis=0) - margin, ends.max(axis=0) + margin, cell_m)


def segment_meshes(size: HandSize, forearm: bool = True) -> list[Mesh]:
    """Mesh of each segment in its own frame, in the order of the hand's tree.

    `forearm`: whether part of the forearm is shown; otherwise its mesh is `NOTHING`.
    """
    count = len(hand_tree(size).segments)
    cells = [*_CELLS_M, *(_DIGIT_CELL_M for _ in range(count - 2))]
    scale = size.hand_mm / _HAND_MM
    turn, place = AT_REFERENCE
    own = flesh(size, Poses(np.tile(turn, (count, 1)), np.tile(place, (count, 1))))
    return [hand_surface(segment_flesh(own, k, size), scale * cell) if k > 0 or forearm else NOTHING
            for k, cell in enumerate(cells)]


def segment_flesh(own: Flesh, segment: int, size: HandSize) -> Flesh:
    """Bars of one segment in its own frame, in one group; the forearm's are cut to the part that is shown."""
    of_segment = own.segments == segment
    # The palm's bars are repeated in the fingers' groups, where they blend with the fingers.
    group = own.groups[of_segment].min()
    chosen = of_segment & (own.groups == group)
    bars = own.bars[chosen]
    if segment == 0:
        bars = _cut(bars, FOREARM_SHOWN * size.forearm)
    zeros = np.zeros(len(bars), dtype=np.int64)
    return Flesh(bars, zeros, own.blends[group:group + 1], zeros + segment)


def _cut(bars: Array, length_m: float) -> Array:
    """Parts of bars along y within a length of the origin, with unchanged taper."""
    near, far = np.abs(bars[:, 1]), np.abs(bars[:, 4])
    share = np.clip((length_m - near) / (far - near), 0.0, 1.0)[:, np.newaxis]
    cut = bars.copy()
    cut[:, 3:6] = bars[:, :3] + share * (bars[:, 3:6] - bars[:, :3])
    cut[:, 7] = bars[:, 6] + share[:, 0] * (bars[:, 7] - bars[:, 6])
    return np.asarray(cut[share[:, 0] > 0.0])
