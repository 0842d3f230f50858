"""Samples that are flat at the end of their sensor's range, wherever that is."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from fesloop.streams.recording import MotionRecording

Array = NDArray[np.float64]
_FLAT = 3
"""Equal samples in a row that are a flat (chosen: noise forbids two)."""
_STEPS = 4.0
"""By how many of the numbers' own steps a sample must jump to a flat and from it: at the top of a smooth
curve coarse numbers are equal as well, but rise to it by one step (chosen)."""
_OUTERMOST = 0.7
"""Share of a sensor's greatest sample below which a flat is not the end of its range (chosen)."""
_MOST_SHOWN = 4
_UNITS = {"gyr": (180.0 / np.pi, "deg/s", "gyr_range_deg_s"), "acc": (1.0 / 9.80665, "g", "acc_range_g")}


def clipped_text(recording: MotionRecording, first: int = 0, stop: int | None = None) -> str:
    """Which sensors are clipped, at what, and what to set so that trackers know; empty for none."""
    told, settings = [], []
    for kind, (scale, unit, setting) in _UNITS.items():
        samples = getattr(recording, kind)[first:stop]
        found = {name: clipped_at(samples[:, number]) for number, name in enumerate(recording.sensors)}
        levels = {name: scale * level for name, (level, count) in found.items() if count}
        told += [f"{kind} of {name} at {level:.4g} {unit} ({found[name][1]} samples)"
                 for name, level in levels.items()]
        if levels:
            settings.append(f"`{setting}` of the tracker to {_below(min(levels.values())):.4g}")
    more = f" and {len(told) - _MOST_SHOWN} more" if len(told) > _MOST_SHOWN else ""
    return f"samples are clipped: {', '.join(told[:_MOST_SHOWN])}{more}: set {' and '.join(settings)}, so " \
           "that its standard deviation knows, and record with a wider range" if told else ""


def _below(level: float) -> float:
    """A number of four digits that is just below."""
    step = 10.0 ** (np.floor(np.log10(level)) - 3.0)
    return float(np.floor(level / step * (1.0 - 1e-6)) * step)


def clipped_at(samples: Array) -> tuple[float, int]:
    """The least end of the range of a sensor's axes (n, 3), and how many samples lie flat on them, or 0."""
    there = samples[np.isfinite(samples).all(axis=1)]
    if not len(there):
        return 0.0, 0
    # A sample that repeats the one before in all axes is held, not clipped.
    new = there[np.concatenate([[True], np.any(np.diff(there, axis=0) != 0.0, axis=1)])]
    outer = _OUTERMOST * float(np.abs(new).max())
    flats = [flat for column in new.T for sign in (1.0, -1.0) for flat in _flats(sign * column, outer)]
    return (min(level for level, _ in flats), sum(count for _, count in flats)) if flats else (0.0, 0)


def _flats(values: Array, outer: float) -> Iterator[tuple[float, int]]:
    """The greatest of values (n,), and how many lie flat there, where it is at least `outer` and any do."""
    level = float(values.max())
    if not level >= outer > 0.0:
        return
    at = np.concatenate([[False], values == level, [False]])
    edges = np.flatnonzero(at[1:] != at[:-1])
    begins, ends = edges[::2], edges[1::2]
    inner = (ends - begins >= _FLAT) & (begins > 0) & (ends < len(values))
    if not inner.any():
        return
    begins, ends = begins[inner], ends[inner]
    jumps = level - 0.5 * (values[begins - 1] + values[ends])
    apart = np.diff(np.unique(values))
    # Of numbers that were scaled, rounding makes steps of next to nothing.
    step = float(apart[apart > 1e-9 * level].min(initial=np.inf))
    if float(np.median(jumps)) > _STEPS * step:
        yield level, int(np.sum(ends - begins))
