"""Numbers in the cells of heat maps, where there is room for them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fesloop.analysis.study.results.estimates import Estimate
from fesloop.show.figures.content import Content
from fesloop.show.figures.value_texts import decimals_of, interval_text, value_text
from fesloop.show.picture.palette import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing

_LARGEST, _SMALLEST = 8.5, 5.5
"""Sizes of text, points."""
_WIDE, _HIGH = 0.67, 1.25
"""Of a digit and of a line, as shares of the size of the text."""
_FILLED = 0.9
"""Share of a cell that text may fill."""
_SMALLER, _LINES = 0.8, 2.2
"""Size of an interval beside that of its value; lines that both take."""
_DARK = 0.5
"""Luminance of a cell below which its text is white."""


@dataclass(frozen=True, slots=True, eq=False)
class _Square:
    """A cell with its panel, its middle, and its width and height in points."""

    axes: Axes
    cell: Estimate
    middle: tuple[float, float]
    width: float
    height: float


def write_values(
    drawing: Drawing, every: Sequence[Axes], content: Content, colour_of: Callable[[float], Any]
) -> bool:
    """Write each value into its square, upright where only that has room; whether intervals are there too.

    All have one size. `colour_of` a value that is shown is that of its square.
    """
    # Sizes are known only once the layout is settled.
    drawing.draw_without_rendering()
    squares = [_square(axes, content, cell)
               for axes, panel in zip(every, content.panels, strict=True) for cell in content.on(panel)]
    decimals = decimals_of(content.cells)
    for square in squares:
        if not square.cell.runs and not square.cell.failed:
            square.axes.annotate("–", square.middle, ha="center", va="center", color="0.6", gid="nothing")
    known = [square for square in squares if np.isfinite(square.cell.value)]
    if not known:
        return False
    below = _room_for_intervals(known, decimals)
    fits = [_fitting(square, value_text(square.cell, decimals), _LINES if below else 1.0) for square in known]
    size = min((fit for fit, _ in fits if fit >= _SMALLEST), default=0.0)
    for square, (fit, turned) in zip(known, fits, strict=True):
        if fit >= _SMALLEST:
            red, green, blue, _ = colour_of(content.factor * square.cell.value)
            dark = 0.299 * red + 0.587 * green + 0.114 * blue < _DARK
            _write(square, decimals, size, turned, below, "white" if dark else INK)
    return below


def _room_for_intervals(squares: Sequence[_Square], decimals: int) -> bool:
    """Whether every interval fits below its value."""
    texts = [(square, interval_text(square.cell, decimals)) for square in squares]
    sizes = [min(_SMALLER * _LARGEST, square.width / (_WIDE * len(text)),
                 _SMALLER * square.height / (_HIGH * _LINES)) for square, text in texts if text]
    return bool(sizes) and min(sizes) >= _SMALLEST


def _fitting(square: _Square, text: str, lines: float) -> tuple[float, bool]:
    """Size of text that fits, points, and whether it is turned upright."""
    level = min(_LARGEST, square.width / (_WIDE * len(text)), square.height / (_HIGH * lines))
    if level >= _SMALLEST or lines > 1.0:
        return level, False
    return min(_LARGEST, square.height / (_WIDE * len(text)), square.width / _HIGH), True


def _write(square: _Square, decimals: int, size: float, turned: bool, below: bool, colour: str) -> None:
    interval = interval_text(square.cell, decimals) if below else ""
    look: dict[str, Any] = {"textcoords": "offset points", "ha": "center", "va": "center", "color": colour,
                            "zorder": 6}
    above = 0.5 * size if interval else 0.0
    square.axes.annotate(value_text(square.cell, decimals), square.middle, (0.0, above), fontsize=size,
                         rotation=90 if turned else 0, gid="value", **look)
    if interval:
        square.axes.annotate(interval, square.middle, (0.0, -0.6 * size), fontsize=_SMALLER * size,
                             gid="interval", **look)


def _square(axes: Axes, content: Content, cell: Estimate) -> _Square:
    spans = content.x.span(cell.levels[content.figure.x]), content.y.span(cell.levels[str(content.figure.y)])
    ends = axes.transData.transform(np.transpose(spans))
    middle = axes.transData.inverted().transform(ends.mean(axis=0))
    drawing = axes.get_figure()
    assert drawing is not None
    width, height = _FILLED * np.abs(ends[1] - ends[0]) * 72.0 / drawing.dpi
    return _Square(axes, cell, (float(middle[0]), float(middle[1])), float(width), float(height))
