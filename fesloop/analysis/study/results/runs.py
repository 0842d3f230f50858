"""Planned runs of a study as a pandas table, and which of them are independent of each other."""

from __future__ import annotations

import importlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.analysis.study.design.figure_specs import OWN_COLUMNS
from fesloop.analysis.study.results.axis_levels import Axes, axes_of, place_of
from fesloop.analysis.study.store.reading import ResultRow, RunRow, StoreRows
from fesloop.errors import InputError, did_you_mean

DONE, FAILED, WAITING = "done", "failed", "waiting"
"""Status of a run; a planned run that has not ended is waiting."""
Frame = Any
"""A pandas DataFrame (pandas has no types of its own)."""


def extra(module: str) -> Any:
    """Import a module of the extra `study`. Raises InputError where it is not installed."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise InputError(module, "is not installed", f"{module}, of fesloop's extra `study`",
                         "pip install 'fesloop[study]'") from None


def run_table(path: Path, rows: StoreRows, declared: Sequence[str]) -> tuple[Axes, tuple[str, ...], Frame]:
    """Axes and metrics of a study, and a table with a row for each planned run, by cell and replicate.

    Its columns are cell; the axes, each a categorical column of its levels in order; replicate, seed, id,
    status, cause; the metrics, NaN where a run failed, has not ended, or lacks the value; wall_s, recording.
    Metrics come in the order `declared`, then others.

    Raises InputError for a store whose rows make no such table.
    """
    pandas = extra("pandas")
    try:
        levels = [json.loads(cell.levels) for cell in rows.cells]
        axes, places = axes_of(levels)
        number = {cell.cell: i for i, cell in enumerate(rows.cells)}
        planned = np.array([number[run.cell] for run in rows.runs], dtype=np.int64)
        runs = pandas.DataFrame(rows.runs, columns=list(RunRow._fields)).astype(
            {"cell": np.int64, "replicate": np.int64, "seed": np.int64, "id": "str"})
        results, metrics = _results(pandas, rows.results, declared)
        names = [*OWN_COLUMNS, *axes, *metrics]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise InputError(f"{path}: {twice[0]}", "is the name of two columns",
                             f"axes and metrics under names of their own, and not {', '.join(OWN_COLUMNS)}")
        for place, (axis, ordered) in enumerate(axes.items()):
            runs.insert(1 + place, axis, pandas.Categorical.from_codes(
                places[axis][planned], categories=list(ordered), ordered=True))
        runs = runs.merge(results, on="id", how="left").fillna(
            {"status": WAITING, "cause": "", "recording": ""})
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as fault:
        if isinstance(fault, InputError):
            raise
        raise InputError(str(path), f"is damaged: its tables contradict each other ({fault!r})",
                         "a study's store, as `fesloop study` writes it") from None
    return axes, metrics, runs


def _results(pandas: Any, rows: Sequence[ResultRow], declared: Sequence[str]
             ) -> tuple[Frame, tuple[str, ...]]:
    """Outcomes by id, their metrics as columns, and the names of these."""
    for row in rows:
        if row.status not in (DONE, FAILED):
            raise ValueError(f"status {row.status!r}")
    found = [json.loads(row.metrics) if row.status == DONE and row.metrics else {} for row in rows]
    if not all(isinstance(each, dict) for each in found):
        raise ValueError("metrics that are no table")
    names = tuple(dict.fromkeys([*declared, *(name for each in found for name in each)]))
    values = {name: np.array([each.get(name) for each in found], dtype=np.float64) for name in names}
    text = {name: pandas.Series([getattr(row, name) or "" for row in rows], dtype="str")
            for name in ("id", "status", "cause", "recording")}
    return pandas.DataFrame({
        "id": text["id"], "status": text["status"], "cause": text["cause"], **values,
        "wall_s": np.array([row.wall_s for row in rows], dtype=np.float64),
        "recording": text["recording"]}), names


def sampled_axes(study: Mapping[str, Any], axes: Axes) -> list[str]:
    """Axes whose levels are a sample: those of cohorts, and all of a random or Sobol design."""
    if study.get("study", {}).get("design", "grid") != "grid":
        return list(axes)
    return [axis for axis, table in study.get("axes", {}).items() if axis in axes and table.get("cohort")]


def selected(axes: Axes, runs: Frame, at: Mapping[str, Any]) -> Frame:
    """The runs at these levels. Raises InputError for an axis or a level that the study does not have."""
    for axis, level in at.items():
        place = place_of(axes, axis, level)
        runs = runs[runs[axis].cat.codes == place]
    return runs


def require_metric(metric: str, metrics: Sequence[str]) -> None:
    """Raise InputError for a metric that the study does not keep."""
    if metric not in metrics:
        raise InputError(metric, "is not a metric of the study", ", ".join(metrics) or "it has none",
                         did_you_mean(metric, metrics))


def unit_keys(runs: Frame, sampled: Sequence[str]) -> list[str]:
    """Columns whose combinations are the units: values that are independent of each other.

    Runs of one replicate share a seed in all cells, so they are not independent. Over axes with chosen
    levels, values are averaged within a replicate and the replicates are the units. Sampled levels (members
    of a cohort, points of a random or Sobol design) are the units where they vary among the runs; replicates
    are then averaged within each level.
    """
    return [axis for axis in sampled if runs[axis].nunique() > 1] or ["replicate"]
