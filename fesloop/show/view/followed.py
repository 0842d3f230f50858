"""A recording that is being written, followed: what its loop did a moment ago."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from threading import Lock

import numpy as np

from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_S
from fesloop.show.report.motion import figure_of, hand_of
from fesloop.show.report.recorded_hand import RecordedHand
from fesloop.show.view.growing import GrowingRecording
from fesloop.show.view.head import Head
from fesloop.show.view.played import NO_HAND, WITH_HAND
from fesloop.show.view.poses import AHEAD, Seen, poses_at
from fesloop.show.view.shown import FRAME_S, Play, Shown, Span, Start

_FIRST_ROWS_S, _LOOK_S = 30.0, 0.05
"""How long to wait for the first rows of a run, and how often to look for them."""
_SILENT_NS = 2 * NS_PER_S
"""Without new rows for so long something is wrong: a run writes every .4 to .8 s."""
_LATE_NS = 2 * NS_PER_S
"""What a run is behind the wall clock when it has just written and keeps up is less: the writing."""
_LOOKED_AT = 20
"""Frames of what is there at first, by which the page places its camera."""
_PER_S = round(1.0 / FRAME_S)
RUNNING = "running"


class FollowedRecording:
    """What was shown last, and how far that is behind.

    Parameters
    ----------
    recording: as it is now; it is closed, for of a file that is open twice HDF5 reads wrong chunks.
    clock: the machine's monotonic one, ns.

    Raises InputError for a recording that holds no hand, or into which nothing is written.
    """

    def __init__(self, recording: Recording, clock: Callable[[], int] = time.monotonic_ns) -> None:
        self._clock, self._lock, path = clock, Lock(), recording.path
        hand = hand_of(recording)
        self.title = f"{recording.name}, seed {recording.seed}"
        if hand is None:
            raise InputError(str(path), NO_HAND, WITH_HAND)
        self.spans: Mapping[int, Span] = {}
        self.notices: Sequence[str] = ()
        self._hand = hand
        recording.close()
        self._rows = GrowingRecording(path, list(dict.fromkeys(
            name.partition(".")[0] for name in hand.sources)))
        try:
            trial, newest_ns = _first_rows(self._rows, hand, path)
            times, _ = self._rows.column(hand.sources[0], trial)
            at_ns = np.linspace(times[0], newest_ns, _LOOKED_AT).astype(np.int64)
            figure = figure_of(self._rows, hand, {trial: at_ns}, NS_PER_S)
            if figure is None:
                raise InputError(str(path), NO_HAND, WITH_HAND)
        except BaseException:
            self._rows.close()
            raise
        self.figure = figure
        self._head, self._grown_ns, self._origins = Head(), clock(), dict[int, int | None]()
        self._made: dict[tuple[int, int], Seen] = {}
        self._last = self._frame("", 0)

    def play(self, start: Start) -> Play:
        """From now on; where somebody wants to start does not matter."""
        before: Shown | None = None

        def at(elapsed_s: float) -> Shown | None:
            nonlocal before
            with self._lock:
                shown = self._shown()
            seen, before = before, shown
            return None if shown is seen else shown

        return at

    def _shown(self) -> Shown:
        """What is to be seen now; the same object as long as nothing of it changes."""
        now_ns = self._clock()
        if self._rows.refresh():
            self._grown_ns = now_ns
        newest = self._rows.newest(self._hand.sources)
        assert newest is not None
        self._head.move(now_ns, newest, self._end_of)
        known_ns = newest[1] if newest[0] == self._head.trial else self._head.time_ns
        frame = self._frame(self._note(now_ns, newest), known_ns)
        if (frame.trial, frame.time_s, frame.note) != (self._last.trial, self._last.time_s, self._last.note):
            self._last = frame
        return self._last

    def _end_of(self, trial: int) -> int | None:
        times, _ = self._rows.column(self._hand.sources[0], trial)
        return int(times[-1]) if times.size else None

    def _note(self, now_ns: int, newest: tuple[int, int]) -> str:
        """How far behind this is."""
        head = self._head
        silent_ns = now_ns - self._grown_ns
        if silent_ns > _SILENT_NS:
            status = self._rows.status
            return (f"nothing was written for {silent_ns // NS_PER_S} s" if status == RUNNING
                    else f"the run has ended: {status}")
        if self._origins.get(head.trial) is None:
            self._origins[head.trial] = self._rows.origin_ns(head.trial)
        origin_ns = self._origins[head.trial]
        if origin_ns is not None:
            # The loop is late by itself where it is behind the wall clock when it has just written.
            late_ns = max(0, self._grown_ns - origin_ns - newest[1]) if newest[0] == head.trial else 0
            behind_ns = now_ns - origin_ns - head.time_ns - late_ns
            late = f"; the loop itself is {late_ns / NS_PER_S:.0f} s late" if late_ns > _LATE_NS else ""
            return f"{behind_ns / NS_PER_S:.1f} s behind the loop{late}"
        return f"the run is at {newest[1] / NS_PER_S:.1f} s of trial {newest[0]}, not in real time"

    def _frame(self, note: str, known_ns: int) -> Shown:
        """At the last instant of the frames' grid before the head; so that several can be made together."""
        trial, number = self._head.trial, _number(self._head.time_ns)
        if (trial, number) not in self._made:
            numbers = range(number, max(number, min(number + AHEAD - 1, _number(known_ns))) + 1)
            seen = poses_at(self._rows, self._hand, trial, [_instant_ns(each) for each in numbers],
                            len(self.figure.objects))
            self._made = {(trial, each): poses for each, poses in zip(numbers, seen, strict=True)}
        hands, objects = self._made[trial, number]
        time_s = _instant_ns(number) / NS_PER_S
        return Shown(trial=trial, time_s=time_s, note=note, hands=hands, objects=objects)

    def close(self) -> None:
        """Let the file go."""
        self._rows.close()


def _number(time_ns: int) -> int:
    """Of the frame that is shown then."""
    return time_ns * _PER_S // NS_PER_S


def _instant_ns(number: int) -> int:
    """The first at which a frame is shown."""
    return -(-number * NS_PER_S // _PER_S)


def _first_rows(rows: GrowingRecording, hand: RecordedHand, path: Path) -> tuple[int, int]:
    """Up to where the recording is known, once it is anywhere."""
    until = time.monotonic() + _FIRST_ROWS_S
    while time.monotonic() < until:
        newest = rows.newest(hand.sources)
        if newest is not None:
            return newest
        time.sleep(_LOOK_S)
        rows.refresh()
    raise InputError(str(path), f"nothing of a hand was written into it for {_FIRST_ROWS_S:g} s",
                     remedy="look again once the run goes on")
