"""Heat maps of a study: a metric over two axes, panels side by side in one scale of colours."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fesloop.analysis.study.results.axis_levels import AxisLevel
from fesloop.analysis.study.results.estimates import Estimate
from fesloop.show.figures.content import Content
from fesloop.show.figures.layout import (
    add_key,
    colour_ends,
    columns_of,
    is_leftmost,
    is_lowest,
    lay_out,
    rewrite_caption,
)
from fesloop.show.picture.palette import BLACK, INK, PURPLE, VERMILION, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap, Normalize
    from matplotlib.figure import Figure as Drawing


def decimals_of(cells: Sequence[Estimate]) -> int:
    """Number of decimals with which the largest value has three digits; none for shares in percent."""
    if cells[0].statistic == "share":
        return 0
    largest = max((abs(cell.value) for cell in cells if np.isfinite(cell.value)), default=0.0)
    return int(np.clip(2 - np.floor(np.log10(largest)), 0, 6)) if largest > 0.0 else 0


def value_text(cell: Estimate, decimals: int) -> str:
    """Text of a value in its cell."""
    return f"{100.0 * cell.value:.0f}" if cell.statistic == "share" else f"{cell.value:.{decimals}f}"


def interval_text(cell: Estimate, decimals: int) -> str:
    """Text of an interval; empty without one."""
    if not np.isfinite(cell.high - cell.low):
        return ""
    factor = 100.0 if cell.statistic == "share" else 1.0
    return f"{factor * cell.low:.{decimals}f}–{factor * cell.high:.{decimals}f}"


_LARGEST, _SMALLEST = 8.5, 5.5
"""Sizes of text, points."""
_WIDE, _HIGH = 0.67, 1.25
"""Width of a digit and height of a line, relative to the size of the text."""
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
    """Write each value into its square, upright where only that has room; return whether intervals fit too.

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
    """Return whether every interval fits below its value."""
    texts = [(square, interval_text(square.cell, decimals)) for square in squares]
    sizes = [min(_SMALLER * _LARGEST, square.width / (_WIDE * len(text)),
                 _SMALLER * square.height / (_HIGH * _LINES)) for square, text in texts if text]
    return bool(sizes) and min(sizes) >= _SMALLEST


def _fitting(square: _Square, text: str, lines: float) -> tuple[float, bool]:
    """Size of text that fits a square, points, and whether it is rotated."""
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


_OVERLAYS = ((VERMILION, "-"), (BLACK, "--"), (PURPLE, ":"))
_STRIP = 0.16
"""Height of the mark of failed runs, as a share of its cell."""
_LETTER_IN, _BAR_IN = 0.068, 0.15
"""Widths of a label's letter and of the colour bar, inches."""
_HATCHED: dict[str, Any] = {"facecolor": "0.88", "edgecolor": INK, "hatch": "//////",
                            "linewidth": 0.0}


def heat_map(content: Content) -> Drawing:
    """Draw a figure of kind "heat_map"."""
    count, key = len(content.panels), _key(content)
    width, height = _panel_size(content)
    drawing, every = lay_out(count, (width, height), content.title, content.caption(intervals=True),
                             list(key), "above")
    colours, norm = _colours(), _scale(content)
    for number, (axes, panel) in enumerate(zip(every, content.panels, strict=True)):
        content.x.apply(axes, "x", squares=True)
        content.y.apply(axes, "y", squares=True)
        if content.is_grid:
            _draw_squares(axes, content, panel, colours, norm)
        else:
            _draw_dots(axes, content, content.on(panel), colours, norm)
        _draw_overlays(axes, content, panel)
        content.x.label(axes, "x", width)
        content.y.label(axes, "y", height)
        tidy(axes, content.axis_label(content.figure.x) if is_lowest(number, count) else "",
             content.axis_label(str(content.figure.y)) if is_leftmost(number, count) else "",
             content.level_label(content.figure.panels, panel))
    _colour_bar(drawing, every, colours, norm, content)
    add_key(drawing, key, "above")
    written = content.is_grid and write_values(drawing, every, content, lambda value: colours(norm(value)))
    rewrite_caption(drawing, content.caption(intervals=written))
    return drawing


def _panel_size(content: Content) -> tuple[float, float]:
    """Size in inches: squares large enough for numbers, and room for labels of text."""
    x, y = content.x, content.y
    width = float(np.clip(0.45 * len(x.levels), 2.0, 4.4)) + 1.2
    height = float(np.clip(0.4 * len(y.levels), 1.2, 4.0 if y.numeric else 7.0)) + 0.7
    # Labels are beside the first of the panels abreast, which all have the same room.
    beside = 0.0 if y.numeric else _LETTER_IN * y.longest / columns_of(len(content.panels))
    below = 0.5 * _LETTER_IN * x.longest if x.slanted else 0.0
    return width + beside, height + below


def _colours() -> Colormap:
    """Colours from light to dark, without ends on which neither black nor white can be read."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    return ListedColormap(colormaps["YlGnBu"](np.linspace(0.04, 0.92, 256)))


def _scale(content: Content) -> Normalize:
    """Colour scale of all panels."""
    from matplotlib.colors import Normalize

    return Normalize(*colour_ends(content))


def _draw_squares(axes: Axes, content: Content, panel: AxisLevel | None, colours: Colormap,
                  norm: Normalize) -> None:
    """Draw the squares: hatched where all runs failed; where some did, their share along the foot of the
    cell."""
    from matplotlib.patches import Rectangle

    x, y = content.x, content.y
    values = np.full((len(y.levels), len(x.levels)), np.nan)
    for cell in content.on(panel):
        across, up = cell.levels[content.figure.x], cell.levels[str(content.figure.y)]
        values[y.levels.index(up), x.levels.index(across)] = content.factor * cell.value
        if cell.failed:
            (left, right), (low, high) = x.span(across), y.span(up)
            foot, height = (high, low - high) if y.downwards else (low, high - low)
            some = np.isfinite(cell.value)
            axes.add_patch(Rectangle(
                (left, foot), (right - left) * (cell.failed / cell.planned if some else 1.0),
                height * (_STRIP if some else 1.0), zorder=2, gid="failed", **_HATCHED))
    axes.pcolormesh(x.edges, y.edges, np.ma.masked_invalid(values), cmap=colours, norm=norm, linewidth=0.4,
                    edgecolors="white")


def _draw_dots(axes: Axes, content: Content, cells: Sequence[Estimate], colours: Colormap,
               norm: Normalize) -> None:
    """Draw sampled points; a cross where there is no value."""
    x = content.x.places_of([cell.levels[content.figure.x] for cell in cells])
    y = content.y.places_of([cell.levels[str(content.figure.y)] for cell in cells])
    values = content.factor * np.array([cell.value for cell in cells])
    known = np.isfinite(values)
    axes.scatter(x[known], y[known], c=values[known], cmap=colours, norm=norm, s=46, edgecolors="0.4",
                 linewidths=0.6, zorder=3, clip_on=False)
    axes.scatter(x[~known], y[~known], marker="x", color="0.3", s=30, linewidths=1.2, zorder=3,
                 clip_on=False)


def _overlay_look(content: Content, label: str) -> dict[str, Any]:
    labels = list(dict.fromkeys(overlay.label for overlay in content.overlays))
    colour, style = _OVERLAYS[labels.index(label) % len(_OVERLAYS)]
    return {"linestyle": style, "color": colour, "linewidth": 1.8}


def _draw_overlays(axes: Axes, content: Content, panel: AxisLevel | None) -> None:
    from matplotlib.patheffects import withStroke

    casing = [withStroke(linewidth=3.6, foreground="white")]
    for overlay in content.overlays_on(panel):
        look = _overlay_look(content, overlay.label) | {"path_effects": casing, "zorder": 5, "gid": "overlay"}
        x = content.x.along(overlay.x)
        if len(overlay.y):
            axes.plot(x, content.y.along(overlay.y), scalex=False, scaley=False, **look)
            continue
        for at in x[np.isfinite(x)]:
            axes.axvline(at, **look)


def _colour_bar(drawing: Drawing, every: Sequence[Axes], colours: Colormap, norm: Normalize,
                content: Content) -> None:
    """Draw the colour bar, with an arrow at an end beyond which there are values."""
    from matplotlib.cm import ScalarMappable

    known = [content.factor * cell.value for cell in content.cells if np.isfinite(cell.value)]
    shares = np.asarray(norm(np.array(known)))
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    bar = drawing.colorbar(ScalarMappable(norm, colours), ax=every, fraction=0.05, pad=0.015,
                           aspect=drawing.get_figheight() / _BAR_IN,
                           extend=extend[bool((shares < 0.0).any()), bool((shares > 1.0).any())])
    bar.set_label(content.metric_label, fontsize=9)
    bar.ax.tick_params(labelsize=8)
    bar.outline.set_visible(False)


def _key(content: Content) -> dict[str, Any]:
    """Key of overlays and failed runs, by label."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    found: dict[str, Any] = {overlay.label: Line2D([], [], **_overlay_look(content, overlay.label))
                             for overlay in content.overlays}
    if content.is_grid and any(cell.failed for cell in content.cells):
        found["share of runs that failed"] = Patch(**_HATCHED)
    if not content.is_grid and any(not cell.runs for cell in content.cells):
        found["no value"] = Line2D([], [], marker="x", linestyle="none", color="0.3", markersize=5)
    return found
