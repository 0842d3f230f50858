"""Results of a study: its table, its statistics, differences between cells."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.study.design.figure_specs import Statistic
from fesloop.analysis.study.results.axis_levels import Axes, AxisLevel, is_numeric
from fesloop.analysis.study.results.comparison import Comparison, compare
from fesloop.analysis.study.results.estimates import Estimate, estimates
from fesloop.analysis.study.results.runs import (
    FAILED,
    WAITING,
    Frame,
    extra,
    require_metric,
    run_table,
    sampled_axes,
    selected,
)
from fesloop.analysis.study.store.reading import read_store, store_path
from fesloop.errors import InputError
from fesloop.experiment.metrics.words import is_never_negative
from fesloop.tables import Table, as_html, as_text


@dataclass(frozen=True, slots=True, kw_only=True)
class SummaryRow:
    """A cell, or a level of one axis averaged over all others.

    Attributes
    ----------
    levels: by axis. planned, failed, waiting: numbers of runs. metrics: estimates by metric.
    """

    levels: dict[str, AxisLevel]
    planned: int
    failed: int
    waiting: int
    metrics: dict[str, Estimate]


def load(path: str | Path, *, check: bool = True) -> StudyResults:
    """Load the results of a study, finished or under way.

    Parameters
    ----------
    path: the store, or its folder.
    check: refuse a store whose rows are not those that fesloop wrote; False reads them as they are.

    Raises InputError for a file that is not a store, is damaged, or of another version, and without pandas.
    """
    store = store_path(path)
    rows = read_store(store, check=check)
    try:
        study = json.loads(rows.about["study"])
        declared = list(study.get("study", {}).get("metrics", {}))
    except (KeyError, ValueError, AttributeError, TypeError):
        raise InputError(str(store), "is damaged: it does not say which study it is of",
                         "a study's store, as `fesloop study` writes it") from None
    axes, metrics, runs = run_table(store, rows, declared)
    return StudyResults(store, rows.about, study, axes, metrics, runs)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class StudyResults:
    """Results of a study at the instant when its store was read; made by `load`.

    Attributes
    ----------
    path: of the store. about: its facts: name, form, created, ... study: the settled study document.
    axes: levels by axis; numbers ascending, text in the study's order. metrics: names.
    runs: every planned run, finished or not, as a pandas DataFrame
        (`fesloop.analysis.study.results.runs.run_table`).
    """

    path: Path
    about: dict[str, str]
    study: dict[str, Any]
    axes: Axes
    metrics: tuple[str, ...]
    runs: Frame

    @property
    def name(self) -> str:
        """Name of the study."""
        return self.about.get("name", "")

    @property
    def planned(self) -> int:
        """Number of runs of all cells."""
        return len(self.runs)

    @property
    def finished(self) -> int:
        """Number of planned runs that have ended, done or failed."""
        return int((self.runs["status"] != WAITING).sum())

    def frame(self) -> Frame:
        """The runs that have ended, done or failed, as a pandas DataFrame.

        Columns are the cell, its axes, replicate, seed, id, status, cause, metrics, wall_s and recording.
        Numbers are float or int, NaN where a run has no such number; everything else is text.
        """
        ended = self.runs[self.runs["status"] != WAITING].reset_index(drop=True)
        return ended.astype({axis: np.asarray(levels).dtype if is_numeric(levels) else "str"
                             for axis, levels in self.axes.items()})

    def table(self) -> dict[str, NDArray[Any]]:
        """The columns of `frame` as numpy arrays by name; text is of dtype object."""
        return {name: column.to_numpy(dtype=None if column.dtype.kind in "if" else object)
                for name, column in self.frame().items()}

    def to_csv(self, path: str | Path) -> None:
        """Write the table as CSV (RFC 4180); numbers read back the same, missing ones are empty.

        Raises InputError where the file cannot be written.
        """
        self._write(Path(path), lambda target: self.frame().to_csv(
            target, index=False, lineterminator="\r\n"))

    def to_parquet(self, path: str | Path) -> None:
        """Write the table as Parquet; missing numbers are null.

        Raises InputError where the file cannot be written or pyarrow is not installed.
        """
        extra("pyarrow")
        self._write(Path(path), lambda target: self.frame().to_parquet(target, index=False))

    def _write(self, path: Path, write: Callable[[Path], Any]) -> None:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            write(path)
        except OSError as fault:
            raise InputError(str(path), f"cannot be written: {fault.strerror or fault}",
                             "a place that can be written, with room") from None

    def cells(
        self, metric: str, by: Sequence[str] | None = None, at: Mapping[str, Any] | None = None,
        statistic: Statistic | None = None, confidence: float = 0.95,
    ) -> list[Estimate]:
        """A metric in each cell, with its confidence interval.

        Parameters
        ----------
        by: axes whose levels are separate cells, the others being averaged over; None: all but cohorts.
        at: levels at which other axes are fixed. statistic: None: the share for a metric without unit that is
            always 0 or 1, else the mean. confidence: of the intervals.

        Raises InputError for an axis, level or metric that the study does not have.
        """
        require_metric(metric, self.metrics)
        named = [axis for axis in self._chosen_axes() if axis not in (at or {})] if by is None else by
        return estimates(self.axes, self.runs, sampled_axes(self.study, self.axes), metric, named, at or {},
                         statistic, confidence, self._least(metric))

    def binned(
        self, metric: str, over: str, edges: Sequence[float], at: Mapping[str, Any] | None = None,
        statistic: Statistic | None = None, confidence: float = 0.95,
    ) -> list[Estimate]:
        """A metric of the runs in which another metric, `over`, is between successive edges.

        Such as the share that held by the tracker's error. The level of `over` reads "1 to 2": from an edge
        to below the next. Runs beyond the edges, and bins without runs, are left out; other parameters and
        errors are those of `cells`. Raises InputError for edges that do not increase, too.
        """
        for name in (metric, over):
            require_metric(name, self.metrics)
        if metric == over:
            raise InputError("over", f"{over!r} is the metric itself", "another metric")
        if len(edges) < 2 or not np.all(np.diff(edges) > 0.0):
            raise InputError("edges", f"{list(edges)}", "two or more numbers that increase")
        labels = [f"{low:g} to {high:g}" for low, high in pairwise(edges)]
        runs = selected(self.axes, self.runs, at or {})
        bins = extra("pandas").cut(runs[over], list(edges), right=False, labels=labels)
        inside = runs.assign(**{over: bins})[bins.notna()].reset_index(drop=True)
        return estimates({**self.axes, over: tuple(labels)}, inside, sampled_axes(self.study, self.axes),
                         metric, [over], {}, statistic, confidence, self._least(metric))

    def _least(self, metric: str) -> float:
        """The least value that a metric can have by the definition of what it keeps of a run."""
        kept = self.study.get("study", {}).get("metrics", {}).get(metric, metric)
        return 0.0 if is_never_negative(str(kept).partition(":")[0].removesuffix("?")) else -math.inf

    def _chosen_axes(self) -> list[str]:
        """Axes whose levels are cells of their own: all but cohorts."""
        return [axis for axis in self.axes if not self.study.get("axes", {}).get(axis, {}).get("cohort")]

    def compare(
        self, metric: str, first: Mapping[str, Any], second: Mapping[str, Any],
        at: Mapping[str, Any] | None = None, statistic: Statistic | None = None, confidence: float = 0.95,
    ) -> Comparison:
        """A metric at levels `first` less that at `second`, over pairs of runs that differ in nothing else.

        Runs of one replicate have the same seed, hence the same noise, so that a difference is known more
        precisely than the two values. `at`: levels at which other axes are fixed. Raises InputError for axes,
        levels or metrics that the study does not have, and where there are no pairs.
        """
        require_metric(metric, self.metrics)
        return compare(self.axes, self.runs, sampled_axes(self.study, self.axes), metric, first, second,
                       at or {}, statistic, confidence)

    def summary(self, most: int = 40) -> list[SummaryRow]:
        """A row for every cell where these are at most so many, else for every level of each axis."""
        chosen = self._chosen_axes()
        whole = not chosen or len(self.runs[chosen].drop_duplicates()) <= most
        rows = []
        for by in ([None] if whole else [[axis] for axis in self.axes]) if self.metrics else ():
            found = {metric: self.cells(metric, by) for metric in self.metrics}
            rows += [SummaryRow(levels=cell.levels, planned=cell.planned, failed=cell.failed,
                                waiting=cell.waiting, metrics={name: each[i] for name, each in found.items()})
                     for i, cell in enumerate(found[self.metrics[0]])]
        return rows

    def failures(self) -> dict[str, int]:
        """Number of distinct runs that failed, by cause, the most frequent first."""
        failed = self.runs[self.runs["status"] == FAILED].drop_duplicates("id")
        return {str(cause): int(count) for cause, count in failed["cause"].value_counts().items()}

    def _tables(self) -> list[Table]:
        from fesloop.analysis.study.results.shown import failures_table, results_table

        return [results_table(self), *([failures_table(self)] if self.failures() else [])]

    def __repr__(self) -> str:
        return f"StudyResults({self.name!r}: {self.finished} of {self.planned} runs, {str(self.path)!r})"

    def __str__(self) -> str:
        return as_text(self._tables())

    def _repr_html_(self) -> str:
        return as_html(self._tables())

    def digest(self) -> str:
        """SHA-256 of every planned run and its outcome, without wall-clock times.

        Equal for two stores if and only if all their numbers are, bit for bit.
        """
        total, metrics = hashlib.sha256(), sorted(self.metrics)
        columns = self.runs[["cell", "replicate", "id", "status", "cause", *metrics]]
        total.update(json.dumps(metrics).encode())
        for row in zip(*(column.tolist() for _, column in columns.items()), strict=True):
            total.update(json.dumps(row).encode())
        return total.hexdigest()
