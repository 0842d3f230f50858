"""What stands about a recorded hand: an object, and a table that may sink, as solids and their poses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fesloop.show.picture.cast import Player
from fesloop.show.picture.held import Signals
from fesloop.show.picture.render import Solid as Drawn
from fesloop.show.picture.scene import solids_of
from fesloop.show.report.figure3d import Solid

Array = NDArray[np.float64]
Instants = NDArray[np.int64]
_OBJECT, _TABLE = "object", "surface"


def object_poses(
    signals: Signals, plant: Player | None, trial: int, at_ns: Instants
) -> tuple[list[Solid], Array]:
    """Solids, object first, and their poses (t, solids, 7): orientation (w, x, y, z) and position, global, m.

    NaN where one is not known; none where there is no plant.
    """
    if plant is None:
        return [], np.empty((len(at_ns), 0, 7))
    drawn, _ = solids_of(signals, plant, trial, at_ns)
    kinds: dict[bool, Drawn] = {each.fades: each for row in drawn for each in row}
    order = sorted(kinds)
    poses = np.full((len(at_ns), len(order), 7), np.nan)
    for row, there in zip(poses, drawn, strict=True):
        for each in there:
            row[order.index(each.fades)] = [*each.orientation, *each.position]
    return [_solid(kinds[fades]) for fades in order], poses


def padded(poses: Array, count: int) -> Array:
    """Poses (t, count, 7) of so many solids; the object, which comes first, may be unknown all the time."""
    missing = np.full((len(poses), count - poses.shape[1], 7), np.nan)
    return np.concatenate([missing, poses], axis=1)


def _solid(drawn: Drawn) -> Solid:
    x, y, z = (float(half) for half in drawn.half)
    halves = {"box": (x, y, z), "cylinder": (x, x, y), "sphere": (x, x, x)}[drawn.kind]
    return Solid(kind=drawn.kind, half_sizes=halves, role=_TABLE if drawn.fades else _OBJECT,
                 moves=True)


def holdable(solids: Sequence[Solid]) -> bool:
    """Whether there is anything that a hand may hold."""
    return any(solid.role == _OBJECT for solid in solids)
