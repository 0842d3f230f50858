"""Specification of a study's figure: a table [[figures]] of a study file, or an object in Python."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Literal

from fesloop.errors import InputError, did_you_mean

OWN_COLUMNS = ("cell", "replicate", "seed", "id", "status", "cause", "wall_s", "recording")
"""Columns of every table of results; no axis or metric may have these names."""

Kind = Literal["heat_map", "curves"]
Statistic = Literal["mean", "median", "share"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """A metric over one axis of a study, as curves, or over two, as a heat map.

    Other axes are averaged over; see `fesloop.analysis.study.results.estimates`.

    Attributes
    ----------
    name: of the figure's file.
    metric: the metric shown. x: axis along the abscissa.
    y: axis along the ordinate of a heat map. by: axis with a curve per level.
    panels: axis with a panel per level.
    at: levels at which other axes are fixed, by axis.
    statistic: of the repeated runs; None: the share for a metric without unit that is always 0 or 1, else the
        mean.
    confidence: of the intervals about curves.
    title, label, unit: of the figure, and of its metric; label "": the metric's name, whose ending also gives
        the unit (`_deg`, `_ms`, ...).
    low, high: ends of the scale of the metric; None: those of the data.
    theory: theory drawn over the data, where the experiments are linear loops: along an x that is a wire's
        latency, the critical latency; or, on curves, the exact cost at rest, which is the limit of
        joint_rmse_deg, of all or of one of `joints`, in a long run at a constant reference, without bias.
    spacing: of numeric levels: to scale (logarithmic where the study spaces them so), or even, for levels too
        uneven to be read to scale.
    """

    name: str
    kind: Kind
    metric: str
    x: str
    y: str | None = None
    by: str | None = None
    panels: str | None = None
    at: dict[str, float | int | str | bool] = field(default_factory=dict)
    statistic: Statistic | None = None
    confidence: float = 0.95
    title: str = ""
    label: str = ""
    unit: str = ""
    low: float | None = None
    high: float | None = None
    theory: Literal["none", "critical_latency", "stationary_cost"] = "none"
    spacing: Literal["to_scale", "even"] = "to_scale"

    def __post_init__(self) -> None:
        if not self.name.replace("_", "").replace("-", "").isalnum():
            raise InputError("name", f"{self.name!r}", "letters, digits, _ and -: it names a file")
        if self.kind == "heat_map" and (self.y is None or self.by is not None):
            raise InputError("y" if self.y is None else "by", f"{self.y if self.y is None else self.by!r}",
                             "a heat map has x and y, and no by", "show the third axis as panels")
        if self.kind == "curves" and self.y is not None:
            raise InputError("y", f"{self.y!r}", "curves have x and by, and no y",
                             "name the axis with a curve per level as by")
        if self.kind == "heat_map" and self.theory == "stationary_cost":
            raise InputError("theory", "'stationary_cost' over a heat map", "none, critical_latency",
                             "show it as curves")
        named = [axis for _, axis in self.named_axes()]
        for axis in {axis for axis in named if named.count(axis) > 1}:
            raise InputError("x", f"{axis!r} is named more than once among x, y, by, panels and at",
                             "each axis once")
        if not 0.0 < self.confidence < 1.0:
            raise InputError("confidence", f"{self.confidence:g}", "between 0 and 1, such as 0.95")
        if self.low is not None and self.high is not None and not self.low < self.high:
            raise InputError("low", f"{self.low:g}", f"below high, {self.high:g}")

    def named_axes(self) -> list[tuple[str, str]]:
        """Key and axis of each axis that the figure names."""
        one = [("x", self.x), ("y", self.y), ("by", self.by), ("panels", self.panels)]
        return [(key, axis) for key, axis in one if axis is not None] + [("at", axis) for axis in self.at]

    def faults(self, axes: Collection[str], metrics: Collection[str]) -> list[InputError]:
        """Errors for axes and metrics that the study does not have."""
        faults = [InputError(key, f"there is no axis {axis!r}", ", ".join(axes) or "the study has none",
                             did_you_mean(axis, axes)) for key, axis in self.named_axes() if axis not in axes]
        if self.metric not in metrics:
            faults.append(InputError("metric", f"the study keeps no metric {self.metric!r}",
                                     ", ".join(metrics), did_you_mean(self.metric, metrics)))
        return faults
