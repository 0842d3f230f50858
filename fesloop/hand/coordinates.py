"""Coordinates of the freedoms that move: what follows them, how far they go, which of them hang together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.hand.segments import SegmentTree

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
