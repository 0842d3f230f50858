"""Grip force of a hand on an object, from normal forces on parts of the hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.hand.anthropometry import FINGERS, FINGERTIPS, PARTS

Array = NDArray[np.float64]


def require_places(places: Sequence[str], where: str) -> None:
    """Raise InputError, naming the parameter `where`, unless each place is one of `PARTS`, and once."""
    for place in places:
        if place not in PARTS:
            raise InputError(where, f"{place!r} is no part of the hand", ", ".join(PARTS),
                             did_you_mean(str(place), PARTS))
        if list(places).count(place) > 1:
            raise InputError(where, f"{place!r} is listed twice", "each part once")


def places_of(forces: Array) -> tuple[str, ...]:
    """Places of forces (..., k) without names: all of `PARTS` if there are as many, else the fingertips."""
    return PARTS if forces.shape[-1] == len(PARTS) else FINGERTIPS


def _digit(place: str) -> str:
    return "thumb" if place.startswith("F1") else "palm" if place == "palm" else "fingers"


def _row(place: str) -> str:
    """Parts that press on an object from about one direction: thumb, palm, or one row of phalanges."""
    side = _digit(place)
    return place[-1] if side == "fingers" else side


def grip_force(forces: Array, places: Sequence[str]) -> Array:
    """Grip force (...), N: friction carries 2 friction grip_force, at least.

    Of normal forces (..., k) on `places`, k of `PARTS`. With all parts it is half of their sum: the force of
    each side in a grip between two. Where parts have no sensor, it is the force of thumb, palm or one row of
    phalanges of the four fingers if that is greater: on an object at rest what presses from one side is met
    from the other, by parts with or without a sensor.
    """
    half = 0.5 * forces.sum(axis=-1)
    if set(places) >= set(PARTS):
        return np.asarray(half)
    rows = [_row(place) for place in places]
    each = [forces[..., [row == name for row in rows]].sum(axis=-1) for name in dict.fromkeys(rows)]
    return np.asarray(np.maximum.reduce([half, *each]))


def sides(forces: Array, places: Sequence[str]) -> Array:
    """Sums (..., s), N, over thumb, fingers and palm, as far as `places` are on them, of forces (..., k)."""
    digits = [_digit(place) for place in places]
    return np.stack([forces[..., [digit == name for digit in digits]].sum(axis=-1)
                     for name in ("thumb", "fingers", "palm") if name in digits], axis=-1)


def by_digit(forces: Array, places: Sequence[str]) -> dict[str, Array]:
    """Sums (...), N, over each digit and the palm, as far as `places` are on them, of forces (..., k)."""
    names = [place if place == "palm" else place[:2] for place in places]
    return {name: np.asarray(forces[..., [each == name for each in names]].sum(axis=-1))
            for name in (*FINGERS, "palm") if name in names}
