"""How axes, levels and metrics of a study are called in its figures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from fesloop.study.axis_levels import AxisLevel, level_text
from fesloop.study.estimates import Estimate
from fesloop.study.figure_specs import Figure, Statistic
from fesloop.study.results import StudyResults

_UNITS = {"deg": "deg", "ms": "ms", "s": "s", "min": "min", "mm": "mm", "cm": "cm", "hz": "Hz", "ma": "mA",
          "us": "µs", "ut": "µT", "n": "N", "nc": "nC", "percent": "%"}
"""Ends of names in fesloop, each with its unit."""


def called(name: str, label: str = "", unit: str = "") -> str:
    """A quantity with its unit: as `label` and `unit` say, else as its name does ("latency_ms")."""
    stem, _, end = name.rpartition("_")
    known = end in _UNITS and stem != ""
    text = label or (stem if known else name).replace("_", " ")
    unit = unit or (_UNITS[end] if known else "")
    return f"{text}, {unit}" if unit else text


def axis_label(results: StudyResults, axis: str) -> str:
    """Of an axis, as its study file calls it."""
    table = results.study.get("axes", {}).get(axis, {})
    return called(axis, table.get("label", ""), table.get("unit", ""))


def metric_label(figure: Figure, statistic: Statistic) -> str:
    """Of the metric that a figure shows; shares are shown in percent."""
    return called(figure.metric, figure.label, figure.unit or ("%" if statistic == "share" else ""))


def level_label(results: StudyResults, axis: str, level: AxisLevel) -> str:
    """A level with the name of its axis where that is a number."""
    if isinstance(level, str):
        return level
    name, _, unit = axis_label(results, axis).rpartition(", ")
    return f"{name} {level_text(level)} {unit}" if name else f"{unit} {level_text(level)}"


def title(results: StudyResults, figure: Figure) -> str:
    """Of a figure: its own, else what it shows of which study."""
    return figure.title or f"{results.name}: {figure.label or called(figure.metric).rpartition(', ')[0]}"


def caption(results: StudyResults, figure: Figure, found: Sequence[Estimate]) -> str:
    """What the numbers of a figure are, and what is no part of them."""
    first = found[0]
    units = sorted({cell.units for cell in found if cell.units})
    counted = "" if not units else f" of {units[0]}" if len(units) == 1 else f" of {units[0]} to {units[-1]}"
    parts = [f"{first.statistic}{counted}", f"{100.0 * first.confidence:g} % interval by {first.interval}"]
    named = {axis for _, axis in figure.named_axes()}
    over = [axis_label(results, axis).partition(",")[0] for axis, levels in results.axes.items()
            if axis not in named and len(levels) > 1]
    parts += [f"over {', '.join(over)}"] if over else []
    parts += [f"{axis_label(results, axis)} = {level_text(first.levels[axis])}" for axis in figure.at]
    counts = Counter({"failed": sum(cell.failed for cell in found),
                      "without the metric": sum(cell.missing for cell in found),
                      "not over yet": sum(cell.waiting for cell in found)})
    planned = sum(cell.planned for cell in found)
    parts += [f"{count} of {planned} runs {what}" for what, count in counts.items() if count]
    return "; ".join(parts)
