"""Source that plays a recording from any instant at any speed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_S
from fesloop.show.best_trial import best_trial
from fesloop.show.picture.cast import cast_of
from fesloop.show.picture.signals import Signals
from fesloop.show.report.motion import figure_of, hand_of, recorded_spans
from fesloop.show.report.recorded_hand import RecordedHand, hands_at, padded
from fesloop.show.view.readout import Readout, readout_of
from fesloop.show.view.shown import FRAME_S, Play, Shown, Span, Start

Array = NDArray[np.float64]
AHEAD = 15
"""Frames that are made together (chosen: half a second of them)."""


class Seen(NamedTuple):
    """Poses at one instant, of each hand (17, 7), and of the objects that move (objects, 7), and readings."""

    hands: Mapping[str, Array]
    objects: Array
    readings: Mapping[str, Any]


def seen_at(signals: Signals, hand: RecordedHand, readout: Readout, trial: int, at_ns: list[int],
            objects: int) -> list[Seen]:
    """Poses and readings at instants of a trial; `objects`: how many there are."""
    instants = np.array(at_ns, dtype=np.int64)
    found = hands_at(signals, hand, trial, instants)
    things = padded(found.solid_poses, objects)
    readings = readout.at(signals, trial, instants)
    return [Seen({name: rows[i] for name, rows in found.hands.items()}, things[i], readings[i])
            for i in range(len(at_ns))]


NO_HAND = "holds no hand"
WITH_HAND = "a recording of a hand, of a tracker with its 23 angles, or of a finger whose three are scored"
_CAMERA_FRAMES = 20
"""Number of frames of a trial that the page uses to place its camera."""
_FASTEST = 100.0


class PlayedRecording:
    """A recording that is complete, or whose writer was killed, or what is left of one.

    Parameters
    ----------
    recording: opened.
    notices: what is missing of it, a sentence each.
    release: closes it; called once, when this is closed.

    Raises InputError for one without a hand.
    """

    def __init__(self, recording: Recording, notices: Sequence[str], release: Callable[[], None]) -> None:
        self._recording, self._lock, path = recording, Lock(), recording.path
        self.notices, self._release = notices, release
        hand = hand_of(self._recording)
        spans_ns = {} if hand is None else recorded_spans(self._recording, hand)
        if hand is None or not spans_ns:
            raise InputError(str(path), NO_HAND, WITH_HAND)
        step_ns = max(1, max(last - first for first, last in spans_ns.values()) // _CAMERA_FRAMES)
        figure = figure_of(self._recording, hand, {
            trial: np.arange(first, last + 1, step_ns) for trial, (first, last) in spans_ns.items()}, step_ns)
        if figure is None:
            raise InputError(str(path), NO_HAND, WITH_HAND)
        self._hand, self.figure = hand, figure
        self.title = f"{self._recording.name}, seed {self._recording.seed}"
        self.spans: Mapping[int, Span] = {
            trial: Span(first_s=first / NS_PER_S, last_s=last / NS_PER_S)
            for trial, (first, last) in spans_ns.items()}
        best = best_trial(self._recording)
        self.shown = best if best in self.spans else min(self.spans)
        self.readout = readout_of(self._recording, cast_of(self._recording),
                                  self._recording.experiment.get("score", {}))

    def play(self, start: Start) -> Play:
        """Play from an instant to the end of its trial. Raises InputError for a start that does not exist."""
        span = self.spans.get(start.trial)
        if span is None:
            raise InputError("trial", f"{start.trial}", ", ".join(map(str, self.spans)))
        if not 0.0 <= start.speed <= _FASTEST:
            raise InputError("speed", f"{start.speed:g}", f"0 to {_FASTEST:g}")
        return _Playing(self._frames, start, span).at

    def _frames(self, trial: int, times_s: list[float]) -> list[Shown]:
        """Frames of several instants."""
        at_ns = [round(time_s * NS_PER_S) for time_s in times_s]
        with self._lock:
            seen = seen_at(self._recording, self._hand, self.readout, trial, at_ns, len(self.figure.objects))
        return [Shown(trial=trial, time_s=time_s, hands=each.hands, objects=each.objects,
                      readings=each.readings)
                for time_s, each in zip(times_s, seen, strict=True)]

    def close(self) -> None:
        """Close the file."""
        self._release()


class _Playing:
    """Frames on their way to one viewer."""

    def __init__(self, frames: Callable[[int, list[float]], list[Shown]], start: Start, span: Span) -> None:
        self._frames, self._start, self._span = frames, start, span
        self._made: dict[float, Shown] = {}
        self._before: float | None = None

    def at(self, elapsed_s: float) -> Shown | None:
        """Frame at a time since the start, s; None while nothing changes."""
        number = int(elapsed_s / FRAME_S)
        time_s = self._time(number)
        if time_s == self._before:
            return None
        if time_s not in self._made:
            ahead = AHEAD if self._start.speed > 0.0 else 1
            times = list(dict.fromkeys(self._time(number + each) for each in range(ahead)))
            self._made = dict(zip(times, self._frames(self._start.trial, times), strict=True))
        self._before = time_s
        return self._made[time_s]

    def _time(self, number: int) -> float:
        played = max(self._start.at_s, self._span.first_s) + self._start.speed * FRAME_S * number
        return min(played, self._span.last_s)
