"""Source of a recording that is still being written, shown with a short delay."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.experiment.recording.form import undamaged
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.show.picture.cast import cast_of
from fesloop.show.report.motion import figure_of, hand_of
from fesloop.show.report.recorded_hand import RecordedHand
from fesloop.show.view.played import AHEAD, NO_HAND, WITH_HAND, Seen, seen_at
from fesloop.show.view.readout import readout_of
from fesloop.show.view.shown import FRAME_S, Play, Shown, Span, Start

Instants = NDArray[np.int64]
_MOST_ROWS = 4000
"""Rows of a stream that are kept and, after a while unwatched, read (chosen: 4 s of a plant at 1000 Hz)."""


class GrowingStream:
    """Rows of one node as they are added, the newest of them in memory."""

    def __init__(self, dataset: h5py.Dataset) -> None:
        self._dataset = dataset
        self._read = max(0, int(dataset.shape[0]) - _MOST_ROWS)
        self.rows: NDArray[Any] = np.empty(0, dataset.dtype)

    def refresh(self) -> bool:
        """Read added rows; return whether there were any."""
        self._dataset.refresh()
        count = int(self._dataset.shape[0])
        if count <= self._read:
            return False
        added = self._dataset[max(self._read, count - _MOST_ROWS):count]
        self.rows = np.concatenate([self.rows, added])[-_MOST_ROWS:]
        self._read = count
        return True


class GrowingRecording:
    """Signals of a file under single writer, multiple readers (SWMR); see
    `fesloop.show.picture.signals.Signals`.

    Parameters
    ----------
    path: of the recording.
    nodes: blocks and plants whose outputs are read.

    Raises InputError where the file cannot be opened so, here and where it is read.
    """

    def __init__(self, path: Path, nodes: Sequence[str]) -> None:
        self._path = path
        with undamaged(path):
            self._file = h5py.File(path, "r", swmr=True)
            self._streams = {node: GrowingStream(self._file[f"{kind}/{node}"]) for node in nodes
                             for kind in ("blocks", "plants") if f"{kind}/{node}" in self._file}
            self._status = self._file["status"]
            self._origins = self._file.get("wall/origins")
        self.signals = [f"{node}.{port}" for node, stream in self._streams.items()
                        for port in stream.rows.dtype.names or () if stream.rows.dtype[port].base == "<f8"]
        self.refresh()

    def refresh(self) -> bool:
        """Read added rows; return whether there were any."""
        with undamaged(self._path):
            grown = [stream.refresh() for stream in self._streams.values()]
        return any(grown)

    def column(self, name: str, trial: int = 0) -> tuple[Instants, NDArray[np.float64]]:
        """Instants (n,), ns, and values (n, *shape) of the newest rows of a signal in a trial."""
        node, _, port = name.partition(".")
        if name not in self.signals:
            raise InputError(f"{self._path}: {name}", "is not recorded", ", ".join(self.signals))
        rows = self._streams[node].rows
        first, stop = np.searchsorted(rows["trial"], [trial, trial + 1])
        return rows["time_ns"][first:stop], rows[port][first:stop]

    def newest(self, names: Sequence[str]) -> tuple[int, int] | None:
        """Trial and instant, ns, up to which these signals are recorded, as far as they are in that trial.

        The trial is that of the first signal, the position of the hand; None before the first of its rows.
        """
        ends = [(int(rows[-1]["trial"]), int(rows[-1]["time_ns"])) if len(rows) else (-1, 0)
                for rows in (self._streams[name.partition(".")[0]].rows for name in names)]
        trial = ends[0][0]
        return None if trial < 0 else min(end for end in ends if end[0] == trial)

    @property
    def status(self) -> str:
        """Status: running, done, failed or interrupted."""
        with undamaged(self._path):
            self._status.refresh()
            return bytes(self._status[()]).decode(errors="replace")

    def origin_ns(self, trial: int) -> int | None:
        """Instant of t = 0 of a trial on the monotonic clock; None for a run that is not in step with it."""
        if self._origins is None:
            return None
        with undamaged(self._path):
            self._origins.refresh()
            origins = {int(row["trial"]): int(row["monotonic_ns"]) for row in self._origins[()]}
        return origins.get(trial)

    def close(self) -> None:
        """Close the file."""
        self._file.close()


Instant = tuple[int, int]
"""Trial, and time in it, ns."""
_LAG_NS = 900 * NS_PER_MS
"""Delay behind the file at the start (chosen: a run writes every .4 to .8 s; nothing has to
stop until more comes)."""
_FARTHEST_NS = 5 * NS_PER_S // 2
"""Farther behind it leaps ahead (chosen): a run that is not in step with the wall clock may be faster."""


@dataclass(slots=True)
class Head:
    """Instant that is shown: it follows the wall clock from trial to trial and waits for data."""

    trial: int = -1
    time_ns: int = 0
    _moved_ns: int = 0

    def move(self, now_ns: int, newest: Instant, end_of: Callable[[int], int | None]) -> None:
        """Move to the current instant of the wall clock.

        Parameters
        ----------
        newest: up to where the recording is known.
        end_of: up to where a trial is known, ns; None where it is forgotten.
        """
        elapsed, self._moved_ns = now_ns - self._moved_ns, now_ns
        trial, end = newest
        if self.trial != trial:
            last = end_of(self.trial) if self.trial >= 0 else None
            left = 0 if last is None else last - self.time_ns
            if left <= elapsed or left + end > _FARTHEST_NS:
                self.trial, self.time_ns = trial, max(0, end - _LAG_NS)
            else:
                self.time_ns += elapsed
        elif end - self.time_ns > _FARTHEST_NS:
            self.time_ns = end - _LAG_NS
        else:
            self.time_ns = min(self.time_ns + elapsed, end)


_FIRST_ROWS_S, _LOOK_S = 30.0, 0.05
"""Longest wait for the first rows of a run, and interval between checks, s."""
_SILENT_NS = 2 * NS_PER_S
"""Time without new rows after which something is wrong: a run writes every .4 to .8 s."""
_LATE_NS = 2 * NS_PER_S
"""Delay beyond which a run that has just written is late: writing alone takes less."""
_CAMERA_FRAMES = 20
"""Number of frames, of the first rows, that the page uses to place its camera."""
_PER_S = round(1.0 / FRAME_S)
RUNNING = "running"


class FollowedRecording:
    """Source that follows a recording while it is written.

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
        self._hand, self.shown = hand, 0
        self.readout = readout_of(recording, cast_of(recording), recording.experiment.get("score", {}))
        recording.close()
        of_hand = [name.partition(".")[0] for name in hand.sources]
        self._rows = GrowingRecording(path, list(dict.fromkeys([*of_hand, *self.readout.nodes])))
        try:
            trial, newest_ns = _first_rows(self._rows, hand, path)
            times, _ = self._rows.column(hand.sources[0], trial)
            at_ns = np.linspace(times[0], newest_ns, _CAMERA_FRAMES).astype(np.int64)
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
        """Begin to show the newest frames; `start` is ignored."""
        before: Shown | None = None

        def at(elapsed_s: float) -> Shown | None:
            nonlocal before
            with self._lock:
                shown = self._shown()
            seen, before = before, shown
            return None if shown is seen else shown

        return at

    def _shown(self) -> Shown:
        """Current frame; the same object while nothing changes."""
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
        """Note on the delay of the view."""
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
        """Frame at the last instant of the grid before the head, so that several can be made together."""
        trial, number = self._head.trial, _number(self._head.time_ns)
        if (trial, number) not in self._made:
            numbers = range(number, max(number, min(number + AHEAD - 1, _number(known_ns))) + 1)
            at_ns = [_instant_ns(each) for each in numbers]
            seen = seen_at(self._rows, self._hand, self.readout, trial, at_ns, len(self.figure.objects))
            self._made = {(trial, each): poses for each, poses in zip(numbers, seen, strict=True)}
        hands, objects, readings = self._made[trial, number]
        time_s = _instant_ns(number) / NS_PER_S
        return Shown(trial=trial, time_s=time_s, note=note, hands=hands, objects=objects,
                     readings=readings)

    def close(self) -> None:
        """Close the file."""
        self._rows.close()


def _number(time_ns: int) -> int:
    """Number of the frame at an instant."""
    return time_ns * _PER_S // NS_PER_S


def _instant_ns(number: int) -> int:
    """First instant at which a frame is shown."""
    return -(-number * NS_PER_S // _PER_S)


def _first_rows(rows: GrowingRecording, hand: RecordedHand, path: Path) -> tuple[int, int]:
    """Wait for the first rows; return the trial and the instant up to which the recording is known."""
    until = time.monotonic() + _FIRST_ROWS_S
    while time.monotonic() < until:
        newest = rows.newest(hand.sources)
        if newest is not None:
            return newest
        time.sleep(_LOOK_S)
        rows.refresh()
    raise InputError(str(path), f"nothing of a hand was written into it for {_FIRST_ROWS_S:g} s",
                     remedy="view it again when the run continues")
