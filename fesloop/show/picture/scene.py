"""Objects around a recorded hand: the object that it may grasp, and the table."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.hand import quaternion
from fesloop.hand.mug import Mug, parts_of
from fesloop.show.picture.cast import Player
from fesloop.show.picture.render import Kind, Solid
from fesloop.show.picture.signals import Signals, values_at

Array = NDArray[np.float64]
Instants = NDArray[np.int64]
_KINDS: dict[str, Kind] = {"cylinder": "cylinder", "ball": "sphere", "block": "box", "card": "box"}
_OBJECT, _TABLE = (0.42, 0.66, 0.84), (0.86, 0.85, 0.82)
_TOP_M = 0.01
"""Thickness of a table top."""
_UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
_WAITING_M = 1e-3
"""Distance from its waiting place within which an object waits (chosen: it is held there exactly)."""


def solids_of(
    recording: Signals, hand: Player, trial: int, at_ns: Instants
) -> tuple[list[list[Solid]], list[str]]:
    """Object and table, from the wrist's centre, at each instant; and notes on what cannot be drawn of them.

    Both come from a hand plant with the parameters `object` (shape, size_mm) and `table` (height_m, centre_m,
    half_m, and `drop(time_ns)`, how far it has sunk, m), each of which may be absent. An object that waits,
    `waits_m` beside where it will be given, is not there yet.
    """
    things, notes = _objects(recording, hand, trial, at_ns)
    tops = _tables(getattr(hand.part, "table", None), at_ns)
    return [thing + top for thing, top in zip(things, tops, strict=True)], notes


def _objects(
    recording: Signals, hand: Player, trial: int, at_ns: Instants
) -> tuple[list[list[Solid]], list[str]]:
    thing = getattr(hand.part, "object", None)
    nothing: list[list[Solid]] = [[] for _ in at_ns]
    if thing is None:
        return nothing, []
    names = [f"{hand.name}.object_{port}" for port in ("position", "orientation")]
    missing = [name for name in names if name not in recording.signals]
    if missing:
        return nothing, [f"the object is not drawn: {', '.join(missing)} not recorded"]
    if thing.shape not in (*_KINDS, "mug"):
        known = ", ".join((*_KINDS, "mug"))
        return nothing, [f"the object is not drawn: shape {thing.shape!r} is none of {known}"]
    positions, turns = (values_at(recording, name, trial, at_ns) for name in names)
    if positions is None or turns is None:
        return nothing, ["the object is not drawn: nothing of it was recorded in this trial"]
    parts = _mug(thing.size_mm) if thing.shape == "mug" else [
        Solid(_KINDS[thing.shape], np.zeros(3), _UPRIGHT, half_sizes(thing.shape, thing.size_mm), _OBJECT)]
    there = np.isfinite(positions).all(axis=1) & np.isfinite(turns).all(axis=1) & ~_waiting(thing, positions)
    return [[_placed(part, place, turn) for part in parts] if is_there else []
            for place, turn, is_there in zip(positions, turns, there, strict=True)], []


def _waiting(thing: Any, positions: Array) -> NDArray[np.bool_]:
    """Whether an object waits to be given, at its places (t, 3), m."""
    off = np.asarray(getattr(thing, "waits_m", (0.0, 0.0, 0.0)))
    if not (off.any() and getattr(thing, "given_at_s", 0.0) > 0.0):
        return np.zeros(len(positions), np.bool_)
    return np.asarray(np.linalg.norm(positions - thing.position_m - off, axis=1) < _WAITING_M)


def _placed(part: Solid, place: Array, turn: Array) -> Solid:
    """A part of an object whose origin and orientation are given."""
    if part.position.any() or part.orientation[0] != 1.0:
        place = place + quaternion.rotate(turn, part.position)
        turn = quaternion.multiply(turn, part.orientation)
    return replace(part, position=place, orientation=turn)


def _mug(size_mm: tuple[float, ...]) -> list[Solid]:
    """Solids of a mug, in its axes; the rods of its handle have spheres where they meet."""
    mug = Mug.of(size_mm)
    solids = [Solid("box" if part.kind == "box" else "cylinder", part.centre, part.orientation, part.half,
                    _OBJECT) for part in parts_of(mug)]
    joint = np.array([mug.rod, 0.0, 0.0])
    return solids + [Solid("sphere", point, _UPRIGHT, joint, _OBJECT) for point in mug.handle_line()[1:-1]]


def half_sizes(shape: str, size_mm: tuple[float, ...]) -> Array:
    """Half sizes of a solid (see `Solid`), m, from an object's `size_mm`, its diameters and sides."""
    half = 5e-4 * np.array(size_mm, dtype=np.float64)
    return np.concatenate([half, np.zeros(3 - len(half))])


def _tables(table: Any, at_ns: Instants) -> list[list[Solid]]:
    if table is None:
        return [[] for _ in at_ns]
    half = np.array([*table.half_m, 0.5 * _TOP_M])
    heights = [table.height_m - 0.5 * _TOP_M - table.drop(int(now)) for now in at_ns]
    places = [np.array([*table.centre_m, height]) for height in heights]
    return [[Solid("box", place, _UPRIGHT, half, _TABLE, fades=True)] for place in places]
