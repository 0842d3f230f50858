"""A person's hand beside the one that a tracker is told: lengths and joint axes of its own."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.segments import FREEDOMS, Segment, SegmentTree

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Deviation:
    """How a person's hand differs from the textbook's. All zero: it does not.

    Attributes
    ----------
    length: relative sd of each segment's length (a few per cent: doi 10.3390/s19010208, section 5).
    centre_mm: sd of each finger's first joint's place on the palm, each axis.
    axis_tilt_deg: least and most angle by which each joint's axes are tilted as a whole against the
        segments, about a random direction, uniform in between (5 to 10: doi 10.3390/s19010208, section 5).
    """

    length: float = 0.0
    centre_mm: float = 0.0
    axis_tilt_deg: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        if not 0.0 <= self.length <= 0.2:
            raise InputError("length", f"{self.length}", "0 to 0.2, a relative sd")
        if not 0.0 <= self.centre_mm <= 20.0:
            raise InputError("centre_mm", f"{self.centre_mm}", "0 to 20 mm")
        low, high = self.axis_tilt_deg
        if not 0.0 <= low <= high <= 30.0:
            raise InputError("axis_tilt_deg", f"{self.axis_tilt_deg}", "least <= most, within 0 to 30 deg")


def person(tree: SegmentTree, deviation: Deviation, rng: np.random.Generator) -> SegmentTree:
    """The tree of one person: `tree` with lengths, places and axes drawn. The root stays as it is."""
    segments = [tree.segments[0]]
    for segment in tree.segments[1:]:
        scale = max(0.5, 1.0 + deviation.length * float(rng.standard_normal()))
        moved = 1e-3 * deviation.centre_mm * rng.standard_normal(3)
        tilt = _tilt(deviation.axis_tilt_deg, rng)
        first = segment.parent is not None and any(segment.base)
        segments.append(replace(
            segment, offset=_triple(scale * np.array(segment.offset)),
            base=_triple(np.array(segment.base) + moved) if first else segment.base,
            axes=_tilted_axes(segment, tilt)))
    return SegmentTree(tuple(segments))


def _tilt(limits_deg: tuple[float, float], rng: np.random.Generator) -> Array:
    """A rotation about a random direction, (4,)."""
    direction, share = rng.standard_normal(3), rng.uniform()
    angle = math.radians(limits_deg[0] + share * (limits_deg[1] - limits_deg[0]))
    return quaternion.from_axis_angle(direction / np.linalg.norm(direction), angle)


def _tilted_axes(segment: Segment, tilt: Array) -> tuple[tuple[float, float, float], ...]:
    rows = quaternion.rotate(tilt, segment.frame)[:FREEDOMS[segment.joint]]
    return tuple(_triple(row) for row in rows)


def _triple(vector: Array) -> tuple[float, float, float]:
    x, y, z = (float(each) for each in vector)
    return x, y, z
