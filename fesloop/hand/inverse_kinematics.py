"""Inverse kinematics: postures within ranges of motion that bring fingertips to where they should be.

    min over z of  sum_i |tip_i(q) - target_i|^2 + w |z - z_preferred|^2,   q = q_0 + E z,   q within ranges

The freedoms that move are coordinates z; coupled ones follow theirs, DIP follows PIP in a hand. Where there
is more than one posture the small weight w picks the one nearest to the preferred one; where a target is out
of reach the nearest reachable point remains, with its distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.errors import InputError
from fesloop.hand.anthropometry import FINGERS, HandSize
from fesloop.hand.coordinates import Coupling, connected, coordinates_of, spread
from fesloop.hand.inverse_kinematics_kernels import place_tips, seek
from fesloop.hand.kinematics import checked_angles
from fesloop.hand.segments import SegmentTree
from fesloop.hand.skeleton import contact_point, hand_tree

Array = NDArray[np.float64]

DIP_OF_PIP = 2.0 / 3.0
"""DIP over PIP flexion (Rijpkema and Girard 1991, doi 10.1145/122718.122754)."""
HAND_COUPLING: Coupling = {f"{finger}_dip_flexion": (f"{finger}_pip_flexion", DIP_OF_PIP)
                           for finger in FINGERS[1:]}
_PREFERENCES = (1e-4, 1e-6, 1e-9)
"""w, m^2/rad^2, one after the other (chosen): at first 0.1 rad off the preferred posture counts as much as
1 mm off the target, at last 1 rad as 0.03 mm. With the last alone the search would creep along the curved
valley of all postures that reach the target; with the first, all starts would end in one place."""
_REACHED_M = 5e-5
"""Nearer than this a target counts as reached, and no other start is tried (chosen: half of 0.1 mm)."""
_STARTS, _ITERATIONS = 16, 200
"""Starts that are tried where the first does not reach its target (chosen: of 1500 random postures of a thumb
three took another, of a finger none, of 300 of a whole hand with its wrist none more than six)."""
_ROUNDING = 1e-9
_AT_REFERENCE = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])


class Nearest(NamedTuple):
    """Angles (..., d), rad, and how far each tip stays from its target, (..., t), m."""

    angles: Array
    distances: Array


class _Chain(NamedTuple):
    """Tips and coordinates, by number, that depend on each other but on no others; what `seek` takes."""

    tips: NDArray[np.intp]
    coordinates: NDArray[np.intp]
    segments: NDArray[np.int64]
    places: Array
    basis: Array
    low: Array
    high: Array
    preferred: Array
    starts: Array


class InverseKinematics:
    """Finds postures of a segment tree for places of some of its points.

    Parameters
    ----------
    tree: of d freedoms, its root at the origin of the reference frame.
    segments, places: the t tips: points (t, 3), m, in the frames of segments by name.
    preferred: (d,), rad: what freedoms that do not move keep, and what others come near to if they can.
    moving: names of the freedoms that may move.
    coupled: freedoms that follow another by a factor above 0, {follower: (leader, factor)}; whose leader does
        not move are like any other.

    Raises InputError for unknown names and for a preferred angle outside its range.

    Attributes
    ----------
    low, high: (c,), rad, bounds of the coordinates.
    preferred: (c,), rad, the preferred posture's, within them.
    """

    def __init__(self, tree: SegmentTree, segments: Sequence[str], places: ArrayLike, *,
                 preferred: ArrayLike, moving: Sequence[str], coupled: Coupling | None = None) -> None:
        self.tree = tree
        self._segments = np.array([tree.index(name) for name in segments], dtype=np.int64)
        self._places = np.array(places, dtype=np.float64).reshape(-1, 3)
        if len(self._places) != len(self._segments):
            raise InputError("places", f"{len(self._places)} points", f"{len(self._segments)}, one a segment")
        angles = checked_angles(tree, preferred)
        _require_within(tree, angles)
        leaders, self._basis, self.low, self.high = coordinates_of(tree, moving, coupled or {})
        wanted = angles[[tree.freedom(name) for name in leaders]]
        self.preferred = np.clip(wanted, self.low, self.high)
        self._offset = np.where(self._basis.any(axis=1), 0.0, angles)
        self._chains = self._apart()

    def posture(self, coordinates: ArrayLike) -> Array:
        """Angles (..., d) of coordinates (..., c)."""
        posture: Array = self._offset + np.asarray(coordinates, dtype=np.float64) @ self._basis.T
        return posture

    def tips(self, angles: ArrayLike) -> Array:
        """Places (..., t, 3), m, of the tips in postures (..., d)."""
        postures = checked_angles(self.tree, angles)
        found = np.empty((*postures.shape[:-1], len(self._segments), 3))
        poses = np.empty((len(self.tree.segments), 7))
        rows = postures.reshape(-1, postures.shape[-1])
        for posture, tips in zip(rows, found.reshape(-1, *found.shape[-2:]), strict=True):
            place_tips(self.tree.layout, self.tree.geometry, _AT_REFERENCE, posture, self._segments,
                       self._places, poses, tips)
        return found

    def nearest(self, targets: ArrayLike) -> Nearest:
        """The posture for targets (t, 3), m."""
        wanted = self._checked(targets, 2)
        z = self.preferred.copy()
        for chain in self._chains:
            self._search(chain, wanted, z)
        return self._told(z, wanted)

    def along(self, targets: ArrayLike) -> Nearest:
        """Postures for targets (n, t, 3), m, each searched from the one before it.

        Where a path leaves the reach other starts are tried once, and then not before it is back.
        """
        path = self._checked(targets, 3)
        z, found = self.preferred.copy(), np.empty((len(path), self.preferred.size))
        reached = [True] * len(self._chains)
        for k, row in enumerate(path):
            for i, chain in enumerate(self._chains):
                reached[i] = self._search(chain, row, z, everywhere=reached[i])
            found[k] = z
        return self._told(found, path)

    def _checked(self, targets: ArrayLike, axes: int) -> Array:
        array = np.asarray(targets, dtype=np.float64)
        finite = bool(np.isfinite(array).all())
        if array.ndim != axes or array.shape[-2:] != self._places.shape or not finite:
            raise InputError("targets", f"shape {array.shape}" if finite else "not finite",
                             f"finite, {'(n, ' if axes == 3 else '('}{len(self._places)}, 3)")
        return array

    def _told(self, coordinates: Array, targets: Array) -> Nearest:
        angles = self.posture(coordinates)
        return Nearest(angles, np.linalg.norm(self.tips(angles) - targets, axis=-1))

    def _search(self, chain: _Chain, targets: Array, z: Array, *, everywhere: bool = True) -> bool:
        """Move a chain's part of z to the nearest posture, from there or everywhere; if it gets there."""
        tree, best = self.tree, np.inf
        here = z[chain.coordinates]
        starts = (here, *((here, chain.preferred, *chain.starts) if everywhere else ()))
        for number, start in enumerate(starts):
            trial = start.copy()
            for weight in _PREFERENCES if number == 0 else _PREFERENCES[-1:]:
                cost, furthest = seek(
                    tree.layout, tree.geometry, tree.moved, _AT_REFERENCE, chain.segments, chain.places,
                    targets[chain.tips], chain.basis, self._offset, chain.low, chain.high, chain.preferred,
                    weight, _ITERATIONS, trial)
            if cost < best:
                best, z[chain.coordinates] = cost, trial
            if furthest < _REACHED_M:
                return True
        return False

    def _apart(self) -> tuple[_Chain, ...]:
        """What hangs together, each for itself: with the wrist at rest, every finger."""
        chains = []
        for tips, mine in connected(self.tree.moved[self._segments] @ np.abs(self._basis) > 0.0):
            low, high = self.low[mine], self.high[mine]
            chains.append(_Chain(
                tips, mine, self._segments[tips], self._places[tips],
                np.ascontiguousarray(self._basis[:, mine]), low, high, self.preferred[mine],
                low + spread(_STARTS, mine.size) * (high - low)))
        return tuple(chains)


def _require_within(tree: SegmentTree, angles: Array) -> None:
    """Raise InputError, naming the freedom, unless angles (d,) are within their ranges."""
    for name, angle, (low, high) in zip(tree.freedoms, angles, tree.ranges, strict=True):
        if not low - _ROUNDING <= angle <= high + _ROUNDING:
            raise InputError(f"preferred.{name}", f"{np.degrees(angle):.5g} deg",
                             f"{np.degrees(low):.5g} to {np.degrees(high):.5g} deg")


def of_hand(
    size: HandSize, fingers: Sequence[str], preferred: ArrayLike, *, moving: Sequence[str] = (),
    contact: str = "tip",
) -> InverseKinematics:
    """For fingertips of a hand in the wrist coordinate system, DIP following PIP.

    Parameters
    ----------
    fingers: F1 to F5, those whose tips have targets.
    preferred: (23,), rad, as in `InverseKinematics`.
    moving: freedoms that may move; empty: all of these fingers.
    contact: which point of a fingertip (`fesloop.hand.skeleton.CONTACTS`); the bone's end is "tip".
    """
    tree = hand_tree(size)
    own = tuple(name for name in tree.freedoms if name.partition("_")[0] in fingers)
    places = [contact_point(size, finger, contact) for finger in fingers]
    return InverseKinematics(
        tree, [f"{finger}d" for finger in fingers], places, preferred=preferred,
        moving=tuple(moving) or own, coupled=HAND_COUPLING)
