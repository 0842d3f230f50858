"""Instants of an XDF stream on the recorder's clock, without the jitter of their arrival.

As pyxdf does by default, the sender's clock is mapped by a robust line through the measured clock offsets,
and instants of a stream of nominal rate are put on a line a stretch without breaks (Kothe et al. 2025, doi
10.1162/IMAG.a.136). Other than by pyxdf, which breaks a line at gaps of more than 1 s and 500 samples alone,
no gap is closed (`fesloop.streams.pace`): a line across one would compress all samples into its time.
"""

from __future__ import annotations

import numpy as np

from fesloop.errors import InputError
from fesloop.streams.checks import Array
from fesloop.streams.formats.xdf_chunks import XdfStream
from fesloop.streams.pace import on_lines, pace_of, rate_change
from fesloop.streams.timebase import require_rate

_WINSOR_S = 1e-4
"""Offsets further from the line than this count less (pyxdf 1.17: winsor_threshold)."""
_LEAST = np.finfo(float).tiny
_ITERATIONS = 1000
_MOST_OFFSETS = 20_000
"""Chosen: LabRecorder measures one each 5 s, so these are of more than a day; the line takes a second."""
_RESET_S, _RESET_DEVIATIONS = (5.0, 1.0), (5.0, 10.0)
"""A clock was reset where the time between offsets and the offsets both jump by more than these s and median
absolute deviations (pyxdf 1.17)."""


def instants_s(stream: XdfStream, where: str, trust_header: bool = True) -> Array:
    """Instants of a stream's samples, (n,), s on the recorder's clock.

    Stamps whose rate changes on the way, and those of a sender that can drop samples, keep their jitter.
    `trust_header`: whether the header's nominal rate must be that of the stamps.

    Raises InputError for instants that are no numbers, for a nominal rate that the stamps contradict, and
    for a sender whose clock was reset on the way: pyxdf would guess how the parts belong together.
    """
    if not np.isfinite(stream.times_s).all():
        raise InputError(where, "has stamps that are no numbers", "an undamaged XDF file")
    times: Array = np.array(stream.times_s)
    if stream.clock_s:
        times = times + _offsets(stream, times, where)
    if stream.rate_hz <= 0.0 or times.size < 2:
        return times
    pace = pace_of(times, stream.rate_hz)
    if trust_header and not stream.drops:
        require_rate(stream.rate_hz, pace, times.size, where)
    if stream.drops or rate_change(times, pace) is not None:
        return times
    return on_lines(times, pace)


def _offsets(stream: XdfStream, times: Array, where: str) -> Array:
    """By how much instants on the sender's clock are behind, (n,), s."""
    clock, offset = np.array(stream.clock_s), np.array(stream.offset_s)
    if clock.size > _MOST_OFFSETS:
        raise InputError(where, f"has {clock.size} clock offsets", f"at most {_MOST_OFFSETS}")
    if clock.size == 1:
        return np.full(times.size, offset[0])
    if _was_reset(clock, offset):
        raise InputError(where, "comes from a clock that was set anew while it was recorded",
                         "streams of steady clocks", "cut the file where the clock was set")
    first, slope = _robust_line(clock, offset)
    return np.asarray(first + slope * (times - clock.min()))


def _was_reset(clock: Array, offset: Array) -> bool:
    """Whether a sender's clock jumped between two measurements of its offset."""
    steps = np.diff(clock)
    if (steps < 0.0).any():
        return True
    jumps = []
    for differences, limit_s, deviations in zip((steps, np.diff(offset)), _RESET_S, _RESET_DEVIATIONS,
                                                strict=True):
        off = np.abs(differences - np.median(differences))
        jumps.append((off > limit_s) & (off > deviations * (np.median(off) + np.finfo(float).eps)))
    return bool((jumps[0] & jumps[1]).any())


def _robust_line(clock: Array, offset: Array) -> tuple[float, float]:
    """Offset at the first measurement, and slope, of the line with the least Huber loss.

    Solved by the alternating direction method of multipliers (Boyd et al. 2011, section 6.1.1,
    doi 10.1561/2200000016), as pyxdf does, in units of the loss's threshold.
    """
    design = np.stack([np.ones(clock.size), (clock - clock.min()) / _WINSOR_S], axis=1)
    wanted = offset / _WINSOR_S
    gram = design.T @ design
    if np.linalg.cond(gram) > 1.0 / np.finfo(float).eps:
        return float(np.median(offset)), 0.0
    solve = np.linalg.solve(gram, design.T)
    residual = dual = np.zeros(clock.size)
    line = np.zeros(2)
    for _ in range(_ITERATIONS):
        line = solve @ (wanted + residual - dual)
        off = design @ line - wanted + dual
        size = np.abs(off)
        beyond = np.maximum(0.0, 1.0 - 2.0 / np.maximum(size, _LEAST))
        residual = 0.5 * off + 0.5 * beyond * off
        dual = off - residual
    return float(line[0] * _WINSOR_S), float(line[1])
