"""A study in a few rows: what is shown of it when it ends."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from fesloop.study.axis_levels import Axes, AxisLevel
from fesloop.study.estimates import Estimate

Cells = Callable[[str, Sequence[str] | None], list[Estimate]]


@dataclass(frozen=True, slots=True, kw_only=True)
class SummaryRow:
    """A cell, or a level of one axis over all others.

    Attributes
    ----------
    levels: by axis. planned, failed, waiting: runs. metrics: estimates by metric.
    """

    levels: dict[str, AxisLevel]
    planned: int
    failed: int
    waiting: int
    metrics: dict[str, Estimate]


def summary(axes: Axes, metrics: Sequence[str], cells: Cells, most: int) -> list[SummaryRow]:
    """A row a cell where they are at most so many, else a row for every level of each axis.

    `cells` gives the estimates of a metric at the levels of some axes, or of its cells for None.
    """
    if not metrics:
        return []
    every = _rows(metrics, cells, None)
    if len(every) <= most:
        return every
    return [row for axis in axes for row in _rows(metrics, cells, [axis])]


def _rows(metrics: Sequence[str], cells: Cells, by: Sequence[str] | None) -> list[SummaryRow]:
    found = {metric: cells(metric, by) for metric in metrics}
    return [SummaryRow(levels=cell.levels, planned=cell.planned, failed=cell.failed, waiting=cell.waiting,
                       metrics={metric: each[i] for metric, each in found.items()})
            for i, cell in enumerate(found[metrics[0]])]
