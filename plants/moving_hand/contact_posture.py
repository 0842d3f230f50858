"""Postures in which fingertips touch, or stay at a distance: the one nearest to a preferred posture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics_kernels import forward, joint_lines, point_jacobian, turned
from fesloop.hand.segments import SegmentTree
from fesloop.hand.skeleton import contact_point
from plants.moving_hand.script import Contact

Array = NDArray[np.float64]
_HELD_M, _STILL = 5e-4, 1e-5
_LEAST_M = 1e-4
"""Below this distance points count as touching: the direction between them is no longer defined."""
_ITERATIONS, _LONGEST_STEP, _TANGENTIAL = 200, 0.3, 0.5
_AT_REFERENCE = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])


class _Pair(NamedTuple):
    """Segments (2,) and places, in them, (2, 3) of both points; their distance, m."""

    segments: tuple[int, int]
    places: tuple[Array, Array]
    distance: float


class ContactSolver:
    """Finds postures of a segment tree in which contacts hold.

    The posture x nearest to the wanted one w with all gaps g(x) = 0 is that to which
    x <- x - J^+ g + s (I - J^+ J) (w - x) converges, J the gaps' Jacobian, s < 1 for gaps that curve; where
    it leaves a joint's range, that joint is held at the range's end.

    Attributes
    ----------
    freedoms: indices of those of the touching fingers; all others keep their preferred angle.
    """

    def __init__(self, tree: SegmentTree, size: HandSize, contacts: Sequence[Contact]) -> None:
        self._tree = tree
        self._pairs = [_pair(tree, size, contact) for contact in contacts]
        fingers = {tree.names[k][:2] for pair in self._pairs for k in pair.segments}
        self.freedoms = np.array([k for k, name in enumerate(tree.freedoms) if name[:2] in fingers])
        self._low, self._high = tree.ranges[self.freedoms].T

    def solve(self, preferred: Array, start: Array) -> Array:
        """Angles (d,), rad, near `preferred` (d,), searched from `start` (d,).

        Raises InputError where this hand cannot bring the points to that distance.
        """
        angles = preferred.copy()
        wanted = np.clip(preferred[self.freedoms], self._low, self._high)
        x = np.clip(start[self.freedoms], self._low, self._high)
        free = np.ones(x.size, dtype=np.bool_)
        for _ in range(_ITERATIONS):
            angles[self.freedoms] = x
            gaps, slopes = self._gaps(angles)
            slopes[:, ~free] = 0.0
            homewards = np.where(free, wanted - x, 0.0)
            step = _TANGENTIAL * homewards - np.linalg.lstsq(
                slopes, gaps + _TANGENTIAL * (slopes @ homewards), rcond=1e-9)[0]
            longest = float(np.abs(step).max())
            x = x + step * min(1.0, _LONGEST_STEP / max(longest, 1e-12))
            if longest < _STILL:
                beyond = (x < self._low) | (x > self._high)
                if not beyond.any():
                    break
                free &= ~beyond
                x = np.clip(x, self._low, self._high)
        worst = float(np.abs(gaps).max())
        outside = float(np.maximum(self._low - x, x - self._high).max())
        if worst > _HELD_M or outside > 0.01:
            raise InputError("contacts", f"stay {1e3 * worst:.1f} mm off", "a contact that this hand reaches",
                             "change posture_deg, distance_mm or the points")
        return angles

    def _gaps(self, angles: Array) -> tuple[Array, Array]:
        """Distance less the wanted one (for a touch all three coordinates), and the Jacobian."""
        tree = self._tree
        poses, lines = np.empty((len(tree.segments), 7)), np.empty((angles.size, 6))
        forward(tree.layout, tree.geometry, angles, _AT_REFERENCE, poses)
        joint_lines(tree.layout, tree.geometry, angles, poses, lines)
        gaps: list[Array] = []
        rows: list[Array] = []
        for segments, places, distance in self._pairs:
            ends, change = [], []
            for k, place in zip(segments, places, strict=True):
                w, x, y, z = poses[k, :4]
                end = poses[k, 4:] + np.array(turned((w, x, y, z), *place))
                slope = np.empty((6, angles.size))
                point_jacobian(lines, tree.moved[k], end, slope)
                ends.append(end)
                change.append(slope[:3, self.freedoms])
            between = ends[1] - ends[0]
            length = float(np.linalg.norm(between))
            touch = distance < _LEAST_M
            towards = np.eye(3) if touch else between[np.newaxis] / max(length, _LEAST_M)
            gaps.append(between if touch else np.array([length - distance]))
            rows.append(towards @ (change[1] - change[0]))
        return np.concatenate(gaps), np.vstack(rows)


def _pair(tree: SegmentTree, size: HandSize, contact: Contact) -> _Pair:
    (first, a), (second, b) = (text.split(" ") for text in (contact.first, contact.second))
    segments = tree.index(f"{first}d"), tree.index(f"{second}d")
    place, other, distance = contact_point(size, first, a), contact_point(size, second, b), (
        1e-3 * contact.distance_mm)
    if contact.facing:
        # A point straight out from the skin of the first, which the second has to meet.
        return _Pair(segments, (place * (1.0 + distance / float(np.linalg.norm(place))), other), 0.0)
    return _Pair(segments, (place, other), distance)
