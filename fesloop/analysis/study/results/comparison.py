"""Paired comparison of two places of a study: what differs where everything else is the same."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.study.design.figure_specs import Statistic
from fesloop.analysis.study.results.axis_levels import Axes, AxisLevel, level_text
from fesloop.analysis.study.results.estimates import (
    Interval,
    in_words,
    mean_interval,
    median_interval,
    middle,
    place_at,
    settled_statistic,
    share_difference_interval,
    sign_test,
    signed_rank_test,
    spread,
)
from fesloop.analysis.study.results.repeats import Rows, selected, unit_means, units_of, values_of
from fesloop.analysis.study.results.run_columns import FAILED, WAITING, RunColumns
from fesloop.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """A metric at `first` less that at `second`, over pairs of runs that differ in nothing else.

    Attributes
    ----------
    metric: that is compared. first, second: levels of the two places, by axis.
    statistic: mean or median of the differences, or difference of the shares.
    value: of the units; positive where the metric is larger at `first`.
    first_value, second_value: the statistic at the two places, over the same units.
    sd: of the units' differences. low, high: ends of the interval of the value at `confidence`; NaN where
        units are too few. interval: how it was made.
    p: chance of differences like these where there is none, by `test`, two-sided.
    pairs: of runs, that both have the metric. units: values that are independent of each other
        (`fesloop.analysis.study.results.repeats`), each of one or more pairs.
    dropped: pairs that are no part of it, by why: a run failed, is not over, or lacks a finite metric.
    unpaired: runs at either place without a counterpart at the other.
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
        """The difference and its interval: "-1.2 (-1.9 to -0.5)", or why there is none."""
        return in_words(self.value, self.low, self.high, self.units, self.sd)


def compare(
    axes: Axes, runs: RunColumns, drawn: Sequence[str], metric: str, first: Mapping[str, Any],
    second: Mapping[str, Any], at: Mapping[str, Any], statistic: Statistic | None, confidence: float,
) -> Comparison:
    """Pair runs of the same replicate at the same levels of all other axes, and compare them.

    Raises InputError for places that name different axes or are the same, for what the study does not have,
    and where nothing can be paired.
    """
    _require_comparable(first, second, at, confidence)
    values = values_of(runs, metric)
    kind = settled_statistic(values, metric, statistic)
    rows = [selected(axes, runs, {**at, **place}) for place in (first, second)]
    pairs = _paired(axes, runs, rows[0], rows[1], tuple(first))
    if not len(pairs):
        raise InputError(f"{_text(first)} and {_text(second)}", "share no levels of the other axes",
                         "two places of a grid", "points that were drawn have no pairs: see their estimates")
    whole = np.isfinite(values[pairs[:, 0]] - values[pairs[:, 1]])
    dropped = Counter(_reason(*runs.status[pair]) for pair in pairs[~whole])
    kept = pairs[whole]
    units = units_of(runs, kept[:, 0], [axis for axis in drawn if axis not in first])
    one, other = (unit_means(units, values[kept[:, side]]) for side in (0, 1))
    found = _compared(one, other, kind, confidence)
    places = [place_at(axes, runs, {**place, **at}, int(pairs[0, side]))
              for side, place in enumerate((first, second))]
    return Comparison(metric=metric, first=places[0], second=places[1], statistic=kind, confidence=confidence,
                      pairs=len(kept), units=len(one), dropped=dict(dropped.most_common()),
                      unpaired=len(rows[0]) + len(rows[1]) - 2 * len(pairs), **found)


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
    if not 0.0 < confidence < 1.0:
        raise InputError("confidence", f"{confidence:g}", "between 0 and 1, such as 0.95")


def _text(place: Mapping[str, Any]) -> str:
    return ", ".join(f"{axis} = {level_text(level)}" for axis, level in place.items()) or "no axis"


def _paired(axes: Axes, runs: RunColumns, first: Rows, second: Rows, compared: tuple[str, ...]) -> Rows:
    """Rows of runs that differ in the compared axes alone, (pairs, 2)."""
    same = [runs.places[axis] for axis in axes if axis not in compared]
    keys = np.stack([*same, runs.replicate, runs.seed], axis=1)
    counterpart = {tuple(key): row for key, row in zip(keys[second].tolist(), second.tolist(), strict=True)}
    pairs = [(row, counterpart.get(tuple(key), -1))
             for key, row in zip(keys[first].tolist(), first.tolist(), strict=True)]
    return np.array([pair for pair in pairs if pair[1] >= 0], dtype=np.int64).reshape(-1, 2)


def _reason(first: str, second: str) -> str:
    """Why a pair may not be whole."""
    if WAITING in (first, second):
        return "not over yet"
    failed = [name for name, status in (("first", first), ("second", second)) if status == FAILED]
    return {0: "without a finite metric", 1: f"{''.join(failed)} failed", 2: "both failed"}[len(failed)]


def _compared(one: Array, other: Array, statistic: Statistic, confidence: float) -> dict[str, Any]:
    """What two values (units,) each differ by."""
    differences = one - other
    interval, name, test, p = _judged(one, other, differences, statistic, confidence)
    return {"value": middle(differences, statistic), "first_value": middle(one, statistic),
            "second_value": middle(other, statistic), "sd": spread(differences), "low": interval[0],
            "high": interval[1], "interval": name, "test": test, "p": p}


def _judged(
    one: Array, other: Array, differences: Array, statistic: Statistic, confidence: float
) -> tuple[Interval, str, str, float]:
    """Interval, its name, the test's name, its p."""
    if statistic == "share":
        return (share_difference_interval(one, other, confidence), "Newcombe, paired", "sign (McNemar)",
                sign_test(differences))
    if statistic == "median":
        return (median_interval(differences, confidence), "binomial order statistics", "sign",
                sign_test(differences))
    return (mean_interval(differences, confidence), "Student's t", "Wilcoxon signed rank",
            signed_rank_test(differences))
