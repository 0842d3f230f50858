"""Curves of a study: a metric over one axis with its intervals as bands, a line for each level of another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fesloop.picture.palette import BLACK, CHANNELS, INK, tidy
from fesloop.study.axis_levels import AxisLevel, is_numeric, level_text
from fesloop.study.estimates import Estimate
from fesloop.study.figure_axes import head, mark_levels, panels, places, set_scales
from fesloop.study.figure_labels import axis_label, caption, level_label, metric_label, title
from fesloop.study.figure_specs import Figure
from fesloop.study.overlays import Overlay, on_panel
from fesloop.study.results import StudyResults

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing

Array = NDArray[np.float64]
_MARKERS = "os^Dv<>P"
_OWN_STYLES = ("--", ":", "-.")
_DODGE = 0.12
"""How far lines are shifted past each other over text, of the distance between two levels."""


def curves(results: StudyResults, figure: Figure, found: Sequence[Estimate],
           overlays: Sequence[Overlay]) -> Drawing:
    """Draw a figure of kind "curves"; `found` are its cells."""
    levels: Sequence[AxisLevel | None] = [None] if figure.panels is None else results.axes[figure.panels]
    beside = 1.6 if figure.by is not None or overlays or any(cell.failed for cell in found) else 0.2
    drawing, every = panels(len(levels), 5.2 if len(levels) == 1 else 3.7, 3.3, beside)
    for axes, level in zip(every, levels, strict=True):
        mine = [cell for cell in found if level is None or cell.levels[str(figure.panels)] == level]
        set_scales(axes, results, figure.x, None)
        _draw_lines(axes, results, figure, mine)
        _draw_overlays(axes, results, figure, on_panel(overlays, level), overlays)
        first = axes.get_subplotspec().is_first_col()  # type: ignore[union-attr]
        tidy(axes, axis_label(results, figure.x), metric_label(figure, found[0].statistic) if first else "",
             "" if level is None else level_label(results, str(figure.panels), level))
        axes.grid(axis="y", color="0.9", linewidth=0.7)
        axes.set_axisbelow(True)
    _limit(every, results, figure, found)
    _mark_lost(every, results, figure, found, levels)
    _key(drawing, every, results, figure, found)
    head(drawing, title(results, figure), caption(results, figure, found))
    return drawing


def _lines(results: StudyResults, figure: Figure) -> Sequence[AxisLevel | None]:
    return [None] if figure.by is None else results.axes[figure.by]


def _colour(results: StudyResults, figure: Figure, number: int) -> Any:
    """Of a line: told apart where it is a kind, in order where it is a number."""
    lines = _lines(results, figure)
    if figure.by is None or not is_numeric(results.axes[figure.by]) or len(lines) < 3:
        return CHANNELS[number % len(CHANNELS)]
    from matplotlib import colormaps

    return colormaps["viridis"](0.88 * number / (len(lines) - 1))


def _draw_lines(axes: Axes, results: StudyResults, figure: Figure, cells: Sequence[Estimate]) -> None:
    lines = _lines(results, figure)
    for number, line in enumerate(lines):
        mine = [cell for cell in cells if line is None or cell.levels[str(figure.by)] == line]
        x = _x(results, figure, [cell.levels[figure.x] for cell in mine], number - 0.5 * (len(lines) - 1))
        label = "" if line is None else level_text(line)
        _draw_line(axes, x, mine, _colour(results, figure, number), _MARKERS[number % len(_MARKERS)], label,
                   is_numeric(results.axes[figure.x]))


def _x(results: StudyResults, figure: Figure, levels: Sequence[AxisLevel], shift: float) -> Array:
    """Places of levels; over text lines stand beside each other."""
    every = results.axes[figure.x]
    at = places(every)[[every.index(level) for level in levels]]
    return at if is_numeric(every) else at + _DODGE * shift


def _draw_line(axes: Axes, x: Array, cells: Sequence[Estimate], colour: Any, marker: str, label: str,
               joined: bool) -> None:
    """A line with its band, or over text points with bars; hollow where some of the runs failed."""
    factor = 100.0 if cells and cells[0].statistic == "share" else 1.0
    value, low, high = (factor * np.array([getattr(cell, name) for cell in cells])
                        for name in ("value", "low", "high"))
    some_failed = np.array([cell.failed > 0 for cell in cells], dtype=bool)
    if joined:
        axes.fill_between(x, low, high, color=colour, alpha=0.17, linewidth=0.0, zorder=1)
        axes.plot(x, value, color=colour, linewidth=1.5, zorder=3)
    else:
        axes.vlines(x, low, high, color=colour, linewidth=1.5, zorder=2)
    for chosen, face in ((~some_failed, colour), (some_failed, "white")):
        axes.plot(x[chosen], value[chosen], marker, color=colour, markerfacecolor=face, markersize=4.5, zorder=4)
    axes.plot([], [], marker, linestyle="-" if joined else "none", color=colour, markersize=4.5, label=label or None)


def _draw_overlays(axes: Axes, results: StudyResults, figure: Figure, mine: Sequence[Overlay],
                   every: Sequence[Overlay]) -> None:
    labels = list(dict.fromkeys(overlay.label for overlay in every))
    lines = [level_text(line) for line in _lines(results, figure) if line is not None]
    for overlay in mine:
        style = _OWN_STYLES[labels.index(overlay.label) % len(_OWN_STYLES)]
        number = None if overlay.line is None else lines.index(level_text(overlay.line))
        colour = BLACK if number is None else _colour(results, figure, number)
        if len(overlay.y):
            axes.plot(overlay.x, overlay.y, style, color=colour, linewidth=1.6, zorder=5, gid="overlay")
        for x in () if len(overlay.y) else overlay.x:
            axes.axvline(x, linestyle=style, color=colour, linewidth=1.3, zorder=2, gid="overlay")
        axes.plot([], [], style, color=INK, linewidth=1.4, label=overlay.label)


def _limit(every: Sequence[Axes], results: StudyResults, figure: Figure, found: Sequence[Estimate]) -> None:
    """One scale for all panels: from 0 where nothing is below, shares to 100 %."""
    share = found[0].statistic == "share"
    factor = 100.0 if share else 1.0
    low, high = figure.low, figure.high
    if low is None and all(not cell.low < 0.0 and not cell.value < 0.0 for cell in found):
        low = -0.02 if share else 0.0
    if high is None and share:
        high = 1.02
    every[0].set_ylim(None if low is None else factor * low, None if high is None else factor * high)
    for axes in every:
        levels = results.axes[figure.x]
        if not is_numeric(levels):
            axes.set_xlim(-0.5, len(levels) - 0.5)
        axes.get_xlim()
        mark_levels(axes, "x", levels)


def _mark_lost(every: Sequence[Axes], results: StudyResults, figure: Figure, found: Sequence[Estimate],
               levels: Sequence[AxisLevel | None]) -> None:
    """A cross at the foot of the panel where all runs failed."""
    from matplotlib.transforms import blended_transform_factory

    lines = _lines(results, figure)
    for axes, level in zip(every, levels, strict=True):
        foot = blended_transform_factory(axes.transData, axes.transAxes)
        for number, line in enumerate(lines):
            lost = [cell.levels[figure.x] for cell in found if cell.failed and not cell.runs
                    and (level is None or cell.levels[str(figure.panels)] == level)
                    and (line is None or cell.levels[str(figure.by)] == line)]
            if lost:
                axes.plot(_x(results, figure, lost, number - 0.5 * (len(lines) - 1)),
                          np.full(len(lost), 0.025 + 0.035 * number), "x", color=_colour(results, figure, number),
                          markersize=5, transform=foot, clip_on=False, zorder=6, gid="all failed")


def _key(drawing: Drawing, every: Sequence[Axes], results: StudyResults, figure: Figure,
         found: Sequence[Estimate]) -> None:
    """Beside the panels, so that it hides nothing."""
    from matplotlib.lines import Line2D

    handles: dict[str, Any] = {}
    for axes in every:
        handles |= {label: handle for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
                    if label not in handles}
    if any(cell.failed and cell.runs for cell in found):
        handles["some runs failed"] = Line2D([], [], marker="o", linestyle="none", color="0.4",
                                             markerfacecolor="white", markersize=4.5)
    if any(cell.failed and not cell.runs for cell in found):
        handles["all runs failed"] = Line2D([], [], marker="x", linestyle="none", color="0.4", markersize=5)
    if handles:
        name = None if figure.by is None else axis_label(results, figure.by)
        drawing.legend(handles.values(), handles, loc="outside right upper", frameon=False, fontsize=8, title=name,
                       title_fontsize=8, alignment="left")
