"""A closed surface of triangles about a shape that is given by distances to it.

Surface nets (Gibson 1998, doi 10.1007/BFb0056277): one vertex in each cell of a grid that the surface passes
through, one quadrangle about each edge of the grid that it crosses; then every vertex moves onto the surface.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fesloop.show.report.figure3d import Mesh

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
Distances = Callable[[Array], Array]
"""Of points (n, 3) from a surface, (n,), m, negative inside; at least near it no steeper than 1."""
_CORNERS = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)])
_EDGES = np.array([(a, b) for a in range(8) for b in range(a + 1, 8)
                   if np.abs(_CORNERS[a] - _CORNERS[b]).sum() == 1])
"""Corners of a cell, and the corners that its 12 edges join."""
_STEPS = 3
"""Newton steps towards the surface (chosen: what is left is below a micrometre)."""
_DIFFERENCE_M = 1e-6


def surface_net(distances: Distances, low: Array, high: Array, cell_m: float) -> Mesh:
    """The surface within the corners `low` and `high` (3,), m, which has to lie a cell inside of them."""
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
    """Whether some but not all corners of each cell are inside."""
    sizes = np.array(inside.shape) - 1
    corners = np.stack([inside[tuple(slice(first, first + size) for first, size in zip(corner, sizes,
                                                                                        strict=True))]
                        for corner in _CORNERS])
    return np.asarray(corners.any(axis=0) & ~corners.all(axis=0))


def _middles(values: Array, cells: Numbers) -> Array:
    """Mean (n, 3) of where the surface crosses the edges of each cell, in cells from its first corner."""
    corners = values[tuple((cells[:, np.newaxis] + _CORNERS).transpose(2, 0, 1))]
    start, end = corners[:, _EDGES[:, 0]], corners[:, _EDGES[:, 1]]
    crosses = (start < 0.0) != (end < 0.0)
    share = np.divide(start, start - end, out=np.zeros_like(start), where=crosses)
    first, along = _CORNERS[_EDGES[:, 0]], _CORNERS[_EDGES[:, 1]] - _CORNERS[_EDGES[:, 0]]
    places = (first + share[..., np.newaxis] * along) * crosses[..., np.newaxis]
    return np.asarray(places.sum(axis=1) / crosses.sum(axis=1)[:, np.newaxis])


def _to_surface(distances: Distances, points: Array) -> Array:
    """A Newton step (n, 3) away from the surface along the distance's gradient."""
    ahead, behind = (np.stack([distances(points + way * _DIFFERENCE_M * axis) for axis in np.eye(3)], axis=-1)
                     for way in (1.0, -1.0))
    gradient = (ahead - behind) / (2.0 * _DIFFERENCE_M)
    square = np.square(gradient).sum(axis=-1, keepdims=True)
    return np.asarray(distances(points)[:, np.newaxis] * gradient / np.maximum(square, 0.25))


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
