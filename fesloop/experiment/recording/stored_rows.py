"""Rows of a recording's datasets: of a short one all read at once and kept, of a long one those asked for."""

from __future__ import annotations

import json
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
        """Memory that kept rows take."""
        return 0 if self._kept is None else self._kept.nbytes

    @cached_property
    def units(self) -> dict[str, str]:
        """Of the ports among the fields."""
        told: dict[str, str] = json.loads(self._dataset.attrs["units"])
        return told

    @cached_property
    def names(self) -> dict[str, tuple[str, ...]]:
        """Names of the rows of ports that state them."""
        told = json.loads(self._dataset.attrs.get("rows", "{}"))
        return {port: tuple(names) for port, names in told.items()}

    @cached_property
    def pairs(self) -> dict[str, tuple[tuple[int, int], ...]]:
        """(parent, child) rows of ports whose rows are sensors that are known."""
        told = json.loads(self._dataset.attrs.get("pairs", "{}"))
        return {port: tuple((parent, child) for parent, child in pairs) for port, pairs in told.items()}

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
        """Values of a span of rows; a step is not honoured."""
        start, stop, _ = rows.indices(self.shape[0])
        return self._rows.read(self._field, self._first + start, self._first + max(start, stop))
