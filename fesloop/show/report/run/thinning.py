"""Thinned signals over time, read from the file in pieces, for runs of any length."""


from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.metrics.joints import columns
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_S
from fesloop.show.report.parts import Line

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]
POINTS = 600
"""Most points of a line (chosen: about the width of a chart in pixels)."""
FEWER_POINTS = 300
"""Most points of a line in a fold (chosen: there are many lines)."""


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """Signal over one trial, with neighbouring rows merged into points.

    Attributes
    ----------
    seconds: (m,), when each point begins. mean: (m, *shape), of its rows that are finite; NaN for none.
    low, high: (m, *shape), extremes of its rows; None where every row is a point of its own.
    first: (m, *shape), its first row; None as above. rows: of a point.
    """

    seconds: Array
    mean: Array
    low: Array | None
    high: Array | None
    first: Array | None = None
    rows: int = 1

    def columns(self) -> Course:
        """Course of vectors; a number becomes a vector of one component."""
        low, high, first = (None if each is None else columns(each)
                            for each in (self.low, self.high, self.first))
        return Course(self.seconds, columns(self.mean), low, high, first, self.rows)

    def line(self, name: str, role: str, at: int | tuple[int, ...] = (), factor: float = 1.0,
             style: str = "line") -> Line:
        """Line of one component, multiplied by `factor` > 0.

        The mean of what is held in steps, such as pulses, may be a value that never was: of "steps" each
        point is its first row.
        """
        where: tuple[Any, ...] = (slice(None), at) if isinstance(at, int) else (slice(None), *at)
        low, high = (None if each is None else factor * each[where] for each in (self.low, self.high))
        y = self.first if style == "steps" and self.first is not None else self.mean
        return Line(name=name, role=role, x=self.seconds, y=factor * y[where], low=low, high=high,
                    style=style, thinned=self.rows)


def course(recording: Recording, name: str, trial: int, points: int = POINTS) -> Course | None:
    """Signal of a trial in at most `points` points; None if it has no row in it.

    Raises InputError for a name that is not recorded, and for rows that the file lost.
    """
    (table,) = recording.tables([name], trial)
    return thinned(((piece.times_ns, piece.values[0]) for piece in table.pieces()), table.count, points)


def thinned(pieces: Iterable[tuple[Stamps, Array]], count: int, points: int = POINTS) -> Course | None:
    """Course made from pieces of rows: instants (n,), ns, and values (n, *shape); None without rows.

    Parameters
    ----------
    count: rows of all pieces together, or more.
    """
    per_point = max(1, -(-count // points))
    sums: Array | None = None
    first = 0
    for times, values in pieces:
        if not len(values):
            continue
        if sums is None:
            shape = (-(-count // per_point), *values.shape[1:])
            sums, known = np.zeros(shape), np.zeros(shape)
            low, high = np.full(shape, np.nan), np.full(shape, np.nan)
            begin, begun = np.full(shape[0], -1, np.int64), np.full(shape, np.nan)
        numbers = (first + np.arange(len(values))) // per_point
        edges = np.flatnonzero(np.diff(numbers, prepend=-1))
        rows = numbers[edges]
        finite = np.isfinite(values)
        sums[rows] += np.add.reduceat(np.where(finite, values, 0.0), edges)
        known[rows] += np.add.reduceat(finite.astype(np.float64), edges)
        low[rows] = np.fmin(low[rows], np.fmin.reduceat(values, edges))
        high[rows] = np.fmax(high[rows], np.fmax.reduceat(values, edges))
        new = begin[rows] < 0
        begin[rows[new]], begun[rows[new]] = times[edges[new]], values[edges[new]]
        first += len(values)
    if sums is None:
        return None
    there = begin >= 0
    mean = np.divide(sums, known, out=np.full(sums.shape, np.nan), where=known > 0.0)[there]
    seconds = begin[there] / NS_PER_S
    if per_point == 1:
        return Course(seconds, mean, None, None)
    return Course(seconds, mean, low[there], high[there], begun[there], per_point)


def from_zero(lines: Sequence[Line]) -> tuple[float, float]:
    """Limits of an axis from 0 to a little above the greatest value of lines."""
    values = [line.y if line.high is None else line.high for line in lines]
    known = [float(each[np.isfinite(each)].max(initial=0.0)) for each in values]
    return 0.0, 1.05 * max(known, default=0.0) or 1.0
