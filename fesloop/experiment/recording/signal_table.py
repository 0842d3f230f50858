"""Tables of signals that share their instants, read piece by piece for runs of any length."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.recording.form import undamaged

_ROWS_A_READ = 65536


class StoredRows:
    """A dataset of rows with named fields.

    Parameters
    ----------
    dataset: opened for reading; rows may still be added to it.
    room: bytes that its rows may take to be kept.

    Raises InputError for rows that the file lost, here and where they are read.
    """

    def __init__(self, dataset: h5py.Dataset, room: int) -> None:
        self._dataset = dataset
        self.count = int(dataset.shape[0])
        self.dtype: np.dtype[Any] = dataset.dtype
        short = self.count * self.dtype.itemsize <= room
        with undamaged(dataset.file.filename):
            self._kept: NDArray[Any] | None = dataset[:] if short else None

    @property
    def kept_bytes(self) -> int:
        """Size of the rows kept in memory, bytes."""
        return 0 if self._kept is None else self._kept.nbytes

    @cached_property
    def units(self) -> dict[str, str]:
        """Units of the ports among the fields."""
        units: dict[str, str] = json.loads(self._dataset.attrs["units"])
        return units

    @cached_property
    def names(self) -> dict[str, tuple[str, ...]]:
        """Names of the rows of ports that state them."""
        rows = json.loads(self._dataset.attrs.get("rows", "{}"))
        return {port: tuple(names) for port, names in rows.items()}

    @cached_property
    def pairs(self) -> dict[str, tuple[tuple[int, int], ...]]:
        """(parent, child) rows of ports whose rows are sensors that are known."""
        sensors = json.loads(self._dataset.attrs.get("pairs", "{}"))
        return {port: tuple((parent, child) for parent, child in pairs) for port, pairs in sensors.items()}

    def read(self, field: str, first: int, stop: int) -> NDArray[Any]:
        """One field of rows `first` to `stop`, an array of its own.

        HDF5 makes notes on every chunk of a read, so one read takes not too many.
        """
        if self._kept is not None:
            return self._kept[field][first:stop].copy()
        dtype, source = self.dtype[field], self._dataset.fields(field)
        values = np.empty((stop - first, *dtype.shape), dtype.base)
        for start in range(first, stop, _ROWS_A_READ):
            until = min(start + _ROWS_A_READ, stop)
            with undamaged(self._dataset.file.filename):
                values[start - first:until - first] = source[start:until]
        return values

    def span(self, trial: int) -> tuple[int, int]:
        """First row of a trial, and the row after its last."""
        begun, edges = self._begun
        first, after = np.searchsorted(begun, [trial, trial + 1])
        return int(edges[first]), int(edges[after])

    @cached_property
    def _begun(self) -> tuple[NDArray[Any], NDArray[np.int64]]:
        """Trials that have rows, and where their rows begin, the end of all behind them."""
        trials = self.read("trial", 0, self.count)
        first = np.flatnonzero(np.diff(trials, prepend=-1))
        return trials[first], np.append(first, self.count)


class Column:
    """Values of a signal, (n, *shape of the port), read from the file where they are sliced."""

    def __init__(self, rows: StoredRows, field: str, first: int, stop: int) -> None:
        self._rows, self._field, self._first = rows, field, first
        self.shape: tuple[int, ...] = (stop - first, *rows.dtype[field].shape)

    def __getitem__(self, rows: slice) -> NDArray[np.float64]:
        """Values of a span of rows; the step of the slice is ignored."""
        start, stop, _ = rows.indices(self.shape[0])
        return self._rows.read(self._field, self._first + start, self._first + max(start, stop))


Stamps = NDArray[np.int64]
_PIECE_BYTES = 2**20
"""Largest size of a piece, unless one row is longer (chosen: HDF5 keeps 1 MB of chunks)."""


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
        """Block or plant that the signal belongs to."""
        return self.name.partition(".")[0]

    @property
    def port(self) -> str:
        """Name of its port."""
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
    """Rows of a trial that exist when the table is made; rows written later are not included.

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
        """Number of rows."""
        return self._stop - self._first

    def times_ns(self) -> Stamps:
        """Instants at which the values were put out or recorded, (n,), ns."""
        return self._rows.read("time_ns", self._first, self._stop)

    def pieces(self) -> Iterator[Piece]:
        """All rows in order, in pieces of about a megabyte."""
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
