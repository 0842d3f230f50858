"""Forces of a grasp: when thumb and fingers touch, how hard they grip, and how much of that is needed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.hand.motion import STANDARD_GRAVITY

Array = NDArray[np.float64]
LASTING_S = 0.1
"""Contact counts that stays for so long (chosen: a touch in passing is shorter)."""


def grip_force(forces: Array) -> Array:
    """(n,) N from the normal forces (n, 5), N, on the fingertips: the thumb's, or all fingers' if greater.

    On an object at rest what presses from one side is met from the other, by fingertips or by parts of the
    hand that no sensor is on, so that friction carries 2 friction grip_force at least.
    """
    return np.asarray(np.maximum(forces[..., 0], forces[..., 1:].sum(axis=-1)))


def contact_s(times_s: Array, forces: Array, starts_s: float, contact_n: float, *,
              one_side: bool = False) -> float:
    """First instant from `starts_s` on at which the thumb (first column of (n, 5), N) and all fingers
    together press by more than `contact_n` and go on so for `LASTING_S`; NaN if there is none.

    `one_side`: whether thumb or fingers alone will do.
    """
    sides = forces[:, 0] > contact_n, forces[:, 1:].sum(axis=1) > contact_n
    touching = (sides[0] | sides[1] if one_side else sides[0] & sides[1]) & (times_s >= starts_s)
    first = first_lasting(times_s, touching)
    return math.nan if first is None else float(times_s[first])


def first_lasting(times_s: Array, flags: NDArray[np.bool_]) -> int | None:
    """Number of the first row (of n) from which on a flag holds for `LASTING_S`; None if there is none."""
    changes = np.flatnonzero(np.diff(flags.astype(np.int8), prepend=0, append=0))
    for first, after in zip(changes[::2], changes[1::2], strict=True):
        # A row at an end stands until the next one does.
        if times_s[min(after, times_s.size - 1)] - times_s[first] >= LASTING_S:
            return int(first)
    return None


def needed_grip_n(node: Mapping[str, Any]) -> float:
    """Least grip force, N, that keeps an object from slipping: weight / (2 friction).

    Of the object that the table of a hand plant tells; NaN where it tells none. Two fingers of force N on
    either side carry 2 friction N (Westling and Johansson 1984, doi 10.1007/BF00238156, for the slip ratio).
    """
    thing = node.get("object")
    if not isinstance(thing, Mapping) or not thing.get("friction"):
        return math.nan
    return float(thing["mass_kg"] * STANDARD_GRAVITY / (2.0 * thing["friction"]))
