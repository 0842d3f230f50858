"""Results of a study with the labels of its axes, levels and values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from fesloop.analysis.study.results.axis_levels import AxisLevel, level_text
from fesloop.analysis.study.results.estimates import Estimate
from fesloop.analysis.study.results.quantities import called, with_unit
from fesloop.analysis.study.results.runs import sampled_axes
from fesloop.analysis.study.results.statistics import do_not_differ
from fesloop.analysis.study.results.study_results import StudyResults
from fesloop.show.figures.content import Content
from fesloop.show.report.run.words import listed

Better = Literal["low", "high"]
_HIGH = frozenset({"held", "held_s", "grip_margin", "grasps_until_fatigue", "found_true_quality",
                   "found_true_selectivity", "optimum_share", "fingertip_coverage"})
"""Metrics of runs (`fesloop.experiment.metrics`) that are better when greater."""
_LOW = ("rmse", "rmse_deg", "rmse_mm", "rmse_n", "error_deg", "minutes", "queries", "charge_uc",
        "object_moved_mm", "unwanted_motion_deg", "decline_pct", "time_to_grasp_s")
"""Suffixes of the names of metrics that are better when smaller."""


def better_end(results: StudyResults, metric: str) -> Better | None:
    """The good end of a study's metric, from the metric of a run; None where that is not known."""
    kept = str(results.study.get("study", {}).get("metrics", {}).get(metric, metric))
    parts = kept.partition(":")[0].split(".")
    if any(part in _HIGH for part in parts):
        return "high"
    if any(part.endswith(_LOW) for part in (*parts, metric)):
        return "low"
    return None


@dataclass(frozen=True)
class Shown:
    """Results of a study for its report.

    Attributes
    ----------
    results: that were read.
    """

    results: StudyResults = field(repr=False)

    @cached_property
    def metric(self) -> str:
        """The main metric: that of the first figure, else the first; empty where there is none."""
        figures = self.results.study.get("figures") or [{}]
        named = figures[0].get("metric", "")
        return named if named in self.results.metrics else next(iter(self.results.metrics), "")

    @property
    def better(self) -> Better | None:
        """The good end of the main metric, where that is known."""
        return better_end(self.results, self.metric)

    @cached_property
    def drawn(self) -> tuple[str, ...]:
        """Axes whose levels are a sample: members of a cohort, points of a sampled design."""
        return tuple(sampled_axes(self.results.study, self.results.axes))

    @property
    def chosen(self) -> tuple[str, ...]:
        """Axes whose levels were chosen, and that have more than one."""
        return tuple(axis for axis, levels in self.results.axes.items()
                     if axis not in self.drawn and len(levels) > 1)

    def axis(self, axis: str) -> tuple[str, str]:
        """Name and unit of an axis, as its study file calls it."""
        table = self.results.study.get("axes", {}).get(axis, {})
        return called(axis, table.get("label", ""), table.get("unit", ""))

    def metric_name(self, metric: str) -> tuple[str, str]:
        """Name and unit of a metric, from the first figure that shows it."""
        for figure in self.results.study.get("figures") or ():
            if figure.get("metric") == metric:
                return called(metric, figure.get("label", ""), figure.get("unit", ""))
        return called(metric)

    def metric_label(self, metric: str) -> str:
        """Heading of a metric in a table."""
        return with_unit(*self.metric_name(metric))

    def level(self, axis: str, level: AxisLevel) -> str:
        """A level with the name of its axis: "latency 40 ms", "controller pid"."""
        name, unit = self.axis(axis)
        return f"{name} {level_text(level)} {unit if not isinstance(level, str) else ''}".rstrip()

    def place(self, levels: Mapping[str, AxisLevel]) -> str:
        """Levels in a row; empty for none."""
        return ", ".join(self.level(axis, level) for axis, level in levels.items())

    def value(self, estimate: Estimate, *, interval: bool = True) -> str:
        """An estimate with its unit and interval: "0.53 deg (0.48 to 0.58)", "75 % (41 to 93)"."""
        return value_text(estimate.value, estimate.low, estimate.high, estimate.sd,
                          share=estimate.statistic == "share", interval=interval)


def value_text(value: float, low: float, high: float, sd: float, *, share: bool, interval: bool = True
               ) -> str:
    """A value with its interval, to three digits; shares in percent; "-" for what is not known."""
    if not np.isfinite(value):
        return "-"
    factor, sign = (100.0, " %") if share else (1.0, "")
    decimals = 0 if share else decimals_of([value, low, high])
    text = f"{factor * value:.{decimals}f}{sign}"
    if interval and np.isfinite(high - low):
        text += f" ({factor * low:.{decimals}f} to {factor * high:.{decimals}f})"
    elif interval and do_not_differ(value, sd):
        text += " (values do not differ)"
    return text


def decimals_of(values: Sequence[float]) -> int:
    """Number of decimals with which the largest value has three digits."""
    largest = max((abs(value) for value in values if np.isfinite(value)), default=0.0)
    exponent = int(f"{largest:.2e}".partition("e")[2])
    return min(max(2 - exponent, 0), 6) if largest > 0.0 else 0


def by_axes(content: Content, axes: Sequence[str]) -> str:
    """A metric by its axes, without units: "Motion at rest, RMS, by latency and law"."""
    figure = content.figure
    metric, _ = called(figure.metric, figure.label)
    return by(metric, [content.axis_name(axis) for axis in axes])


def by(quantity: str, axes: Sequence[str]) -> str:
    """A quantity by its axes; set off by a comma where it has one itself."""
    text = f"{quantity}{',' if ',' in quantity else ''} by {listed(axes)}"
    return text[:1].upper() + text[1:]
