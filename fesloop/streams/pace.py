"""The pace of stamped samples: their period, where samples are missing, and whether the rate is constant.

A sample that is stamped late, and after which the stamps catch up, is jitter; where they never catch up,
samples are missing. Both look alike at the sample itself, so the earliest arrivals of a stretch before
and after it are compared.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

_LATE = 1.5
"""Distance of two samples, in periods, above which one may be missing between them."""
_MISSING = 0.5
"""Delay of all later samples, in periods, above which one is missing (chosen: half way to none)."""
_DEVIATIONS = 4.0
"""Greatest delay, in standard deviations of the jitter, that counts as jitter (chosen)."""
_AROUND, _MOST_AROUND = 8, 4096
"""Samples before and after a delay that are searched for the earliest, besides those that catch up."""
_USUAL_STEP = 0.7, 1.05
_STATED_STEP = 0.45, 1.05
"""Bounds of a usual step, and of a stated period, relative to the mean of a few steps, where few samples are
missing."""
_IN_PACKET = 0.1
"""Share of a stated period below which a step is one within a packet, whose samples share the instant of its
arrival (chosen: no sensor is ten times as fast as it says)."""
_PACKETS = 16
"""Packets over which a rate is computed."""
_FASTEST_HZ = 5000.0
"""Upper bound of the rates of inertial sensors, Hz (chosen: the fastest give 1 to 4 kHz)."""
_LAG, _BLOCK = 16, 64
"""Samples over which a rate is computed, and number of such rates in one median (chosen)."""
_STEADY = 0.02
"""Relative difference allowed between the rate of a stretch and that of all samples (chosen: sensors' clocks
are within 1 %)."""
_REFINEMENTS = 5
_LEVEL_AROUND, _LEVEL_LEAST = 512, 64
"""Samples before and after a step back whose levels are compared, at most and at least: a sender that stamps
chunk by chunk steps back at many of them, and forward again at others (chosen)."""
_CHUNK_AROUND, _CHUNKS = 16, 3
"""Samples on each side over which steps back are compared, and number of steps of half the size that show a
sender that stamps chunk by chunk, each late by another time (chosen)."""
_MOST_MISSING = 5_000_000
"""Samples in gaps that are played: more than half a day at 100 Hz (chosen)."""


@dataclass(frozen=True, slots=True, eq=False)
class Pace:
    """Period and gaps of stamped samples.

    Attributes
    ----------
    period_s: between samples, without gaps.
    breaks: numbers of the samples before which others are missing, ascending.
    jitter_s: robust standard deviation of a stamp; in packets it includes the wait for the last sample.
    """

    period_s: float
    breaks: Numbers
    jitter_s: float = 0.0

    @property
    def rate_hz(self) -> float:
        """Samples a second, without gaps."""
        return 1.0 / self.period_s


class Gap(NamedTuple):
    """A stretch without samples: the last sample before it, the first after it, how many are missing."""

    from_s: float
    to_s: float
    missing: int

    def __str__(self) -> str:
        return f"no sample for {self.to_s - self.from_s:.4g} s, {self.missing} missing"


def pace_of(times_s: Array, stated_hz: float = 0.0) -> Pace:
    """The pace of stamps (n,), s, which may have jitter; `stated_hz` is a nominal rate, 0 for none."""
    steps = np.diff(times_s)
    none = np.zeros(0, dtype=np.int64)
    if steps.size < 2:
        return Pace(float(steps.sum()), none)
    period = _likely_period(times_s, steps, stated_hz)
    together = max(1, round(packets(times_s))) if abs(stated_hz * period - 1.0) < 1e-9 else 1
    breaks, jitter = none, 0.0
    for _ in range(_REFINEMENTS):
        if not period > 0.0:
            return Pace(float(steps.mean()), none)
        breaks, jitter = _breaks(times_s, period, together)
        before, period = period, _robust_slope(times_s, breaks, period, together)
        if abs(period - before) <= 1e-9 * before:
            break
    first, number = _stretches(times_s.size, breaks)
    on_time = _on_time(times_s, breaks, period, jitter)
    number = number - _means(number, first, on_time)
    number[~on_time] = 0.0
    size = float(number @ number)
    if size > 0.0:
        period = float(number @ (times_s - _means(times_s, first, on_time))) / size
    return Pace(period, breaks, jitter)


def _likely_period(times_s: Array, steps: Array, stated_hz: float) -> float:
    """A first guess: the usual step; where samples come in bursts the stated period, or a longer mean."""
    usual = float(np.median(steps))
    if stated_hz > 0.0 and usual * stated_hz < _IN_PACKET:
        size = steps.size / max(1, int((steps * stated_hz >= _IN_PACKET).sum()))
        lag = max(1, min(round(_PACKETS * size), steps.size // 2))
        mean = float(np.quantile(times_s[lag:] - times_s[:-lag], 0.25)) / lag
        if _STATED_STEP[0] * mean <= 1.0 / stated_hz <= _STATED_STEP[1] * mean:
            return 1.0 / stated_hz
    lag = max(1, min(_LAG, steps.size // 4))
    # The lower quarter: most stretches of so many samples may hold a gap.
    mean = float(np.quantile(times_s[lag:] - times_s[:-lag], 0.25)) / lag
    if _USUAL_STEP[0] * mean <= usual <= _USUAL_STEP[1] * mean:
        return usual
    if stated_hz > 0.0 and _STATED_STEP[0] * mean <= 1.0 / stated_hz <= _STATED_STEP[1] * mean:
        return 1.0 / stated_hz
    return mean


def packets(times_s: Array) -> float:
    """Mean size of the packets of samples (n,) that are stamped on arrival; 0 for none.

    Most steps are then shorter than any inertial sensor's period, and the others make up the time.
    """
    steps = np.diff(times_s)
    short = steps * _FASTEST_HZ < 1.0
    if 2 * int(short.sum()) < steps.size or times_s[-1] - times_s[0] <= times_s.size / _FASTEST_HZ:
        return 0.0
    return times_s.size / (1.0 + float((~short).sum()))


def _breaks(times_s: Array, period: float, together: int) -> tuple[Numbers, float]:
    """Samples at which stamps fall behind a period for good, and the jitter, s.

    `together`: samples of a packet; steps within it show no jitter, steps between packets do.
    """
    late = times_s - period * np.arange(times_s.size)
    steps = np.diff(late)
    apart = steps if together == 1 else late[together:] - late[:-together]
    jitter = float(1.4826 * np.median(np.abs(apart - np.median(apart))) / np.sqrt(2.0))
    least = max(_MISSING * together * period, _DEVIATIONS * jitter)
    found: list[int] = []
    for k in (np.flatnonzero(steps > (_LATE - 1.0) * period) + 1).tolist():
        catching_up = min(_MOST_AROUND, 2.0 * float(steps[k - 1]) / period)
        before = late[max(found[-1] if found else 0, k - _AROUND):k].min()
        if late[k:k + _AROUND + int(catching_up)].min() - before > least:
            found.append(k)
    if together > 1:
        jitter = float(np.hypot(jitter, together * period / np.sqrt(12.0)))
    return np.array(found, dtype=np.int64), jitter


def set_back(times_s: Array) -> tuple[int, float] | None:
    """Sample at which stamps (n,), s, step back for good, and the size of the step, s; None for no step.

    A step is neither jitter nor an exchange of samples: later stamps are earlier than those before predict,
    by half a period or more and by more than the stamps scatter.
    """
    steps = np.diff(times_s)
    lag = min(_LEVEL_AROUND, times_s.size // 4)
    if not lag or not (steps < 0.0).any():
        return None
    period = float(np.median(times_s[lag:] - times_s[:-lag])) / lag
    if not period > 0.0:
        return None
    # No step of a normal jitter is below this, and the others are skipped.
    scatter = 1.4826 * float(np.median(np.abs(steps - np.median(steps))))
    number = np.arange(times_s.size, dtype=np.float64)
    back = np.flatnonzero(steps < min(0.0, period - _DEVIATIONS * scatter)) + 1
    back = back[(back >= _LEVEL_LEAST) & (back <= times_s.size - _LEVEL_LEAST)]
    found = [(k, -change) for k in back.tolist() if (
        change := level_change(number, times_s, k, _LEVEL_AROUND, period)) < -_MISSING * period]
    largest = max(found, key=lambda each: each[1], default=None)
    if largest is None:
        return None
    alike = sum(level_change(number, times_s, k, _CHUNK_AROUND, period) < -0.5 * largest[1]
                for k in back.tolist())
    return largest if alike < _CHUNKS else None


def level_change(along: Array, values: Array, at: int, around: int, slope: float | None = None,
                 steepest: float = np.inf) -> float:
    """Distance of values from a place on to the line of those before, 0 where it is within scatter.

    Levels and slopes are medians of up to `around` values on each side, of two or more: a few that are far
    off do not change them.

    Parameters
    ----------
    along: (n,), increasing, what the line is along.
    values: (n,).
    at: number of the first value after the place.
    slope: of the line; None for that of these values.
    steepest: slope above which scatter of a few values is taken for one; then there is none.
    """
    sides = slice(max(0, at - around), at), slice(at, at + around)
    half = min(at - sides[0].start, values[sides[1]].size) // 2
    if half < 1:
        return 0.0
    runs = np.concatenate([along[side][half:] - along[side][:-half] for side in sides])
    rises = np.concatenate([values[side][half:] - values[side][:-half] for side in sides])
    if not (runs > 0.0).all():
        return 0.0
    own = float(np.median(rises / runs))
    own = own if abs(own) <= steepest else 0.0
    flat = [values[side] - own * along[side] for side in sides]
    scatter = 1.4826 * float(np.median(np.abs(np.concatenate([part - np.median(part) for part in flat]))))
    levels = flat if slope is None else [values[side] - slope * along[side] for side in sides]
    change = float(np.median(levels[1]) - np.median(levels[0]))
    return change if abs(change) > _DEVIATIONS * scatter else 0.0


def _stretches(size: int, breaks: Numbers) -> tuple[Numbers, Array]:
    """The first sample of each stretch without a gap, and each sample's number from its stretch's middle."""
    first = np.concatenate([[0], breaks]).astype(np.int64)
    length = np.diff(np.append(first, size))
    middle = first + 0.5 * (length - 1)
    return first, np.arange(size, dtype=np.float64) - np.repeat(middle, length)


def _robust_slope(times_s: Array, breaks: Numbers, period: float, together: int) -> float:
    """Median period of pairs of samples half the recording apart, without gaps."""
    closed = np.diff(times_s)
    closed[breaks - 1] = period * together
    even = np.concatenate([[0.0], np.cumsum(closed)])
    far = max(1, times_s.size // 2)
    return float(np.median(even[far:] - even[:-far])) / far


def _on_time(times_s: Array, breaks: Numbers, period: float, jitter: float) -> NDArray[np.bool_]:
    """Samples that are not delayed, (n,): they differ by jitter alone from the others of their stretch."""
    first, number = _stretches(times_s.size, breaks)
    late = times_s - period * number
    usual = np.repeat([np.median(part) for part in np.split(late, breaks)],
                      np.diff(np.append(first, times_s.size)))
    on_time = np.abs(late - usual) <= max(_MISSING * period, _DEVIATIONS * jitter)
    return np.asarray(on_time | np.repeat(np.logical_not(np.logical_or.reduceat(on_time, first)),
                                          np.diff(np.append(first, times_s.size))))


def _means(values: Array, first: Numbers, of: NDArray[np.bool_]) -> Array:
    """For each sample the mean over those of its stretch that count."""
    length = np.diff(np.append(first, values.size))
    total = np.add.reduceat(np.where(of, values - values[0], 0.0), first)
    return np.asarray(np.repeat(total / np.add.reduceat(of, first, dtype=np.int64), length) + values[0])


def on_lines(times_s: Array, pace: Pace) -> Array:
    """Stamps without jitter: each stretch between gaps is a line of the common period, by least squares.

    Delayed samples do not bend it.
    """
    first, number = _stretches(times_s.size, pace.breaks)
    on_time = _on_time(times_s, pace.breaks, pace.period_s, pace.jitter_s)
    middle = _means(times_s - pace.period_s * number, first, on_time)
    return np.asarray(middle + pace.period_s * number)


def gaps_of(times_s: Array, pace: Pace) -> list[Gap]:
    """Gaps between samples, with the number of missing ones."""
    return [Gap(float(times_s[k - 1]), float(times_s[k]),
                max(1, round(float(times_s[k] - times_s[k - 1]) / pace.period_s) - 1))
            for k in pace.breaks.tolist()]


def rate_change(times_s: Array, pace: Pace) -> tuple[float, float, float] | None:
    """Instant at which the rate changes, s, and the rates before and after, Hz; None for one rate."""
    first, _ = _stretches(times_s.size, pace.breaks)
    lag = _LAG * max(1, round(packets(times_s)))
    rates = []
    for start, stop in zip(first.tolist(), [*first[1:].tolist(), times_s.size], strict=True):
        part = times_s[start:stop]
        periods = (part[lag:] - part[:-lag]) / lag
        rates += [(float(part[at]), float(np.median(periods[at:at + _BLOCK])))
                  for at in range(0, periods.size - _BLOCK + 1, _BLOCK)]
    if not rates:
        return None
    allowed = _STEADY + _DEVIATIONS * np.sqrt(2.0) * pace.jitter_s / (lag * pace.period_s)
    periods = np.array([period for _, period in rates])
    if not (periods > 0.0).all() or periods.max() / periods.min() - 1.0 <= allowed:
        return None
    at = int(np.argmax(np.abs(periods / periods[0] - 1.0) > 0.5 * allowed))
    return rates[at][0], 1.0 / float(periods[0]), 1.0 / float(periods[at])


@dataclass(frozen=True, slots=True, eq=False)
class Timeline:
    """Instants of samples and of those that gaps lack.

    Attributes
    ----------
    stamps_ns: (n,), ascending.
    rows: (n,), number of each sample, -1 for one that is missing.
    gaps: by the number of the first instant in each.
    period_s: of the samples.
    """

    stamps_ns: Numbers
    rows: Numbers
    gaps: dict[int, Gap]
    period_s: float

    @property
    def rate_hz(self) -> float:
        """Samples a second."""
        return 1.0 / self.period_s


def timeline(stamps_ns: Numbers, where: str) -> Timeline:
    """The timeline of samples (n,), ns.

    Raises InputError for a rate that changes, since filters integrate samples over one period, and where more
    samples are missing than can be played.
    """
    times_s = stamps_ns / NS_PER_S
    pace = pace_of(times_s)
    changed = rate_change(times_s, pace)
    if changed is not None:
        at_s, before, then = changed
        raise InputError(where, f"rate changes from {before:.4g} Hz to {then:.4g} Hz at {at_s:.4g} s",
                         f"one rate, within {100.0 * _STEADY:g} %",
                         "play a part of one rate, with start_s and duration_s")
    found = gaps_of(times_s, pace)
    if sum(gap.missing for gap in found) > _MOST_MISSING:
        longest = max(found, key=lambda gap: gap.missing)
        raise InputError(where, f"has a gap of {longest.to_s - longest.from_s:.6g} s after "
                         f"{longest.from_s:.6g} s", f"at most {_MOST_MISSING} missing samples",
                         "play what lies before or after it, with start_s and duration_s")
    stamps, rows, gaps, done, size = [], [], {}, 0, 0
    for k, gap in zip(pace.breaks.tolist(), found, strict=True):
        steps = np.rint(pace.period_s * NS_PER_S * np.arange(1, gap.missing + 1)).astype(np.int64)
        inside = stamps_ns[k - 1] + steps
        inside = inside[inside < stamps_ns[k]]
        gaps[size + k - done] = gap
        stamps += [stamps_ns[done:k], inside]
        rows += [np.arange(done, k), np.full(inside.size, -1)]
        size += k - done + inside.size
        done = k
    return Timeline(np.concatenate([*stamps, stamps_ns[done:]]),
                    np.concatenate([*rows, np.arange(done, stamps_ns.size)]).astype(np.int64), gaps,
                    pace.period_s)
