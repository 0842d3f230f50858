"""The planned runs of a study as columns, made of the rows of its store."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.study.results.axis_levels import Axes, axes_of
from fesloop.analysis.study.store.reading import StoreRows
from fesloop.errors import InputError

DONE, FAILED, WAITING = "done", "failed", "waiting"
"""Of a run: over, over with a cause, planned but not over yet."""
Column = NDArray[Any]


@dataclass(frozen=True, slots=True, eq=False)
class RunColumns:
    """Every planned run, in order of cell and replicate; arrays are (runs,) and must not be written.

    Attributes
    ----------
    cell, replicate, seed: of each. id: fingerprint of its experiment; cells may share a run.
    places: of the level of its cell, by axis.
    status: done, failed, or waiting for what is not over yet. cause: of failure, else empty.
    values: by metric; NaN where a run failed, is not over, or has no such value.
    wall_s: how long it took, NaN where it is not over. recording: its file, empty where none was kept.
    """

    cell: NDArray[np.int64]
    replicate: NDArray[np.int64]
    seed: NDArray[np.int64]
    id: Column
    places: dict[str, NDArray[np.int64]]
    status: Column
    cause: Column
    values: dict[str, NDArray[np.float64]]
    wall_s: NDArray[np.float64]
    recording: Column


def run_columns(path: Path, rows: StoreRows, declared: Sequence[str]) -> tuple[Axes, RunColumns]:
    """Axes of the study and its runs; metrics in the order `declared`, then others as they come.

    Raises InputError for a store whose content does not hang together.
    """
    try:
        axes, places = axes_of([json.loads(levels) for _, levels in rows.cells])
        of_cell = {cell: i for i, (cell, _) in enumerate(rows.cells)}
        planned = np.array([of_cell[cell] for cell, *_ in rows.runs], dtype=np.int64)
        of_run = {axis: each[planned] for axis, each in places.items()}
        return axes, _columns(rows, of_run, declared)
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as fault:
        raise InputError(str(path), f"is damaged: its tables do not hang together ({fault!r})",
                         "a study's store, as `fesloop study` writes it") from None


class _Outcome(NamedTuple):
    """What came of a run."""

    status: str
    cause: str
    metrics: dict[str, Any]
    wall_s: float
    recording: str


def _outcome(row: tuple[Any, ...]) -> _Outcome:
    _, status, cause, metrics, wall_s, recording = row
    if status not in (DONE, FAILED):
        raise ValueError(f"status {status!r}")
    return _Outcome(status, cause or "", json.loads(metrics) if status == DONE and metrics else {},
                    math.nan if wall_s is None else float(wall_s), recording or "")


def _columns(
    rows: StoreRows, places: dict[str, NDArray[np.int64]], declared: Sequence[str]
) -> RunColumns:
    results = [_outcome(row) for row in rows.results]
    names = dict.fromkeys([*declared, *(name for result in results for name in result.metrics)])
    # What is not over yet reads from one row more, at the end.
    results.append(_Outcome(WAITING, "", {}, math.nan, ""))
    of_id = {row[0]: i for i, row in enumerate(rows.results)}
    found = np.array([of_id.get(id_, -1) for *_, id_ in rows.runs], dtype=np.int64)
    values = {name: np.array([_number(result.metrics.get(name)) for result in results])[found]
              for name in names}
    numbers = np.array([row[:3] for row in rows.runs], dtype=np.int64).reshape(-1, 3)
    return RunColumns(
        cell=numbers[:, 0], replicate=numbers[:, 1], seed=numbers[:, 2],
        id=_objects([row[3] for row in rows.runs]), places=places,
        status=_objects([result.status for result in results])[found],
        cause=_objects([result.cause for result in results])[found],
        values=values, wall_s=np.array([result.wall_s for result in results])[found],
        recording=_objects([result.recording for result in results])[found])


def _number(value: Any) -> float:
    """Of a metric; NaN where the run had none."""
    return math.nan if value is None else float(value)


def _objects(texts: list[str]) -> Column:
    """Text as objects: an array of text of fixed length would make room for its longest in each row."""
    made = np.empty(len(texts), dtype=object)
    made[:] = texts
    return made
