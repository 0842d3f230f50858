"""The moving hand of a recording for pages: meshes, and poses at evenly spaced instants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.show.picture.cast import cast_of
from fesloop.show.picture.hand import view_of
from fesloop.show.picture.posture import Posture
from fesloop.show.picture.signals import Signals, span_ns
from fesloop.show.report.parts import Figure3d, Frames, Solid
from fesloop.show.report.recorded_hand import (
    ESTIMATE,
    TRUTH,
    RecordedHand,
    hands_at,
    holdable,
    padded,
    recorded_hand,
)

Array = NDArray[np.float64]
Instants = NDArray[np.int64]
View = tuple[float, float, float]
_STEP_NS, _FRAMES = 40 * NS_PER_MS, 4000
"""Time between two frames, and most frames of all trials (chosen: 25 Hz coincides with samples of 25, 50, 100
and 1000 Hz; 4000 frames take some 3 MB of a report)."""
_ENDS_APART = ("damaged", "running")
"""Statuses of files whose signals may end at different instants: damaged files and killed runs."""
_HELD_NS = 100 * NS_PER_MS
"""Duration for which the last row of a signal is shown (chosen: ten rows of a tracker at 100 Hz)."""
_LOOKED_AT = 50
"""Frames of a trial from which the view is chosen."""


def hand_motion(recording: Recording) -> Figure3d | None:
    """True and estimated hand with the objects around them, in every trial.

    The hand of a plant follows its recorded sites, or its joint angles if sites are not recorded. The first
    tracker of a whole hand is aligned with it. Without a plant a tracker is shown alone, and three scored
    joint angles are shown as an index finger. The result is None for other recordings.

    Raises InputError for a block whose kind is not installed any more or has other parameters by now.
    """
    hand = hand_of(recording)
    if hand is None:
        return None
    spans = recorded_spans(recording, hand)
    step_ns = step_between(sum(last - first for first, last in spans.values()))
    figure = figure_of(recording, hand, {trial: np.arange(first, last + 1, step_ns)
                                         for trial, (first, last) in spans.items()}, step_ns)
    return None if figure is None else _with_still_objects(figure)


def hand_of(recording: Recording) -> RecordedHand | None:
    """Hands of a recording; None if it has none. Raises InputError as `hand_motion` does."""
    hand = recorded_hand(recording, cast_of(recording), recording.experiment.get("score", {}))
    if hand is None or recording.status not in _ENDS_APART:
        return hand
    return replace(hand, held_ns=_HELD_NS)


def figure_of(signals: Signals, hand: RecordedHand, instants: Mapping[int, Instants],
              step_ns: int) -> Figure3d | None:
    """Hands and objects at evenly spaced instants of trials; None if nothing is recorded there."""
    frames: dict[int, Frames] = {}
    every: Sequence[Solid] = []
    view: View | None = None
    for trial, at_ns in instants.items():
        found = hands_at(signals, hand, trial, at_ns)
        if not found.hands:
            continue
        every = max(every, found.solids, key=len)
        frames[trial] = Frames(start_s=float(at_ns[0]) / NS_PER_S, step_s=step_ns / NS_PER_S,
                               hands=found.hands, objects=found.solid_poses)
        view = view or view_into(found.postures, holdable(found.solids))
    if not frames:
        return None
    trials = {trial: replace(each, objects=padded(each.objects, len(every)))
              for trial, each in frames.items()}
    figure = Figure3d(key="hand", trials=trials, shapes=hand.shapes, objects=every, text=hand.text)
    return figure if view is None else replace(figure, view=view)


def recorded_spans(recording: Recording, hand: RecordedHand) -> dict[int, tuple[int, int]]:
    """First and last instant, ns, of the hand's posture in each trial that has one."""
    found = {trial: _span(recording, hand, trial) for trial in range(recording.trials)}
    return {trial: span for trial, span in found.items() if span is not None}


def _span(recording: Recording, hand: RecordedHand, trial: int) -> tuple[int, int] | None:
    found = [span for name in hand.sources if (span := span_ns(recording, name, trial)) is not None]
    return (min(first for first, _ in found), max(last for _, last in found)) if found else None


def step_between(whole_ns: int) -> int:
    """Time between two frames, ns, a multiple of 40 ms, for trials of this total duration."""
    return _STEP_NS * max(1, -(-whole_ns // (_FRAMES * _STEP_NS)))


def view_into(postures: Mapping[str, Posture], holding: bool) -> View | None:
    """Direction of view that shows motion and objects best; None if no posture is finite."""
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


def _with_still_objects(figure: Figure3d) -> Figure3d:
    """Figure in which solids that never move have one pose instead of frames."""
    every = np.concatenate([each.objects for each in figure.trials.values()])
    moves = [not bool((every[:, i] == every[0, i]).all()) for i in range(len(figure.objects))]
    objects = [solid if moving else replace(solid, moves=False, pose=tuple(every[0, i].tolist()))
               for i, (solid, moving) in enumerate(zip(figure.objects, moves, strict=True))]
    return replace(figure, objects=objects, trials={
        trial: replace(each, objects=each.objects[:, moves]) for trial, each in figure.trials.items()})
