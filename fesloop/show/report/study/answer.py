"""A study's question and answer in a sentence or two."""

from __future__ import annotations

import numpy as np

from fesloop.analysis.study.results.estimates import Estimate
from fesloop.show.report.run.words import counted, listed
from fesloop.show.report.study.shown import Shown


def answer(shown: Shown) -> str:
    """What was varied over what, and where the main metric came out best and worst."""
    return " ".join(filter(None, (_question(shown), _state(shown), _found(shown))))


def _question(shown: Shown) -> str:
    results = shown.results
    base = results.study.get("study", {}).get("experiment", "an experiment")
    axes = [f"{shown.axis(axis)[0]} ({counted(len(levels), 'level')})"
            for axis, levels in results.axes.items() if len(levels) > 1]
    if not axes:
        return f"`{base}` was repeated."
    drawn = results.study.get("study", {}).get("design", "grid") != "grid"
    names = [shown.axis(axis)[0] for axis, levels in results.axes.items() if len(levels) > 1]
    varied = f"over {counted(results.runs['cell'].nunique(), 'point')} of {listed(names)}" if drawn \
        else f"over {listed(axes)}"
    return f"`{base}` was run {varied}."


def _state(shown: Shown) -> str:
    """What of it is over."""
    results = shown.results
    if not results.planned:
        return "No run is planned."
    left = results.planned - results.finished
    if left == results.planned:
        return f"None of its {counted(results.planned, 'run')} is over yet."
    return f"{left} of its {results.planned} runs are not over yet; this is of the others." if left else ""


def _found(shown: Shown) -> str:
    """The best and the worst cell, the lowest and the highest where it is not known which is which."""
    if not shown.metric:
        return ""
    cells = [cell for cell in shown.results.cells(shown.metric) if np.isfinite(cell.value)]
    name, unit = shown.metric_name(shown.metric)
    if not cells:
        return f"No run gave {name}." if shown.results.finished else ""
    low, high = (end(cells, key=lambda cell: cell.value) for end in (min, max))
    whole = f", 95 % intervals by {low.interval}" if np.isfinite(low.high - low.low) else ""
    if len(cells) == 1 or low.value == high.value:
        return f"{_upper(name)} is {_told(shown, low, unit)}{' everywhere' if len(cells) > 1 else ''}."
    if shown.better is None:
        first, second, words = low, high, ("lowest", "highest")
    else:
        first, second = (low, high) if shown.better == "low" else (high, low)
        words = ("best", "worst")
    return (f"{_upper(name)} is {words[0]} at {shown.place(first.levels)}: {_told(shown, first, unit)}; "
            f"{words[1]} at {shown.place(second.levels)}: {_told(shown, second, unit)}{whole}.")


def _told(shown: Shown, cell: Estimate, unit: str) -> str:
    """A value with its unit before the interval."""
    value, _, interval = shown.value(cell).partition(" (")
    with_unit = value if cell.statistic == "share" or not unit else f"{value} {unit}"
    return with_unit + (f" ({interval}" if interval else "")


def _upper(name: str) -> str:
    return name[:1].upper() + name[1:]
