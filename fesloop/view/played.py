"""A recording that is played as it was run, from any instant at any speed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from threading import Lock

import numpy as np

from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_S
from fesloop.report.motion import figure_of, hand_of, recorded_spans, rows_of
from fesloop.report.objects import object_poses, padded
from fesloop.view.shown import Play, Shown, Span, Start

NO_HAND = "holds no hand"
WITH_HAND = "a recording of a hand, of a tracker with its 23 angles, or of a finger whose three are scored"
_LOOKED_AT = 20
"""Frames of a trial by which the page places its camera."""
_FASTEST = 100.0


class PlayedRecording:
    """A recording that is complete, or whose writer was killed.

    Raises InputError for a file that is none, and for one without a hand.
    """

    def __init__(self, path: Path) -> None:
        self._recording = Recording(path)
        self._lock = Lock()
        try:
            self._begin(path)
        except BaseException:
            self._recording.close()
            raise

    def _begin(self, path: Path) -> None:
        hand = hand_of(self._recording)
        spans_ns = {} if hand is None else recorded_spans(self._recording, hand)
        if hand is None or not spans_ns:
            raise InputError(str(path), NO_HAND, WITH_HAND)
        step_ns = max(1, max(last - first for first, last in spans_ns.values()) // _LOOKED_AT)
        figure = figure_of(self._recording, hand, {
            trial: np.arange(first, last + 1, step_ns) for trial, (first, last) in spans_ns.items()}, step_ns)
        if figure is None:
            raise InputError(str(path), NO_HAND, WITH_HAND)
        self._hand, self.figure = hand, figure
        self.title = f"{self._recording.name}, seed {self._recording.seed}"
        self.spans: Mapping[int, Span] = {
            trial: Span(first_s=first / NS_PER_S, last_s=last / NS_PER_S)
            for trial, (first, last) in spans_ns.items()}

    def play(self, start: Start) -> Play:
        """From an instant on, until the trial ends. Raises InputError for a start that there is not."""
        span = self.spans.get(start.trial)
        if span is None:
            raise InputError("trial", f"{start.trial}", ", ".join(map(str, self.spans)))
        if not 0.0 <= start.speed <= _FASTEST:
            raise InputError("speed", f"{start.speed:g}", f"0 to {_FASTEST:g}")
        shown_s: float | None = None

        def at(elapsed_s: float) -> Shown | None:
            nonlocal shown_s
            time_s = min(max(start.at_s, span.first_s) + start.speed * elapsed_s, span.last_s)
            if time_s == shown_s:
                return None
            shown_s = time_s
            return self._frame(start.trial, time_s)

        return at

    def _frame(self, trial: int, time_s: float) -> Shown:
        at_ns = np.array([round(time_s * NS_PER_S)], dtype=np.int64)
        with self._lock:
            postures = self._hand.postures(self._recording, trial, at_ns)
            _, poses = object_poses(self._recording, self._hand.plant, trial, at_ns)
        return Shown(trial=trial, time_s=time_s, hands={name: rows_of(posture)[0]
                                                        for name, posture in postures.items()},
                     objects=padded(poses, len(self.figure.objects))[0])

    def close(self) -> None:
        """Let the file go."""
        self._recording.close()
