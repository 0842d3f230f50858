"""Heat maps of a study: a metric over two axes, panels side by side in one scale of colours."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fesloop.picture.palette import BLACK, INK, PURPLE, VERMILION, tidy
from fesloop.study.axis_levels import AxisLevel
from fesloop.study.cell_texts import write_values
from fesloop.study.estimates import Estimate
from fesloop.study.figure_axes import edges, head, is_logarithmic, mark_levels, panels, places, set_scales
from fesloop.study.figure_labels import axis_label, caption, level_label, metric_label, title
from fesloop.study.figure_specs import Figure
from fesloop.study.overlays import Overlay, on_panel
from fesloop.study.results import StudyResults

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap, Normalize
    from matplotlib.figure import Figure as Drawing

Array = NDArray[np.float64]
_OVERLAY_COLOURS = (VERMILION, BLACK, PURPLE)
_STRIP = 0.16
"""Height of what tells of failed runs, as a share of its cell."""


def heat_map(results: StudyResults, figure: Figure, found: Sequence[Estimate],
             overlays: Sequence[Overlay]) -> Drawing:
    """Draw a figure of kind "heat_map"; `found` are its cells."""
    assert figure.y is not None
    rows, columns = len(results.axes[figure.y]), len(results.axes[figure.x])
    levels = _panel_levels(results, figure)
    drawing, every = panels(len(levels), max(2.8, min(5.2, 0.9 + 0.42 * columns)),
                            max(2.3, min(4.6, 0.8 + 0.36 * rows)), 0.9)
    colours, norm = _colours(), _scale(figure, found)
    factor = 100.0 if found[0].statistic == "share" else 1.0
    for axes, level in zip(every, levels, strict=True):
        mine = [cell for cell in found if level is None or cell.levels[str(figure.panels)] == level]
        _draw_panel(axes, results, figure, mine, colours, norm)
        _draw_overlays(axes, on_panel(overlays, level), overlays)
        last_row = axes.get_subplotspec().is_last_row() or len(levels) <= 4  # type: ignore[union-attr]
        tidy(axes, axis_label(results, figure.x) if last_row else "",
             axis_label(results, figure.y) if axes.get_subplotspec().is_first_col() else "",  # type: ignore[union-attr]
             "" if level is None else level_label(results, str(figure.panels), level))
    _colour_bar(drawing, every, colours, norm, metric_label(figure, found[0].statistic))
    _key(drawing, every, found)
    head(drawing, title(results, figure), caption(results, figure, found))
    write_values(drawing, every, results, figure, found, lambda value: colours(norm(factor * value)))
    return drawing


def _panel_levels(results: StudyResults, figure: Figure) -> Sequence[AxisLevel | None]:
    return [None] if figure.panels is None else results.axes[figure.panels]


def _colours() -> Colormap:
    """From light to dark, without the ends on which neither black nor white can be read."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    return ListedColormap(colormaps["YlGnBu"](np.linspace(0.04, 0.92, 256)))


def _scale(figure: Figure, found: Sequence[Estimate]) -> Normalize:
    """One for all panels; of shares from 0 to 100 %."""
    from matplotlib.colors import Normalize

    known = [cell.value for cell in found if np.isfinite(cell.value)]
    share = found[0].statistic == "share"
    low = 0.0 if share else min(known, default=0.0)
    high = 1.0 if share else max(known, default=1.0)
    low, high = (figure.low if figure.low is not None else low), (figure.high if figure.high is not None else high)
    factor = 100.0 if share else 1.0
    return Normalize(factor * low, factor * (high if high > low else low + 1.0))


def _draw_panel(axes: Axes, results: StudyResults, figure: Figure, cells: Sequence[Estimate], colours: Colormap,
                norm: Normalize) -> None:
    """Cells as squares where they fill a grid, else as dots."""
    x, y = figure.x, str(figure.y)
    across, up = results.axes[x], results.axes[y]
    x_ends, y_ends = edges(across, is_logarithmic(results, x)), edges(up, is_logarithmic(results, y))
    set_scales(axes, results, x, y)
    axes.set_xlim(x_ends[0], x_ends[-1])
    axes.set_ylim(y_ends[0], y_ends[-1])
    factor = 100.0 if cells and cells[0].statistic == "share" else 1.0
    if is_grid(results, figure, cells):
        values = np.full((len(up), len(across)), np.nan)
        for cell in cells:
            values[up.index(cell.levels[y]), across.index(cell.levels[x])] = factor * cell.value
        axes.pcolormesh(x_ends, y_ends, np.ma.masked_invalid(values), cmap=colours, norm=norm, linewidth=0.4,
                        edgecolors="white")
        for cell in cells:
            _mark_failed(axes, x_ends, y_ends, across.index(cell.levels[x]), up.index(cell.levels[y]), cell)
    else:
        _dots(axes, [_place(across, cell.levels[x]) for cell in cells],
              [_place(up, cell.levels[y]) for cell in cells], [factor * cell.value for cell in cells], colours, norm)
    mark_levels(axes, "x", across)
    mark_levels(axes, "y", up)


def is_grid(results: StudyResults, figure: Figure, cells: Sequence[Estimate]) -> bool:
    """Whether a panel's cells are every level of x at every level of y."""
    return len(cells) == len(results.axes[figure.x]) * len(results.axes[str(figure.y)])


def _place(levels: Sequence[AxisLevel], level: AxisLevel) -> float:
    return float(places(levels)[levels.index(level)])


def _dots(axes: Axes, x: list[float], y: list[float], values: list[float], colours: Colormap,
          norm: Normalize) -> None:
    """Points that were drawn; a cross where there is no value."""
    known = np.isfinite(values)
    axes.scatter(np.array(x)[known], np.array(y)[known], c=np.array(values)[known], cmap=colours, norm=norm, s=46,
                 edgecolors="0.4", linewidths=0.6, zorder=3)
    axes.scatter(np.array(x)[~known], np.array(y)[~known], marker="x", color="0.3", s=30, linewidths=1.2, zorder=3)


def _mark_failed(axes: Axes, x_ends: Array, y_ends: Array, column: int, row: int, cell: Estimate) -> None:
    """Hatch a cell all of whose runs failed; of others the share that did, along the foot of the cell."""
    from matplotlib.patches import Rectangle

    if not cell.failed:
        return
    left, low = x_ends[column], y_ends[row]
    width, height = x_ends[column + 1] - left, y_ends[row + 1] - low
    if np.isfinite(cell.value):
        width, height = width * cell.failed / cell.planned, _STRIP * height
    axes.add_patch(Rectangle((left, low), width, height, facecolor="0.88", edgecolor=INK, hatch="//////",
                             linewidth=0.0, zorder=2, gid="failed"))


def _draw_overlays(axes: Axes, mine: Sequence[Overlay], every: Sequence[Overlay]) -> None:
    from matplotlib.patheffects import withStroke

    labels = list(dict.fromkeys(overlay.label for overlay in every))
    casing = [withStroke(linewidth=3.6, foreground="white")]
    for overlay in mine:
        number = labels.index(overlay.label)
        colour, style = _OVERLAY_COLOURS[number % len(_OVERLAY_COLOURS)], ("-", "--", ":")[number % 3]
        if len(overlay.y):
            axes.plot(overlay.x, overlay.y, style, color=colour, linewidth=1.8, path_effects=casing, zorder=5,
                      label=overlay.label, scalex=False, scaley=False)
            continue
        for x in overlay.x:
            axes.axvline(x, linestyle=style, color=colour, linewidth=1.8, path_effects=casing, zorder=5,
                         label=overlay.label)


def _colour_bar(drawing: Drawing, every: Sequence[Axes], colours: Colormap, norm: Normalize, label: str) -> None:
    from matplotlib.cm import ScalarMappable

    bar = drawing.colorbar(ScalarMappable(norm, colours), ax=every, fraction=0.05, pad=0.015, aspect=25)
    bar.set_label(label, fontsize=9)
    bar.ax.tick_params(labelsize=8)
    bar.outline.set_visible(False)


def _key(drawing: Drawing, every: Sequence[Axes], found: Sequence[Estimate]) -> None:
    """Of overlays, and of hatching where there is any."""
    from matplotlib.patches import Patch

    handles = {label: handle for axes in every
               for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    if any(cell.failed for cell in found):
        handles["share of runs that failed"] = Patch(facecolor="0.88", edgecolor=INK, hatch="//////", linewidth=0.0)
    if handles:
        drawing.legend(handles.values(), handles, loc="outside upper right", ncols=len(handles), frameon=False,
                       fontsize=8)
