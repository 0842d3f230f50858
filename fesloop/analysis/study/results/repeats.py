"""What is repeated in a study, and how often: which runs are independent of each other.

Runs of one replicate have the same seed in every cell, so they are no independent repetitions of each other:
over axes whose levels were chosen, values are first averaged within a replicate, and the replicates are what
is repeated. Levels that were drawn - members of a cohort, points of a random or Sobol design - are themselves
what is repeated, and replicates are first averaged within them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.study.results.axis_levels import Axes, place_of, require_axis
from fesloop.analysis.study.results.run_columns import RunColumns
from fesloop.errors import InputError, did_you_mean

Array = NDArray[np.float64]
Rows = NDArray[np.int64]


def drawn_axes(study: Mapping[str, Any], axes: Axes) -> list[str]:
    """Axes whose levels are a sample: those of cohorts, and all of a design that draws points."""
    if study.get("study", {}).get("design", "grid") != "grid":
        return list(axes)
    return [axis for axis, table in study.get("axes", {}).items() if axis in axes and table.get("cohort")]


def selected(axes: Axes, runs: RunColumns, at: Mapping[str, Any]) -> Rows:
    """Rows of the runs at these levels; InputError for an axis or a level that the study does not have."""
    chosen = np.ones(len(runs.cell), dtype=bool)
    for axis, level in at.items():
        chosen &= runs.places[axis] == place_of(axes, axis, level) if axis in axes else _no_axis(axes, axis)
    return np.flatnonzero(chosen)


def _no_axis(axes: Axes, axis: str) -> bool:
    require_axis(axes, axis)
    return False


def values_of(runs: RunColumns, metric: str) -> Array:
    """A metric of every planned run; InputError for one that the study does not keep."""
    if metric not in runs.values:
        raise InputError(metric, "is no metric of the study", ", ".join(runs.values) or "it has none",
                         did_you_mean(metric, runs.values))
    return runs.values[metric]


def is_switch(values: Array) -> bool:
    """Whether a metric is only ever 0 or 1, as far as it is known."""
    known = values[~np.isnan(values)]
    return bool(len(known)) and bool(np.isin(known, (0.0, 1.0)).all())


def units_of(runs: RunColumns, rows: Rows, drawn: Sequence[str]) -> Rows:
    """Number of the unit that each of these rows belongs to, of those that are independent of each other.

    A unit is what has the same levels on those `drawn` axes that vary among the rows; where none does, a
    replicate.
    """
    keys = [runs.places[axis][rows] for axis in drawn]
    varying = [key for key in keys if len(key) and (key != key[0]).any()]
    return groups_of(varying or [runs.replicate[rows]])


def groups_of(keys: Sequence[Rows]) -> Rows:
    """Number of the group of rows with the same keys, 0 or more each; groups in ascending order of these."""
    groups = np.zeros(len(keys[0]), dtype=np.int64)
    for key in keys:
        # Numbered anew each time, so that no product of many axes overflows.
        groups = np.unique(groups * (key.max(initial=0) + 1) + key, return_inverse=True)[1].reshape(-1)
    return groups


def unit_means(units: Rows, values: Array) -> Array:
    """Mean of each unit that has values, in order."""
    sums, counts = np.bincount(units, values), np.bincount(units)
    return np.asarray(sums[counts > 0] / counts[counts > 0])
