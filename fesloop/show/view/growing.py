"""The newest rows of a recording that is being written, as signals; what is old is forgotten."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.experiment.recording.form import undamaged

Instants = NDArray[np.int64]
_MOST_ROWS = 4000
"""Rows of a stream that are kept and, after a while unwatched, read (chosen: 4 s of a plant at 1000 Hz)."""


class GrowingStream:
    """Rows of one node as they are added, the newest of them in memory."""

    def __init__(self, dataset: h5py.Dataset) -> None:
        self._dataset = dataset
        self._read = max(0, int(dataset.shape[0]) - _MOST_ROWS)
        self.rows: NDArray[Any] = np.empty(0, dataset.dtype)

    def refresh(self) -> bool:
        """Read what was added; whether anything was."""
        self._dataset.refresh()
        count = int(self._dataset.shape[0])
        if count <= self._read:
            return False
        added = self._dataset[max(self._read, count - _MOST_ROWS):count]
        self.rows = np.concatenate([self.rows, added])[-_MOST_ROWS:]
        self._read = count
        return True


class GrowingRecording:
    """Signals of a file under single writer, multiple readers (SWMR); see
    `fesloop.show.picture.held.Signals`.

    Parameters
    ----------
    path: of the recording.
    nodes: blocks and plants whose outputs are wanted.

    Raises InputError where the file cannot be opened so, here and where it is read.
    """

    def __init__(self, path: Path, nodes: Sequence[str]) -> None:
        self._path = path
        with undamaged(path):
            self._file = h5py.File(path, "r", swmr=True)
            self._streams = {node: GrowingStream(self._file[f"{kind}/{node}"]) for node in nodes
                             for kind in ("blocks", "plants") if f"{kind}/{node}" in self._file}
            self._status = self._file["status"]
            self._origins = self._file.get("wall/origins")
        self.signals = [f"{node}.{port}" for node, stream in self._streams.items()
                        for port in stream.rows.dtype.names or () if stream.rows.dtype[port].base == "<f8"]
        self.refresh()

    def refresh(self) -> bool:
        """Read what was added; whether anything was."""
        with undamaged(self._path):
            grown = [stream.refresh() for stream in self._streams.values()]
        return any(grown)

    def column(self, name: str, trial: int = 0) -> tuple[Instants, NDArray[np.float64]]:
        """Instants (n,), ns, and values (n, *shape) of the newest rows of a signal in a trial."""
        node, _, port = name.partition(".")
        if name not in self.signals:
            raise InputError(f"{self._path}: {name}", "is not recorded", ", ".join(self.signals))
        rows = self._streams[node].rows
        first, stop = np.searchsorted(rows["trial"], [trial, trial + 1])
        return rows["time_ns"][first:stop], rows[port][first:stop]

    def newest(self, names: Sequence[str]) -> tuple[int, int] | None:
        """Trial and instant, ns, up to which these signals are known, as far as they are known in that trial.

        The trial is the first signal's, which tells where the hand is; None while nothing of it is known.
        """
        ends = [(int(rows[-1]["trial"]), int(rows[-1]["time_ns"])) if len(rows) else (-1, 0)
                for rows in (self._streams[name.partition(".")[0]].rows for name in names)]
        trial = ends[0][0]
        return None if trial < 0 else min(end for end in ends if end[0] == trial)

    @property
    def status(self) -> str:
        """running, done, failed, interrupted."""
        with undamaged(self._path):
            self._status.refresh()
            return bytes(self._status[()]).decode(errors="replace")

    def origin_ns(self, trial: int) -> int | None:
        """When t = 0 of a trial was, by the monotonic clock; None of a run that is not in step with it."""
        if self._origins is None:
            return None
        with undamaged(self._path):
            self._origins.refresh()
            told = {int(row["trial"]): int(row["monotonic_ns"]) for row in self._origins[()]}
        return told.get(trial)

    def close(self) -> None:
        """Let the file go."""
        self._file.close()

