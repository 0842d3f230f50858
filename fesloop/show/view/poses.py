"""Poses of a recorded hand, several instants at a time: most of what one takes, all take together."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.show.picture.held import Signals
from fesloop.show.report.objects import padded
from fesloop.show.report.recorded_hand import RecordedHand
from fesloop.show.report.standing import standing

Array = NDArray[np.float64]
AHEAD = 15
"""Frames that are made together (chosen: half a second of them)."""


class Seen(NamedTuple):
    """Poses at one instant, of each hand (17, 7), and of the objects that move (objects, 7)."""

    hands: Mapping[str, Array]
    objects: Array


def poses_at(signals: Signals, hand: RecordedHand, trial: int, at_ns: list[int], objects: int) -> list[Seen]:
    """Poses at instants of a trial; `objects`: how many there are."""
    instants = np.array(at_ns, dtype=np.int64)
    found = standing(signals, hand, trial, instants)
    things = padded(found.solid_poses, objects)
    return [Seen({name: rows[i] for name, rows in found.hands.items()}, things[i])
            for i in range(len(at_ns))]
