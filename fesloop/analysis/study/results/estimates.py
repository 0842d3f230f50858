"""What a metric is in a cell of a study, and how sure that is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.analysis.study.design.figure_specs import Statistic
from fesloop.analysis.study.results.axis_levels import Axes, AxisLevel, require_axis
from fesloop.analysis.study.results.quantities import called
from fesloop.analysis.study.results.repeats import (
    Rows,
    groups_of,
    is_switch,
    selected,
    unit_means,
    units_of,
    values_of,
)
from fesloop.analysis.study.results.run_columns import DONE, FAILED, WAITING, RunColumns
from fesloop.errors import InputError

Array = NDArray[np.float64]
Interval = tuple[float, float]
NO_INTERVAL: Interval = (math.nan, math.nan)


def mean_interval(values: ArrayLike, confidence: float) -> Interval:
    """Of the mean of a normal distribution, by Student's t, of independent values (n,), n of 2 or more."""
    from scipy.special import stdtrit

    x = np.asarray(values, dtype=np.float64)
    if len(x) < 2 or not np.isfinite(x).all():
        return NO_INTERVAL
    half = float(stdtrit(len(x) - 1, 0.5 + 0.5 * confidence)) * float(x.std(ddof=1)) / math.sqrt(len(x))
    middle = float(x.mean())
    return middle - half, middle + half


def median_interval(values: ArrayLike, confidence: float) -> Interval:
    """Of the median of any continuous distribution: two order statistics of independent values (n,).

    How many values lie below the median is binomial (n, 1/2), so that the interval holds the median at
    least at the rate asked for. For 95 % it takes 6 values. David and Nagaraja, Order Statistics, 3rd ed.,
    2003, section 7.1.
    """
    from scipy.special import bdtr

    x = np.sort(np.asarray(values, dtype=np.float64))
    n, left_out = len(x), 0.5 * (1.0 - confidence)
    cut = int(np.searchsorted(bdtr(np.arange(n), n, 0.5), left_out, side="right"))
    if cut == 0 or not np.isfinite(x).all():
        return NO_INTERVAL
    return float(x[cut - 1]), float(x[n - cut])


def share_interval(values: ArrayLike, confidence: float) -> Interval:
    """Of a share, by Wilson's score (1927, doi 10.1080/01621459.1927.10502953), of values (n,) in [0, 1].

    Values are 0 or 1; or shares themselves, whose variance is at most that of 0 and 1 of the same mean,
    so that the interval is wide rather than narrow.
    """
    from scipy.special import ndtri

    x = np.asarray(values, dtype=np.float64)
    if not len(x):
        return NO_INTERVAL
    n, share = len(x), float(x.mean())
    z = float(ndtri(0.5 + 0.5 * confidence))
    middle = (share + z * z / (2.0 * n)) / (1.0 + z * z / n)
    half = z / (1.0 + z * z / n) * math.sqrt(share * (1.0 - share) / n + z * z / (4.0 * n * n))
    # The ends are 0 and 1 exactly where all values are; rounding must not put them beside that.
    return (0.0 if share == 0.0 else middle - half), (1.0 if share == 1.0 else middle + half)


def share_difference_interval(first: ArrayLike, second: ArrayLike, confidence: float) -> Interval:
    """Of the difference of two shares, first less second, of paired values (n,) in [0, 1].

    Distances of both shares to the ends of their Wilson intervals are added as correlated vectors: method 10
    of Newcombe 1998 (doi 10.1002/(SICI)1097-0258(19981130)17:22<2635::AID-SIM954>3.0.CO;2-C).
    """
    one, other = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    if not len(one):
        return NO_INTERVAL
    p, q = float(one.mean()), float(other.mean())
    (low_p, high_p), (low_q, high_q) = (share_interval(each, confidence) for each in (one, other))
    correlation = _shared(one, other)
    below = _added(p - low_p, high_q - q, correlation)
    above = _added(high_p - p, q - low_q, correlation)
    return p - q - below, p - q + above


def _shared(one: Array, other: Array) -> float:
    """Correlation of pairs, less a correction for continuity where it is positive."""
    spread = float(one.std() * other.std())
    if spread == 0.0:
        return 0.0
    covariance = float(np.mean(one * other) - one.mean() * other.mean())
    if covariance > 0.0:
        covariance = max(covariance - 0.5 / len(one), 0.0)
    return covariance / spread


def _added(a: float, b: float, correlation: float) -> float:
    return math.sqrt(max(a * a - 2.0 * correlation * a * b + b * b, 0.0))


def sign_test(differences: ArrayLike) -> float:
    """Chance of signs at least as unequal where either is as likely; two-sided, exact, zeros left out.

    For values of 0 and 1 it is McNemar's exact test.
    """
    from scipy.special import bdtr

    signs = np.sign(np.asarray(differences, dtype=np.float64))
    fewer, n = int(min(np.sum(signs > 0), np.sum(signs < 0))), int(np.count_nonzero(signs))
    return min(1.0, 2.0 * float(bdtr(fewer, n, 0.5))) if n else 1.0


def signed_rank_test(differences: ArrayLike) -> float:
    """Wilcoxon's signed-rank test, two-sided, zeros left out; exact for 50 or fewer without ties."""
    from scipy.stats import wilcoxon

    x = np.asarray(differences, dtype=np.float64)
    x = x[x != 0.0]
    if not len(x):
        return 1.0
    exact = len(x) <= 50 and len(np.unique(np.abs(x))) == len(x)
    return float(wilcoxon(x, method="exact" if exact else "approx").pvalue)


_ROUNDING = 1e-9
_INTERVALS = {"mean": (mean_interval, "Student's t"), "share": (share_interval, "Wilson"),
              "median": (median_interval, "binomial order statistics")}


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """A metric at some levels of a study.

    Attributes
    ----------
    levels: by axis; axes that are not named are averaged over.
    statistic: mean, median or share. value: of the units; NaN where there are none.
    sd: of the units; NaN for fewer than two.
    low, high: ends of the interval that holds the true value at `confidence`; NaN where units are too few.
    interval: how it was made.
    units: values that are independent of each other (`fesloop.analysis.study.results.repeats`), each of one
        or more runs.
    runs: that have the metric. failed, missing, waiting: runs that failed, that were done without having the
        metric, and that are not over yet; none of them is part of the value.
    """

    levels: dict[str, AxisLevel]
    statistic: Statistic
    value: float
    sd: float
    low: float
    high: float
    confidence: float
    interval: str
    units: int
    runs: int
    failed: int
    missing: int
    waiting: int

    def __str__(self) -> str:
        """The value and its interval: "5.21 (4.9 to 5.52)", or why there is none."""
        return in_words(self.value, self.low, self.high, self.units, self.sd)

    @property
    def has_interval(self) -> bool:
        """Whether there is one, of values that differ."""
        return math.isfinite(self.high - self.low) and not alike(self.value, self.low, self.high, self.sd)

    @property
    def planned(self) -> int:
        """Runs of any outcome."""
        return self.runs + self.failed + self.missing + self.waiting


def alike(value: float, low: float, high: float, sd: float) -> bool:
    """Whether an interval has no width since repeated values do not differ at all, but for rounding."""
    least = _ROUNDING * abs(value)
    return sd <= least and high - low <= least


def in_words(value: float, low: float, high: float, units: int, sd: float) -> str:
    """A value and its interval; "-" for a value that is not known, and why there is no interval."""
    if not math.isfinite(value):
        return "-"
    if alike(value, low, high, sd):
        return f"{value:.3g} (no interval: {units} values that do not differ)"
    if math.isfinite(high - low):
        return f"{value:.3g} ({low:.3g} to {high:.3g})"
    return f"{value:.3g} (no interval: {units} value{'' if units == 1 else 's'})"


def estimates(
    axes: Axes, runs: RunColumns, drawn: Sequence[str], metric: str, by: Sequence[str],
    at: Mapping[str, Any], statistic: Statistic | None, confidence: float,
) -> list[Estimate]:
    """A metric at every combination of levels of the axes `by` that is planned, in order of these.

    Raises InputError for axes, levels, metrics that are not there, and for a share of what is none.
    """
    for axis in by:
        require_axis(axes, axis)
    if not 0.0 < confidence < 1.0:
        raise InputError("confidence", f"{confidence:g}", "between 0 and 1, such as 0.95")
    values, rows = values_of(runs, metric), selected(axes, runs, at)
    kind = settled_statistic(values, metric, statistic)
    groups = groups_of([runs.places[axis][rows] for axis in by] or [np.zeros(len(rows), dtype=np.int64)])
    # The same units in every group, so that a group in which a member is missing has one fewer.
    units = units_of(runs, rows, [axis for axis in drawn if axis not in by])
    order = np.argsort(groups, kind="stable")
    ends = np.flatnonzero(np.diff(groups[order])) + 1
    found = []
    for members in np.split(order, ends) if len(rows) else []:
        levels = {axis: axes[axis][runs.places[axis][rows[members[0]]]] for axis in by}
        found.append(_estimate(levels | place_at(axes, runs, at, rows[members[0]]), kind, confidence,
                               runs.status[rows[members]], values[rows[members]], units[members]))
    return found


def place_at(axes: Axes, runs: RunColumns, at: Mapping[str, Any], row: int) -> dict[str, AxisLevel]:
    """The levels asked for, as the study has them."""
    return {axis: axes[axis][runs.places[axis][row]] for axis in at}


def settled_statistic(values: Array, metric: str, statistic: Statistic | None) -> Statistic:
    """As asked for; else a share of what has no unit and is only ever 0 or 1, a mean of everything else."""
    if statistic is None:
        _, unit = called(metric)
        return "share" if not unit and is_switch(values) else "mean"
    if statistic not in _INTERVALS:
        raise InputError("statistic", f"{statistic!r}", ", ".join(_INTERVALS))
    known = values[~np.isnan(values)]
    if statistic == "share" and ((known < 0.0) | (known > 1.0)).any():
        raise InputError(metric, f"is no share: it goes from {known.min():g} to {known.max():g}",
                         "a metric between 0 and 1", 'take the statistic "mean" or "median"')
    return statistic


def _estimate(
    levels: dict[str, AxisLevel], statistic: Statistic, confidence: float, status: NDArray[Any],
    values: Array, units: Rows,
) -> Estimate:
    known = ~np.isnan(values)
    repeated = unit_means(units[known], values[known]) if known.any() else np.zeros(0)
    ends, name = _INTERVALS[statistic]
    low, high = ends(repeated, confidence)
    return Estimate(
        levels=levels, statistic=statistic, value=middle(repeated, statistic), sd=spread(repeated), low=low,
        high=high, confidence=confidence, interval=name, units=len(repeated),
        runs=int(known.sum()), failed=int(np.sum(status == FAILED)),
        missing=int(np.sum((status == DONE) & ~known)), waiting=int(np.sum(status == WAITING)))


def middle(values: Array, statistic: Statistic) -> float:
    """Median or mean; NaN of nothing."""
    if not len(values):
        return math.nan
    return float(np.median(values) if statistic == "median" else np.mean(values))


def spread(values: Array) -> float:
    """Standard deviation, of the sample; NaN of fewer than two or of what is not finite."""
    return float(values.std(ddof=1)) if len(values) > 1 and np.isfinite(values).all() else math.nan
