"""A thread that reads a live stream, so that a loop never waits for one."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from statistics import fmean, median
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.abilities import Present
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.signals import NEVER
from fesloop.streams.live.source import Source, StreamLost

AHEAD_NS = 2 * NS_PER_MS
"""Lead of a stamp on its arrival that is allowed: LSL's clocks agree within 0.2 ms, "empirically" (its
documentation of `time_correction`); ten times that (chosen)."""
PATIENCE_NS = NS_PER_S
"""Duration of evenly spaced implausible stamps after which the sender's clock counts as reset (chosen: longer
than a stall of a sender)."""
_MISSING_PERIODS = 2.5
_RATE_SAMPLES, _ARRIVALS, _RATE_TOLERANCE = 10, 100, 0.2
"""Numbers of samples for estimating the rate, with the sender's stamps and from arrivals, and the relative
error of the rate above which it is reported (chosen: filters count time in samples)."""
_STALL, _LEAD = 50.0, 20.0
"""Longest stall, in samples, that a burst may make up for, and the excess above which samples are too
many (chosen)."""


class Verdict(NamedTuple):
    """The judgement of a sample.

    Attributes
    ----------
    captured_ns: by our clock; None where the sample is to be left out.
    status, detail: its fault; empty for none.
    """

    captured_ns: int | None
    status: str = ""
    detail: str = ""


class CaptureStamps:
    """Judges the samples of one stream, in the order of their arrival.

    Captures increase strictly and are never later than arrivals. A sample whose stamp is no later than that
    of the sample before (reordered, repeated, a clock set back), or ahead of its own arrival, is left out: it
    would make something old look new to a controller. Where such stamps are evenly spaced for a second, the
    sender's clock has been reset: later samples are taken to be as old as the one that arrives then, with the
    status `clock_reset`.

    Parameters
    ----------
    period_ns: nominal distance of samples.
    """

    __slots__ = ("_before_ns", "_doubted_since_ns", "_shift_ns", "newest_ns", "period_ns")

    def __init__(self, period_ns: int) -> None:
        self.period_ns = period_ns
        self.newest_ns = NEVER
        self._shift_ns = 0
        self._before_ns: int | None = None
        self._doubted_since_ns = NEVER

    def judge(self, stamp_ns: int, arrived_ns: int) -> Verdict:
        """The verdict on the next sample.

        Parameters
        ----------
        stamp_ns: the sender's stamp by our clock, as far as the offset between the two is known.
        arrived_ns: by our clock, 0 or later.
        """
        before, self._before_ns = self._before_ns, stamp_ns
        captured = stamp_ns + self._shift_ns
        status, detail = self._doubts(captured, arrived_ns)
        captured = min(captured, arrived_ns)
        if not status:
            missing = captured - self.newest_ns if self.newest_ns >= 0 else 0
            self.newest_ns, self._doubted_since_ns = captured, NEVER
            if missing > _MISSING_PERIODS * self.period_ns:
                return Verdict(captured, "samples_missing",
                               f"{missing / NS_PER_MS:.4g} ms lie between two samples")
            return Verdict(captured)
        advances = before is not None and 0 < stamp_ns - before <= PATIENCE_NS
        if self._doubted_since_ns < 0 or not advances:
            self._doubted_since_ns = arrived_ns
        if arrived_ns - self._doubted_since_ns < PATIENCE_NS or arrived_ns <= self.newest_ns:
            return Verdict(None, status, detail)
        self._shift_ns, self.newest_ns = arrived_ns - stamp_ns, arrived_ns
        self._doubted_since_ns = NEVER
        return Verdict(arrived_ns, "clock_reset", f"the sender's clock was reset ({detail}): its stamps "
                       "count from now on as those of samples that arrive at once")

    def _doubts(self, captured_ns: int, arrived_ns: int) -> tuple[str, str]:
        """(status, detail) of an implausible stamp; empty for a plausible one."""
        if captured_ns > arrived_ns + AHEAD_NS:
            ahead = (captured_ns - arrived_ns) / NS_PER_MS
            return "stamp_ahead", f"a sample is stamped {ahead:.4g} ms after it arrived: left out"
        if captured_ns < 0:
            return "stamp_behind", "a sample is stamped before this machine started: left out"
        behind = self.newest_ns - min(captured_ns, arrived_ns)
        if self.newest_ns < 0 or behind < 0:
            return "", ""
        if behind == 0:
            return "stamp_repeated", "a sample has the stamp of the one before: left out"
        return "stamp_behind", f"a sample is stamped {behind / NS_PER_MS:.4g} ms before another: left out"


class RateWatch:
    """Detects samples at another rate than the nominal one.

    Stamps of a sender are judged by the median of ten distances, which a lost sample does not change; short
    distances count only where there have been too many samples altogether, as a sender may catch up after a
    stall. Arrivals may come in bursts: they are judged by the mean of a hundred distances.

    Parameters
    ----------
    period_ns: nominal distance of samples.
    by_sender: whether stamps are the sender's.

    Attributes
    ----------
    changed: whether the rate is wrong now.
    """

    __slots__ = ("_average", "_before_ns", "_by_sender", "_count", "_lead", "_steps", "changed", "period_ns")

    def __init__(self, period_ns: int, *, by_sender: bool = True) -> None:
        self.period_ns, self.changed = period_ns, False
        self._by_sender = by_sender
        self._average: Callable[[list[int]], float] = median if by_sender else fmean
        self._count = _RATE_SAMPLES if by_sender else _ARRIVALS
        self._before_ns = NEVER
        self._lead = 0.0
        self._steps: list[int] = []

    def note(self, captured_ns: int) -> tuple[str, str]:
        """(status, detail) where the rate becomes wrong or right again; usually empty."""
        if self._before_ns >= 0:
            step = captured_ns - self._before_ns
            self._steps.append(step)
            self._lead = max(-_STALL, self._lead + 1.0 - (1.0 + _RATE_TOLERANCE) * step / self.period_ns)
        self._before_ns = captured_ns
        if len(self._steps) < self._count:
            return "", ""
        usual = self._average(self._steps)
        self._steps.clear()
        too_many = self.changed or not self._by_sender or self._lead > _LEAD
        off = usual / self.period_ns - 1.0
        changed = off > _RATE_TOLERANCE or (off < -_RATE_TOLERANCE and too_many)
        if changed == self.changed:
            return "", ""
        self.changed = changed
        found = f"samples come at {NS_PER_S / usual:.4g} Hz, {NS_PER_S / self.period_ns:.4g} Hz were said"
        return ("rate_changed", found) if changed else ("rate_restored", found)


_PULL_S = 0.1
"""Time that the thread waits for a sample before it checks whether to end (chosen)."""
_NOTE_PERIOD_NS = NS_PER_S
_BACKLOG = 10_000
"""Samples that are kept for a loop that lags behind (chosen: ten seconds of the fastest sensors)."""


class Heard(NamedTuple):
    """A plausible sample: every channel, and the instants of its capture and its arrival, ns."""

    values: NDArray[np.float64]
    captured_ns: int
    arrived_ns: int


class Note(NamedTuple):
    """Note on a fault of the stream: instant (ns), status and detail."""

    time_ns: int
    status: str
    detail: str


class StreamReader:
    """Samples of a source in their order, and notes on their faults.

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
        self._noted: dict[str, tuple[int, int]] = {}
        self._bell: Any = None
        self._origin_ns = 0
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._read, name="live stream", daemon=True)

    def start(self) -> None:
        """Begin to read."""
        self._thread.start()

    def attach(self, present: Present) -> None:
        """Begin a trial, which excludes samples that were captured before."""
        self._origin_ns = present.origin_ns
        self._samples.clear()
        self._notes.clear()
        self._noted.clear()
        self._bell = present.bell
        if self._rate.changed:
            self._notes.append(Note(present.origin_ns, "rate_changed", "samples come at a wrong rate"))

    def now_ns(self) -> int:
        """Current time of the wall clock, ns."""
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
        """Faults of the stream since the last call."""
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
        before, left_out = self._noted.get(status, (now_ns - _NOTE_PERIOD_NS, 0))
        if now_ns - before < _NOTE_PERIOD_NS:
            self._noted[status] = before, left_out + 1
            return
        self._noted[status] = now_ns, 0
        more = f" (and {left_out} times more since the last report)" if left_out else ""
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
        """Search until the stream is there again, or the reader is closed."""
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
        """End the thread and close the stream."""
        self._ending.set()
        if self._thread.is_alive():
            self._thread.join(timeout=5.0)
        self._source.close()
