"""What is read from a recording: signals with their stamps, and events."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.recording.signal_table import StoredRows


@dataclass(frozen=True, slots=True, eq=False)
class Signal:
    """One signal of one trial.

    Attributes
    ----------
    name, unit: as the experiment names it ("finger.angles"), and SI.
    indices: (n,), number of the tick; of the row for a plant.
    times_ns: (n,), when each value was put out or recorded.
    values: (n, *shape of the port).
    oldest_ns, newest_ns: (n,), oldest and newest capture that each value derives from.
    left_ns: (n,), when a block's value left it; `times_ns` for a plant.
    """

    name: str
    unit: str
    indices: NDArray[np.int64]
    times_ns: NDArray[np.int64]
    values: NDArray[np.float64]
    oldest_ns: NDArray[np.int64]
    newest_ns: NDArray[np.int64]
    left_ns: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened to a node or a wire in a run."""

    trial: int
    time_ns: int
    where: str
    status: str
    detail: str


def reached_ns(times_ns: NDArray[np.int64]) -> int:
    """Up to where rows at these instants (n,) tell, ns: the last stands as long as the one before it.

    Instants are rounded down to whole ns, which can leave the end of a trial 1 ns short: that is added. 0 of
    fewer than two rows.
    """
    return 2 * int(times_ns[-1]) - int(times_ns[-2]) + 1 if times_ns.size > 1 else 0


def signal_of(name: str, field: str, rows: StoredRows, first: int, stop: int) -> Signal:
    """One field of a stream's rows `first` to `stop`, with their stamps."""
    read = partial(rows.read, first=first, stop=stop)
    names = rows.dtype.names or ()
    times, values = read("time_ns"), read(field)
    left = read("left_ns") if "left_ns" in names else times
    if "captured_ns" in names:
        oldest = newest = read("captured_ns")
    else:
        oldest, newest = read("oldest_ns"), read("newest_ns")
    indices = read("index") if "index" in names else np.arange(len(times))
    return Signal(name, rows.units[field], indices, times, values, oldest, newest, left)
