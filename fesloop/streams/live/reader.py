"""A thread that reads a live stream, so that a loop never waits for one."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.realtime import Present
from fesloop.streams.live.source import Source, StreamLost
from fesloop.streams.live.stamps import CaptureStamps, RateWatch

_PULL_S = 0.1
"""How long the thread waits for a sample before it looks whether it is to end (chosen)."""
_TOLD_EVERY_NS = NS_PER_S
_BACKLOG = 10_000
"""Samples that are kept for a loop that lags behind (chosen: ten seconds of the fastest sensors)."""


class Heard(NamedTuple):
    """A sample that can be believed: every channel, when it was captured and when it arrived, ns."""

    values: NDArray[np.float64]
    captured_ns: int
    arrived_ns: int


class Note(NamedTuple):
    """Something odd about the stream: when (ns), what, and in what way."""

    time_ns: int
    status: str
    detail: str


class StreamReader:
    """Samples of a source in their order, and notes on what was odd about them.

    All instants are of `time.monotonic_ns()`. The thread puts in, the loop takes out; a deque needs no lock
    for that.

    Parameters
    ----------
    source: opened.
    period_ns: nominal distance of samples.
    by_sender: whether samples were captured when their sender says, else when they arrive.
    clock: wall clock, ns.
    """

    def __init__(self, source: Source, period_ns: int, *, by_sender: bool = True,
                 clock: Callable[[], int] = time.monotonic_ns) -> None:
        self._source, self._by_sender, self._clock = source, by_sender, clock
        self._stamps, self._rate = CaptureStamps(period_ns), RateWatch(period_ns, by_sender=by_sender)
        self._samples: deque[Heard] = deque()
        self._notes: deque[Note] = deque()
        self._told: dict[str, tuple[int, int]] = {}
        self._bell: Any = None
        self._origin_ns = 0
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._read, name="live stream", daemon=True)

    def start(self) -> None:
        """Begin to read."""
        self._thread.start()

    def attach(self, present: Present) -> None:
        """A trial begins: what was captured before is not of it."""
        self._origin_ns = present.origin_ns
        self._samples.clear()
        self._notes.clear()
        self._told.clear()
        self._bell = present.bell
        if self._rate.changed:
            self._notes.append(Note(present.origin_ns, "rate_changed", "samples come at a wrong rate"))

    def now_ns(self) -> int:
        """By the wall clock."""
        return self._clock()

    def oldest(self) -> Heard | None:
        """The sample that `take` would give."""
        samples = self._samples
        while samples and samples[0].captured_ns < self._origin_ns:
            samples.popleft()
        return samples[0] if samples else None

    def take(self) -> Heard | None:
        """The oldest sample that has not been taken, None if there is none."""
        return self._samples.popleft() if self.oldest() is not None else None

    def notes(self) -> list[Note]:
        """What has been odd since this was last asked."""
        taken = []
        while self._notes:
            taken.append(self._notes.popleft())
        return taken

    def hear(self, values: NDArray[np.float64], stamp_ns: int, arrived_ns: int) -> None:
        """Take in a sample with its sender's stamp by our clock; the thread calls this.

        While samples come at a wrong rate none is handed on: filters behind would count time wrongly.
        """
        verdict = self._stamps.judge(stamp_ns if self._by_sender else arrived_ns, arrived_ns)
        if verdict.status:
            self._tell(arrived_ns, verdict.status, verdict.detail)
        if verdict.captured_ns is None:
            return
        rate = self._rate.note(verdict.captured_ns)
        if rate[0]:
            self._tell(arrived_ns, *rate)
        if self._rate.changed:
            return
        if len(self._samples) >= _BACKLOG:
            self._samples.popleft()
            self._tell(arrived_ns, "overrun", f"the loop is {_BACKLOG} samples behind: old ones are left out")
        self._samples.append(Heard(values, verdict.captured_ns, arrived_ns))
        if self._bell is not None:
            self._bell.set()

    def _tell(self, now_ns: int, status: str, detail: str) -> None:
        """A note, at most one a second of each status; those left out are counted."""
        before, left_out = self._told.get(status, (now_ns - _TOLD_EVERY_NS, 0))
        if now_ns - before < _TOLD_EVERY_NS:
            self._told[status] = before, left_out + 1
            return
        self._told[status] = now_ns, 0
        more = f" (and {left_out} times more since it was last told)" if left_out else ""
        self._notes.append(Note(now_ns, status, detail + more))

    def _read(self) -> None:
        while not self._ending.is_set():
            try:
                pulled = self._source.pull(_PULL_S)
            except StreamLost:
                self._look_for_it()
                continue
            if pulled is not None:
                self.hear(pulled.values, pulled.stamp_ns, self._clock())

    def _look_for_it(self) -> None:
        """Until the stream is there again, or nobody wants it any more."""
        lost_ns = self._clock()
        self._notes.append(Note(lost_ns, "stream_lost", "its sender is gone: it is looked for"))
        in_its_place = ""
        while not self._ending.is_set():
            try:
                self._source.reopen()
                break
            except StreamLost as fault:
                if str(fault) and str(fault) != in_its_place:
                    in_its_place = str(fault)
                    self._tell(self._clock(), "stream_differs", f"in its place there is {in_its_place}")
        else:
            return
        away_ms = (self._clock() - lost_ns) / NS_PER_MS
        self._notes.append(Note(self._clock(), "stream_found", f"open again after {away_ms:.0f} ms"))

    def close(self) -> None:
        """End the thread and let the stream go."""
        self._ending.set()
        if self._thread.is_alive():
            self._thread.join(timeout=5.0)
        self._source.close()
