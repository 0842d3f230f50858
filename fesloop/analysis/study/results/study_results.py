"""What a study found: its table, its statistics, what differs between cells."""

from __future__ import annotations

import csv
import hashlib
import importlib
import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.study.design.figure_specs import OWN_COLUMNS, Statistic
from fesloop.analysis.study.results.axis_levels import Axes, AxisLevel, is_numeric
from fesloop.analysis.study.results.comparison import Comparison, compare
from fesloop.analysis.study.results.estimates import Estimate, estimates
from fesloop.analysis.study.results.repeats import drawn_axes, groups_of
from fesloop.analysis.study.results.run_columns import FAILED, WAITING, RunColumns, run_columns
from fesloop.analysis.study.store.reading import read_store, store_path
from fesloop.errors import InputError

Table = Mapping[str, NDArray[Any]]


def to_frame(table: Table) -> Any:
    """The pandas DataFrame of a table; InputError where pandas is not installed."""
    return _extra("pandas").DataFrame(dict(table))


def write_csv(table: Table, path: Path) -> None:
    """Write a table as CSV (RFC 4180), numbers so that they read back the same, what is missing as nothing.

    Raises InputError where the file cannot be written.
    """
    with_text = [[_field(value) for value in column.tolist()] for column in table.values()]

    def write() -> None:
        with path.open("w", encoding="utf-8", newline="") as file:
            lines = csv.writer(file)
            lines.writerow(table)
            lines.writerows(zip(*with_text, strict=True))

    _written(path, write)


def write_parquet(table: Table, path: Path) -> None:
    """Write a table as Parquet; a number that is missing is null, an integer stays one.

    Raises InputError where pyarrow is not installed or the file cannot be written.
    """
    arrow, parquet = _extra("pyarrow"), _extra("pyarrow.parquet")
    columns = {name: arrow.array(column, mask=np.isnan(column)) if column.dtype.kind == "f"
               else arrow.array(column.tolist(), arrow.string()) if column.dtype.kind == "O"
               else arrow.array(column) for name, column in table.items()}
    _written(path, lambda: parquet.write_table(arrow.table(columns), path))


def _field(value: Any) -> str:
    """`repr` of a float is the shortest text that reads back as the same float."""
    if isinstance(value, float):
        return "" if value != value else repr(value)
    return str(value)


def _written(path: Path, write: Callable[[], Any]) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write()
    except OSError as fault:
        raise InputError(str(path), f"cannot be written: {fault.strerror or fault}",
                         "a place that can be written, with room") from None


def _extra(module: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError:
        name = module.partition(".")[0]
        raise InputError(name, "is not installed", f"{name}, of fesloop's extra `study`",
                         "pip install 'fesloop[study]'") from None


Cells = Callable[[str, Sequence[str] | None], list[Estimate]]


@dataclass(frozen=True, slots=True, kw_only=True)
class SummaryRow:
    """A cell, or a level of one axis over all others.

    Attributes
    ----------
    levels: by axis. planned, failed, waiting: runs. metrics: estimates by metric.
    """

    levels: dict[str, AxisLevel]
    planned: int
    failed: int
    waiting: int
    metrics: dict[str, Estimate]


def summary_rows(
    metrics: Sequence[str], cells: Cells, tellings: Sequence[Sequence[str] | None]
) -> list[SummaryRow]:
    """The rows of each way to tell runs apart: by the levels of some axes, or by cells (None).

    `cells` gives the estimates of a metric for such a way.
    """
    rows = []
    for by in tellings if metrics else ():
        found = {metric: cells(metric, by) for metric in metrics}
        rows += [SummaryRow(levels=cell.levels, planned=cell.planned, failed=cell.failed,
                            waiting=cell.waiting, metrics={name: each[i] for name, each in found.items()})
                 for i, cell in enumerate(found[metrics[0]])]
    return rows


def load(path: str | Path, *, check: bool = True) -> StudyResults:
    """Load the results of a study, finished or under way.

    Parameters
    ----------
    path: the store, or its folder.
    check: refuse a store whose rows are not those that fesloop wrote; False reads them as they are.

    Raises InputError for a file that is no store, is damaged, or of another version.
    """
    store = store_path(path)
    rows = read_store(store, check=check)
    try:
        study = json.loads(rows.about["study"])
        declared = list(study.get("study", {}).get("metrics", {}))
    except (KeyError, ValueError, AttributeError, TypeError):
        raise InputError(str(store), "is damaged: it does not say which study it is of",
                         "a study's store, as `fesloop study` writes it") from None
    axes, runs = run_columns(store, rows, declared)
    return StudyResults(store, rows.about, study, axes, tuple(runs.values), runs)


@dataclass(frozen=True, slots=True, eq=False)
class StudyResults:
    """A study's runs at the instant when its store was read; `load` makes it.

    Attributes
    ----------
    path: of the store. about: its facts: name, form, created, ... study: the settled study document.
    axes: levels by axis; numbers ascending, text in the study's order. metrics: names.
    runs: every planned run, as columns.
    """

    path: Path
    about: dict[str, str]
    study: dict[str, Any]
    axes: Axes
    metrics: tuple[str, ...]
    runs: RunColumns

    @property
    def name(self) -> str:
        """Of the study."""
        return self.about.get("name", "")

    @property
    def planned(self) -> int:
        """Runs of all cells."""
        return len(self.runs.cell)

    @property
    def finished(self) -> int:
        """Planned runs that are over, done or failed."""
        return int(np.count_nonzero(self.runs.status != WAITING))

    def table(self) -> dict[str, NDArray[Any]]:
        """Columns by name, a row for each planned run that is over, done or failed.

        They are the cell, its axes, replicate, seed, id, status, cause, metrics, wall_s and recording.
        Numbers are arrays of float or int, NaN where a run has no such number; text is of dtype object.
        """
        runs, over = self.runs, self.runs.status != WAITING
        levels = {axis: _levels(each)[runs.places[axis]] for axis, each in self.axes.items()}
        names = [*OWN_COLUMNS, *levels, *self.metrics]
        twice = [name for name, count in Counter(names).items() if count > 1]
        if twice:
            raise InputError(f"{self.path}: {twice[0]}", "is the name of two columns",
                             f"axes and metrics under names of their own, and not {', '.join(OWN_COLUMNS)}")
        columns = {"cell": runs.cell, **levels, "replicate": runs.replicate, "seed": runs.seed, "id": runs.id,
                   "status": runs.status, "cause": runs.cause, **runs.values, "wall_s": runs.wall_s,
                   "recording": runs.recording}
        return {name: column[over] for name, column in columns.items()}

    def frame(self) -> Any:
        """The table as a pandas DataFrame; InputError where pandas is not installed."""
        return to_frame(self.table())

    def to_csv(self, path: str | Path) -> None:
        """Write the table as CSV; InputError where that cannot be."""
        write_csv(self.table(), Path(path))

    def to_parquet(self, path: str | Path) -> None:
        """Write the table as Parquet; InputError where that cannot be or pyarrow is not installed."""
        write_parquet(self.table(), Path(path))

    def cells(
        self, metric: str, by: Sequence[str] | None = None, at: Mapping[str, Any] | None = None,
        statistic: Statistic | None = None, confidence: float = 0.95,
    ) -> list[Estimate]:
        """A metric in each cell, with how sure it is.

        Parameters
        ----------
        by: axes whose levels are told apart, the others being averaged over; None: all but those of cohorts.
        at: levels at which other axes are held. statistic: None: the share for a metric without unit
            that is only ever 0 or 1, else the mean. confidence: of the intervals.

        Raises InputError for an axis, level or metric that the study does not have.
        """
        named = [axis for axis in self._told_apart() if axis not in (at or {})] if by is None else by
        return estimates(self.axes, self.runs, drawn_axes(self.study, self.axes), metric, named, at or {},
                         statistic, confidence)

    def _told_apart(self) -> list[str]:
        """Axes whose levels are cells of their own: all but patients."""
        return [axis for axis in self.axes if not self.study.get("axes", {}).get(axis, {}).get("cohort")]

    def compare(
        self, metric: str, first: Mapping[str, Any], second: Mapping[str, Any],
        at: Mapping[str, Any] | None = None, statistic: Statistic | None = None, confidence: float = 0.95,
    ) -> Comparison:
        """A metric at levels `first` less that at `second`, by pairs of runs that differ in nothing else.

        Runs of one replicate have the same seed, so what is random is the same in a pair, and the difference
        is known better than the two values. `at`: levels at which other axes are held. Raises InputError for
        what the study does not have, and where nothing can be paired.
        """
        return compare(self.axes, self.runs, drawn_axes(self.study, self.axes), metric, first, second,
                       at or {}, statistic, confidence)

    def summary(self, most: int = 40) -> list[SummaryRow]:
        """The study in at most so many rows, if that can be: every cell, else every level of each axis."""
        cells = groups_of([self.runs.places[axis] for axis in self._told_apart()] or [self.runs.cell * 0])
        whole = int(cells.max(initial=-1)) < most
        return summary_rows(self.metrics, self.cells, [None] if whole else [[axis] for axis in self.axes])

    def failures(self) -> dict[str, int]:
        """How many distinct runs failed, by cause, the most frequent first."""
        failed = self.runs.status == FAILED
        cause_of = dict(zip(self.runs.id[failed], self.runs.cause[failed], strict=True))
        return dict(Counter(cause_of.values()).most_common())

    def digest(self) -> str:
        """SHA-256 of every planned run and what came of it, leaving out what the wall clock left.

        Equal for two stores if and only if all their numbers are, bit for bit.
        """
        runs, total = self.runs, hashlib.sha256()
        metrics = sorted(self.metrics)
        columns = [runs.cell, runs.replicate, runs.id, runs.status, runs.cause,
                   *(runs.values[name] for name in metrics)]
        total.update(json.dumps(metrics).encode())
        # Rows are in order of cell and replicate, whatever the order in which runs ended.
        for row in zip(*(column.tolist() for column in columns), strict=True):
            total.update(json.dumps(row).encode())
        return total.hexdigest()


def _levels(levels: tuple[AxisLevel, ...]) -> NDArray[Any]:
    """Levels of an axis as an array: of numbers where they are such, else of objects."""
    return np.array(levels) if is_numeric(levels) else np.array(levels, dtype=object)
