"""The hand of a recording in motion, as a report shows it: meshes, and poses at evenly spaced instants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.picture.cast import cast_of
from fesloop.picture.hand import view_of
from fesloop.picture.held import span_ns
from fesloop.picture.posture import Posture
from fesloop.report.objects import holdable, object_poses
from fesloop.report.parts import Figure3d, Frames, Solid
from fesloop.report.recorded_hand import ESTIMATE, TRUTH, RecordedHand, recorded_hand

Array = NDArray[np.float64]
Instants = NDArray[np.int64]
View = tuple[float, float, float]
_STEP_NS, _FRAMES = 40 * NS_PER_MS, 4000
"""Between two frames, and how many there are in all trials at most (chosen: 25 a second fall onto the samples
of 25, 50, 100 and 1000 Hz; so many take some 3 MB of a report)."""
_LOOKED_AT = 50
"""Frames of a trial by which the view is chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class _Trial:
    """Frames of a trial, all objects among them, whether they move or not."""

    frames: Frames
    objects: Sequence[Solid]


def hand_motion(recording: Recording) -> Figure3d | None:
    """The true and the estimated hand, and what is about them, in every trial.

    A hand's plant is drawn as its sites were (its joint angles where they are not recorded), of the trackers
    the first that knows a whole hand, laid onto the true one; a tracker by itself where there is no plant;
    three scored joint angles as an index finger. None where a recording has nothing of that.

    Raises InputError for a block whose kind is not installed any more or has other parameters by now.
    """
    hand = recorded_hand(recording, cast_of(recording), recording.experiment.get("score", {}))
    if hand is None:
        return None
    spans = {trial: span for trial in range(recording.trials)
             if (span := recorded_span(recording, hand, trial)) is not None}
    step_ns = step_between(sum(last - first for first, last in spans.values()))
    trials: dict[int, _Trial] = {}
    view: View | None = None
    for trial, (first, last) in spans.items():
        at_ns = np.arange(first, last + 1, step_ns)
        postures = hand.postures(recording, trial, at_ns)
        if postures:
            trials[trial] = _trial(recording, hand, trial, at_ns, step_ns, postures)
            view = view or view_into(postures, holdable(trials[trial].objects))
    if not trials:
        return None
    every = max((each.objects for each in trials.values()), key=len)
    solids, frames = _standing_still(every, {trial: _padded(each.frames, len(every))
                                             for trial, each in trials.items()})
    figure = Figure3d(key="hand", trials=frames, shapes=hand.shapes, objects=solids, text=hand.text)
    return figure if view is None else replace(figure, view=view)


def recorded_span(recording: Recording, hand: RecordedHand, trial: int) -> tuple[int, int] | None:
    """First and last instant, ns, of what tells where the hand was; None where nothing does."""
    found = [span for name in hand.sources if (span := span_ns(recording, name, trial)) is not None]
    return (min(first for first, _ in found), max(last for _, last in found)) if found else None


def step_between(whole_ns: int) -> int:
    """Between two frames of trials that take so long together, ns: a multiple of 40 ms."""
    return _STEP_NS * max(1, -(-whole_ns // (_FRAMES * _STEP_NS)))


def rows_of(posture: Posture) -> Array:
    """(t, 17, 7): orientation and position of each segment, as `Frames` has them."""
    return np.concatenate([posture.poses.orientation, posture.poses.position], axis=-1)


def view_into(postures: Mapping[str, Posture], holding: bool) -> View | None:
    """From where motion, and what may be held, shows best; None where no posture is finite."""
    posture = postures[TRUTH if TRUTH in postures else ESTIMATE]
    rows = np.flatnonzero(posture.finite)
    rows = rows[::max(1, len(rows) // _LOOKED_AT)]
    if not rows.size:
        return None
    poses = posture.poses
    looked_at = Posture(posture.size, poses._replace(orientation=poses.orientation[rows],
                                                     position=poses.position[rows]))
    east, north, up = view_of(looked_at, holding).along.tolist()
    return east, north, up


def _trial(recording: Recording, hand: RecordedHand, trial: int, at_ns: Instants, step_ns: int,
           postures: Mapping[str, Posture]) -> _Trial:
    solids, poses = ([], np.empty((len(at_ns), 0, 7))) if hand.plant is None else object_poses(
        recording, hand.plant, trial, at_ns)
    return _Trial(Frames(start_s=float(at_ns[0]) / NS_PER_S, step_s=step_ns / NS_PER_S, objects=poses,
                         hands={name: rows_of(posture) for name, posture in postures.items()}), solids)


def _padded(frames: Frames, count: int) -> Frames:
    """Frames with a pose of so many solids; an object, which comes first, may be unknown in a whole trial."""
    missing = np.full((len(frames.objects), count - frames.objects.shape[1], 7), np.nan)
    return replace(frames, objects=np.concatenate([missing, frames.objects], axis=1))


def _standing_still(
    solids: Sequence[Solid], frames: Mapping[int, Frames]
) -> tuple[list[Solid], dict[int, Frames]]:
    """Solids of which those that never move have one pose, and frames without these."""
    every = np.concatenate([each.objects for each in frames.values()])
    moves = [not bool((every[:, i] == every[0, i]).all()) for i in range(len(solids))]
    stood = [solid if moving else replace(solid, moves=False, pose=tuple(every[0, i].tolist()))
             for i, (solid, moving) in enumerate(zip(solids, moves, strict=True))]
    return stood, {trial: replace(each, objects=each.objects[:, moves]) for trial, each in frames.items()}
