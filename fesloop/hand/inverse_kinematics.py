"""Inverse kinematics: postures within ranges of motion that bring fingertips to where they should be.

    min over z of  sum_i |tip_i(q) - target_i|^2 + w |z - z_preferred|^2,   q = q_0 + E z,   q within ranges

The freedoms that move are coordinates z; coupled ones follow theirs, DIP follows PIP in a hand. Where there
is more than one posture the small weight w picks the one nearest to the preferred one; where a target is out
of reach the nearest reachable point remains, with its distance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.hand.anthropometry import FINGERS, HandSize
from fesloop.hand.kinematics import checked_angles
from fesloop.hand.kinematics_kernels import forward, joint_lines, point_jacobian, turned
from fesloop.hand.segments import SegmentTree
from fesloop.hand.skeleton import contact_point, hand_tree

Array = NDArray[np.float64]
Coupling = Mapping[str, tuple[str, float]]
"""Freedoms that follow another by a factor above 0: {follower: (leader, factor)}."""


class Coordinates(NamedTuple):
    """Freedoms that lead, by name; E (d, c); bounds (c,), rad, that leaders' and followers' ranges leave."""

    leaders: tuple[str, ...]
    basis: Array
    low: Array
    high: Array


def coordinates_of(tree: SegmentTree, moving: Sequence[str], coupled: Coupling) -> Coordinates:
    """The coordinates that the moving freedoms leave."""
    leaders = tuple(name for name in dict.fromkeys(moving)
                    if name not in coupled or coupled[name][0] not in moving)
    basis, bounds = np.zeros((len(tree.freedoms), len(leaders))), []
    for j, name in enumerate(leaders):
        factors = {name: 1.0, **{follower: factor for follower, (leader, factor) in coupled.items()
                                 if leader == name}}
        for follower, factor in factors.items():
            basis[tree.freedom(follower), j] = factor
        ends = np.array([tree.ranges[tree.freedom(name)] / factor for name, factor in factors.items()])
        bounds.append((ends[:, 0].max(), ends[:, 1].min()))
    low, high = np.array(bounds).reshape(-1, 2).T
    return Coordinates(leaders, basis, low, high)


def connected(moves: NDArray[np.bool_]) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Tips and coordinates of what hangs together in `moves` (t, c), whether a coordinate moves a tip."""
    left, parts = list(range(moves.shape[0])), []
    while left:
        tips = [left.pop(0)]
        while joined := [tip for tip in left if (moves[tip] & moves[tips].any(axis=0)).any()]:
            tips += joined
            left = [tip for tip in left if tip not in joined]
        coordinates = np.flatnonzero(moves[tips].any(axis=0))
        if coordinates.size:
            parts.append((np.array(sorted(tips)), coordinates))
    return parts


def spread(count: int, dimensions: int) -> Array:
    """(count, dimensions) points spread evenly over the unit cube, always the same.

    Multiples of the powers of 1 / g, g^(dimensions + 1) = g + 1, modulo 1 (Roberts 2018, "The unreasonable
    effectiveness of quasirandom sequences").
    """
    g = 2.0
    for _ in range(60):
        g = (1.0 + g) ** (1.0 / (dimensions + 1))
    steps = g ** -np.arange(1.0, dimensions + 1.0)
    return np.asarray((0.5 + np.arange(1.0, count + 1.0)[:, np.newaxis] * steps) % 1.0)


Layout = NDArray[np.int64]

STILL_RAD = 1e-9
"""A step below this is none."""
_FIRST_DAMPING, _LEAST_DAMPING, _MOST_DAMPING = 1e-6, 1e-14, 1e4
"""m^2/rad^2. Chosen: squared lever arms of a hand's joints are 1e-4 to 1e-2 m^2."""


@compiled
def place_tips(
    layout: Layout, geometry: Array, root: Array, angles: Array, segments: NDArray[np.int64], places: Array,
    poses: Array, tips: Array,
) -> None:
    """Fill `poses` (n, 7), and `tips` (t, 3), m, in the reference frame."""
    forward(layout, geometry, angles, root, poses)
    for i in range(segments.shape[0]):
        pose, place = poses[segments[i]], places[i]
        arm = turned((pose[0], pose[1], pose[2], pose[3]), place[0], place[1], place[2])
        for j in range(3):
            tips[i, j] = pose[4 + j] + arm[j]


@compiled
def slopes_of_tips(
    layout: Layout, geometry: Array, moves: NDArray[np.bool_], angles: Array, poses: Array,
    segments: NDArray[np.int64], tips: Array, basis: Array, lines: Array, each: Array, slopes: Array,
) -> None:
    """Fill `slopes` (3 t, c), m/rad: the tips' Jacobian in z. `lines` (d, 6), `each` (6, d) are scratch."""
    joint_lines(layout, geometry, angles, poses, lines)
    for i in range(segments.shape[0]):
        point_jacobian(lines, moves[segments[i]], tips[i], each)
        slopes[3 * i:3 * i + 3] = each[:3] @ basis


@compiled
def damp_step(
    slopes: Array, gradient: Array, held: NDArray[np.bool_], damping: float, step: Array
) -> None:
    """Fill `step` (c,) with -(J'J + damping I)^-1 g in the coordinates that are not held, else 0."""
    matrix = slopes.T @ slopes
    right = -gradient
    for i in range(held.size):
        matrix[i, i] += damping
        if held[i]:
            matrix[i, :] = 0.0
            matrix[:, i] = 0.0
            matrix[i, i], right[i] = 1.0, 0.0
    step[:] = np.linalg.solve(matrix, right)


@compiled
def seek(
    layout: Layout, geometry: Array, moves: NDArray[np.bool_], root: Array, segments: NDArray[np.int64],
    places: Array, targets: Array, basis: Array, offset: Array, low: Array, high: Array, preferred: Array,
    weight: float, iterations: int, z: Array,
) -> Any:
    """Move z (c,), within [low, high], to a least of |tips - targets|^2 + weight |z - preferred|^2.

    Gives that least, and the greatest distance of a tip from its target, m; floats.

    Levenberg-Marquardt on the coordinates that no bound holds, projected onto the bounds (Bertsekas 1982, doi
    10.1137/0320018: two-metric projection): a step is taken if it lessens the cost, else damped more.
    """
    freedoms, tip_count = offset.size, segments.shape[0]
    poses, lines, each = np.empty((layout.shape[0], 7)), np.empty((freedoms, 6)), np.empty((6, freedoms))
    tips, slopes, step = np.empty((tip_count, 3)), np.empty((3 * tip_count, z.size)), np.empty(z.size)
    angles = offset + basis @ z
    place_tips(layout, geometry, root, angles, segments, places, poses, tips)
    away, damping = tips - targets, _FIRST_DAMPING
    cost = np.sum(away**2) + weight * np.sum((z - preferred) ** 2)
    for _ in range(iterations):
        slopes_of_tips(layout, geometry, moves, angles, poses, segments, tips, basis, lines, each, slopes)
        gradient = slopes.T @ away.ravel() + weight * (z - preferred)
        held = ((z <= low) & (gradient > 0.0)) | ((z >= high) & (gradient < 0.0))
        least, trial = cost, z
        while least >= cost and damping < _MOST_DAMPING:
            damp_step(slopes, gradient, held, weight + damping, step)
            trial = np.minimum(np.maximum(z + step, low), high)
            angles = offset + basis @ trial
            place_tips(layout, geometry, root, angles, segments, places, poses, tips)
            least = np.sum((tips - targets) ** 2) + weight * np.sum((trial - preferred) ** 2)
            damping = max(0.1 * damping, _LEAST_DAMPING) if least < cost else 10.0 * damping
        if least >= cost:
            break
        moved = np.abs(trial - z).max()
        z[:], cost, away = trial, least, tips - targets
        if moved < STILL_RAD:
            break
    return cost, np.sqrt(np.sum(away**2, axis=1)).max()


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
    coupled: freedoms that follow another by a factor above 0, {follower: (leader, factor)}; one whose
        leader does not move is like any other.

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
        preferred = angles[[tree.freedom(name) for name in leaders]]
        self.preferred = np.clip(preferred, self.low, self.high)
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
        return self._result(z, wanted)

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
        return self._result(found, path)

    def _checked(self, targets: ArrayLike, axes: int) -> Array:
        array = np.asarray(targets, dtype=np.float64)
        finite = bool(np.isfinite(array).all())
        if array.ndim != axes or array.shape[-2:] != self._places.shape or not finite:
            raise InputError("targets", f"shape {array.shape}" if finite else "not finite",
                             f"finite, {'(n, ' if axes == 3 else '('}{len(self._places)}, 3)")
        return array

    def _result(self, coordinates: Array, targets: Array) -> Nearest:
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
        """Independent chains: with the wrist at rest, every finger."""
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
