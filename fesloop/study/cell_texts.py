"""Numbers in the cells of heat maps, where there is room for them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fesloop.picture.palette import INK
from fesloop.study.estimates import Estimate
from fesloop.study.figure_axes import edges, is_logarithmic, places
from fesloop.study.figure_specs import Figure
from fesloop.study.results import StudyResults

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing

_LARGEST, _SMALLEST = 8.5, 5.5
"""Sizes of text, points."""
_WIDE, _HIGH = 0.6, 1.25
"""Of a digit and of a line, as shares of the size of the text."""
_FILLED = 0.88
_DARK = 0.5
"""Luminance below which text is white."""


def write_values(
    drawing: Drawing, every: Sequence[Axes], results: StudyResults, figure: Figure,
    found: Sequence[Estimate], colour_of: Callable[[float], Any],
) -> None:
    """Write each cell's value into its square, and its interval below where that has room too."""
    # Sizes are known only once the layout is settled.
    drawing.draw_without_rendering()
    levels = [None] if figure.panels is None else results.axes[figure.panels]
    decimals = decimals_of(found)
    for axes, level in zip(every, levels, strict=True):
        cells = [cell for cell in found if level is None or cell.levels[str(figure.panels)] == level]
        if len(cells) == len(results.axes[figure.x]) * len(results.axes[str(figure.y)]):
            _write(axes, results, figure, [cell for cell in cells if np.isfinite(cell.value)], decimals, colour_of)


def _write(axes: Axes, results: StudyResults, figure: Figure, cells: Sequence[Estimate], decimals: int,
           colour_of: Callable[[float], Any]) -> None:
    sizes = [_room(axes, results, figure, cell) for cell in cells]
    values, intervals = [value_text(cell, decimals) for cell in cells], [interval_text(cell, decimals) for cell in cells]
    with_interval = all(_size(room, text, 2.2) >= _SMALLEST / 0.8
                        for room, text in zip(sizes, intervals, strict=True) if text)
    lines = 2.2 if with_interval and any(intervals) else 1.0
    fitting = [_size(room, text, lines) for room, text in zip(sizes, values, strict=True)]
    size = min([each for each in fitting if each >= _SMALLEST], default=0.0)
    for cell, own, value, interval in zip(cells, fitting, values, intervals, strict=True):
        if own < _SMALLEST:
            continue
        x, y = _centre(results, figure, cell)
        red, green, blue, _ = colour_of(cell.value)
        colour = "white" if 0.299 * red + 0.587 * green + 0.114 * blue < _DARK else INK
        below = lines > 1.0 and interval
        axes.annotate(value, (x, y), (0.0, 0.45 * size if below else 0.0), textcoords="offset points", ha="center",
                      va="center", fontsize=size, color=colour, zorder=4, gid="value")
        if below:
            axes.annotate(interval, (x, y), (0.0, -0.6 * size), textcoords="offset points", ha="center",
                          va="center", fontsize=0.8 * size, color=colour, zorder=4, gid="interval")


def _size(room: tuple[float, float], text: str, lines: float) -> float:
    """Of text that fits, points."""
    width, height = room
    return min(_LARGEST, width / (_WIDE * max(1, len(text))), height / (_HIGH * lines))


def _room(axes: Axes, results: StudyResults, figure: Figure, cell: Estimate) -> tuple[float, float]:
    """Width and height of a cell that text may fill, points."""
    corners = []
    for side in (0, 1):
        corner = []
        for axis in (figure.x, str(figure.y)):
            levels = results.axes[axis]
            ends = edges(levels, is_logarithmic(results, axis))
            corner.append(ends[levels.index(cell.levels[axis]) + side])
        corners.append(axes.transData.transform(corner))
    drawing = axes.get_figure()
    assert drawing is not None
    width, height = _FILLED * (corners[1] - corners[0]) * 72.0 / drawing.dpi
    return float(width), float(height)


def _centre(results: StudyResults, figure: Figure, cell: Estimate) -> tuple[float, float]:
    x, y = (float(places(levels)[levels.index(cell.levels[axis])])
            for axis in (figure.x, str(figure.y)) for levels in (results.axes[axis],))
    return x, y


def decimals_of(found: Sequence[Estimate]) -> int:
    """So many that the largest value has three digits; none of a share, which is in percent."""
    if found[0].statistic == "share":
        return 0
    largest = max((abs(cell.value) for cell in found if np.isfinite(cell.value)), default=0.0)
    return int(np.clip(2 - np.floor(np.log10(largest)), 0, 6)) if largest > 0.0 else 0


def value_text(cell: Estimate, decimals: int) -> str:
    """As it is written into a cell."""
    return f"{100.0 * cell.value:.0f}" if cell.statistic == "share" else f"{cell.value:.{decimals}f}"


def interval_text(cell: Estimate, decimals: int) -> str:
    """Its ends; empty where it has none."""
    if not np.isfinite(cell.high - cell.low):
        return ""
    factor = 100.0 if cell.statistic == "share" else 1.0
    return f"{factor * cell.low:.{decimals}f}–{factor * cell.high:.{decimals}f}"
