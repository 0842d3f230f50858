"""Sections of a study's report with its figures: those of its file, or a default choice."""


from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.study.design.figure_specs import Figure
from fesloop.analysis.study.design.study_file import study_of
from fesloop.analysis.study.results.axis_levels import AxisLevel, is_numeric, level_text
from fesloop.analysis.study.results.estimates import Estimate
from fesloop.errors import FesloopError, InputErrors
from fesloop.forms.schema import make
from fesloop.show.figures.axis_scale import AxisScale
from fesloop.show.figures.content import Content, Overlay
from fesloop.show.figures.heat_maps import decimals_of, value_text
from fesloop.show.figures.layout import colour_ends, curve_ends
from fesloop.show.figures.theory_overlays import kept_overlays, theory_overlays
from fesloop.show.report.parts import Chart, HeatMap, Line, Notice, Paragraph, Part, Section
from fesloop.show.report.study.shown import Shown, better_end, by, by_axes

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
            text=_heat_text(content, heading, values))


def _way(content: Content) -> int:
    """Rows of a map are counted from below; text begins at the top."""
    return -1 if content.y.downwards else 1


def _texts(scale: AxisScale) -> list[str]:
    return [level_text(level) for level in scale.levels]


def _grid(shown: Shown, content: Content, panel: AxisLevel | None) -> tuple[Array, list[list[str]],
                                                                           list[list[str]]]:
    """Values, texts in cells, and tooltips of cells, row by row from below."""
    x, y = content.x.levels, content.y.levels
    values = np.full((len(y), len(x)), np.nan)
    cells = [["" for _ in x] for _ in y]
    texts = [["not planned" for _ in x] for _ in y]
    decimals = decimals_of(content.cells)
    for cell in content.on(panel):
        row = y.index(cell.levels[str(content.figure.y)])
        column = x.index(cell.levels[content.figure.x])
        values[row, column] = content.factor * cell.value
        cells[row][column] = _cell_text(cell, decimals)
        texts[row][column] = _tooltip(shown, content, cell)
    way = _way(content)
    return values[::way], cells[::way], texts[::way]


def _cell_text(cell: Estimate, decimals: int) -> str:
    """The value, with a star where some runs failed; a cross where all did, a dash for nothing yet."""
    if np.isfinite(cell.value):
        return value_text(cell, decimals) + ("*" if cell.failed else "")
    return "×" if cell.failed else "–"


def _tooltip(shown: Shown, content: Content, cell: Estimate) -> str:
    lost = [f"{count} of {cell.planned} runs {what}" for count, what in (
        (cell.failed, "failed"), (cell.missing, "without it"), (cell.waiting, "not over yet")) if count]
    return "; ".join([f"{content.metric_label}: {shown.value(cell)}", *lost])


def _contour(content: Content, overlay: Overlay) -> Line:
    """An overlay in units of columns and rows; one without y is a vertical line over all rows."""
    x = _counted(content.x, np.array(overlay.x, dtype=np.float64))
    if len(overlay.y):
        y = _counted(content.y, np.array(overlay.y, dtype=np.float64))
    else:
        # A gap after each keeps several of them apart.
        x = np.repeat(x, 3)
        y = np.tile([-0.5, len(content.y.levels) - 0.5, np.nan], len(overlay.x))
    return Line(name=overlay.label, role="theory", x=x, y=y, style="line" if len(overlay.y) else "dashed")


def _counted(scale: AxisScale, numbers: Array) -> Array:
    """Positions of numbers among levels that are one apart; NaN beyond their ends."""
    levels = np.array(scale.levels, dtype=np.float64)
    if scale.kind == "log":
        levels, numbers = np.log(levels), np.log(numbers)
    return np.interp(numbers, levels, np.arange(len(levels)), np.nan, np.nan)


def _heat_text(content: Content, heading: str, values: Array) -> str:
    known = values[np.isfinite(values)]
    axes = [content.axis_label(axis) for axis in (content.figure.x, str(content.figure.y))]
    shown = by(content.metric_label, axes)
    where = f"{shown}, {heading}" if heading else shown
    return f"{where}: {known.min():.3g} to {known.max():.3g}." if known.size else f"{where}: no value."


def beside_theory(content: Content) -> str:
    """A sentence on cells at which theory has a value; empty where there are none."""
    if content.figure.theory != "stationary_cost":
        return ""
    off: list[float] = []
    inside: list[bool] = []
    panels = {level_text(panel): panel for panel in content.panels if panel is not None}
    lines = {level_text(line): line for line in content.lines if line is not None}
    for overlay in content.overlays:
        panel = None if overlay.panel is None else panels[level_text(overlay.panel)]
        line = None if overlay.line is None else lines[level_text(overlay.line)]
        exact = dict(zip(overlay.x, overlay.y, strict=False))
        for cell in content.on(panel, line):
            value = exact.get(float(cell.levels[content.figure.x]))
            if value and np.isfinite(cell.value):
                off.append(100.0 * (cell.value / value - 1.0))
                inside += [cell.low <= value <= cell.high] if np.isfinite(cell.high - cell.low) else []
    if not off:
        return ""
    within = f"; theory lies within {sum(inside)} of {len(inside)} intervals" if inside else ""
    return f"Simulation lies {min(off):+.1f} to {max(off):+.1f} % off theory at {len(off)} cells{within}."


_ROLES = 8
_BESIDE = 0.12
"""Offset between points of different lines over text levels, as a share of the distance between levels."""


def curves(content: Content) -> Iterator[Chart]:
    """A chart of each panel: a line with a band for each level of `by`, theory dashed."""
    figure = content.figure
    limits = curve_ends(content)
    for number, panel in enumerate(content.panels):
        lines = [line for place, level in enumerate(content.lines)
                 if (line := _curve(content, content.on(panel, level), place, level)) is not None]
        heading = content.level_label(figure.panels, panel)
        yield Chart(
            key=f"figure-{figure.name}-{number}", title=heading or content.metric_label,
            x_label=content.axis_label(figure.x), y_label=content.metric_label,
            lines=[*lines, *_theory(content, panel, limits)], limits=limits,
            x_levels=[] if content.x.numeric and not _even(content) else
            [level_text(level) for level in content.x.levels],
            x_log=content.x.kind == "log", text=_text(content, heading, lines))


def _even(content: Content) -> bool:
    """Return whether levels are one apart."""
    return content.x.kind == "even"


def _curve(content: Content, cells: Sequence[Estimate], place: int, level: AxisLevel | None) -> Line | None:
    """Values of one line; points with bars where values between them are not defined."""
    if not cells:
        return None
    x = content.x.places_of([cell.levels[content.figure.x] for cell in cells])
    joined = content.x.numeric and not content.drawn
    if not content.x.numeric:
        x = x + _BESIDE * (place - 0.5 * (len(content.lines) - 1))
    value, low, high = (content.factor * np.array([getattr(cell, name) for cell in cells])
                        for name in ("value", "low", "high"))
    known = bool(np.isfinite(high - low).any())
    name = content.level_label(content.figure.by, level) or content.metric_label
    return Line(name=name, role=f"series-{place % _ROLES}", x=x, y=value, low=low if known else None,
                high=high if known else None, style="line" if joined else "points")


def _theory(content: Content, panel: AxisLevel | None, limits: tuple[float, float]) -> Iterator[Line]:
    """Overlays, each in the colour of its line; one without y is vertical."""
    lines = [level_text(line) for line in content.lines if line is not None]
    for overlay in content.overlays_on(panel):
        at = content.x.along(overlay.x)
        role, name = "theory", overlay.label
        if overlay.line is not None:
            role = f"series-{lines.index(level_text(overlay.line)) % _ROLES}"
            name = f"{content.level_label(content.figure.by, overlay.line)}: {overlay.label}"
        y = np.array(overlay.y, dtype=np.float64)
        if not len(overlay.y):
            at, y = np.repeat(at, 3), np.tile([*limits, np.nan], len(overlay.x))
        else:
            # Points above the chart would cover its title.
            y = np.where(y > limits[1], np.nan, y)
        yield Line(name=name, role=role, x=at, y=y, style="dashed")


def _text(content: Content, heading: str, lines: Sequence[Line]) -> str:
    shown = by(content.metric_label, [content.axis_label(content.figure.x)])
    where = f"{shown}, {heading}" if heading else shown
    ranges = [f"{line.name} {np.nanmin(line.y):.3g} to {np.nanmax(line.y):.3g}" for line in lines
              if np.isfinite(line.y).any()]
    return f"{where}: {'; '.join(ranges) or 'no value'}."


_MOST_LINES, _MOST_METRICS = 8, 4
"""Most curves of a chart, and most charts, where a study's file requests none (chosen)."""
_MOST_SOLVED = 20
"""Most cells of a study whose missing theory is computed for its report (chosen: takes seconds)."""
_NO_THEORY = ("Theory is not drawn: none was kept beside this study's results. Start the study once more: "
              "runs that are over are not run again, and theory's lines are kept.")


def figure_sections(shown: Shown) -> Iterator[Section]:
    """One section per figure, with a notice on what cannot be shown."""
    tables = shown.results.study.get("figures") or list(_chosen(shown))
    kept, faults = _kept(shown)
    for number, table in enumerate(tables):
        parts: list[Part] = []
        title = f"Figure {number + 1}"
        try:
            figure: Figure = make(Figure, table, {}, f"figures[{number}]")
            content, notices = _content(shown, figure, kept)
            title = _title(content)
            parts = [*_parts(shown, content), *notices]
        except (FesloopError, LookupError, TypeError, ValueError) as fault:
            parts.append(Notice(text=f"This figure cannot be shown: {_line(fault)}"))
        yield Section(key=f"figure-{number}", title=title, parts=[*parts, *faults])
        faults = []


def _chosen(shown: Shown) -> Iterator[dict[str, Any]]:
    """Curves of the first metrics, over the axis of numbers with most levels, by another with few."""
    axes = shown.results.axes
    sizes = {axis: len(axes[axis]) for axis in (shown.chosen or tuple(axes))}
    if not sizes:
        return
    numeric = [axis for axis in sizes if is_numeric(axes[axis])]
    x = max(numeric or sizes, key=sizes.__getitem__)
    by = next((axis for axis in sizes if axis not in (x, *shown.drawn) and sizes[axis] <= _MOST_LINES), None)
    for metric in shown.results.metrics[:_MOST_METRICS]:
        yield {"name": metric, "kind": "curves", "metric": metric, "x": x} | ({"by": by} if by else {})


def _kept(shown: Shown) -> tuple[dict[str, list[Overlay]], list[Part]]:
    """Theory that was kept, by figure, and a notice if it cannot be read."""
    try:
        return kept_overlays(shown.results.path.parent, shown.results.about.get("created", "")), []
    except FesloopError as fault:
        return {}, [Notice(text=f"Theory is not drawn: {_line(fault)}")]


def _content(
    shown: Shown, figure: Figure, kept: Mapping[str, Sequence[Overlay]]
) -> tuple[Content, list[Part]]:
    """Content of a figure, with theory if it is known, and notices."""
    results = shown.results
    faults = figure.faults(tuple(results.axes), results.metrics)
    if faults:
        raise InputErrors(faults)
    overlays: Sequence[Overlay] = kept.get(figure.name, ())
    notices: list[Part] = []
    if figure.theory != "none" and figure.name not in kept:
        if results.runs["cell"].nunique() > _MOST_SOLVED:
            notices.append(Notice(text=_NO_THEORY))
        else:
            try:
                overlays = theory_overlays(study_of(results.study), figure)
            except (FesloopError, LookupError, TypeError, ValueError) as fault:
                notices.append(Notice(text=f"Theory is not drawn: {_line(fault)}"))
    try:
        return Content.of(results, figure, overlays), notices
    except FesloopError:
        # A figure is shown without theory that does not fit.
        if not overlays:
            raise
        return Content.of(results, figure, ()), [Notice(text="Theory is not drawn: it fits another figure.")]


def _parts(shown: Shown, content: Content) -> Iterator[Part]:
    """The pictures, and a description of their numbers."""
    if not any(np.isfinite(cell.value) for cell in content.cells):
        yield Notice(text=f"Nothing to show yet: no run that is over has {content.metric_label}.")
        yield Paragraph(text=f"{_upper(content.caption(intervals=False))}.")
        return
    if content.figure.kind == "curves":
        yield from curves(content)
    elif content.is_grid:
        yield from heat_maps(shown, content)
    else:
        yield from _points(content)
    starred = content.figure.kind == "heat_map" and any(cell.failed for cell in content.cells)
    known = any(np.isfinite(cell.high - cell.low) for cell in content.cells)
    yield Paragraph(text=f"{_upper(content.caption(intervals=known))}."
                    + (" A star: some runs failed; a cross: all did." if starred else ""))
    beside = beside_theory(content)
    if beside:
        yield Paragraph(text=beside)


def _points(content: Content) -> Iterator[Chart]:
    """Charts of sampled points of two axes, over each axis."""
    value = content.factor * np.array([cell.value for cell in content.cells])
    for axis, scale in ((content.figure.x, content.x), (str(content.figure.y), content.y)):
        yield Chart(
            key=f"figure-{content.figure.name}-{axis}", x_label=content.axis_label(axis),
            title=by_axes(content, [axis]), y_label=content.metric_label,
            lines=[Line(name="a point of the design", role="series-0", style="points", y=value,
                        x=scale.places_of([cell.levels[axis] for cell in content.cells]))],
            x_levels=[] if scale.numeric else [str(level) for level in scale.levels],
            x_log=scale.kind == "log",
            text=f"{content.metric_label} at {len(value)} points that were drawn.")


def _title(content: Content) -> str:
    """The figure's own title, else its metric and axes."""
    figure = content.figure
    return figure.title or by_axes(content, [axis for axis in (figure.x, figure.y) if axis is not None])


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:]


def _line(fault: Exception) -> str:
    return " ".join(str(fault).split())
