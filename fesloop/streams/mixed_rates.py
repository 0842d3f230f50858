"""Samples of several rates in rows of one: found by where numbers are missing, held where a layout says so.

A sensor that loses samples loses all its kinds at once, at irregular rows. A kind that is missing while
others of the same sensor are there, row after row, or at regular rows, has a rate of its own.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.streams.recording import MotionRecording

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

_STRETCHES = 20
"""Stretches without a sample from which on a rate can be told from losses (chosen)."""
_REGULAR = 0.95
"""Which share of stretches of one length, or one more, is no chance (chosen)."""
_ALONE = 0.35
"""Which share of a sensor's rows one kind may lack while others are there (chosen: of two rates without
common rows, one lacks half or more)."""


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
                raise _refusal(f"{recording.path}: {sensor}: {kind}", kind, flags[:, number])


def _has_own_rate(there: Flags, sensor_there: Flags) -> bool:
    """Whether rows (n,) with a sample of a kind are of another rate than all rows."""
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
    """Whether lengths are one number, or that and the next, as of two rates in one table."""
    counts = np.bincount(lengths)
    pairs = counts + np.append(counts[1:], 0)
    return bool(pairs.max() >= _REGULAR * lengths.size)


def _refusal(where: str, kind: str, there: Flags) -> InputError:
    rows = np.diff(np.flatnonzero(there))
    usual = int(np.median(rows)) if rows.size else 0
    whole = usual > 1 and (rows == usual).mean() >= _REGULAR
    how = f", usually every {_ordinal(usual)}" if whole else ""
    remedy = (f"say so in a layout, `every = {{{kind} = {usual}}}`: each value then holds until the next"
              if whole else "give a table of one rate, with the rows of one kind alone")
    return InputError(where, f"is there in {int(there.sum())} of {there.size} rows{how}: it has a rate of "
                      "its own, and nothing is resampled unasked",
                      "a sample of each kind in every row", remedy)


def _ordinal(number: int) -> str:
    ending = {1: "st", 2: "nd", 3: "rd"}.get(number % 10 if number % 100 not in (11, 12, 13) else 0, "th")
    return f"{number}{ending}"


def hold(samples: Mapping[str, Array], every: Mapping[str, int]) -> dict[str, Array]:
    """Samples {kind: (n, 3)} with each value held until the next, for `every` - 1 rows at most."""
    return {kind: _held(values, every.get(kind, 1)) for kind, values in samples.items()}


def _held(values: Array, every: int) -> Array:
    if every == 1:
        return values
    there = np.isfinite(values).all(axis=1)
    row = np.arange(len(values))
    newest = np.maximum.accumulate(np.where(there, row, -1))
    lasting = (newest >= 0) & (row - newest < every)
    return np.where(lasting[:, np.newaxis], values[newest], np.nan)
