"""Table of a study's cells, and section on its failed runs."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.study.results.axis_levels import level_text
from fesloop.analysis.study.results.quantities import with_unit
from fesloop.analysis.study.results.runs import FAILED
from fesloop.show.report.parts import Bars, Paragraph, Part, Section, Table
from fesloop.show.report.run.words import counted
from fesloop.show.report.study.shown import Shown

_MOST_ROWS = 60
"""Most cells that are listed one by one; of more, levels of each axis are listed (chosen)."""
_MOST_INTERVALS = 4
"""Most metrics that are listed with their intervals (chosen)."""
_MOST_CAUSES, _MOST_LEVELS = 20, 4
"""Most causes that are listed, and most levels that are named for each (chosen)."""


def cells_section(shown: Shown) -> Section | None:
    """Every cell, or every level of each axis, with all metrics; None without results."""
    rows = shown.results.summary(_MOST_ROWS)
    if not rows or not shown.results.finished:
        return None
    axes = list(dict.fromkeys(axis for row in rows for axis in row.levels))
    whole = all(len(row.levels) == len(rows[0].levels) for row in rows) and len(axes) == len(rows[0].levels)
    intervals = len(shown.results.metrics) <= _MOST_INTERVALS and any(
        each.has_interval for row in rows for each in row.metrics.values())
    table = Table(columns=[*(with_unit(*shown.axis(axis)) for axis in axes), "runs", "failed",
                           *(shown.metric_label(metric) for metric in shown.results.metrics)],
                  rows=[[*(level_text(row.levels[axis]) if axis in row.levels else "all" for axis in axes),
                         str(row.planned - row.waiting), str(row.failed),
                         *(shown.value(each, interval=intervals) for each in row.metrics.values())]
                        for row in rows])
    text = "Every cell" if whole else "Every level of each axis, averaged over the others"
    text += ", with 95 % intervals of what is repeated." if intervals else "."
    return Section(key="cells", title="Cells" if whole else "Levels", parts=[Paragraph(text=text), table])


def failures_section(shown: Shown) -> Section | None:
    """Section on failed runs by cause and level; None if no run failed."""
    runs = shown.results.runs
    failed = (runs["status"] == FAILED).to_numpy()
    if not failed.any():
        return None
    by_cause: dict[str, list[int]] = defaultdict(list)
    for row in np.flatnonzero(failed).tolist():
        by_cause[runs["cause"][row]].append(row)
    ordered = sorted(by_cause.items(), key=lambda item: -len(item[1]))
    rows = [[str(len(members)), cause or "unknown", _where(shown, np.array(members))]
            for cause, members in ordered[:_MOST_CAUSES]]
    more = sum(len(members) for _, members in ordered[_MOST_CAUSES:])
    parts: list[Part] = [Paragraph(text=(
        f"{counted(int(failed.sum()), 'run')} of {shown.results.planned} failed"
        f"{f', {more} of them for causes that are not listed' if more else ''}; none of them is part of any "
        "value above.")), Table(columns=["runs", "cause", "only at"], rows=rows), *_shares(shown, failed)]
    return Section(key="failures", title="Failures", parts=parts)


def _where(shown: Shown, rows: NDArray[np.int64]) -> str:
    """Levels to which runs are confined, axis by axis; "everywhere" where they are not."""
    parts = []
    for axis, levels in shown.results.axes.items():
        places = np.unique(shown.results.runs[axis].cat.codes.to_numpy()[rows])
        if len(places) < len(levels) and len(places) <= _MOST_LEVELS:
            name, unit = shown.axis(axis)
            texts = ", ".join(level_text(levels[place]) for place in places)
            parts.append(f"{name} {texts} {unit}".rstrip())
    return "; ".join(parts) or "everywhere"


def _shares(shown: Shown, failed: NDArray[np.bool_]) -> Iterator[Part]:
    """Share of runs that failed at each level, of the axis along which that differs most."""
    runs, best = shown.results.runs, ("", np.zeros(0))
    for axis in shown.chosen:
        count = len(shown.results.axes[axis])
        places = runs[axis].cat.codes.to_numpy()
        shares = np.bincount(places[failed], minlength=count) / np.maximum(
            1, np.bincount(places, minlength=count))
        if count <= 24 and (not best[0] or np.ptp(shares) > np.ptp(best[1])):
            best = axis, shares
    axis, shares = best
    if axis:
        name = shown.axis(axis)[0]
        yield Bars(key="failures-by-level", title=f"Share of runs that failed, by {name}",
                   x_label="failed, %", names=[level_text(level) for level in shown.results.axes[axis]],
                   values={"failed": (100.0 * shares).tolist()}, roles={"failed": "plain"}, stacked=False,
                   text=f"Share of runs that failed at each level of {name}.")
