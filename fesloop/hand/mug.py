"""A mug: a hollow cylinder with a floor and a handle, made of boxes, cylinders and rods.

Its axes are those of the cylinder that it stands in: z upwards along the axis, x towards the handle, origin
halfway up. The handle is half an ellipse of round rods. Density is uniform.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.hand import quaternion

Array = NDArray[np.float64]
SIZES = ("diameter", "height", "wall", "handle")
"""Meaning of a mug's sizes: outer diameter and height, thickness of wall and floor, and how far the handle
reaches beyond the wall."""
_FLAT_M = 0.0005
"""Depth of an edge of the wall beyond the middle of its faces (chosen: a tenth of a fingertip's skin)."""
_RODS, _ROD_M, _HANDLE_SHARE = 6, 0.005, 0.3
"""Number of rods of a handle, their radius, and half the handle's height as a share of the mug's (chosen)."""


class Mug(NamedTuple):
    """Sizes, m: outer radius and height, thickness of wall and floor, reach of the handle beyond the wall."""

    radius: float
    height: float
    wall: float
    handle: float

    @classmethod
    def of(cls, size_mm: Sequence[float]) -> Mug:
        """From `SIZES`, mm."""
        diameter, height, wall, handle = (1e-3 * each for each in size_mm)
        return cls(0.5 * diameter, height, wall, handle)

    @property
    def rod(self) -> float:
        """Radius of the handle's rods, m: two of them leave half of a short handle's reach free."""
        return min(_ROD_M, 0.25 * self.handle)

    @property
    def reach(self) -> float:
        """Distance from the origin beyond which nothing of it lies, m."""
        return math.hypot(self.radius + self.handle, 0.5 * self.height)

    def handle_line(self) -> Array:
        """Ends of the rods along the handle's middle, (rods + 1, 3), m; the outer ones lie in the wall."""
        angle = np.linspace(-0.5 * math.pi, 0.5 * math.pi, _RODS + 1)
        start = self.radius - 0.5 * self.wall
        out = start + (self.radius + self.handle - self.rod - start) * np.cos(angle)
        return np.column_stack([out, np.zeros(angle.size), _HANDLE_SHARE * self.height * np.sin(angle)])

    def lowest(self, turned: Array) -> Array:
        """Depth of the lowest point below the origin, (n,), m, under orientations (n, 4) to global axes."""
        upright = np.clip(np.abs(quaternion.rotate(turned, np.array([0.0, 0.0, 1.0]))[:, 2]), 0.0, 1.0)
        cylinder = 0.5 * self.height * upright + self.radius * np.sqrt(1.0 - upright**2)
        heights = quaternion.rotate(turned[:, np.newaxis], self.handle_line())[..., 2]
        return np.asarray(np.maximum(cylinder, self.rod - heights.min(axis=1)))


class Part(NamedTuple):
    """Part of a mug: floor, side of the wall, or rod of the handle.

    Attributes
    ----------
    kind: cylinder or rod (round ends beyond its half length) about its z, or box.
    centre, orientation: in the mug's axes, (3,) m and (4,).
    half: (3,), m: half sides of a box; radius, half length and 0 of the others.
    """

    kind: Literal["box", "cylinder", "rod"]
    centre: Array
    orientation: Array
    half: Array


def parts_of(mug: Mug) -> list[Part]:
    """Floor, sides of the wall, rods of the handle; the wall's outside is within .25 mm of the cylinder's."""
    bottom = -0.5 * mug.height
    upright = np.array([1.0, 0.0, 0.0, 0.0])
    parts = [Part("cylinder", np.array([0.0, 0.0, bottom + 0.5 * mug.wall]), upright,
                  np.array([mug.radius, 0.5 * mug.wall, 0.0]))]
    sides = math.ceil(math.pi / math.acos(1.0 - min(_FLAT_M / mug.radius, 0.5)))
    face = 2.0 * mug.radius / (1.0 + 1.0 / math.cos(math.pi / sides))  # edges as far outside as faces inside
    half = np.array([0.5 * mug.wall, face * math.tan(math.pi / sides), 0.5 * (mug.height - mug.wall)])
    for k in range(sides):
        angle = 2.0 * math.pi * k / sides
        at = face - 0.5 * mug.wall
        parts.append(Part("box", np.array([at * math.cos(angle), at * math.sin(angle), 0.5 * mug.wall]),
                          np.array([math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle)]), half))
    for middle, along in _rods(mug):
        length = float(np.linalg.norm(along))
        turn = 0.5 * math.atan2(along[0], along[2])  # about y, in whose plane the handle lies
        parts.append(Part("rod", middle, np.array([math.cos(turn), 0.0, math.sin(turn), 0.0]),
                          np.array([mug.rod, 0.5 * length, 0.0])))
    return parts


def _rods(mug: Mug) -> Iterator[tuple[Array, Array]]:
    """Middle and extent of each rod, (3,) m each."""
    line = mug.handle_line()
    for start, end in pairwise(line):
        yield 0.5 * (start + end), end - start


def inertia_of(mug: Mug, mass_kg: float) -> tuple[Array, Array]:
    """Centre of mass (3,), m, and inertia about it (3, 3), kg m^2, of the round wall, the floor and the rods.

    Rods count without their round ends, which lie in their neighbours.
    """
    inner, deep = mug.radius - mug.wall, mug.height - mug.wall
    bodies = [_round_body(math.pi * (mug.radius**2 - inner**2) * deep, np.array([0.0, 0.0, 0.5 * mug.wall]),
                          mug.radius**2 + inner**2, np.array([0.0, 0.0, deep])),
              _round_body(math.pi * mug.radius**2 * mug.wall, np.array([0.0, 0.0, -0.5 * deep]),
                          mug.radius**2, np.array([0.0, 0.0, mug.wall]))]
    bodies += [_round_body(math.pi * mug.rod**2 * float(np.linalg.norm(along)), middle, mug.rod**2, along)
               for middle, along in _rods(mug)]
    density = mass_kg / sum(volume for volume, *_ in bodies)
    centre = np.sum([density / mass_kg * volume * middle for volume, middle, _ in bodies], axis=0)
    inertia = np.zeros((3, 3))
    for volume, middle, own in bodies:
        off = middle - centre
        inertia += density * volume * (own + off @ off * np.eye(3) - np.outer(off, off))
    return centre, inertia


def _round_body(volume: float, middle: Array, square: float, along: Array) -> tuple[float, Array, Array]:
    """Volume, middle, and inertia a unit of mass of a round body; `square`: sum of its squared radii."""
    length = float(np.linalg.norm(along))
    axis = np.outer(along, along) / length**2
    return volume, middle, 0.5 * square * axis + (0.25 * square + length**2 / 12.0) * (np.eye(3) - axis)
