"""Table of a study's results: a row for every cell, or for every level of each axis."""

from __future__ import annotations

import math
from typing import Any

from fesloop.analysis.study.results.estimates import Estimate
from fesloop.tables import Table

_WITH_INTERVALS = 3
"""Most metrics that a row has room for with their intervals."""


def results_table(results: Any) -> Table:
    """The table of a `fesloop.analysis.study.results.study_results.StudyResults`."""
    rows = results.summary()
    axes = list(dict.fromkeys(axis for row in rows for axis in row.levels))
    intervals = len(results.metrics) <= _WITH_INTERVALS and any(
        each.has_interval for row in rows for each in row.metrics.values())
    cells = [[*(str(row.levels.get(axis, "all")) for axis in axes), f"{row.planned - row.waiting}",
              f"{row.failed}", *(_estimate(each, intervals) for each in row.metrics.values())]
             for row in rows]
    statistics = " or ".join(dict.fromkeys(each.statistic for row in rows for each in row.metrics.values()))
    statistics += " and 95 % interval over replicates" if intervals else ""
    distinct = results.runs.drop_duplicates("id")["status"]
    return Table(f"{results.name}: {(distinct == 'done').sum()} of {len(distinct)} runs done; {statistics}",
                 (*axes, "runs", "failed", *results.metrics), cells)


def failures_table(results: Any, most: int = 10) -> Table:
    """Causes of failed runs, the most frequent first."""
    rows = [(cause, f"{count}") for cause, count in list(results.failures().items())[:most]]
    return Table("Failed", ("cause", "runs"), rows)


def _estimate(estimate: Estimate, interval: bool) -> str:
    if math.isnan(estimate.value):
        return "-"
    known = interval and estimate.has_interval
    return f"{estimate.value:.3g}" + (f" ({estimate.low:.3g} to {estimate.high:.3g})" if known else "")
