"""Lines over the figures of a study, such as theory beside simulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fesloop.analysis.study.design.figure_specs import Figure
from fesloop.analysis.study.results.axis_levels import AxisLevel, is_numeric, level_text, place_of
from fesloop.analysis.study.results.study_results import StudyResults
from fesloop.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class Overlay:
    """A line over a figure.

    Attributes
    ----------
    label: of the legend; overlays of one label look alike and stand there once.
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
    """Raise InputError for one that does not fit the figure."""
    for overlay in overlays:
        where = f"overlay {overlay.label!r}"
        if not is_numeric(results.axes[figure.x]):
            raise InputError(where, f"{figure.x} is no axis of numbers", "a figure over numbers")
        if figure.y is not None and len(overlay.y) and not is_numeric(results.axes[figure.y]):
            raise InputError(where, f"{figure.y} is no axis of numbers", "a figure over numbers")
        asked = (("panel", overlay.panel, figure.panels), ("line", overlay.line, figure.by))
        for key, level, axis in asked:
            if level is not None and axis is None:
                raise InputError(f"{where}: {key}", f"{level_text(level)}, but the figure has none", "None")
            if level is not None and axis is not None:
                place_of(results.axes, axis, level)
