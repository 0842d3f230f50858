"""Signals that share their instants, side by side, read a piece at a time: for runs of any length."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.recording.stored_rows import StoredRows

Stamps = NDArray[np.int64]
_PIECE_BYTES = 2**20
"""What a piece takes at most, unless a row alone is longer (chosen: HDF5 keeps 1 MB of chunks)."""


@dataclass(frozen=True, slots=True)
class TableSignal:
    """A signal of a table.

    Attributes
    ----------
    name: "finger.angles".
    unit, shape: of its port.
    rows: names of its rows, as its port states them; empty where it does not.
    pairs: (parent, child) rows of sensors on neighbouring segments.
    """

    name: str
    unit: str
    shape: tuple[int, ...]
    rows: tuple[str, ...] = ()
    pairs: tuple[tuple[int, int], ...] = ()

    @property
    def named_pairs(self) -> tuple[tuple[str, str], ...]:
        """`pairs` by the names of the rows."""
        return tuple((self.rows[parent], self.rows[child]) for parent, child in self.pairs)

    @property
    def node(self) -> str:
        """The block or plant that puts it out, or takes it in."""
        return self.name.partition(".")[0]

    @property
    def port(self) -> str:
        """Its port's name."""
        return self.name.partition(".")[2]


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """Consecutive rows of a table; stamps (n,), ns, as those of `Signal`; values a signal, (n, *shape)."""

    indices: Stamps
    times_ns: Stamps
    left_ns: Stamps
    oldest_ns: Stamps
    newest_ns: Stamps
    values: tuple[NDArray[np.float64], ...]


class SignalTable:
    """Rows of a trial; as many as there are when it is made, also if more are written later.

    Parameters
    ----------
    rows: of the node's dataset.
    fields: name in the dataset and name of each signal.
    trial: counted from 0.
    """

    def __init__(self, rows: StoredRows, fields: dict[str, str], trial: int) -> None:
        self._rows, self._fields = rows, tuple(fields)
        self._first, self._stop = rows.span(trial)
        self.trial = trial
        self.signals = tuple(TableSignal(name, rows.units[field], rows.dtype[field].shape,
                                         rows.names.get(field, ()), rows.pairs.get(field, ()))
                             for field, name in fields.items())

    @property
    def count(self) -> int:
        """How many rows there are."""
        return self._stop - self._first

    def times_ns(self) -> Stamps:
        """When each row's values were put out or recorded, (n,)."""
        return self._rows.read("time_ns", self._first, self._stop)

    def pieces(self) -> Iterator[Piece]:
        """All rows, in their order, in pieces of about a megabyte; none where there is no row."""
        length = max(1, _PIECE_BYTES // self._rows.dtype.itemsize)
        for first in range(self._first, self._stop, length):
            yield self._piece(first, min(first + length, self._stop))

    def _piece(self, first: int, stop: int) -> Piece:
        read, names = self._rows.read, self._rows.dtype.names or ()
        times = read("time_ns", first, stop)
        left = read("left_ns", first, stop) if "left_ns" in names else times
        if "captured_ns" in names:
            oldest = newest = read("captured_ns", first, stop)
        else:
            oldest, newest = read("oldest_ns", first, stop), read("newest_ns", first, stop)
        indices = (read("index", first, stop) if "index" in names
                   else np.arange(first - self._first, stop - self._first))
        values = tuple(read(field, first, stop) for field in self._fields)
        return Piece(indices, times, left, oldest, newest, values)
