"""Reader of recordings: signals with their stamps, events, and the digest of the content."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import h5py
import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.experiment.recording.form import (
    ALLOWED,
    INSTANTS,
    ORIGINS,
    require_form,
    require_tables,
    undamaged,
)
from fesloop.given_files import is_file
from fesloop.loop.clock import FOREVER
from fesloop.streams.hdf5 import require_sound_heaps

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import DataArray

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
    rows: names of the rows of a value, such as joints or muscles, as its port states them; empty where it
        does not.
    """

    name: str
    unit: str
    indices: NDArray[np.int64]
    times_ns: NDArray[np.int64]
    values: NDArray[np.float64]
    oldest_ns: NDArray[np.int64]
    newest_ns: NDArray[np.int64]
    left_ns: NDArray[np.int64]
    rows: tuple[str, ...] = ()

    def to_dataframe(self, *, degrees: bool = False, stamps: bool = False) -> DataFrame:
        """The signal as a pandas DataFrame: a row for each value, its index `time_s`.

        Columns are named by the rows of a value and, where these are vectors, quaternions or pulses, their
        components ("F2d.x"); `frame.attrs` has the signal's name and unit.

        Parameters
        ----------
        degrees: give rad and rad/s as deg and deg/s.
        stamps: add the columns captured_oldest_s, captured_newest_s and left_s.

        Raises InputError where pandas is not installed.
        """
        from fesloop.experiment.recording.frames import signal_frame

        return signal_frame(self, degrees=degrees, stamps=stamps)

    def to_xarray(self, *, degrees: bool = False) -> DataArray:
        """The signal as an xarray DataArray over time_s, row and component, with its stamps as coordinates.

        `degrees` as in `to_dataframe`. Raises InputError where xarray is not installed.
        """
        from fesloop.experiment.recording.frames import signal_array

        array: DataArray = signal_array(self, degrees=degrees)
        return array


class Extent(NamedTuple):
    """Unit of a signal, shape of its values, how many there are, and the first and last instant, ns."""

    unit: str
    shape: tuple[int, ...]
    values: int
    first_ns: int
    last_ns: int


@dataclass(frozen=True, slots=True)
class Event:
    """An event of a node or a wire in a run."""

    trial: int
    time_ns: int
    where: str
    status: str
    detail: str


def reached_ns(times_ns: NDArray[np.int64]) -> int:
    """End of the time that rows at instants (n,) cover, ns: the last lasts as long as the one before it.

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
    return Signal(name, rows.units[field], indices, times, values, oldest, newest, left,
                  rows.names.get(field, ()))


_ATTEMPTS, _BETWEEN_S = 3, 0.02
"""Attempts to open a file that is too short, and the time between them (chosen: writers need less)."""


def open_file(path: Path) -> h5py.File:
    """Open a file for reading; InputError for one that is missing, damaged or no recording."""
    if not is_file(path):
        raise InputError(str(path), "there is no such recording", ALLOWED)
    try:
        require_sound_heaps(path)
        file = _open_anyhow(path)
    except (OSError, RuntimeError) as fault:
        raise InputError(str(path), f"is no HDF5 file, or a damaged one: {fault}", ALLOWED) from None
    try:
        with undamaged(path):
            form = str(file.attrs.get("format", ""))
        if not form.startswith("fesloop recording"):
            raise InputError(str(path), "is an HDF5 file, but no recording of fesloop", ALLOWED)
        require_form(file, path)
    except InputError:
        file.close()
        raise
    return file


def _open_anyhow(path: Path) -> h5py.File:
    """Open a file, in SWMR mode if its writer lives or was killed."""
    try:
        return _open_when_long_enough(path)
    except OSError as fault:
        if not any(sign in str(fault) for sign in ("already open for", "unable to lock")):
            raise
    file = h5py.File(path, "r", swmr=True)
    needed, size = _end_of_data(file), path.stat().st_size
    if needed > size:
        file.close()
        raise OSError(f"cut short: {size} bytes of {needed}")
    return file


def _open_when_long_enough(path: Path) -> h5py.File:
    """Wait for a file to become as long as its writer has announced."""
    for _ in range(_ATTEMPTS):
        try:
            return h5py.File(path, "r")
        except OSError as fault:
            if "truncated file" not in str(fault):
                raise
        time.sleep(_BETWEEN_S)
    return h5py.File(path, "r")


def _end_of_data(file: h5py.File) -> int:
    """End of the last chunk, which HDF5 itself does not check in SWMR mode."""
    ends = [0]

    def note(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.chunks:
            item.id.chunk_iter(lambda chunk: ends.append(chunk.byte_offset + chunk.size))

    file.visititems(note)
    return max(ends)


__all__ = ["Event", "Recording", "Signal"]
_KEPT_BYTES = 2**21
"""Most bytes of rows kept in memory: reading a field of some rows from HDF5 takes 0.2 ms each time."""
_STREAMS = ("blocks", "plants", "inputs")
_TABLES = ("events", "messages")


class Recording:
    """The recording of a run, opened for reading, also while it is written or after its writer was killed.

    Raises InputError for a file that is missing, damaged or no recording of fesloop.

    Attributes
    ----------
    path: of the file.
    experiment: tables of the experiment, every parameter resolved.
    name, seed, fingerprint, versions: of the run.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._file = open_file(self.path)
        self._rows: dict[str, StoredRows] = {}
        self.experiment: dict[str, Any] = self._read_experiment()
        self.name = str(self._file.attrs["name"])
        self.seed = int(self._file.attrs["seed"])
        self.fingerprint = str(self._file.attrs["fingerprint"])
        self.versions: dict[str, str] = json.loads(self._file.attrs["versions"])

    def _read_experiment(self) -> dict[str, Any]:
        """Tables of the experiment; the file is closed where they are damaged."""
        try:
            with undamaged(f"{self.path}: experiment"):
                document = json.loads(self._file["experiment"][()])
            return require_tables(document, f"{self.path}: experiment")
        except InputError:
            self.close()
            raise

    def _values(self, path: str) -> Any:
        """All values of a dataset; InputError where the file has lost them."""
        with undamaged(self.path):
            return self._file[path][()]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    @property
    def closed(self) -> bool:
        """Whether the file is closed, so that no signal can be read."""
        return not self._file

    def __repr__(self) -> str:
        return f"Recording({str(self.path)!r}){' (closed)' if self.closed else ''}"

    def __str__(self) -> str:
        from fesloop.experiment.shown import recording_tables
        from fesloop.tables import as_text

        return as_text(recording_tables(self))

    def _repr_html_(self) -> str:
        from fesloop.experiment.shown import recording_tables
        from fesloop.tables import as_html

        return as_html(recording_tables(self))

    @property
    def status(self) -> str:
        """Status: done, failed or interrupted; running also after a run that was killed."""
        return bytes(self._values("status")).decode(errors="replace")

    @property
    def wall(self) -> dict[str, Any]:
        """Wall-clock facts: seconds, deadlines, missed_deadlines, worst_late_s, started, machine.

        Of a run in real time also policy, period_ms, memory, scheduling, collections, worst_collection_ms,
        worst_write_ms.
        """
        with undamaged(self.path):
            return self._read_wall()

    def _read_wall(self) -> dict[str, Any]:
        wall = self._file["wall"]
        scalars = {name: item for name, item in wall.items()
                   if isinstance(item, h5py.Dataset) and item.shape == ()}
        for name, item in scalars.items():
            if item.dtype.kind not in "biuf":
                raise InputError(f"{self.path}: wall/{name}", "is no number", ALLOWED)
        numbers = {name: item[()].item() for name, item in scalars.items()}
        return {**numbers, **dict(wall.attrs)}

    @property
    def step_times_ns(self) -> dict[str, NDArray[np.int64]]:
        """Duration of each step of the timed blocks, ns, by block."""
        with undamaged(self.path):
            return {name: dataset[:] for name, dataset in self._file.get("wall/step_ns", {}).items()}

    @property
    def instants(self) -> NDArray[np.void]:
        """Instants of a run in real time, a row each, all trials; no rows for other runs.

        Fields: trial; time_ns; late_ns, by how much its work began late; took_ns, how long that took; action:
        kept, run late, skipped or stopped.
        """
        paced = "wall/instants" in self._file
        rows: NDArray[np.void] = self._values("wall/instants") if paced else np.empty(0, INSTANTS)
        return rows

    @property
    def origins(self) -> NDArray[np.void]:
        """Wall-clock time of t = 0 of each trial of a run in real time; no rows for other runs.

        Fields: trial; monotonic_ns, by the machine's monotonic clock; utc_ns, since 1970.
        """
        paced = "wall/origins" in self._file
        rows: NDArray[np.void] = self._values("wall/origins") if paced else np.empty(0, ORIGINS)
        return rows

    @property
    def trials(self) -> int:
        """Number of trials that have begun."""
        every = [self._rows_of(path) for path in self._datasets]
        last = [int(rows.read("trial", rows.count - 1, rows.count)[0]) for rows in every if rows.count]
        begun = max(last, default=-1) + 1
        if begun > sum(rows.count for rows in every):
            raise InputError(str(self.path), f"is damaged: {begun} trials in fewer rows", ALLOWED)
        return begun

    @property
    def signals(self) -> list[str]:
        """Every output signal, as "node.port"."""
        return list(self.units)

    @cached_property
    def units(self) -> dict[str, str]:
        """Unit of every output signal, by "node.port"."""
        return {f"{node}.{port}": unit for kind in ("blocks", "plants")
                for node, dataset in sorted(self._file.get(kind, {}).items())
                for port, unit in json.loads(dataset.attrs["units"]).items()}

    @property
    def inputs(self) -> list[str]:
        """Every plant input whose values are recorded, unless an output has its name."""
        outputs = set(self.signals)
        names = [path.removeprefix("inputs/").replace("/", ".") for path in self._datasets
                 if path.startswith("inputs/")]
        return [name for name in names if name not in outputs]

    def signal(self, name: str, trial: int = 0) -> Signal:
        """An output signal, or the values of a plant input, in one trial.

        Raises InputError for a name that is not recorded, or a trial that never began.
        """
        rows, field = self._stream(name)
        return signal_of(name, field, rows, *self._span(rows, trial))

    def extent(self, name: str, trial: int = 0) -> Extent:
        """Unit, shape, number of values, and first and last instant of a signal, without reading its values.

        Raises InputError as `signal` does.
        """
        rows, field = self._stream(name)
        first, stop = self._span(rows, trial)
        first_ns, last_ns = (int(rows.read("time_ns", row, row + 1)[0]) if stop > first else 0
                             for row in (first, stop - 1))
        return Extent(rows.units[field], rows.dtype[field].shape, stop - first, first_ns, last_ns)

    def column(self, name: str, trial: int = 0, after_ns: int = 0,
               until_ns: int = FOREVER) -> tuple[NDArray[np.int64], Column]:
        """Instants (n,) of a signal from `after_ns` to `until_ns`; its values, left in the file until sliced.

        For signals of any length. Raises InputError as `signal` does.
        """
        rows, field = self._stream(name)
        first, stop = self._span(rows, trial)
        times = rows.read("time_ns", first, stop)
        late, end = np.searchsorted(times, after_ns), np.searchsorted(times, until_ns, side="right")
        return times[late:end], Column(rows, field, first + int(late), first + int(end))

    def _span(self, rows: StoredRows, trial: int) -> tuple[int, int]:
        """First row of a trial, and the row after its last; of a run without any trial, none."""
        first, stop = rows.span(trial)
        if first == stop and (begun := self.trials) and trial not in range(begun):
            raise InputError(f"{self.path}: trial", f"{trial}", f"0 to {begun - 1}")
        return first, stop

    def tables(self, names: Sequence[str], trial: int = 0) -> list[SignalTable]:
        """The named signals of a trial, those of one node side by side; a plant's input has its own table.

        Raises InputError for a name that is not recorded.
        """
        fields: dict[StoredRows, dict[str, str]] = {}
        for name in names:
            rows, field = self._stream(name)
            fields.setdefault(rows, {})[field] = name
        return [SignalTable(rows, of_rows, trial) for rows, of_rows in fields.items()]

    def _stream(self, name: str) -> tuple[StoredRows, str]:
        """Rows and field of a signal."""
        node, _, port = name.partition(".")
        for path in (f"blocks/{node}", f"plants/{node}"):
            if path in self._datasets and port in self._rows_of(path).units:
                return self._rows_of(path), port
        path = f"inputs/{node}/{port}"
        if path not in self._datasets:
            raise InputError(f"{self.path}: {name}", "is not recorded", ", ".join(self.signals),
                             did_you_mean(name, self.signals))
        return self._rows_of(path), "value"

    def _rows_of(self, path: str) -> StoredRows:
        """Rows of a dataset, cached until some are added."""
        known, dataset = self._rows.get(path), self._datasets[path]
        if known is None or known.count != dataset.shape[0]:
            room = _KEPT_BYTES - sum(rows.kept_bytes for rows in self._rows.values())
            known = self._rows[path] = StoredRows(dataset, room)
        return known

    @property
    def events(self) -> list[Event]:
        """All events, in the order in which they happened."""
        texts = ("where", "status", "detail")
        events = [Event(int(row["trial"]), int(row["time_ns"]),
                        *(row[name].decode(errors="replace") for name in texts))
                  for row in self._values("events")]
        # A plant is advanced when its outputs are read, and reports only then.
        return sorted(events, key=lambda event: (event.trial, event.time_ns))

    def events_frame(self) -> DataFrame:
        """All events as a pandas DataFrame: trial, time_s, where, status, detail.

        Raises InputError where pandas is not installed.
        """
        from fesloop.experiment.recording.frames import event_frame

        return event_frame(self.events)

    @property
    def messages(self) -> list[dict[str, dict[str, int]]]:
        """Messages sent, lost and late, by wire, for each trial that is over."""
        wires, begun = json.loads(self._file.attrs["wires"]), self.trials
        trials: list[dict[str, dict[str, int]]] = []
        for row in self._values("messages"):
            if not (0 <= row["trial"] < begun and 0 <= row["wire"] < len(wires)):
                raise InputError(f"{self.path}: messages", "is damaged", ALLOWED)
            while len(trials) <= row["trial"]:
                trials.append({})
            counts = {name: int(row[name]) for name in ("sent", "lost", "late")}
            trials[row["trial"]][wires[row["wire"]]] = counts
        return trials

    def digest(self) -> str:
        """SHA-256 of signals, stamps, statuses and experiment: all but what the wall clock left."""
        total = hashlib.sha256(self._values("experiment"))
        total.update(self.status.encode())
        for path, dataset in [*self._datasets.items(), *((name, self._file[name]) for name in _TABLES)]:
            total.update(f"{path} {dataset.dtype.descr} {dataset.shape}".encode())
            for start in range(0, dataset.shape[0], _ROWS_A_READ):
                with undamaged(self.path):
                    total.update(dataset[start:start + _ROWS_A_READ].tobytes())
        return total.hexdigest()

    @cached_property
    def _datasets(self) -> dict[str, h5py.Dataset]:
        """Streams by path, in the order of their paths: all that a file will have, it has from the start."""
        found = {}
        for kind in _STREAMS:
            for name, item in sorted(self._file.get(kind, {}).items()):
                if isinstance(item, h5py.Dataset):
                    found[f"{kind}/{name}"] = item
                else:
                    found |= {f"{kind}/{name}/{port}": dataset for port, dataset in sorted(item.items())}
        return found
