"""Heat maps of a study, a part a panel."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.study.results.axis_levels import AxisLevel, level_text
from fesloop.analysis.study.results.estimates import Estimate
from fesloop.show.figures.axis_scale import AxisScale
from fesloop.show.figures.content import Content
from fesloop.show.figures.heat_maps import decimals_of, value_text
from fesloop.show.figures.layout import colour_ends
from fesloop.show.figures.overlays import Overlay
from fesloop.show.report.parts import HeatMap, Line
from fesloop.show.report.study.shown import Shown, better_end, by

Array = NDArray[np.float64]


def heat_maps(shown: Shown, content: Content) -> Iterator[HeatMap]:
    """A heat map of each panel, all in one scale of colours, theory over them."""
    figure = content.figure
    low, high = colour_ends(content)
    for number, panel in enumerate(content.panels):
        values, cells, told = _grid(shown, content, panel)
        heading = content.level_label(figure.panels, panel)
        yield HeatMap(
            key=f"figure-{figure.name}-{number}", title=heading or content.metric_label,
            x_label=content.axis_label(figure.x), y_label=content.axis_label(str(figure.y)),
            x_levels=_texts(content.x), y_levels=_texts(content.y)[::_way(content)],
            values=values, cells=cells, told=told, value_label=content.metric_label, low=low, high=high,
            better=better_end(shown.results, figure.metric) or "low",
            contours=[_contour(content, overlay) for overlay in content.overlays_on(panel)],
            text=_text(content, heading, values))


def _way(content: Content) -> int:
    """Rows of a map are counted from below; text begins at the top."""
    return -1 if content.y.downwards else 1


def _texts(scale: AxisScale) -> list[str]:
    return [level_text(level) for level in scale.levels]


def _grid(shown: Shown, content: Content, panel: AxisLevel | None) -> tuple[Array, list[list[str]],
                                                                           list[list[str]]]:
    """Values, what stands in cells, and what is told of each, row by row from below."""
    x, y = content.x.levels, content.y.levels
    values = np.full((len(y), len(x)), np.nan)
    cells = [["" for _ in x] for _ in y]
    told = [["not planned" for _ in x] for _ in y]
    decimals = decimals_of(content.cells)
    for cell in content.on(panel):
        row = y.index(cell.levels[str(content.figure.y)])
        column = x.index(cell.levels[content.figure.x])
        values[row, column] = content.factor * cell.value
        cells[row][column] = _cell_text(cell, decimals)
        told[row][column] = _told(shown, content, cell)
    way = _way(content)
    return values[::way], cells[::way], told[::way]


def _cell_text(cell: Estimate, decimals: int) -> str:
    """The value, with a star where some runs failed; a cross where all did, a dash for nothing yet."""
    if np.isfinite(cell.value):
        return value_text(cell, decimals) + ("*" if cell.failed else "")
    return "×" if cell.failed else "–"


def _told(shown: Shown, content: Content, cell: Estimate) -> str:
    lost = [f"{count} of {cell.planned} runs {what}" for count, what in (
        (cell.failed, "failed"), (cell.missing, "without it"), (cell.waiting, "not over yet")) if count]
    return "; ".join([f"{content.metric_label}: {shown.value(cell)}", *lost])


def _contour(content: Content, overlay: Overlay) -> Line:
    """An overlay counted in columns and rows; one without y stands upright over all rows."""
    x = _counted(content.x, np.array(overlay.x, dtype=np.float64))
    if len(overlay.y):
        y = _counted(content.y, np.array(overlay.y, dtype=np.float64))
    else:
        # A gap after each keeps several of them apart.
        x = np.repeat(x, 3)
        y = np.tile([-0.5, len(content.y.levels) - 0.5, np.nan], len(overlay.x))
    return Line(name=overlay.label, role="theory", x=x, y=y, style="line" if len(overlay.y) else "dashed")


def _counted(scale: AxisScale, numbers: Array) -> Array:
    """Where numbers stand among levels that are drawn one apart; NaN beyond them."""
    levels = np.array(scale.levels, dtype=np.float64)
    if scale.kind == "log":
        levels, numbers = np.log(levels), np.log(numbers)
    return np.interp(numbers, levels, np.arange(len(levels)), np.nan, np.nan)


def _text(content: Content, heading: str, values: Array) -> str:
    known = values[np.isfinite(values)]
    axes = [content.axis_label(axis) for axis in (content.figure.x, str(content.figure.y))]
    shown = by(content.metric_label, axes)
    where = f"{shown}, {heading}" if heading else shown
    return f"{where}: {known.min():.3g} to {known.max():.3g}." if known.size else f"{where}: no value."
