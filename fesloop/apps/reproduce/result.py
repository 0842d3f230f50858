"""Result of a reproduction: rows of the comparison, sweeps, and curves for figures."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fesloop.apps.reproduce.comparison import FigureScores, PatternScores, Row, share_that_holds
from fesloop.apps.reproduce.published import HALVES


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """A table without published counterpart, such as a sweep of an unpublished parameter or of error sources.

    Attributes
    ----------
    title, unit: of it.
    columns: names of the columns. rows: name of each row, and its values.
    """

    title: str
    unit: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, tuple[float, ...]], ...]

    def as_table(self) -> dict[str, Any]:
        """Table for `fesloop reproduce --json`."""
        return {"title": self.title, "unit": self.unit,
                "rows": [{"row": name, **dict(zip(self.columns, values, strict=True))}
                         for name, values in self.rows]}


@dataclass(frozen=True, slots=True)
class Reproduction:
    """A paper's experiments on virtual subjects.

    Attributes
    ----------
    paper: name. subjects: number of virtual subjects.
    rows: of the comparison.
    sweeps: by name.
    curves: arrays for figures.
    baseline: commit of the model that scores are compared with.
    frozen: commit of the model that was fitted, before the predicted figures were simulated.
    unit: what `subjects` counts.
    """

    paper: str
    subjects: int
    rows: Sequence[Row]
    sweeps: dict[str, Sweep] = field(default_factory=dict)
    curves: dict[str, Any] = field(default_factory=dict)
    baseline: str = ""
    frozen: str = ""
    unit: str = "virtual subject"

    @property
    def cohort(self) -> str:
        """Number of subjects as text."""
        return f"{self.subjects} {self.unit}" + "s" * (self.subjects != 1)

    def as_table(self) -> dict[str, Any]:
        """Table for `fesloop reproduce --json`."""
        table = {"paper": self.paper, "subjects": self.subjects,
                 "rows": [row.as_table() for row in self.rows],
                 "holding": share_that_holds(self.rows),
                 "sweeps": {name: sweep.as_table() for name, sweep in self.sweeps.items()}}
        scored = {"summary": summary(self.rows), "baseline": self.baseline, "frozen": self.frozen}
        return table | scored if self.baseline else table


def summary(rows: Sequence[Row]) -> dict[str, dict[str, float]]:
    """Summary of scored rows: of fitted and predicted figures, and of patterns, each beside the baseline's.

    Log scores are means, `log_score_better` counts rows that are better than the baseline's, and
    `band_over_sd` is the median of the rows that have one.
    """
    found: dict[str, dict[str, float]] = {}
    for half in HALVES:
        group = [(row, row.scores) for row in rows
                 if isinstance(row.scores, FigureScores) and row.scores.half == half]
        scores = [each for _, each in group]
        found[half] = _holding(group) | {
            "log_score": _mean(each.log_score for each in scores),
            "log_score_better": sum(each.log_score > each.baseline_log_score for each in scores),
            "baseline_log_score": _mean(each.baseline_log_score for each in scores),
            "band_over_sd": float(np.median([each.band_over_sd for each in scores
                                             if not math.isnan(each.band_over_sd)] or math.nan))}
    found["patterns"] = _holding([(row, row.scores) for row in rows if isinstance(row.scores, PatternScores)])
    return found


def _holding(group: Sequence[tuple[Row, FigureScores | PatternScores]]) -> dict[str, float]:
    return {"rows": len(group), "holding": sum(row.holds for row, _ in group),
            "baseline_holding": sum(scores.baseline_holds for _, scores in group)}


def _mean(values: Iterable[float]) -> float:
    return float(np.mean([*values] or math.nan))


def summary_lines(found: Mapping[str, Any]) -> list[str]:
    """Lines of text on the summary in a table of `Reproduction.as_table`, also one read from JSON."""
    lines = []
    for half in HALVES:
        part = found["summary"][half]
        lines.append(
            f"{half}: {_of_rows(part)} in the band, {_shown(part['baseline_holding'])} in the baseline's; "
            f"mean log score {_shown(part['log_score'])}, baseline {_shown(part['baseline_log_score'])}, "
            f"better in {part['log_score_better']} rows; "
            f"bands {_shown(part['band_over_sd'])} published standard deviations, median")
    part = found["summary"]["patterns"]
    lines.append(f"patterns: {_of_rows(part)} hold, {_shown(part['baseline_holding'])} with the baseline")
    frozen = f"; frozen before the predicted half was simulated: {found['frozen']}" if found["frozen"] else ""
    return [*lines, f"baseline: the model of {found['baseline']}{frozen}"]


def _of_rows(part: Mapping[str, Any]) -> str:
    return f"{part['holding']} of {part['rows']} rows"


def _shown(value: float | None) -> str:
    return "undefined" if value is None or math.isnan(value) else f"{value:.3g}"
