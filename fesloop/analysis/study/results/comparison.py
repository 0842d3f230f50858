"""Paired comparison of two places of a study over runs that differ in nothing else."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.study.design.figure_specs import Statistic
from fesloop.analysis.study.results.axis_levels import Axes, AxisLevel, level_text, require_axis
from fesloop.analysis.study.results.estimates import (
    in_words,
    levels_of,
    middle,
    require_confidence,
    settled_statistic,
    spread,
    unit_means,
)
from fesloop.analysis.study.results.runs import FAILED, WAITING, Frame, selected, unit_keys
from fesloop.analysis.study.results.statistics import (
    Interval,
    mean_interval,
    median_interval,
    share_difference_interval,
    sign_test,
    signed_rank_test,
)
from fesloop.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """A metric at `first` less that at `second`, over pairs of runs that differ in nothing else.

    Attributes
    ----------
    metric: the compared metric. first, second: levels of the two places, by axis.
    statistic: mean or median of the differences, or difference of the shares.
    value: of the units; positive where the metric is larger at `first`.
    first_value, second_value: the statistic at the two places, over the same units.
    sd: of the units' differences. low, high: ends of the interval of the value at `confidence`; NaN where
        units are too few, or do not differ. interval: its method.
    p: two-sided p value of `test` for no difference.
    pairs: number of pairs of runs that both have the metric. units: number of values that are independent of
        each other (`fesloop.analysis.study.results.runs`), each of one or more pairs.
    dropped: number of pairs that are left out, by cause: a run failed, has not ended, or lacks the metric.
    unpaired: number of runs at either place without a counterpart at the other.
    """

    metric: str
    first: dict[str, AxisLevel]
    second: dict[str, AxisLevel]
    statistic: Statistic
    value: float
    first_value: float
    second_value: float
    sd: float
    low: float
    high: float
    confidence: float
    interval: str
    test: str
    p: float
    pairs: int
    units: int
    dropped: dict[str, int]
    unpaired: int

    def __str__(self) -> str:
        """The difference and its interval: "-1.2 (-1.9 to -0.5)", or why there is no interval."""
        return in_words(self.value, self.low, self.high, self.units, self.sd)


class _Method(NamedTuple):
    """Interval and test of a statistic; the functions take values (units,) at both places."""

    interval: str
    ends: Callable[[Array, Array, float], Interval]
    test: str
    p: Callable[[Array], float]


_METHODS: dict[Statistic, _Method] = {
    "mean": _Method("Student's t", lambda one, other, confidence: mean_interval(one - other, confidence),
                    "Wilcoxon signed rank", signed_rank_test),
    "median": _Method("binomial order statistics", lambda one, other, confidence:
                      median_interval(one - other, confidence), "sign", sign_test),
    "share": _Method("Newcombe, paired", share_difference_interval, "sign (McNemar)", sign_test),
}


def compare(
    axes: Axes, runs: Frame, sampled: Sequence[str], metric: str, first: Mapping[str, Any],
    second: Mapping[str, Any], at: Mapping[str, Any], statistic: Statistic | None, confidence: float,
) -> Comparison:
    """Pair runs of the same replicate at the same levels of all other axes, and compare them.

    Raises InputError for places that name different axes or are the same, for axes or levels that the study
    does not have, and where there are no pairs.
    """
    _require_comparable(first, second, at, confidence)
    for axis in first:
        require_axis(axes, axis)
    kind = settled_statistic(runs, metric, statistic)
    sides = [selected(axes, runs, {**at, **place}) for place in (first, second)]
    shared = [*(axis for axis in axes if axis not in first), "replicate", "seed"]
    # A left row meets its counterpart by all that the two places have in common.
    pairs = sides[0][[*shared, metric, "status"]].merge(sides[1][[*shared, metric, "status"]], on=shared,
                                                        suffixes=("_first", "_second"))
    if not len(pairs):
        raise InputError(f"{_text(first)} and {_text(second)}", "share no levels of the other axes",
                         "two places of a grid",
                         "points of a random or Sobol design have no pairs: see their estimates")
    names = [f"{metric}_first", f"{metric}_second"]
    whole = np.isfinite(pairs[names]).all(axis=1)
    dropped = Counter(_reason(*statuses) for statuses in zip(
        pairs["status_first"][~whole], pairs["status_second"][~whole], strict=True))
    kept = pairs[whole]
    keys = unit_keys(kept, [axis for axis in sampled if axis not in first])
    one, other = (unit_means(kept, name, keys, kept["seed"] * 0).to_numpy() for name in names)
    differences, method = one - other, _METHODS[kind]
    low, high = method.ends(one, other, confidence)
    places = [levels_of(axes, side, [*first, *at], side.index[0]) for side in sides]
    return Comparison(
        metric=metric, first=places[0], second=places[1], statistic=kind, value=middle(differences, kind),
        first_value=middle(one, kind), second_value=middle(other, kind), sd=spread(differences), low=low,
        high=high, confidence=confidence, interval=method.interval, test=method.test, p=method.p(differences),
        pairs=len(kept), units=len(one), dropped=dict(dropped.most_common()),
        unpaired=len(sides[0]) + len(sides[1]) - 2 * len(pairs))


def _require_comparable(
    first: Mapping[str, Any], second: Mapping[str, Any], at: Mapping[str, Any], confidence: float
) -> None:
    if set(first) != set(second) or not first:
        raise InputError(f"{_text(first)} and {_text(second)}", "do not name the same axes",
                         "two places by the same axes, one or more")
    if all(level_text(first[axis]) == level_text(second[axis]) for axis in first):
        raise InputError(_text(first), "is compared with itself", "two different places")
    for axis in set(first) & set(at):
        raise InputError(f"at.{axis}", "is among the axes that are compared", "another axis")
    require_confidence(confidence)


def _text(place: Mapping[str, Any]) -> str:
    return ", ".join(f"{axis} = {level_text(level)}" for axis, level in place.items()) or "no axis"


def _reason(first: str, second: str) -> str:
    """The cause for which a pair is left out."""
    if WAITING in (first, second):
        return "not over yet"
    failed = [name for name, status in (("first", first), ("second", second)) if status == FAILED]
    return {0: "without a finite metric", 1: f"{''.join(failed)} failed", 2: "both failed"}[len(failed)]
