"""Trees of rigid segments joined by hinges, saddles and balls, for trackers and kinematics.

A segment's own frame sits at its far end (the distal centre of rotation, or the tip). From its parent's
frame one moves by `base` to the joint's centre, turns about the joint's axes one after the other, each as
turned by those before it (intrinsic), and moves by `offset` along the turned frame. With all angles 0 every
frame is parallel to the root's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
JointKind = Literal["fixed", "hinge", "saddle", "ball"]

FREEDOMS: dict[JointKind, int] = {"fixed": 0, "hinge": 1, "saddle": 2, "ball": 3}
"""Degrees of freedom of each kind of joint."""
MOTIONS = ("flexion", "abduction", "pronation")
"""Names of a joint's rotations, in the order in which they are applied."""
AXES: tuple[Vector, Vector, Vector] = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
"""Axes z, x, y of these rotations (intrinsic z-x-y, doi 10.3390/s19010208, eq. 20-22)."""
_TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Segment:
    """A rigid segment and the joint that ties it to its parent.

    Attributes
    ----------
    name: of the segment.
    parent: name of the parent segment; None for the root, whose pose is given from outside.
    joint: kind of the joint; the root's is "fixed".
    joint_name: of the joint; empty where it is fixed.
    base: the joint's centre in the parent's frame, m.
    offset: the segment's frame from the joint's centre, in the segment's own axes, m.
    axes: unit vectors at right angles, as many as the joint has freedoms, in the order of `MOTIONS`; a
        third one is their right-handed complement. Empty: z, x, y. Other axes describe joints that are
        tilted against their segments.
    ranges: lowest and highest angle about each axis, rad; empty: a whole turn.
    """

    name: str
    parent: str | None = None
    joint: JointKind = "fixed"
    joint_name: str = ""
    base: Vector = (0.0, 0.0, 0.0)
    offset: Vector = (0.0, 0.0, 0.0)
    axes: tuple[Vector, ...] = ()
    ranges: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        where = f"segment {self.name!r}"
        if self.joint not in FREEDOMS:
            raise InputError(where, f"joint {self.joint!r}", ", ".join(FREEDOMS))
        freedoms = FREEDOMS[self.joint]
        for key, vector in (("base", self.base), ("offset", self.offset)):
            if len(vector) != 3 or not np.isfinite(vector).all():
                raise InputError(f"{where}: {key}", f"{vector}", "three finite numbers, m")
        for key, rows in (("axes", self.axes), ("ranges", self.ranges)):
            if rows and len(rows) != freedoms:
                raise InputError(f"{where}: {key}", f"{len(rows)} of them",
                                 f"{freedoms}, as a {self.joint} joint has, or none")
        if self.axes:
            _require_orthonormal(f"{where}: axes", self.axes)
        for low, high in self.ranges:
            if not -np.pi <= low < high <= np.pi:
                raise InputError(f"{where}: ranges", f"({low}, {high})", "low < high within [-pi, pi], rad")

    @property
    def frame(self) -> Array:
        """The joint's three axes as rows, (3, 3); the third is the first x the second, as y is z x x."""
        given = np.array(self.axes or AXES[:1], dtype=np.float64)
        first = given[0]
        if len(given) < 2:
            given = np.stack([first, _least_turned_x(first)])
        third = np.cross(first, given[1])
        return np.stack([first, given[1], third])


def _require_orthonormal(where: str, axes: Sequence[Vector]) -> None:
    rows = np.asarray(axes, dtype=np.float64)
    if rows.shape[1:] != (3,) or np.abs(rows @ rows.T - np.eye(len(rows))).max() > _TOLERANCE:
        raise InputError(where, f"{tuple(axes)}", "unit vectors at right angles", "normalise them")
    if len(rows) == 3 and np.linalg.det(rows) < 0.0:
        raise InputError(where, f"{tuple(axes)}", "a third axis equal to first x second", "turn it round")


def _least_turned_x(first: Array) -> Array:
    """x, after the shortest rotation that takes z to `first`; where that is a half turn, the one about x."""
    if first[2] < -1.0 + _TOLERANCE:
        return np.array([1.0, 0.0, 0.0])
    x, y, z = first
    return np.array([1.0 - x * x / (1.0 + z), -x * y / (1.0 + z), -x])


@dataclass(frozen=True, slots=True)
class SegmentTree:
    """Segments, the root first and each after its parent; n segments with d degrees of freedom in all.

    Angles, rates and the like of the whole tree are arrays (..., d), segment by segment, in each segment
    in the order of its axes.

    Attributes
    ----------
    segments: of the tree.
    layout: (n, 3) integers: index of the parent (-1 for the root), freedoms, index of the first freedom.
    geometry: (n, 5, 3): the joint's three axes, base, offset; m.
    ranges: (d, 2), lowest and highest angle, rad.
    moved: (n, d), True where a freedom moves a segment.

    Raises InputError for names given twice, unknown parents and parents that come after their children.
    """

    segments: tuple[Segment, ...]
    layout: NDArray[np.int64] = field(init=False, repr=False, compare=False)
    geometry: Array = field(init=False, repr=False, compare=False)
    ranges: Array = field(init=False, repr=False, compare=False)
    moved: NDArray[np.bool_] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        _require_tree(self.segments)
        names = self.names
        freedoms = [FREEDOMS[segment.joint] for segment in self.segments]
        first = np.concatenate([[0], np.cumsum(freedoms)])
        parents = [-1 if segment.parent is None else names.index(segment.parent) for segment in self.segments]
        layout = np.stack([parents, freedoms, first[:-1]], axis=1).astype(np.int64)
        geometry = np.stack([np.vstack([s.frame, s.base, s.offset]) for s in self.segments])
        whole = (-np.pi, np.pi)
        ranges = [row for segment, count in zip(self.segments, freedoms, strict=True)
                  for row in (segment.ranges or (whole,) * count)]
        moved = np.zeros((len(names), first[-1]), dtype=np.bool_)
        for k, parent in enumerate(parents):
            if parent >= 0:
                moved[k] = moved[parent]
            moved[k, first[k]:first[k + 1]] = True
        for key, array in (("layout", layout), ("geometry", geometry), ("moved", moved),
                           ("ranges", np.array(ranges, dtype=np.float64).reshape(-1, 2))):
            array.flags.writeable = False
            object.__setattr__(self, key, array)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the segments."""
        return tuple(segment.name for segment in self.segments)

    @property
    def freedoms(self) -> tuple[str, ...]:
        """Names of the degrees of freedom, such as `F2_mcp_flexion`."""
        return tuple(f"{segment.joint_name or segment.name}_{motion}" for segment in self.segments
                     for motion in MOTIONS[:FREEDOMS[segment.joint]])

    def index(self, name: str) -> int:
        """Index of a segment; raises InputError for an unknown name."""
        return _position(name, self.names, "segment")

    def freedom(self, name: str) -> int:
        """Index of a degree of freedom; raises InputError for an unknown name."""
        return _position(name, self.freedoms, "degree of freedom")


def _position(name: str, known: tuple[str, ...], what: str) -> int:
    if name not in known:
        raise InputError(what, f"{name!r}", ", ".join(known), did_you_mean(name, known))
    return known.index(name)


def _require_tree(segments: tuple[Segment, ...]) -> None:
    """Raise InputError unless the segments, in this order, form one tree."""
    if not segments:
        raise InputError("segment tree", "no segment", "one or more")
    before: list[str] = []
    for segment in segments:
        where = f"segment {segment.name!r}"
        if segment.name in before:
            raise InputError(where, "given twice", "one of a name")
        if not before:
            if segment.parent is not None or segment.joint != "fixed":
                raise InputError(where, "is first and not a root", "parent None, joint 'fixed'")
        elif segment.parent is None:
            raise InputError(where, "a second root", "one root, the first segment", "give it a parent")
        elif segment.parent not in before:
            raise InputError(where, f"parent {segment.parent!r}", ", ".join(before),
                             did_you_mean(segment.parent, before) or "list parents before their children")
        before.append(segment.name)
