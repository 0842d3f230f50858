"""Where recorded hands stood at some instants, and what stood about them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.show.picture.held import Signals
from fesloop.show.picture.posture import Posture
from fesloop.show.report.figure3d import Solid
from fesloop.show.report.objects import holdable, object_poses
from fesloop.show.report.recorded_hand import TRUTH, RecordedHand

Array = NDArray[np.float64]
Instants = NDArray[np.int64]


class Standing(NamedTuple):
    """Hands and solids at instants t of a trial.

    Attributes
    ----------
    postures: as the newest rows tell them, by hand ("truth", "estimate"); none where nothing is recorded.
    hands: poses of their segments, (t, 17, 7), as `fesloop.show.report.figure3d.Frames` has them; NaN where
        they are not known.
    solids, solid_poses: what stands there, object first, and (t, solids, 7), NaN likewise.
    """

    postures: Mapping[str, Posture]
    hands: Mapping[str, Array]
    solids: Sequence[Solid]
    solid_poses: Array


def standing(signals: Signals, hand: RecordedHand, trial: int, at_ns: Instants) -> Standing:
    """Of a trial. Raises InputError for rows that the file lost."""
    postures = hand.postures(signals, trial, at_ns)
    solids, solid_poses = object_poses(signals, hand.plant, trial, at_ns)
    hands = {name: rows_of(posture) for name, posture in postures.items()}
    for name, rows in hands.items():
        ended = hand.ended(signals, name, trial, at_ns)
        rows[ended] = np.nan
        if name == TRUTH:
            # The object is told by the same rows; a table is where its parameters say.
            held = np.array([holdable([solid]) for solid in solids], dtype=np.bool_)
            solid_poses[np.ix_(ended, held)] = np.nan
    return Standing(postures, hands, solids, solid_poses)


def rows_of(posture: Posture) -> Array:
    """(t, 17, 7): orientation and position of each segment, as `Frames` has them."""
    return np.concatenate([posture.poses.orientation, posture.poses.position], axis=-1)
