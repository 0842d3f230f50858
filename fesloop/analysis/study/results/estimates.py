"""What a metric is in a cell of a study, and how sure that is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.study.design.figure_specs import Statistic
from fesloop.analysis.study.results.axis_levels import Axes, AxisLevel, require_axis
from fesloop.analysis.study.results.intervals import mean_interval, median_interval, share_interval
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
