"""Offset between the clocks of two recordings, from a motion in both.

Salchow-Hoemmen et al. 2019 (doi 10.3390/s19010208, section 3.1.2) let each recording start with a
characteristic motion of one finger. The correlation of both signals shows its instants in both; sizes of
angular rates need no common frame.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import correlate, correlation_lags, find_peaks

from fesloop.errors import InputError

Array = NDArray[np.float64]
_LEAST = 20
_GAP_PERIODS = 3.0
"""Distance of samples, in usual periods, above which a gap is not interpolated (chosen)."""
_ENERGY_SHARE = 0.2
"""Least share of each recording's variation within the overlap (chosen): rest correlates with any rest."""
_PROMINENCE = 0.02
"""Prominence above which a second peak counts (chosen)."""
LEAST_PEAK = 0.7
"""Correlation above which two recordings show the same motion (chosen)."""
LEAST_MARGIN = 0.1
"""Least difference from the second peak (chosen)."""


class TimeOffset(NamedTuple):
    """Difference of two clocks.

    Attributes
    ----------
    offset_s: seconds to add to the second recording's times to have them on the first one's clock.
    peak: correlation at this offset, at most 1.
    second_peak: highest other peak; 0 for none.
    overlap_s: duration for which both recordings are then known, s.
    """

    offset_s: float
    peak: float
    second_peak: float
    overlap_s: float


class _Even(NamedTuple):
    """Signal on an even grid: its start, values, and mask of known samples."""

    start_s: float
    values: Array
    known: Array


def time_offset(
    first_times_s: ArrayLike, first: ArrayLike, second_times_s: ArrayLike, second: ArrayLike, *,
    within_s: float = math.inf, least_overlap_s: float | None = None, least_peak: float = LEAST_PEAK,
    least_margin: float = LEAST_MARGIN,
) -> TimeOffset:
    """Offset between the clocks of two recordings of one motion.

    Both are interpolated (cubic splines, gaps left open) at the higher of their rates; the highest
    correlation over the overlap, and a parabola through it and its neighbours, give the offset.

    Parameters
    ----------
    first_times_s, second_times_s: (m,) and (k,), s, increasing; rates may differ and need not be even.
    first, second: (m,) and (k,), a scalar such as a joint angle, or (m, 3) and (k, 3), of which the size is
        taken, such as angular rates; in one unit or not. NaN where unknown.
    within_s: largest offset of the search, s.
    least_overlap_s: least duration for which both are known, s; by default half the shorter recording.
    least_peak, least_margin: limits below which the result is refused.

    Raises InputError for unusable recordings, and where the correlation is too weak, has a second peak of
    similar height, or is highest at an end of the search.
    """
    times = [_known(*pair) for pair in ((first_times_s, first, "first"), (second_times_s, second, "second"))]
    period = min(float(np.median(np.diff(time))) for time, _ in times)
    a, b = (_even(time, values, period) for time, values in times)
    shorter = min(float(time[-1] - time[0]) for time, _ in times)
    overlap = 0.5 * shorter if least_overlap_s is None else least_overlap_s
    lags, correlation, together = _correlation(a, b)
    offsets = np.asarray(a.start_s - b.start_s + lags * period, dtype=np.float64)
    searched = (together * period >= overlap) & (np.abs(offsets) <= within_s)
    if searched.sum() < 3:
        raise InputError("recordings", f"of {shorter:g} s at least",
                         f"{overlap:g} s in common within {within_s:g} s of offset", "record for longer")
    correlation = np.where(searched, correlation, -1.0)
    at = int(np.argmax(correlation))
    second_peak = _second_peak(correlation, offsets, at, least_peak, least_margin)
    before, peak, after = correlation[at - 1:at + 2]
    top = 0.5 * (before - after) / (before - 2.0 * peak + after)
    return TimeOffset(float(offsets[at] + top * period), float(peak), second_peak,
                      float(together[at] * period))


def _second_peak(
    correlation: Array, offsets: Array, at: int, least_peak: float, least_margin: float
) -> float:
    """Height of the second peak, 0 without one; raises InputError for an unreliable first one, `at`.

    `correlation` is -1 where it was not searched.
    """
    peak = correlation[at]
    if not peak >= least_peak:
        raise InputError("recordings", f"correlate by {peak:.2f} at most", f"{least_peak:g} or more",
                         "begin both with the same characteristic motion")
    if at in (0, correlation.size - 1) or -1.0 in (correlation[at - 1], correlation[at + 1]):
        raise InputError("recordings", "correlate best at the end of what was searched",
                         "an offset between the ends", "search farther, or record for longer")
    others = [k for k in find_peaks(correlation, prominence=_PROMINENCE)[0] if k != at]
    rival = max(others, key=lambda k: correlation[k], default=None)
    if rival is None or correlation[rival] <= 0.0:
        return 0.0
    if peak - correlation[rival] < least_margin:
        raise InputError("recordings", f"fit as well at {offsets[rival]:.3f} s ({correlation[rival]:.2f}) as "
                         f"at {offsets[at]:.3f} s ({peak:.2f})", f"{least_margin:g} between the two",
                         "begin both with a motion that does not repeat itself, or give within_s")
    return float(correlation[rival])


def _known(times_s: ArrayLike, signal: ArrayLike, where: str) -> tuple[Array, Array]:
    """Times and values of the known samples, the size of vectors."""
    times, values = np.asarray(times_s, dtype=np.float64), np.asarray(signal, dtype=np.float64)
    if values.ndim == 2 and values.shape[1] == 3:
        values = np.linalg.norm(values, axis=1)
    if times.ndim != 1 or values.shape != times.shape:
        raise InputError(where, f"shapes {times.shape} and {np.shape(signal)}",
                         "times (m,), samples (m,) or (m, 3)")
    if not (np.isfinite(times).all() and (np.diff(times) > 0.0).all()):
        raise InputError(f"{where} times", "do not increase", "finite instants, each after the one before, s")
    known = np.isfinite(values)
    if known.sum() < _LEAST:
        raise InputError(where, f"{known.sum()} samples are known", f"{_LEAST} or more")
    if np.ptp(values[known]) == 0.0:
        raise InputError(where, "does not vary", "a recording of a motion")
    return times[known], values[known]


def _even(times: Array, values: Array, period: float) -> _Even:
    """Signal less its mean at an even period; zero where unknown."""
    grid = times[0] + period * np.arange(math.floor((times[-1] - times[0]) / period) + 1)
    after = np.clip(np.searchsorted(times, grid), 1, times.size - 1)
    steps = np.diff(times)
    known = (steps <= _GAP_PERIODS * np.median(steps))[after - 1].astype(np.float64)
    centred = values - values.mean()
    return _Even(float(times[0]), known * CubicSpline(times, centred)(grid), known)


def _correlation(a: _Even, b: _Even) -> tuple[NDArray[np.int64], Array, Array]:
    """Lags of a behind b, Pearson's correlation of the samples known in both, and their number.

    The correlation is zero where too little of either's variation overlaps.
    """

    def summed(left: Array, right: Array) -> Array:
        return np.asarray(correlate(left, right, method="fft"))

    together = np.rint(summed(a.known, b.known))
    count = np.maximum(together, 1.0)
    sum_a, sum_b = summed(a.values, b.known), summed(a.known, b.values)
    energy_a = summed(a.values**2, b.known) - sum_a**2 / count
    energy_b = summed(a.known, b.values**2) - sum_b**2 / count
    product = summed(a.values, b.values) - sum_a * sum_b / count
    least_a, least_b = (_ENERGY_SHARE * np.sum(one.values**2) for one in (a, b))
    enough = (energy_a > least_a) & (energy_b > least_b)
    size = np.sqrt(np.where(enough, energy_a * energy_b, 1.0))
    lags = np.asarray(correlation_lags(a.values.size, b.values.size), dtype=np.int64)
    return lags, np.where(enough, product / size, 0.0), together
