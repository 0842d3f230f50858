"""Hands of a recording, true and estimated, with their objects, at any instants.

Three kinds of recordings have a hand: those of a hand plant, with or without a tracker; those of a tracker
alone, as with replayed sensors; and those of a finger with three joints.
"""


from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import Poses
from fesloop.hand.skeleton import RESTING_DEG, hand_tree
from fesloop.loop.clock import FOREVER
from fesloop.show.picture.cast import Cast, Player
from fesloop.show.picture.hand_mesh import NOTHING, Mesh, segment_meshes
from fesloop.show.picture.posture import Posture, estimated_posture, posture_of_angles, true_posture
from fesloop.show.picture.render import Solid as Drawn
from fesloop.show.picture.scene import solids_of
from fesloop.show.picture.signals import Signals, values_at
from fesloop.show.report.parts import Solid

Array = NDArray[np.float64]
Instants = NDArray[np.int64]
_OBJECT_ROLE, _TABLE_ROLE = "object", "surface"


def object_poses(
    signals: Signals, plant: Player | None, trial: int, at_ns: Instants
) -> tuple[list[Solid], Array]:
    """Solids, the object first, and poses (t, solids, 7): orientation (w, x, y, z) and position, global, m.

    Unknown poses are NaN. Without a plant there are no solids.
    """
    if plant is None:
        return [], np.empty((len(at_ns), 0, 7))
    drawn, _ = solids_of(signals, plant, trial, at_ns)
    things, tops = (max((_of(row, fades) for row in drawn), key=len, default=[]) for fades in (False, True))
    poses = np.full((len(at_ns), len(things) + len(tops), 7), np.nan)
    for row, there in zip(poses, drawn, strict=True):
        for first, fades in ((0, False), (len(things), True)):
            for number, each in enumerate(_of(there, fades), first):
                row[number] = [*each.orientation, *each.position]
    return [_solid(each) for each in (*things, *tops)], poses


def _of(solids: Sequence[Drawn], fades: bool) -> list[Drawn]:
    """The solids of the object, or of the table, which fades."""
    return [each for each in solids if each.fades == fades]


def padded(poses: Array, count: int) -> Array:
    """Poses (t, count, 7), padded with NaN for an object, the first solids, that is never known."""
    missing = np.full((len(poses), count - poses.shape[1], 7), np.nan)
    return np.concatenate([missing, poses], axis=1)


def _solid(drawn: Drawn) -> Solid:
    x, y, z = (float(half) for half in drawn.half)
    halves = {"box": (x, y, z), "cylinder": (x, x, y), "sphere": (x, x, x)}[drawn.kind]
    return Solid(kind=drawn.kind, half_sizes=halves, role=_TABLE_ROLE if drawn.fades else _OBJECT_ROLE,
                 moves=True)


def holdable(solids: Sequence[Solid]) -> bool:
    """Return whether there is an object that a hand may hold."""
    return any(solid.role == _OBJECT_ROLE for solid in solids)


Postures = Callable[[Signals, int, Instants], dict[str, Posture]]
"""Function from signals, trial and instants to the postures of the hands that are recorded in the trial."""
TRUTH, ESTIMATE = "truth", "estimate"
_POSTURE_PORTS = ("site_orientation", "angles")
_FINGER = "F2"
_FLEXIONS = tuple(f"{_FINGER}_{joint}_flexion" for joint in ("mcp", "pip", "dip"))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordedHand:
    """Recorded hands.

    Attributes
    ----------
    text: description in a sentence or two.
    shapes: by hand ("truth", "estimate"), one mesh per segment.
    sources: signals from which postures derive.
    postures: function that gives postures at instants.
    pose_signals: by hand, the signal whose rows give its posture.
    plant: plant whose object and table are shown; None without one.
    held_ns: duration for which the last row of a signal is shown in a trial.
    """

    text: str
    shapes: Mapping[str, Sequence[Mesh]]
    sources: Sequence[str]
    postures: Postures
    pose_signals: Mapping[str, str]
    plant: Player | None = None
    held_ns: int = FOREVER

    def ended(self, signals: Signals, name: str, trial: int, at_ns: Instants) -> NDArray[np.bool_]:
        """Mask (t,) of the instants after the end of a hand's signal."""
        times, _ = signals.column(self.pose_signals[name], trial)
        return np.asarray(at_ns - self.held_ns > times[-1])


def recorded_hand(signals: Signals, cast: Cast, score: Mapping[str, Any]) -> RecordedHand | None:
    """Hands of a recording, from its blocks and scored signals; None if it has none."""
    trackers = [each for each in cast.trackers if _holds_whole_hand(signals, each)]
    tracker = trackers[0] if trackers else None
    truth = [f"{cast.hand.name}.{port}" for port in _POSTURE_PORTS] if cast.hand is not None else []
    truth = [name for name in truth if name in signals.signals]
    if cast.hand is not None and truth:
        return _hand_of_plant(cast.hand, tracker, truth)
    if tracker is not None:
        return _hand_of_tracker(tracker)
    return _finger(signals, score)


def _holds_whole_hand(signals: Signals, tracker: Player) -> bool:
    return _shape(signals, f"{tracker.name}.angles") == (len(hand_tree(tracker.hand_size).ranges),)


def _shape(signals: Signals, name: str | None) -> tuple[int, ...] | None:
    """Shape of a signal's values; None if it is not recorded."""
    if name is None or name not in signals.signals:
        return None
    return tuple(signals.column(name)[1].shape[1:])


def _hand_of_plant(hand: Player, tracker: Player | None, truth: Sequence[str]) -> RecordedHand:
    size = hand.hand_size
    shapes = {TRUTH: segment_meshes(size)}
    text = f"A {size.side} hand of {size.hand_mm:.0f} mm as it was"
    if tracker is not None:
        shapes[ESTIMATE] = segment_meshes(tracker.hand_size, forearm=False)
        text += f", and translucent as {tracker.name} had it, laid onto the true forearm or palm"

    def postures(signals: Signals, trial: int, at_ns: Instants) -> dict[str, Posture]:
        true = true_posture(signals, hand, trial, at_ns)
        if true is None:
            return {}
        found = estimated_posture(signals, tracker, trial, at_ns, true) if tracker is not None else None
        if tracker is None or found is None:
            return {TRUTH: true}
        name = f"{tracker.name}.angles"
        return {TRUTH: true, ESTIMATE: _since_first(found[0], signals, name, trial, at_ns)}

    estimate = {ESTIMATE: f"{tracker.name}.angles"} if tracker is not None else {}
    return RecordedHand(text=f"{text}.", shapes=shapes, sources=[*truth, *estimate.values()],
                        postures=postures, pose_signals={TRUTH: truth[0], **estimate}, plant=hand)


def _hand_of_tracker(tracker: Player) -> RecordedHand:
    name, size = f"{tracker.name}.angles", tracker.hand_size

    def postures(signals: Signals, trial: int, at_ns: Instants) -> dict[str, Posture]:
        angles = values_at(signals, name, trial, at_ns)
        if angles is None:
            return {}
        return {ESTIMATE: _since_first(posture_of_angles(size, angles), signals, name, trial, at_ns)}

    text = f"A {size.side} hand of {size.hand_mm:.0f} mm as {tracker.name} had it, its forearm at rest."
    return RecordedHand(text=text, shapes={ESTIMATE: segment_meshes(size)}, sources=[name], postures=postures,
                        pose_signals={ESTIMATE: name})


def _finger(signals: Signals, score: Mapping[str, Any]) -> RecordedHand | None:
    """Hand whose index finger has three scored joint angles; None for any other number."""
    names = {hand: str(score[hand]) for hand in (TRUTH, ESTIMATE)
             if _shape(signals, score.get(hand)) == (len(_FLEXIONS),)}
    if TRUTH not in names:
        return None
    size = HandSize()
    whole = segment_meshes(size)
    of_finger = [mesh if name.startswith(_FINGER) else NOTHING
                 for name, mesh in zip(hand_tree(size).names, whole, strict=True)]
    shapes = {TRUTH: whole, ESTIMATE: of_finger}
    text = f"The index finger as {names[TRUTH]} has it; the hand about it is drawn at rest."
    if ESTIMATE in names:
        text = f"{text[:-1]}. Translucent: as {names[ESTIMATE]} has it."
    return RecordedHand(text=text, shapes={hand: shapes[hand] for hand in names},
                        sources=list(names.values()), postures=partial(_finger_postures, names, size),
                        pose_signals=names)


def _finger_postures(
    names: Mapping[str, str], size: HandSize, signals: Signals, trial: int, at_ns: Instants
) -> dict[str, Posture]:
    tree = hand_tree(size)
    resting = np.deg2rad([RESTING_DEG[freedom] for freedom in tree.freedoms])
    columns = [tree.freedom(name) for name in _FLEXIONS]
    found: dict[str, Posture] = {}
    for hand, name in names.items():
        values = values_at(signals, name, trial, at_ns)
        if values is not None:
            angles = np.tile(resting, (len(at_ns), 1))
            angles[:, columns] = values
            found[hand] = _since_first(posture_of_angles(size, angles), signals, name, trial, at_ns)
    return found


def _since_first(posture: Posture, signals: Signals, name: str, trial: int, at_ns: Instants) -> Posture:
    """Posture with NaN before a signal's first value in the trial."""
    times, _ = signals.column(name, trial)
    early = (at_ns < times[0])[:, np.newaxis, np.newaxis]
    poses = posture.poses
    return Posture(posture.size, Poses(np.where(early, np.nan, poses.orientation),
                                       np.where(early, np.nan, poses.position)))


class HandsAt(NamedTuple):
    """Hands and solids at instants t of a trial.

    Attributes
    ----------
    postures: from the newest rows, by hand ("truth", "estimate"); empty if nothing is recorded.
    hands: poses of their segments, (t, 17, 7), as `fesloop.show.report.parts.Frames` has them; NaN where
        they are not known.
    solids, solid_poses: solids, the object first, and their poses (t, solids, 7); NaN likewise.
    """

    postures: Mapping[str, Posture]
    hands: Mapping[str, Array]
    solids: Sequence[Solid]
    solid_poses: Array


def hands_at(signals: Signals, hand: RecordedHand, trial: int, at_ns: Instants) -> HandsAt:
    """Hands and solids of a trial. Raises InputError for rows that the file lost."""
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
    return HandsAt(postures, hands, solids, solid_poses)


def rows_of(posture: Posture) -> Array:
    """Orientation and position (t, 17, 7) of each segment, as in `Frames`."""
    return np.concatenate([posture.poses.orientation, posture.poses.position], axis=-1)
