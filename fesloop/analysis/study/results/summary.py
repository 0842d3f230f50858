"""A study in a few rows: what is shown of it when it ends."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from fesloop.analysis.study.results.axis_levels import AxisLevel
from fesloop.analysis.study.results.estimates import Estimate

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


def summary_rows(
    metrics: Sequence[str], cells: Cells, tellings: Sequence[Sequence[str] | None]
) -> list[SummaryRow]:
    """The rows of each way to tell runs apart: by the levels of some axes, or by cells (None).

    `cells` gives the estimates of a metric for such a way.
    """
    rows = []
    for by in tellings if metrics else ():
        found = {metric: cells(metric, by) for metric in metrics}
        rows += [SummaryRow(levels=cell.levels, planned=cell.planned, failed=cell.failed,
                            waiting=cell.waiting, metrics={name: each[i] for name, each in found.items()})
                 for i, cell in enumerate(found[metrics[0]])]
    return rows
