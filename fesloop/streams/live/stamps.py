"""Whether the stamps of a live stream can be believed, and when its samples were captured by our clock."""

from __future__ import annotations

from collections.abc import Callable
from statistics import fmean, median
from typing import NamedTuple

from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.signals import NEVER

AHEAD_NS = 2 * NS_PER_MS
"""By how much a sample may seem to come from the future: LSL's clocks agree within 0.2 ms, "empirically"
(its documentation of `time_correction`); ten times that (chosen)."""
PATIENCE_NS = NS_PER_S
"""For how long stamps that cannot be believed must go on evenly before they count as a clock set anew
(chosen: longer than a stall of a sender)."""
_MISSING_PERIODS = 2.5
_RATE_SAMPLES, _ARRIVALS, _RATE_TOLERANCE = 10, 100, 0.2
"""Samples that a rate is judged by, with senders' stamps and without, and what may be wrong with it: filters
count time in samples (chosen)."""
_STALL, _LEAD = 50.0, 20.0
"""Samples that a sender may make up for after a stall, and beyond which they are too many (chosen)."""


class Verdict(NamedTuple):
    """What to make of a sample.

    Attributes
    ----------
    captured_ns: by our clock; None where the sample is to be left out.
    status, detail: what is odd about it; empty for nothing.
    """

    captured_ns: int | None
    status: str = ""
    detail: str = ""


class CaptureStamps:
    """Judges the samples of one stream, in the order in which they come.

    What it gives increases strictly and is never later than the arrival. A sample whose stamp is no later
    than that of the sample before (reordered, repeated, a clock set back), or ahead of its own arrival, is
    left out: it would tell a controller that something old is new. Where such stamps go on evenly for a
    second, the sender's clock has been set anew: from then on the samples are taken to be as old as the one
    that arrives then, which is told.

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
        return Verdict(arrived_ns, "clock_reset", f"the sender's clock was set anew ({detail}): its stamps "
                       "count from now on as those of samples that arrive at once")

    def _doubts(self, captured_ns: int, arrived_ns: int) -> tuple[str, str]:
        """(status, detail) of why a stamp cannot be believed, empty where it can."""
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
    """Tells when samples come at another rate than they should.

    Stamps of a sender are judged by the median of ten distances, as it does not mind a lost sample; that they
    are too close counts where there have been too many on the whole, for after a stall a sender may make up
    for it. Arrivals may come in bursts: of them the mean of a hundred counts.

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
        """(status, detail) where the rate has begun to be wrong or to be right again; usually empty."""
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
