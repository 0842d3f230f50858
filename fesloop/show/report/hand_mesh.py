"""The drawn hand as rigid pieces, a mesh a segment, that stay closed as joints bend.

Shapes are those of `fesloop.show.picture.flesh`, each bar with the segment that it is the flesh of.
Neighbours end in balls about the joint between them, of one size, so that they meet in a smooth line at any
angle.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import AT_REFERENCE, Poses
from fesloop.hand.skeleton import hand_tree
from fesloop.show.picture.distance_kernels import flesh_distances
from fesloop.show.picture.flesh import Flesh, flesh
from fesloop.show.report.figure3d import Mesh
from fesloop.show.report.surface_net import surface_net

Array = NDArray[np.float64]
FOREARM_SHOWN = 0.4
"""Share of the forearm that is shown, from the wrist."""
_CELLS_M = (0.0105, 0.0075)
"""Between vertices on forearm and palm, of a hand of `_HAND_MM` (chosen: a few thousand triangles in all)."""
_DIGIT_CELL_M = 0.004
"""The same on thumb and fingers (chosen: a dozen about the thinnest)."""
_HAND_MM = 190.0
NOTHING = Mesh(vertices=np.empty((0, 3)), faces=np.empty((0, 3), dtype=np.int32))
"""Of a segment that is not shown."""


def segment_meshes(size: HandSize, forearm: bool = True) -> list[Mesh]:
    """A mesh of each segment in its own frame, in the order of the hand's tree.

    `forearm`: whether a piece of it is shown; its mesh is `NOTHING` otherwise.
    """
    count = len(hand_tree(size).segments)
    cells = [*_CELLS_M, *(_DIGIT_CELL_M for _ in range(count - 2))]
    scale = size.hand_mm / _HAND_MM
    own = _in_own_frames(size, count)
    return [_mesh(segment_flesh(own, k, size), scale * cell) if k > 0 or forearm else NOTHING
            for k, cell in enumerate(cells)]


def _in_own_frames(size: HandSize, count: int) -> Flesh:
    """All bars, each in the frame of its own segment."""
    turn, place = AT_REFERENCE
    return flesh(size, Poses(np.tile(turn, (count, 1)), np.tile(place, (count, 1))))


def segment_flesh(own: Flesh, segment: int, size: HandSize) -> Flesh:
    """The bars of one segment, blended with each other; of the forearm what is shown."""
    of_segment = own.segments == segment
    # The palm's bars come again in the fingers' groups, to blend with them there.
    group = own.groups[of_segment].min()
    chosen = of_segment & (own.groups == group)
    bars = own.bars[chosen]
    if segment == 0:
        bars = _cut(bars, FOREARM_SHOWN * size.forearm)
    zeros = np.zeros(len(bars), dtype=np.int64)
    return Flesh(bars, zeros, own.blends[group:group + 1], zeros + segment)


def _cut(bars: Array, length_m: float) -> Array:
    """Of bars along y the pieces within a length of the origin, their radii tapering as before."""
    near, far = np.abs(bars[:, 1]), np.abs(bars[:, 4])
    share = np.clip((length_m - near) / (far - near), 0.0, 1.0)[:, np.newaxis]
    cut = bars.copy()
    cut[:, 3:6] = bars[:, :3] + share * (bars[:, 3:6] - bars[:, :3])
    cut[:, 7] = bars[:, 6] + share[:, 0] * (bars[:, 7] - bars[:, 6])
    return np.asarray(cut[share[:, 0] > 0.0])


def _mesh(shape: Flesh, cell_m: float) -> Mesh:
    ends = shape.bars[:, :6].reshape(-1, 3)
    # Blending adds at most a quarter of its reach.
    margin = shape.bars[:, 6:].max() + 0.25 * shape.blends.max() + 2.0 * cell_m
    return surface_net(lambda points: flesh_distances(points, shape.bars, shape.groups, shape.blends),
                       ends.min(axis=0) - margin, ends.max(axis=0) + margin, cell_m)
