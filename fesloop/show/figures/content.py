"""Description of a figure of a study, for files and pages that draw it: cells, panels, lines, labels."""


from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from fesloop.analysis.study.design.figure_specs import Figure
from fesloop.analysis.study.results.axis_levels import AxisLevel, is_numeric, level_text, place_of
from fesloop.analysis.study.results.estimates import Estimate
from fesloop.analysis.study.results.quantities import called, with_unit
from fesloop.analysis.study.results.runs import sampled_axes
from fesloop.analysis.study.results.study_results import StudyResults
from fesloop.errors import InputError
from fesloop.show.figures.axis_scale import AxisScale


@dataclass(frozen=True, slots=True, kw_only=True)
class Overlay:
    """Line over a figure, such as theory beside simulation.

    Attributes
    ----------
    label: of the legend; overlays of one label look alike and are listed once.
    x: places along the figure's x. y: along the y of a heat map, or the metric of curves; empty: a vertical
        line at each x.
    panel: level of the figure's panels on which it is drawn; None: all.
    line: level of the figure's `by` whose colour it takes; None: one of its own.
    """

    label: str
    x: Sequence[float]
    y: Sequence[float] = ()
    panel: AxisLevel | None = None
    line: AxisLevel | None = None

    def __post_init__(self) -> None:
        if not len(self.x) or (len(self.y) and len(self.y) != len(self.x)):
            raise InputError(f"overlay {self.label!r}", f"{len(self.x)} x and {len(self.y)} y",
                             "as many y as x, or none")


def check_overlays(results: StudyResults, figure: Figure, overlays: Sequence[Overlay]) -> None:
    """Raise InputError for an overlay that does not fit the figure."""
    for overlay in overlays:
        where = f"overlay {overlay.label!r}"
        if not is_numeric(results.axes[figure.x]):
            raise InputError(where, f"{figure.x} is no axis of numbers", "a figure over numbers")
        if figure.y is not None and len(overlay.y) and not is_numeric(results.axes[figure.y]):
            raise InputError(where, f"{figure.y} is no axis of numbers", "a figure over numbers")
        levels = (("panel", overlay.panel, figure.panels), ("line", overlay.line, figure.by))
        for key, level, axis in levels:
            if level is not None and axis is None:
                raise InputError(f"{where}: {key}", f"{level_text(level)}, but the figure has none", "None")
            if level is not None and axis is not None:
                place_of(results.axes, axis, level)


@dataclass(frozen=True, eq=False)
class Content:
    """A figure with the results that it shows.

    Attributes
    ----------
    results, figure, overlays: as given. cells: one or more estimates to draw.
    """

    results: StudyResults
    figure: Figure
    overlays: Sequence[Overlay]
    cells: Sequence[Estimate]

    @classmethod
    def of(cls, results: StudyResults, figure: Figure, overlays: Sequence[Overlay]) -> Content:
        """Estimate what a figure shows; InputError for what the study does not have."""
        check_overlays(results, figure, overlays)
        named = [axis for key, axis in figure.named_axes() if key != "at"]
        cells = results.cells(figure.metric, named, figure.at, figure.statistic, figure.confidence)
        if not cells:
            raise InputError(f"figure {figure.name}", "shows nothing: no run is planned there",
                             "levels of a cell")
        return cls(results, figure, overlays, cells)

    @property
    def share(self) -> bool:
        """True if shares are shown, in percent."""
        return self.cells[0].statistic == "share"

    @property
    def factor(self) -> float:
        """Factor from values to shown numbers."""
        return 100.0 if self.share else 1.0

    @property
    def panels(self) -> Sequence[AxisLevel | None]:
        """Level of each panel; one None where there are no panels."""
        return [None] if self.figure.panels is None else self.results.axes[self.figure.panels]

    @property
    def lines(self) -> Sequence[AxisLevel | None]:
        """Level of each line; one None where there is one line."""
        return [None] if self.figure.by is None else self.results.axes[self.figure.by]

    @cached_property
    def x(self) -> AxisScale:
        """The abscissa."""
        return self._scale(self.figure.x, upright=False)

    @cached_property
    def y(self) -> AxisScale:
        """The ordinate of a heat map."""
        assert self.figure.y is not None
        return self._scale(self.figure.y, upright=True)

    def _scale(self, axis: str, *, upright: bool) -> AxisScale:
        levels = self.results.axes[axis]
        declared = self.results.study.get("axes", {}).get(axis, {}).get("scale", "linear")
        if not is_numeric(levels) or self.figure.spacing == "even":
            return AxisScale(levels, "even", downwards=upright and not is_numeric(levels))
        return AxisScale(levels, "log" if declared == "log" and float(levels[0]) > 0.0 else "linear")

    def on(self, panel: AxisLevel | None, line: AxisLevel | None = None) -> list[Estimate]:
        """Cells of a panel, or of one of its lines."""
        axes = [(axis, level) for axis, level in ((self.figure.panels, panel), (self.figure.by, line))
                if axis is not None and level is not None]
        return [cell for cell in self.cells if all(cell.levels[axis] == level for axis, level in axes)]

    def overlays_on(self, panel: AxisLevel | None) -> list[Overlay]:
        """Overlays of a panel."""
        return [overlay for overlay in self.overlays if overlay.panel is None
                or (panel is not None and level_text(overlay.panel) == level_text(panel))]

    @property
    def drawn(self) -> bool:
        """True if the levels of x are a random sample."""
        return self.figure.x in sampled_axes(self.results.study, self.results.axes)

    @property
    def is_grid(self) -> bool:
        """True if each panel of a heat map has every level of x at every level of y."""
        return len(self.cells) == len(self.x.levels) * len(self.y.levels) * len(self.panels)

    def _called(self, axis: str) -> tuple[str, str]:
        table = self.results.study.get("axes", {}).get(axis, {})
        return called(axis, table.get("label", ""), table.get("unit", ""))

    def axis_name(self, axis: str) -> str:
        """Name of an axis without its unit."""
        return self._called(axis)[0]

    def axis_label(self, axis: str) -> str:
        """Label of an axis, with its unit."""
        return with_unit(*self._called(axis))

    @property
    def metric_label(self) -> str:
        """Label of the metric, with its unit; shares are in percent."""
        figure = self.figure
        return with_unit(*called(figure.metric, figure.label, figure.unit or ("%" if self.share else "")))

    def level_label(self, axis: str | None, level: AxisLevel | None) -> str:
        """A level, with the name of its axis where it is a number; empty for none."""
        if axis is None or level is None:
            return ""
        return level if isinstance(level, str) else self._level_of_axis(axis, level)

    def _level_of_axis(self, axis: str, level: AxisLevel) -> str:
        """A level with the name of its axis, and if it is a number with its unit."""
        name, unit = self._called(axis)
        return f"{name} {level}" if isinstance(level, str) else f"{name} {level_text(level)} {unit}".rstrip()

    @property
    def title(self) -> str:
        """Title of the figure: its own, or else study and metric."""
        metric, _ = called(self.figure.metric, self.figure.label)
        return self.figure.title or f"{self.results.name}: {metric}"

    def caption(self, *, intervals: bool) -> str:
        """Caption: definition of the numbers and runs left out; `intervals`: whether these are shown."""
        first, named = self.cells[0], {axis for _, axis in self.figure.named_axes()}
        others = [axis for axis, levels in self.results.axes.items()
                  if axis not in named and len(levels) > 1]
        sampled = [axis for axis in sampled_axes(self.results.study, self.results.axes) if axis in others]
        parts = [self._counted(sampled)]
        if intervals:
            parts.append(f"{100.0 * first.confidence:g} % interval ({first.interval})")
        over = [self._called(axis)[0] for axis in others if axis not in sampled]
        parts += [f"averaged over {', '.join(over)}"] if over else []
        parts += [self._level_of_axis(axis, first.levels[axis]) for axis in self.figure.at]
        return "; ".join([*parts, *self._left_out()])

    def _counted(self, sampled: list[str]) -> str:
        units = sorted({cell.units for cell in self.cells if cell.units})
        if not units:
            return f"{self.cells[0].statistic} of no value yet"
        counted = f"{units[0]}" if len(units) == 1 else f"{units[0]} to {units[-1]}"
        cohorts = [axis for axis in sampled if self.results.study.get("axes", {}).get(axis, {}).get("cohort")]
        what = "replicate" if not sampled else "patient" if cohorts == sampled else "point"
        return f"{self.cells[0].statistic} of {counted} {what}{'' if units == [1] else 's'}"

    def _left_out(self) -> list[str]:
        counts = Counter({"failed": sum(cell.failed for cell in self.cells),
                          "without the metric": sum(cell.missing for cell in self.cells),
                          "not over yet": sum(cell.waiting for cell in self.cells)})
        planned = sum(cell.planned for cell in self.cells)
        return [f"{count} of {planned} runs {what}" for what, count in counts.items() if count]
