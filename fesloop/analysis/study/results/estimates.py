"""Estimates of a metric at levels of a study, with confidence intervals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.study.design.figure_specs import Statistic
from fesloop.analysis.study.results.axis_levels import Axes, AxisLevel, require_axis
from fesloop.analysis.study.results.quantities import called
from fesloop.analysis.study.results.runs import DONE, FAILED, WAITING, Frame, selected, unit_keys
from fesloop.analysis.study.results.statistics import (
    do_not_differ,
    mean_interval,
    median_interval,
    share_interval,
)
from fesloop.errors import InputError

Array = NDArray[np.float64]
_INTERVALS = {"mean": (mean_interval, "Student's t"), "share": (share_interval, "Wilson"),
              "median": (median_interval, "binomial order statistics")}


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """A metric at some levels of a study.

    Attributes
    ----------
    levels: by axis; unnamed axes are averaged over.
    statistic: mean, median or share. value: of the units; NaN where there are none.
    sd: of the units; NaN for fewer than two.
    low, high: ends of the interval that covers the true value at `confidence`; NaN where there are too few
        units, or these do not differ.
    interval: method of the interval.
    units: number of values that are independent of each other (`fesloop.analysis.study.results.runs`), each
        the mean of one or more runs.
    runs: number of runs that have the metric. failed, missing, waiting: runs that failed, that ended without
        the metric, and that have not ended; none of them contributes to the value.
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
        """The value and its interval: "5.21 (4.9 to 5.52)", or why there is no interval."""
        return in_words(self.value, self.low, self.high, self.units, self.sd)

    @property
    def has_interval(self) -> bool:
        """Whether there is an interval."""
        return math.isfinite(self.high - self.low)

    @property
    def planned(self) -> int:
        """Number of planned runs."""
        return self.runs + self.failed + self.missing + self.waiting


def in_words(value: float, low: float, high: float, units: int, sd: float) -> str:
    """A value and its interval, or why there is none; "-" for a value that is not known."""
    if not math.isfinite(value):
        return "-"
    if math.isfinite(high - low):
        return f"{value:.3g} ({low:.3g} to {high:.3g})"
    same = " that do not differ" if do_not_differ(value, sd) else ""
    return f"{value:.3g} (no interval: {units} value{'' if units == 1 else 's'}{same})"


def estimates(
    axes: Axes, runs: Frame, sampled: Sequence[str], metric: str, by: Sequence[str],
    at: Mapping[str, Any], statistic: Statistic | None, confidence: float, least: float = -math.inf,
) -> list[Estimate]:
    """A metric at every planned combination of levels of the axes `by`, in order of these.

    `least`: the least value that the metric can have by its definition. Intervals end there: what is cut off
    never holds the true value, so that they cover it as often as before.

    Raises InputError for axes or levels that the study does not have, and for a share of other values.
    """
    for axis in by:
        require_axis(axes, axis)
    require_confidence(confidence)
    kind = settled_statistic(runs, metric, statistic)
    chosen = selected(axes, runs, at)
    group = chosen.groupby(list(by), observed=True).ngroup() if by else chosen["cell"] * 0
    # The same units in every group, so that a group in which a member is missing has one fewer.
    keys = unit_keys(chosen, [axis for axis in sampled if axis not in by])
    means = unit_means(chosen, metric, keys, group).groupby(level=0)
    values = {number: each.to_numpy() for number, each in means}
    known = chosen[metric].notna()
    counts = [(part.groupby(group).sum() if len(part) else {}) for part in (
        known, chosen["status"] == FAILED, (chosen["status"] == DONE) & ~known, chosen["status"] == WAITING)]
    ends, name = _INTERVALS[kind]
    found = []
    for number, first in group.drop_duplicates().sort_values().items():
        units = values.get(first, np.zeros(0))
        low, high = ends(units, confidence)
        low = max(low, least)  # NaN stays
        with_metric, failed, missing, waiting = (int(count[first]) for count in counts)
        found.append(Estimate(
            levels=levels_of(axes, chosen, [*by, *at], number), statistic=kind, value=middle(units, kind),
            sd=spread(units), low=low, high=high, confidence=confidence, interval=name, units=len(units),
            runs=with_metric, failed=failed, missing=missing, waiting=waiting))
    return found


def require_confidence(confidence: float) -> None:
    """Raise InputError for a confidence that is not between 0 and 1."""
    if not 0.0 < confidence < 1.0:
        raise InputError("confidence", f"{confidence:g}", "between 0 and 1, such as 0.95")


def unit_means(runs: Frame, metric: str, keys: Sequence[str], group: Any) -> Any:
    """Means of the units that have the metric: a pandas series by group, then by the columns `keys`."""
    return runs.groupby([group, *keys], observed=True)[metric].mean().dropna()


def levels_of(axes: Axes, runs: Frame, named: Sequence[str], row: int) -> dict[str, AxisLevel]:
    """Levels of a row's cell on the named axes."""
    return {axis: axes[axis][runs[axis].cat.codes[row]] for axis in named}


def settled_statistic(runs: Frame, metric: str, statistic: Statistic | None) -> Statistic:
    """The given statistic; without one, a share for a metric without unit that is always 0 or 1, else a mean.

    Raises InputError for an unknown statistic, and for a share of values beyond 0 and 1.
    """
    known = runs[metric].dropna()
    if statistic is None:
        _, unit = called(metric)
        return "share" if not unit and len(known) and known.isin((0.0, 1.0)).all() else "mean"
    if statistic not in _INTERVALS:
        raise InputError("statistic", f"{statistic!r}", ", ".join(_INTERVALS))
    if statistic == "share" and not known.between(0.0, 1.0).all():
        raise InputError(metric, f"is not a share: it goes from {known.min():g} to {known.max():g}",
                         "a metric between 0 and 1", 'take the statistic "mean" or "median"')
    return statistic


def middle(values: Array, statistic: Statistic) -> float:
    """Median or mean; NaN without values."""
    if not len(values):
        return math.nan
    return float(np.median(values) if statistic == "median" else np.mean(values))


def spread(values: Array) -> float:
    """Standard deviation of the sample; NaN for fewer than two values, or infinite ones."""
    return float(values.std(ddof=1)) if len(values) > 1 and np.isfinite(values).all() else math.nan
