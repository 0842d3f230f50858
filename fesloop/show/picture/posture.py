"""Postures of a recorded hand at given instants: the true one, and the estimate of a tracker."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import Poses, placed, segment_poses
from fesloop.hand.skeleton import dorsal_points, hand_tree
from fesloop.show.picture.cast import Player
from fesloop.show.picture.signals import Signals, values_at

Array = NDArray[np.float64]
Instants = NDArray[np.int64]
_HALF = np.sqrt(0.5)
_PALM_DOWN = {"left": (_HALF, 0.0, -_HALF, 0.0), "right": (0.0, _HALF, 0.0, -_HALF)}
"""Default orientation of the forearm: palm down, fingers to the north."""
_HAND = 1
"""Segment of the palm."""


@dataclass(frozen=True, slots=True, eq=False)
class Posture:
    """A hand at some instants t.

    Attributes
    ----------
    size: of the hand. poses: (t, 17), of its segments, global, m.
    """

    size: HandSize
    poses: Poses

    def at(self, i: int) -> Poses:
        """Poses (17,) at one of the instants."""
        return Poses(self.poses.orientation[i], self.poses.position[i])

    @property
    def finite(self) -> NDArray[np.bool_]:
        """Mask (t,) of instants whose numbers are all finite."""
        return np.asarray(np.isfinite(self.poses.orientation).all(axis=(1, 2))
                          & np.isfinite(self.poses.position).all(axis=(1, 2)))


def true_posture(recording: Signals, hand: Player, trial: int, at_ns: Instants) -> Posture | None:
    """True posture from the sites' orientations or from `angles`; None if neither is recorded.

    Orientations are what a hand has; angles leave out how one person's axes are tilted. Lengths are those of
    the hand's measures.
    """
    size = hand.hand_size
    tree = hand_tree(size)
    angles, orientation, position = (
        values_at(recording, name, trial, at_ns) if name in recording.signals else None
        for name in (f"{hand.name}.{port}" for port in ("angles", "site_orientation", "site_position")))
    if orientation is not None:
        wrist = np.zeros((len(at_ns), 3))
        if position is not None:
            wrist = position[:, 0] - quaternion.rotate(orientation[:, 0], dorsal_points(size)[0])
        return Posture(size, placed(tree, orientation, wrist))
    if angles is None:
        return None
    # A forearm that was not recorded is drawn as at the start, with the wrist at the origin.
    return posture_of_angles(size, angles, getattr(hand.part, "forearm_orientation", ()))


def posture_of_angles(size: HandSize, angles: Array, forearm: Sequence[float] = ()) -> Posture:
    """Posture from joint angles (t, 23), rad, with the wrist at the origin and by default the palm down."""
    turn = np.broadcast_to(np.array(forearm or _PALM_DOWN[size.side], dtype=np.float64), (len(angles), 4))
    return Posture(size, segment_poses(hand_tree(size), angles, Poses(turn, np.zeros((len(angles), 3)))))


def estimated_posture(
    recording: Signals, tracker: Player, trial: int, at_ns: Instants, truth: Posture
) -> tuple[Posture, str] | None:
    """Posture of a tracker aligned with the true one at a segment, and that segment; None if it has none yet.

    A tracker has no place, and without a magnetometer no heading: its hand is aligned with the true forearm,
    or with the true palm where the tracker does not estimate the wrist.
    """
    angles = values_at(recording, f"{tracker.name}.angles", trial, at_ns)
    size = tracker.hand_size
    tree = hand_tree(size)
    if angles is None or angles.shape[1:] != (len(tree.ranges),):
        return None
    own = segment_poses(tree, angles)
    unseen = f"{tracker.name}.angle_sd" in recording.signals and _wrist_unseen(
        values_at(recording, f"{tracker.name}.angle_sd", trial, at_ns))
    segment = _HAND if unseen else 0
    return Posture(size, _laid_onto(own, truth.poses, segment)), tree.names[segment]


def _wrist_unseen(deviation: Any) -> bool:
    return bool((deviation[:, 0] >= np.pi - 1e-6).any())


def _laid_onto(own: Poses, target: Poses, segment: int) -> Poses:
    """Poses (t, 17) moved as a whole so that one segment has the target's pose."""
    back = quaternion.conjugate(own.orientation[:, segment])
    turn = quaternion.multiply(target.orientation[:, segment], back)[:, np.newaxis]
    place = quaternion.rotate(turn, own.position - own.position[:, segment:segment + 1])
    return Poses(quaternion.multiply(turn, own.orientation), place + target.position[:, segment:segment + 1])
