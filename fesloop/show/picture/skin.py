"""What the surfaces of a picture show: nails, and a forearm and a table that fade out of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import Poses
from fesloop.show.picture.flesh import Flesh
from fesloop.show.picture.render import Colour, Frame, Solid, Traced

Array = NDArray[np.float64]
_SKIN: Colour = (0.93, 0.80, 0.71)
_NAIL: Colour = (0.97, 0.88, 0.84)
_FIRST_M, _LAST_M = 0.08, 0.15
"""From where to where a table fades, m from the hand."""
_FADED = 0.55
"""Share of the shown forearm from which it fades."""


def skin_colours(
    found: Traced, frame: Frame, flesh: Flesh, poses: Poses, size: HandSize, others: Sequence[Colour]
) -> Array:
    """Colour of each pixel's surface before it is lit, (rows, columns, 3)."""
    table = np.array([_SKIN, *others])
    colours = table[np.clip(found.surface, 0, None)]
    points = frame.points(found.depth)
    for i, segment in enumerate(range(4, 17, 3)):
        there = (found.surface == 0) & (flesh.segments[found.bar] == segment)
        own = quaternion.rotate(quaternion.conjugate(poses.orientation[segment]),
                                points[there] - poses.position[segment])
        colours[there] = np.where(_on_nail(own * size.outwards, size.tips[i])[:, np.newaxis], _NAIL,
                                  colours[there])
    return colours


def _on_nail(own: Array, tip: Array) -> NDArray[np.bool_]:
    """Whether points (n, 3), dorsal, distal, ulnar from the bone's end, are under the nail.

    `tip`: soft tissue, thickness, width.
    """
    tissue, thick, _ = tip
    middle = tissue - 0.5 * thick
    long, wide = 0.48 * thick, 0.36 * thick
    inside = ((own[:, 1] - middle) / long) ** 4 + (own[:, 2] / wide) ** 4 < 1.0
    return np.asarray(inside & (own[:, 0] > 0.0))


def faded_solids(picture: Array, found: Traced, frame: Frame, solids: Sequence[Solid], near: Array) -> Array:
    """The picture with solids that fade drawn only about a point `near` (3,), seen from above."""
    faded = picture.copy()
    for number, solid in enumerate(solids):
        if solid.fades:
            there = found.surface == number + 1
            far = np.linalg.norm((frame.points(found.depth)[there] - near)[:, :2], axis=1)
            faded[there, 3] *= np.clip((_LAST_M - far) / (_LAST_M - _FIRST_M), 0.0, 1.0)
    return faded


def faded_forearm(
    picture: Array, found: Traced, frame: Frame, flesh: Flesh, poses: Poses, shown_m: float
) -> Array:
    """The picture with the forearm fading into nothing towards `shown_m` from the wrist."""
    there = (found.surface == 0) & (flesh.segments[found.bar] == 0)
    own = quaternion.rotate(quaternion.conjugate(poses.orientation[0]),
                            frame.points(found.depth)[there] - poses.position[0])
    share = np.abs(own[:, 1]) / shown_m
    faded = picture.copy()
    faded[there, 3] *= np.clip((1.0 - share) / (1.0 - _FADED), 0.0, 1.0)
    return faded
