"""Values of recorded signals at given instants, and thinned over time, for runs of any length."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
Instants = NDArray[np.int64]
_POINTS = 2000
"""Most spans of a curve in a picture: finer than its pixels."""
_ROWS_A_READ = 65536
_NEAR, _ROWS_OF_FEW = 256, 8192
"""Rows this near are read with those between them, and so many at most (measured: a read takes .2 to 1 ms,
which is as long as some hundreds of rows take)."""


class Signals(Protocol):
    """Source of signals: a recording, or one that is still being written."""

    @property
    def signals(self) -> Sequence[str]:
        """Every output signal, as "node.port"."""

    def column(self, name: str, trial: int = 0) -> tuple[Instants, Any]:
        """Instants (n,) of a signal in a trial, ns, and its values (n, *shape), which can be sliced."""


class Described(Signals, Protocol):
    """Source of signals that comes with its experiment."""

    @property
    def experiment(self) -> Mapping[str, Any]:
        """Document of the experiment."""


def values_at(recording: Signals, name: str, trial: int, at_ns: Instants) -> Array | None:
    """Values (len(at_ns), *shape) of a signal, held since its last sample; None where it has no samples.

    Instants before the first sample get its value.

    Raises InputError for a name that is not recorded.
    """
    times, column = recording.column(name, trial)
    if not times.size:
        return None
    rows = np.clip(np.searchsorted(times, at_ns, side="right") - 1, 0, None)
    distinct, places = np.unique(rows, return_inverse=True)
    ends = np.flatnonzero(np.append(np.diff(distinct) > _NEAR, True)) + 1
    return np.concatenate([piece for first, stop in zip([0, *ends], ends, strict=False)
                           for piece in _picked(column, distinct[first:stop])])[places]


def _picked(column: Any, rows: Instants) -> Iterator[Array]:
    """Values of ascending rows near each other, read a span at a time."""
    while rows.size:
        within = int(np.searchsorted(rows, rows[0] + _ROWS_OF_FEW))
        span = column[int(rows[0]):int(rows[within - 1]) + 1]
        yield span[rows[:within] - rows[0]]
        rows = rows[within:]


def span_ns(recording: Recording, name: str, trial: int) -> tuple[int, int] | None:
    """First and last instant of a signal in a trial; None where there is none."""
    times, _ = recording.column(name, trial)
    return (int(times[0]), int(times[-1])) if times.size else None


def curve(recording: Recording, name: str, trial: int, until_ns: int) -> tuple[Array, Array]:
    """Instants (n,), s, and values (n, *shape) of a signal, thinned so that no peak is lost.

    Of each of many spans a long signal keeps the lowest and the highest value of every component.
    """
    times, column = recording.column(name, trial)
    stop = int(np.searchsorted(times, until_ns, side="right"))
    per_span = max(1, stop // _POINTS)
    if per_span == 1:
        return times[:stop] / NS_PER_S, column[:stop]
    seconds: list[Array] = []
    values: list[Array] = []
    whole = max(1, _ROWS_A_READ // per_span) * per_span
    for start in range(0, stop, whole):
        rows = column[start:min(start + whole, stop)]
        for first in range(0, len(rows), per_span):
            span = rows[first:first + per_span]
            seconds.append(np.repeat(times[start + first] / NS_PER_S, 2))
            values.append(np.stack([span.min(axis=0), span.max(axis=0)]))
    return np.concatenate(seconds), np.concatenate(values)


def first_recorded(recording: Recording, names: Sequence[str]) -> str:
    """The first of these signals that is recorded; empty for none."""
    return next((name for name in names if name in recording.signals), "")
