"""Curves of a study: a metric over one axis with its intervals as bands, a line for each level of another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.study.results.axis_levels import AxisLevel, is_numeric, level_text
from fesloop.analysis.study.results.estimates import Estimate
from fesloop.show.figures.content import Content
from fesloop.show.figures.layout import add_key, curve_ends, is_leftmost, is_lowest, lay_out
from fesloop.show.picture.palette import BLACK, BLUE, GREEN, INK, ORANGE, PURPLE, SKY, VERMILION, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing
    from matplotlib.transforms import Transform

Array = NDArray[np.float64]
_COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK, "0.5")
_MARKERS = "os^Dv<>P"
_OVERLAY_STYLES = ("--", ":", "-.")
_DODGE = 0.12
"""Horizontal offset between lines over text levels, as a share of the distance between levels."""
_MOST_BANDS, _BESIDE_PT = 3, 2.2
"""Most bands that can be distinguished where they overlap; distance of bars where there are more, points."""
_FOOT, _MOST_FOOT = 0.045, 0.16
"""Room below the data for each line with failed runs, and for all such lines; as shares of the axis."""


def curves(content: Content) -> Drawing:
    """Draw a figure of kind "curves"."""
    count, key = len(content.panels), _key(content)
    name = "" if content.figure.by is None else content.axis_label(content.figure.by)
    intervals = any(np.isfinite(cell.high) for cell in content.cells)
    width = 5.2 if count == 1 else 3.6
    drawing, every = lay_out(count, (width, 3.2), content.title,
                             content.caption(intervals=intervals), [*key, name] if key else [], "beside")
    low, high = curve_ends(content)
    foot = _foot(content) * (high - low)
    for number, (axes, panel) in enumerate(zip(every, content.panels, strict=True)):
        content.x.apply(axes, "x", squares=False)
        axes.set_ylim(low - foot, high)
        for line, level in enumerate(content.lines):
            _draw_line(axes, content, content.on(panel, level), line)
            _mark_lost(axes, content, content.on(panel, level), line, low)
        _draw_overlays(axes, content, panel)
        content.x.label(axes, "x", width)
        tidy(axes, content.axis_label(content.figure.x) if is_lowest(number, count) else "",
             content.metric_label if is_leftmost(number, count) else "",
             content.level_label(content.figure.panels, panel))
        axes.set_yticks([tick for tick in axes.get_yticks() if low - 1e-9 <= tick <= high])
        axes.grid(axis="y", color="0.9", linewidth=0.7)
        axes.set_axisbelow(True)
    add_key(drawing, key, "beside", name)
    return drawing


def _foot(content: Content) -> float:
    """Room for crosses below the data, as a share of the axis."""
    lost = any(cell.failed and not cell.runs for cell in content.cells)
    return min(_MOST_FOOT, _FOOT * (len(content.lines) + 0.6)) if lost else 0.02 if content.share else 0.0


def _colour(content: Content, number: int) -> Any:
    """Colour of a line: distinct for text levels, ordered for numbers."""
    by, lines = content.figure.by, content.lines
    if by is None or not is_numeric(content.results.axes[by]) or len(lines) < 3:
        return _COLOURS[number % len(_COLOURS)]
    from matplotlib import colormaps

    return colormaps["viridis"](0.88 * number / (len(lines) - 1))


def _x(content: Content, cells: Sequence[Estimate], line: int) -> Array:
    """Positions of cells; over text levels, lines are offset from each other."""
    at = content.x.places_of([cell.levels[content.figure.x] for cell in cells])
    return at if content.x.numeric else at + _DODGE * (line - 0.5 * (len(content.lines) - 1))


def _is_joined(content: Content) -> bool:
    """Return whether values between the levels of x may be interpolated."""
    return content.x.numeric and not content.drawn


def _beside(axes: Axes, lines: float) -> Transform:
    """Shift to the right that separates the marks of lines."""
    from matplotlib.transforms import ScaledTranslation

    return ScaledTranslation(lines * _BESIDE_PT / 72.0, 0.0, axes.figure.dpi_scale_trans)


def _draw_line(axes: Axes, content: Content, cells: Sequence[Estimate], line: int) -> None:
    """Draw a line with its band, or with bars where there are many; only bars over text or sampled points.

    A marker is hollow where some runs failed.
    """
    x, colour, marker = _x(content, cells, line), _colour(content, line), _MARKERS[line % len(_MARKERS)]
    value, low, high = (content.factor * np.array([getattr(cell, name) for cell in cells])
                        for name in ("value", "low", "high"))
    if _is_joined(content):
        crowded = len(content.lines) > _MOST_BANDS
        axes.fill_between(x, low, high, color=colour, alpha=0.06 if crowded else 0.17, linewidth=0.0,
                          zorder=1)
        axes.plot(x, value, color=colour, linewidth=1.5, zorder=3)
        if crowded:
            axes.vlines(x, low, high, color=colour, linewidth=0.9, zorder=2, gid="bars",
                        transform=axes.transData + _beside(axes, line - 0.5 * (len(content.lines) - 1)))
    else:
        axes.vlines(x, low, high, color=colour, linewidth=1.5, zorder=2)
    some_failed = np.array([cell.failed > 0 for cell in cells], dtype=bool)
    for chosen, face in ((~some_failed, colour), (some_failed, "white")):
        axes.plot(x[chosen], value[chosen], marker, color=colour, markerfacecolor=face, markersize=4.5,
                  zorder=4)


def _mark_lost(axes: Axes, content: Content, cells: Sequence[Estimate], line: int, low: float) -> None:
    """Draw a cross below the axis where all runs failed, each line's in a row of its own."""
    lost = [cell for cell in cells if cell.failed and not cell.runs]
    if lost:
        bottom, _ = axes.get_ylim()
        row = low - (low - bottom) * (line + 0.8) / (len(content.lines) + 0.6)
        axes.plot(_x(content, lost, line), np.full(len(lost), row), "x", color=_colour(content, line),
                  markersize=4.5, zorder=6, gid="all failed")
        axes.axhline(low, color="0.75", linewidth=0.7, zorder=0)


def _overlay_style(content: Content, label: str) -> str:
    labels = list(dict.fromkeys(overlay.label for overlay in content.overlays))
    return _OVERLAY_STYLES[labels.index(label) % len(_OVERLAY_STYLES)]


def _draw_overlays(axes: Axes, content: Content, panel: AxisLevel | None) -> None:
    lines = [level_text(line) for line in content.lines if line is not None]
    for overlay in content.overlays_on(panel):
        style = _overlay_style(content, overlay.label)
        colour = INK if overlay.line is None else _colour(content, lines.index(level_text(overlay.line)))
        x = content.x.along(overlay.x)
        if len(overlay.y):
            axes.plot(x, overlay.y, style, color=colour, linewidth=1.6, zorder=5, scalex=False, scaley=False,
                      gid="overlay")
        for at in () if len(overlay.y) else x[np.isfinite(x)]:
            axes.axvline(at, linestyle=style, color=colour, linewidth=1.3, zorder=2, gid="overlay")


def _key(content: Content) -> dict[str, Any]:
    """Key of lines, overlays and failed runs, by label."""
    from matplotlib.lines import Line2D

    found: dict[str, Any] = {}
    for number, level in enumerate(content.lines):
        if level is not None:
            found[level_text(level)] = Line2D(
                [], [], marker=_MARKERS[number % len(_MARKERS)], color=_colour(content, number),
                markersize=4.5, linestyle="-" if _is_joined(content) else "none")
    for overlay in content.overlays:
        style: Any = _overlay_style(content, overlay.label)
        found[overlay.label] = Line2D([], [], linestyle=style, color=INK, linewidth=1.4)
    if any(cell.failed and cell.runs for cell in content.cells):
        found["some runs failed"] = Line2D([], [], marker="o", linestyle="none", color="0.4",
                                           markerfacecolor="white", markersize=4.5)
    if any(cell.failed and not cell.runs for cell in content.cells):
        found["all runs failed"] = Line2D([], [], marker="x", linestyle="none", color="0.4", markersize=4.5)
    return found
