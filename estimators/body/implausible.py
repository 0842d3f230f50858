"""Angles that no joint can have: turned far beyond its range, or round and round, for long."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.hand.segments import SegmentTree
from fesloop.loop.block import Tick
from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
_BEYOND = math.radians(60.0)
"""Beyond a range, from which on an angle is none of the joint (chosen: mounting, tissue and drift that is
corrected now and then make less)."""
_LONG_NS = NS_PER_S // 2
"""For how long (chosen: no filter takes longer to settle from a jump)."""
_REMEDY = "check signs and order of the axes of both sensors, and how they are strapped on"


class ImplausibleAngles:
    """Memory of where joint angles are; reports once when one begins to be implausible.

    Turns are counted where limits lie a whole turn apart, else an angle is taken next to the middle of them.

    Parameters
    ----------
    limits: (a, 2), rad, beyond which an angle is implausible; infinite where nothing is known.
    names: of the angles.
    joint: what cannot have them, in words.
    """

    __slots__ = ("_before", "_joint", "_limits", "_names", "_since_ns", "_told")

    def __init__(self, limits: Array, names: Sequence[str], joint: str = "such joint") -> None:
        self._limits = np.ascontiguousarray(limits, dtype=np.float64)
        self._names = tuple(names)
        self._joint = joint
        self._before = np.zeros(len(limits))
        self._since_ns = np.full(len(limits), -1, dtype=np.int64)
        self._told = np.zeros(len(limits), dtype=np.bool_)

    def note(self, angles: Array, tick: Tick) -> None:
        """Look at the angles (a,), rad, of a tick."""
        if not _implausible(angles, self._limits, tick.time_ns, self._before, self._since_ns, self._told):
            return
        for k in np.flatnonzero((self._since_ns >= 0) & ~self._told
                                & (tick.time_ns - self._since_ns >= _LONG_NS)):
            self._told[k] = True
            tick.report("implausible_angle", f"{self._names[k]} is at {math.degrees(self._before[k]):.0f} "
                        f"deg, which no {self._joint} can reach: {_REMEDY}")


def of_tree(tree: SegmentTree) -> ImplausibleAngles:
    """Of all freedoms of a tree, by their ranges; those that may turn round are not judged."""
    low, high = tree.ranges.T
    round_about = high - low > 2.0 * math.pi - 1e-6
    limits = np.column_stack([low - _BEYOND, high + _BEYOND])
    limits[round_about] = -math.inf, math.inf
    return ImplausibleAngles(limits, tree.freedoms)


def of_unknown_joints(names: Sequence[str]) -> ImplausibleAngles:
    """Of joints of unknown range: none of a hand passes 180 deg."""
    return ImplausibleAngles(np.tile([-math.pi, math.pi], (len(names), 1)), names, "joint of a hand")


@compiled
def _implausible(angles: Array, limits: Array, now_ns: int, before: Array, since_ns: NDArray[np.int64],
                 told: NDArray[np.bool_]) -> bool:
    """Whether any may have to be reported; each angle is kept in `before`, and since when it is beyond."""
    due = False
    for k in range(angles.size):
        if math.isnan(angles[k]):
            continue
        near = before[k]
        if limits[k, 1] - limits[k, 0] < 2.0 * math.pi:
            near = 0.5 * (limits[k, 0] + limits[k, 1])
        angle = near + (angles[k] - near + math.pi) % (2.0 * math.pi) - math.pi
        before[k] = angle
        if limits[k, 0] <= angle <= limits[k, 1]:
            since_ns[k] = -1
            continue
        if since_ns[k] < 0:
            since_ns[k] = now_ns
        due |= not told[k] and now_ns - since_ns[k] >= _LONG_NS
    return due
