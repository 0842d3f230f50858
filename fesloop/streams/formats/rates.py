"""Samples of several rates: resampled at common instants, repeated where a layout says so, or refused.

Streams of different clocks are resampled at common instants where a user gives a rate. Each value is
interpolated linearly between the two samples around its instant. Nothing is made up where there are no
samples: before a stream's first and after its last, in a gap, and beside a lost sample the value is NaN.
Instants without a sample of any stream are left out, so that a gap of all streams stays a gap of the stamps.

Rows of one table may hold samples of several rates as well. A sensor that loses samples loses all its kinds
at once, at irregular rows. A kind that is missing while others of the same sensor are there, row after row,
or at regular rows, has a rate of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S, parse_rate
from fesloop.streams.checks import Array
from fesloop.streams.formats.channels import Part, suggested_hz
from fesloop.streams.pace import Pace, pace_of, rate_change
from fesloop.streams.recording import MotionRecording
from fesloop.streams.timebase import stamps_of_rate

Rate = str | int | float

_SLOWEST, _FASTEST = 0.9, 2.0
"""Bounds of the common rate, relative to the fastest stream's (chosen): below, motion of more than half the
common rate is aliased; above, most values are interpolated."""
_FARTHEST = 3.0
"""Greatest distance between two samples, in periods, for interpolation between them (chosen)."""
_LEAST = 2
_MOST_ADDED = 5_000_000
"""Instants without a sample, as in `fesloop.streams.pace`."""
_ROUNDING = 1e-6
"""Share of a period within which an instant is a sample's own."""


def onto_one_rate(parts: Sequence[Part], rate: Rate, where: str) -> tuple[list[Part], dict[str, float]]:
    """Parts at the instants of a common rate while all of them last, and the rate of each before, Hz.

    The first instant is the first sample of the part that begins last.

    Raises InputError for a rate that is far from the fastest part's, for a part whose stamps do not increase
    or change their rate, and for parts that were not recorded at the same time.
    """
    common = parse_rate(rate, "resample")
    paces = [_pace(part, f"{where}: {part.name}") for part in parts]
    fastest = max(pace.rate_hz for pace in paces)
    if not _SLOWEST * fastest <= common <= _FASTEST * fastest:
        raise InputError("resample", f"{float(common):g} Hz, the fastest stream of {where} has "
                         f"{fastest:.4g} Hz", f"{_SLOWEST * fastest:.4g} to {_FASTEST * fastest:.4g} Hz",
                         f"{suggested_hz(parts)} fits")
    start, stop = max(part.times_s[0] for part in parts), min(part.times_s[-1] for part in parts)
    count = int(float(stop - start) * common * (1.0 + 1e-12)) + 1 if stop > start else 0
    if count < _LEAST:
        spans = ", ".join(f"{part.name} {part.times_s[0]:.9g} to {part.times_s[-1]:.9g} s" for part in parts)
        raise InputError(where, f"has streams that were not recorded at the same time: {spans}",
                         "streams that overlap", "import each by itself, with sensor_set")
    if count > _MOST_ADDED + _FASTEST * sum(part.times_s.size for part in parts):
        raise InputError(where, f"lasts {stop - start:.6g} s, most of it a gap",
                         f"at most {_MOST_ADDED} instants without a sample",
                         "import each by itself, with sensor_set")
    times = start + stamps_of_rate(count, common) / NS_PER_S
    lines = [_Lines(part, pace, times) for part, pace in zip(parts, paces, strict=True)]
    kept = np.any([each.there for each in lines], axis=0)
    return ([replace(part, times_s=times[kept], values=each.values()[kept])
             for part, each in zip(parts, lines, strict=True)],
            {part.key: pace.rate_hz for part, pace in zip(parts, paces, strict=True)})


def _pace(part: Part, where: str) -> Pace:
    """The pace of a part whose samples can be joined by lines."""
    steps = np.diff(part.times_s)
    if steps.size < _LEAST:
        raise InputError(where, f"holds {part.times_s.size} samples", "3 or more")
    if (steps <= 0.0).any():
        at = int(np.argmax(steps <= 0.0)) + 1
        raise InputError(where, f"sample {at} does not come after the one before it", "increasing times")
    pace = pace_of(part.times_s)
    changed = rate_change(part.times_s, pace)
    if changed is not None:
        at_s, before, then = changed
        raise InputError(where, f"rate changes from {before:.4g} Hz to {then:.4g} Hz at "
                         f"{at_s - part.times_s[0]:.4g} s", "streams of one rate each",
                         "save the part before it, or after it, as a file of its own")
    return pace


class _Lines:
    """Linear interpolation between neighbouring samples of a part, at instants (m,).

    Attributes
    ----------
    there: (m,), whether the part has a sample at an instant, or one on each side that belong together.
    """

    def __init__(self, part: Part, pace: Pace, instants_s: Array) -> None:
        self._part = part
        self._right = np.clip(np.searchsorted(part.times_s, instants_s), 1, part.times_s.size - 1)
        steps = np.diff(part.times_s)
        share = (instants_s - part.times_s[self._right - 1]) / steps[self._right - 1]
        near = _ROUNDING * pace.period_s / steps[self._right - 1]
        self._share = np.where(share < near, 0.0, np.where(share > 1.0 - near, 1.0, share))
        apart = steps > _FARTHEST * pace.period_s
        apart[pace.breaks - 1] = True
        self.there = ~apart[self._right - 1] | (self._share == 0.0) | (self._share == 1.0)

    def values(self) -> Array:
        """Values (m, columns), NaN where the part is not there; a sample itself at its own instant."""
        samples, share = self._part.values, self._share[:, np.newaxis]
        before, after = samples[self._right - 1], samples[self._right]
        line = np.where(share == 0.0, before, np.where(share == 1.0, after,
                                                       (1.0 - share) * before + share * after))
        return np.where(self.there[:, np.newaxis], line, np.nan)


Flags = NDArray[np.bool_]

_STRETCHES = 20
"""Number of stretches without a sample that distinguishes a rate from losses (chosen)."""
_REGULAR = 0.95
"""Share of stretches of one length, or one more, that is no chance (chosen)."""
_ALONE = 0.35
"""Share of a sensor's rows that one kind may lack while other kinds are there (chosen: if two rates have no
common rows, one kind lacks half or more)."""


def require_one_rate(recording: MotionRecording) -> None:
    """Raise InputError where a kind of samples of a sensor has another rate than the recording's rows."""
    kinds: dict[str, Array] = {"gyr": recording.gyr, "acc": recording.acc}
    if recording.mag is not None:
        kinds["mag"] = recording.mag
    there = {name: np.asarray(np.isfinite(values).all(axis=2)) for name, values in kinds.items()}
    if all(flags.all() for flags in there.values()):
        return
    any_there = np.asarray(np.any(list(there.values()), axis=0))
    for number, sensor in enumerate(recording.sensors):
        for kind, flags in there.items():
            if _has_own_rate(flags[:, number], any_there[:, number]):
                shares = flags.mean(axis=0)
                alone = bool(np.delete(shares, number).max(initial=0.0) > 0.5 * (1.0 + shares[number]))
                raise _refusal(f"{recording.path}: {sensor}: {kind}", kind, flags[:, number],
                               f"sensors.{sensor}.every" if alone else "every")


def _has_own_rate(there: Flags, sensor_there: Flags) -> bool:
    """Return whether rows (n,) with a sample of a kind have another rate than all rows."""
    missing, filled = _stretches(there)
    if missing.size < _STRETCHES:
        return False
    alone = sensor_there & ~there
    regular = _is_regular(missing) and _is_regular(filled)
    return bool(regular or alone.sum() > _ALONE * sensor_there.sum())


def _stretches(there: Flags) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Lengths of the stretches without and with a sample, but for the first and last of all."""
    turns = np.flatnonzero(np.diff(there)) + 1
    lengths = np.diff(turns)
    return lengths[int(there[turns[0]])::2] if turns.size else lengths, (
        lengths[1 - int(there[turns[0]])::2] if turns.size else lengths)


def _is_regular(lengths: NDArray[np.int64]) -> bool:
    """Return whether lengths are one number, or that number and the next, as with two rates in one table."""
    counts = np.bincount(lengths)
    pairs = counts + np.append(counts[1:], 0)
    return bool(pairs.max() >= _REGULAR * lengths.size)


def _refusal(where: str, kind: str, there: Flags, key: str) -> InputError:
    """Error that proposes `key` of a layout, for this sensor alone where others have all rows."""
    rows = np.diff(np.flatnonzero(there))
    usual = int(np.median(rows)) if rows.size else 0
    whole = usual > 1 and (rows == usual).mean() >= _REGULAR
    how = f", usually every {_ordinal(usual)}" if whole else ""
    remedy = (f"say so in a layout, `{key} = {{{kind} = {usual}}}`: each value then holds until the next"
              if whole else "give a table of one rate, with the rows of one kind alone")
    return InputError(where, f"is there in {int(there.sum())} of {there.size} rows{how}: it has a rate of "
                      "its own, and nothing is resampled unasked",
                      "a sample of each kind in every row", remedy)


def _ordinal(number: int) -> str:
    ending = {1: "st", 2: "nd", 3: "rd"}.get(number % 10 if number % 100 not in (11, 12, 13) else 0, "th")
    return f"{number}{ending}"


def hold(samples: Mapping[str, Array], every: Mapping[str, int]) -> dict[str, Array]:
    """Samples {kind: (n, 3)} with each value repeated until the next, for `every` - 1 rows at most."""
    return {kind: _held(values, every.get(kind, 1)) for kind, values in samples.items()}


def _held(values: Array, every: int) -> Array:
    if every == 1:
        return values
    there = np.isfinite(values).all(axis=1)
    row = np.arange(len(values))
    newest = np.maximum.accumulate(np.where(there, row, -1))
    lasting = (newest >= 0) & (row - newest < every)
    return np.where(lasting[:, np.newaxis], values[newest], np.nan)
