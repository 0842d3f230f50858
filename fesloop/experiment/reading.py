"""Reading a recording: signals with their stamps, events, and the digest of its content."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import h5py
import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError

_ROWS_A_READ = 65536
_STREAMS = ("blocks", "plants", "inputs")
_TABLES = ("events", "messages")


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


class Recording:
    """A run's file, opened for reading; also one that is being written, or whose writer was killed.

    Raises InputError for a file that is missing, damaged or no recording of fesloop.

    Attributes
    ----------
    path: of the file.
    experiment: tables of the experiment, every parameter resolved.
    name, seed, fingerprint, versions: of the run.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._file = _open(self.path)
        self.experiment: dict[str, Any] = json.loads(self._file["experiment"][()])
        self.name = str(self._file.attrs["name"])
        self.seed = int(self._file.attrs["seed"])
        self.fingerprint = str(self._file.attrs["fingerprint"])
        self.versions: dict[str, str] = json.loads(self._file.attrs["versions"])

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Let the file go."""
        self._file.close()

    @property
    def status(self) -> str:
        """done, failed, interrupted; running also stands in the file of a killed run."""
        return bytes(self._file["status"][()]).decode()

    @property
    def wall(self) -> dict[str, Any]:
        """Wall-clock facts: seconds, deadlines, missed_deadlines, worst_late_s, started, machine."""
        wall = self._file["wall"]
        numbers = {name: item[()].item() for name, item in wall.items() if isinstance(item, h5py.Dataset)}
        return {**numbers, **dict(wall.attrs)}

    @property
    def step_times_ns(self) -> dict[str, NDArray[np.int64]]:
        """How long each step of a timed block took, by block."""
        return {name: dataset[:] for name, dataset in self._file.get("wall/step_ns", {}).items()}

    @property
    def trials(self) -> int:
        """How many trials have been begun."""
        last = [dataset["trial"][-1] for _, dataset in self._datasets() if dataset.shape[0]]
        return int(max(last)) + 1 if last else 0

    @property
    def signals(self) -> list[str]:
        """Every output signal, as "node.port"."""
        found = []
        for kind in ("blocks", "plants"):
            for node, dataset in sorted(self._file.get(kind, {}).items()):
                found += [f"{node}.{port}" for port in json.loads(dataset.attrs["units"])]
        return found

    def signal(self, name: str, trial: int = 0) -> Signal:
        """An output signal, or what acted on a plant input, in one trial.

        Raises InputError for a name that is not recorded.
        """
        node, _, port = name.partition(".")
        for kind in ("blocks", "plants"):
            dataset = self._file.get(f"{kind}/{node}")
            if dataset is not None and port in json.loads(dataset.attrs["units"]):
                return _signal(name, port, dataset, trial)
        dataset = self._file.get(f"inputs/{node}/{port}")
        if dataset is None:
            raise InputError(f"{self.path}: {name}", "is not recorded", ", ".join(self.signals))
        return _signal(name, "value", dataset, trial)

    @property
    def events(self) -> list[Event]:
        """Everything out of the ordinary, in the order in which it happened."""
        return [Event(int(row["trial"]), int(row["time_ns"]), row["where"].decode(), row["status"].decode(),
                      row["detail"].decode(errors="replace")) for row in self._file["events"][:]]

    @property
    def messages(self) -> list[dict[str, dict[str, int]]]:
        """Messages sent, lost and late, by wire, for each trial that is over."""
        wires = json.loads(self._file.attrs["wires"])
        trials: list[dict[str, dict[str, int]]] = []
        for row in self._file["messages"][:]:
            while len(trials) <= row["trial"]:
                trials.append({})
            counts = {name: int(row[name]) for name in ("sent", "lost", "late")}
            trials[row["trial"]][wires[row["wire"]]] = counts
        return trials

    def digest(self) -> str:
        """SHA-256 of signals, stamps, statuses and experiment: all but what the wall clock left."""
        total = hashlib.sha256(self._file["experiment"][()])
        total.update(self.status.encode())
        for path, dataset in [*self._datasets(), *((name, self._file[name]) for name in _TABLES)]:
            total.update(f"{path} {dataset.dtype.descr} {dataset.shape}".encode())
            for start in range(0, dataset.shape[0], _ROWS_A_READ):
                total.update(dataset[start:start + _ROWS_A_READ].tobytes())
        return total.hexdigest()

    def _datasets(self) -> Iterator[tuple[str, h5py.Dataset]]:
        """Streams by path, in the order of their paths."""
        for kind in _STREAMS:
            group = self._file.get(kind, {})
            for name in sorted(group):
                if isinstance(group[name], h5py.Dataset):
                    yield f"{kind}/{name}", group[name]
                else:
                    yield from ((f"{kind}/{name}/{port}", group[name][port]) for port in sorted(group[name]))


def _signal(name: str, field: str, dataset: h5py.Dataset, trial: int) -> Signal:
    """One field of a stream's rows of a trial."""
    trials = dataset["trial"]
    first, stop = np.searchsorted(trials, [trial, trial + 1])
    rows = dataset[first:stop]
    times = rows["time_ns"]
    unit = json.loads(dataset.attrs["units"])[field]
    left = rows["left_ns"] if "left_ns" in rows.dtype.names else times
    if "captured_ns" in rows.dtype.names:
        oldest = newest = rows["captured_ns"]
    else:
        oldest, newest = rows["oldest_ns"], rows["newest_ns"]
    indices = rows["index"] if "index" in rows.dtype.names else np.arange(len(rows))
    return Signal(name, unit, indices, times, rows[field], oldest, newest, left)


def _open(path: Path) -> h5py.File:
    if not path.is_file():
        raise InputError(str(path), "there is no such recording", "a file that fesloop run wrote")
    try:
        file = _open_anyhow(path)
    except (OSError, RuntimeError) as fault:
        raise InputError(str(path), f"is no HDF5 file, or a damaged one: {fault}",
                         "a file that fesloop run wrote") from None
    if not str(file.attrs.get("format", "")).startswith("fesloop recording"):
        file.close()
        raise InputError(str(path), "is an HDF5 file, but no recording of fesloop",
                         "a file that fesloop run wrote")
    return file


def _open_anyhow(path: Path) -> h5py.File:
    """A file whose writer lives or was killed still says "open for write" and opens in SWMR mode only."""
    try:
        return h5py.File(path, "r")
    except OSError as fault:
        if not any(sign in str(fault) for sign in ("already open for", "unable to lock")):
            raise
    file = h5py.File(path, "r", swmr=True)
    needed, size = _end_of_data(file), path.stat().st_size
    if needed > size:
        file.close()
        raise OSError(f"cut short: {size} bytes of {needed}")
    return file


def _end_of_data(file: h5py.File) -> int:
    """Where the last chunk ends: in SWMR mode HDF5 itself does not look for a missing end."""
    ends = [0]

    def note(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.chunks:
            item.id.chunk_iter(lambda chunk: ends.append(chunk.byte_offset + chunk.size))

    file.visititems(note)
    return max(ends)
