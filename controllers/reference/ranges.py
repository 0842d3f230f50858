"""Ranges of motion of the rows of a reference: a row is a synergy or a freedom of the hand, by its name."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np

from fesloop.errors import InputError, did_you_mean
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.streams.blocks.synergies import READY, Synergies

Ranges = Mapping[str, Sequence[float]]
"""Least and greatest value of some rows, deg."""
USUAL_ROWS = ("wrist_extension", "finger_flexion", "thumb_flexion")
"""Those of the block `synergies`."""
WHOLE_TURN = (-180.0, 180.0)
"""deg, of a row without a name."""
_ROUNDING_DEG = 1e-6
"""Values that were turned into rad and back lie that far beyond an end at most."""


@cache
def hand_ranges() -> dict[str, tuple[float, float]]:
    """Range of each ready synergy, which follows from its joints, and of each freedom of the hand, deg."""
    tree = hand_tree(HandSize())
    synergies = Synergies(rows=tuple(READY))
    names = (*synergies.rows, *tree.freedoms)
    limits = np.rad2deg(np.concatenate([synergies.ranges, tree.ranges])).tolist()
    return {name: (low, high) for name, (low, high) in zip(names, limits, strict=True)}


def checked_ranges(rows: Sequence[str], range_deg: Ranges) -> dict[str, tuple[float, float]]:
    """`range_deg` as floats: ranges of rows that the hand does not know, and others than the usual ones.

    Raises InputError unless each row has a name of its own and a range.
    """
    known = {**hand_ranges(), **range_deg}
    if not rows or len(set(rows)) < len(rows):
        raise InputError("rows", f"{tuple(rows)}", "one or more names, each once")
    for row in rows:
        if row not in known:
            raise InputError("rows", f"{row!r}", f"{', '.join(READY)}, or a freedom of the hand",
                             did_you_mean(row, known) or "state its range_deg if it is a row of your own")
    for row, ends in range_deg.items():
        if row not in rows:
            raise InputError(f"range_deg.{row}", "is no row", ", ".join(rows), did_you_mean(row, rows))
        if len(ends) != 2 or not all(map(math.isfinite, ends)) or ends[0] >= ends[1]:
            raise InputError(f"range_deg.{row}", f"{list(ends)}", "least and greatest angle, finite")
    return {row: (float(low), float(high)) for row, (low, high) in range_deg.items()}


def require_in_range(where: str, row: str, value_deg: float, range_deg: Ranges) -> None:
    """Raise InputError, naming `where`, unless a row may have that value."""
    known = {**hand_ranges(), **range_deg}
    low, high = known.get(row, WHOLE_TURN)
    if not math.isfinite(value_deg):
        raise InputError(where, f"{value_deg}", "a finite angle")
    if not low - _ROUNDING_DEG <= value_deg <= high + _ROUNDING_DEG:
        what = f"of {row}" if row else "of a joint"
        raise InputError(where, f"{value_deg:.5g} deg is outside the range of motion {what}",
                         f"{low:.5g} to {high:.5g} deg",
                         "stay within it, or state a range_deg of your own" if row else "")
