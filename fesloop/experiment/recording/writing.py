"""Writer of recordings: one HDF5 file per run, readable at any time, even after the writer was killed.

In SWMR mode ("single writer, multiple readers") HDF5 orders its writes so that readers of the file see
everything up to the last flush. Nothing can be created in that mode, so every dataset is made at the
start, with its trial as a column:

    blocks/NODE         a row a step: trial, index, time_ns, left_ns, oldest_ns, newest_ns, each output
    plants/NODE         a row an instant of the recorder: trial, time_ns, captured_ns, each output
    inputs/NODE/PORT    a row a change of a plant input: trial, time_ns, oldest_ns, newest_ns, value
    events              trial, time_ns, where, status, detail
    messages            a row a trial and wire: trial, wire, sent, lost, late
    experiment          the experiment with every parameter resolved, as JSON; `fingerprint` is its SHA-256
    wall/step_ns/NODE   how long each step of a timed block took
    wall/instants       of a run in real time, a row an instant: trial, time_ns, late_ns, took_ns, action
    wall/origins        and of each trial when t = 0 was: trial, monotonic_ns, utc_ns
    status              running, done, failed or interrupted
    wall                what depends on the machine and the hour, and is no part of the digest
"""

from __future__ import annotations

import itertools
import json
import platform
import re
import secrets
import shutil
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from pathlib import Path
from time import perf_counter_ns
from typing import Any

import h5py
import numpy as np

from fesloop.errors import InputError, RunError
from fesloop.experiment.recording.form import (
    BLOCK_STAMPS,
    EVENT,
    INPUT_STAMPS,
    INSTANTS,
    MESSAGES,
    ORIGINS,
    PLANT_STAMPS,
    Rows,
    block_rows,
    event_rows,
    input_rows,
    instant_rows,
    plant_rows,
)
from fesloop.experiment.specification import ExperimentSpecification
from fesloop.given_files import is_folder
from fesloop.loop.block import Block, Tick
from fesloop.loop.nodes import Node
from fesloop.loop.realtime import Pacer
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port, Sample, Value
from fesloop.loop.wiring import Wiring

ROOM_BYTES = 2**24
"""Space left free on the disk (chosen): chunks are written whole, and the end of a run must be noted."""
_CHUNK_CACHE_BYTES = 2**17
"""Chunk cache of each dataset: the chunk that grows, and some more. HDF5 by itself keeps up to 8 MB of each,
which are never read again, so that a run would grow for minutes."""


_END_OF_FILE = 28
"""Offset in the superblock of the length of the file."""


def require_folder_name(folder: Path) -> None:
    """Raise InputError for a folder that does not exist and has the name of a recording."""
    if folder.suffix.lower() in (".h5", ".hdf5") and not is_folder(folder):
        raise InputError(f"--out {folder}", "has the name of a file",
                         "a folder: the recording in it is named after the experiment",
                         f"give --out {folder.with_suffix('')}")


def draft_file(folder: Path, name: str) -> tuple[Path, h5py.File]:
    """Create a file under a hidden name, for as long as it cannot be read."""
    draft = folder / f".{name}-{secrets.token_hex(8)}.h5"
    try:
        free = free_bytes(folder)
        if free < ROOM_BYTES:
            raise InputError(f"--out {folder}", f"the disk is full, {free / 1e6:.0f} MB are left",
                             f"{ROOM_BYTES / 1e6:.0f} MB or more", "make room, or give another folder")
        folder.mkdir(parents=True, exist_ok=True)
        return draft, h5py.File(draft, "w", libver="latest", rdcc_nbytes=_CHUNK_CACHE_BYTES)
    except OSError as fault:
        raise InputError(f"--out {folder}", f"no recording can be made there: {fault.strerror or fault}",
                         "a folder that can be written to") from None


def publish(draft: Path, folder: Path, name: str) -> Path:
    """Rename the draft to the first free name, in one step: no reader ever finds half a file."""
    for number in itertools.count(1):
        path = folder / f"{name}-{number}.h5"
        try:
            path.hardlink_to(draft)
        except FileExistsError:
            continue
        except OSError:  # a file system without links
            if path.exists():
                continue
            return draft.rename(path)
        draft.unlink()
        return path
    raise AssertionError("numbers do not end")


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn failures of HDF5 to write (a quota, a cable) into a RunError of one line."""
    try:
        yield
    except (OSError, RuntimeError) as fault:
        reason = re.search("error message = '([^']*)'", str(fault))
        raise RunError(f"{path}: cannot be written: {reason[1] if reason else fault}") from None


def append(file: h5py.File, tables: Sequence[tuple[h5py.Dataset, Rows]]) -> None:
    """Append rows to datasets and flush them."""
    for dataset, rows in tables:
        if len(rows):
            before = dataset.shape[0]
            dataset.resize(before + len(rows), axis=0)
            dataset[before:] = rows
    file.flush()


def lengthen(path: Path) -> None:
    """Pad a file whose end could not be written with zeros, without which HDF5 does not open it.

    The superblock has the length of the whole file (HDF5 File Format Specification 3.0, II.A, version 3).
    """
    with suppress(OSError), path.open("r+b") as file:
        file.seek(_END_OF_FILE)
        end = int.from_bytes(file.read(8), "little")
        if path.stat().st_size < end:
            file.truncate(end)


def free_bytes(path: Path) -> int:
    """Free space on the disk of a path that may not exist yet."""
    there = next(each for each in (path, *path.absolute().parents) if each.exists())
    return shutil.disk_usage(there).free


class TimedBlock:
    """A block that behaves as another one and times its steps.

    Attributes
    ----------
    durations_ns: of the steps so far, removed by their writer.
    """

    def __init__(self, block: Block) -> None:
        self.__wrapped__ = block
        self.durations_ns: list[int] = []

    def __getattr__(self, name: str) -> Any:
        # The other block has been made for its wires: made again, it would no longer be timed. Its steps are
        # timed one by one.
        if name.startswith("__") or name in ("resolve", "with_sensors", "steps_through"):
            raise AttributeError(name)
        return getattr(self.__wrapped__, name)

    def step(self, state: Any, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """The other block's step."""
        began = perf_counter_ns()
        outputs = self.__wrapped__.step(state, inputs, tick)
        self.durations_ns.append(perf_counter_ns() - began)
        return outputs


def timed(wiring: Wiring, names: Collection[str]) -> tuple[Wiring, dict[str, TimedBlock]]:
    """Replace the named blocks of a wiring by timed ones; return the wiring and these blocks by name."""
    if not names:
        return wiring, {}
    blocks = {node.name: TimedBlock(node.block) for node in wiring.nodes if node.name in names}
    nodes = [replace(node, part=blocks.get(node.name, node.part)) for node in wiring.nodes]
    return Wiring(nodes, [connection.wire for connection in wiring.connections], wiring.seed), blocks


FORMAT = "fesloop recording 1"
STATUS_TYPE = np.dtype("S16")
_PACKAGES = ("fesloop", "numpy", "scipy", "numba", "h5py", "vqf", "osqp", "daqp", "fmpy")


def describe(file: h5py.File, experiment: ExperimentSpecification) -> None:
    """Write all that is known before the first tick."""
    file.attrs["format"] = FORMAT
    file.attrs["name"] = experiment.name
    file.attrs["seed"] = experiment.seed
    file.attrs["fingerprint"] = experiment.fingerprint()
    file.attrs["versions"] = json.dumps(_versions())
    file.attrs["wires"] = json.dumps([wire.name for wire in experiment.wires])
    file.create_dataset("experiment", data=experiment.as_json())
    file.create_dataset("status", data=np.array(b"running", STATUS_TYPE))


def describe_wall(file: h5py.File, realtime: Mapping[str, str | float] | None) -> None:
    """Make the group of facts about machine and wall clock."""
    wall = file.create_group("wall")
    wall.attrs["started"] = datetime.now(UTC).isoformat(timespec="seconds")
    wall.attrs["machine"] = platform.platform()
    wall.attrs.update(realtime or {})
    for name in ("seconds", "worst_late_s", "worst_collection_ms", "worst_write_ms"):
        wall.create_dataset(name, data=0.0)
    for name in ("deadlines", "missed_deadlines", "collections"):
        wall.create_dataset(name, data=0)


@cache
def _versions() -> Mapping[str, str]:
    found = {"python": platform.python_version()}
    for package in _PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "absent"
    return found


_CHUNK_BYTES = 32768


class RecordingWriter:
    """The file of one run.

    Parameters
    ----------
    folder: where it goes; made if it is not there.
    experiment: what is recorded. The file is named after it and numbered, and none is overwritten.
    realtime: of a run in step with the wall clock, how that is done.

    Raises InputError if no file can be made there.
    """

    def __init__(self, folder: Path, experiment: ExperimentSpecification,
                 realtime: Mapping[str, str | float] | None = None) -> None:
        draft, self._file = draft_file(folder, experiment.name)
        try:
            self._make_datasets(experiment, realtime)
            self._file.swmr_mode = True
            self.path = publish(draft, folder, experiment.name)
        except BaseException:
            self._file.close()
            draft.unlink()
            raise

    def _make_datasets(
        self, experiment: ExperimentSpecification, realtime: Mapping[str, str | float] | None
    ) -> None:
        """Create every dataset of the file, empty."""
        describe(self._file, experiment)
        describe_wall(self._file, realtime)
        self._paced = None if realtime is None else (
            self._dataset("wall/instants", INSTANTS), self._dataset("wall/origins", ORIGINS))
        self._step_times = {name: self._dataset(f"wall/step_ns/{name}", np.dtype("<i8"))
                            for name in experiment.record.timed}
        wiring = experiment.wiring
        plants = [node for node in wiring.nodes if node.is_plant]
        self._kept = {node.name: [number for number, port in enumerate(node.part.outputs)
                                  if f"{node.name}.{port.name}" not in experiment.record.leave_out]
                      for node in wiring.nodes}
        self._blocks = {node.name: self._stream(f"blocks/{node.name}", BLOCK_STAMPS, self._ports(node))
                        for node in wiring.nodes if not node.is_plant}
        self._plants = {node.name: self._stream(f"plants/{node.name}", PLANT_STAMPS, self._ports(node))
                        for node in plants}
        self._inputs = {(node.name, number): self._input_stream(node.name, port)
                        for node in plants for number, port in enumerate(node.part.inputs)
                        if f"{node.name}.{port.name}" not in experiment.record.leave_out}
        self._events = self._dataset("events", EVENT)
        self._messages = self._dataset("messages", MESSAGES)
        self._full = False

    def _ports(self, node: Node) -> list[Port]:
        """The outputs that are recorded."""
        return [node.part.outputs[number] for number in self._kept[node.name]]

    def _stream(self, path: str, stamps: list[tuple[str, str]], ports: Sequence[Port]) -> h5py.Dataset:
        taken = [name for name, _ in stamps]
        for port in ports:
            if port.name in taken:
                raise InputError(path.replace("/", "."), f"an output is named {port.name!r}",
                                 f"none of {', '.join(taken)}", "rename the port")
        dataset = self._dataset(path, np.dtype([*stamps, *((p.name, "<f8", p.shape) for p in ports)]))
        dataset.attrs["units"] = json.dumps({port.name: port.unit for port in ports})
        dataset.attrs["rows"] = json.dumps({port.name: port.row_names for port in ports if port.row_names})
        dataset.attrs["pairs"] = json.dumps({port.name: port.sensors.pairs for port in ports
                                             if port.sensors is not None})
        return dataset

    def _input_stream(self, node: str, port: Port) -> h5py.Dataset:
        dtype = np.dtype([*INPUT_STAMPS, ("value", "<f8", port.shape)])
        dataset = self._dataset(f"inputs/{node}/{port.name}", dtype)
        dataset.attrs["units"] = json.dumps({"value": port.unit})
        return dataset

    def _dataset(self, path: str, dtype: np.dtype[Any]) -> h5py.Dataset:
        rows = max(1, _CHUNK_BYTES // dtype.itemsize)
        return self._file.create_dataset(path, shape=(0,), maxshape=(None,), chunks=(rows,), dtype=dtype)

    def write(self, recorder: Recorder, trial: int) -> None:
        """Append the rows of the recorder and flush them.

        Raises RunError where the disk has no room left; what comes after that is not written.
        """
        self._append(list(self._tables(recorder, trial)))

    def write_in_pieces(self, recorder: Recorder, trial: int) -> Iterator[None]:
        """Do the work of `write` in steps, a stream for each `next`; each takes some tenths of a ms."""
        for table in self._tables(recorder, trial):
            self._append([table])
            yield

    def _tables(self, recorder: Recorder, trial: int) -> Iterator[tuple[h5py.Dataset, Rows]]:
        """Rows that the recorder has now, stream by stream."""
        blocks, plants, inputs, events = recorder.drain()
        for name, rows in blocks.items():
            dataset = self._blocks[name]
            yield dataset, block_rows(dataset.dtype, rows, trial, self._kept[name])
        for name, stacks in plants.items():
            dataset = self._plants[name]
            yield dataset, plant_rows(dataset.dtype, stacks, trial, self._kept[name])
        for name, changes in inputs.items():
            for number in {row[1] for row in changes if (name, row[1]) in self._inputs}:
                dataset = self._inputs[name, number]
                yield dataset, input_rows(dataset.dtype, [row for row in changes if row[1] == number], trial)
        yield self._events, event_rows(events, trial)

    def _append(self, tables: Sequence[tuple[h5py.Dataset, Rows]]) -> None:
        """Append rows if there is space: HDF5 does not survive a failed write."""
        if self._full or not tables:
            return
        free = free_bytes(self.path)
        if free < ROOM_BYTES + sum(rows.nbytes for _, rows in tables):
            self._full = True
            raise RunError(f"{self.path}: the disk is full, {free / 1e6:.0f} MB are left; make room, or "
                           "record into another folder")
        try:
            with writing(self.path):
                append(self._file, tables)
        except RunError:
            self._full = True
            raise

    def write_step_times(self, blocks: Mapping[str, TimedBlock]) -> None:
        """Append the durations of the steps of timed blocks."""
        self._append([(self._step_times[name], np.array(block.durations_ns, np.int64))
                      for name, block in blocks.items()])
        for block in blocks.values():
            block.durations_ns.clear()

    def write_wall(self, pacer: Pacer, trial: int) -> None:
        """Append the instants of a trial in real time."""
        if self._paced is not None:
            instants, origins = self._paced
            begun = np.array([(trial, *origin) for origin in pacer.origins], ORIGINS)
            self._append([(instants, instant_rows(pacer.rows, trial)), (origins, begun)])
        pacer.rows.clear()
        pacer.origins.clear()

    def write_messages(self, loop: Loop) -> None:
        """Append the message counts of a trial that is over."""
        counts = loop.message_counts().values()
        rows = [(loop.trial, number, each["sent"], each["lost"], each["late"])
                for number, each in enumerate(counts)]
        self._append([(self._messages, np.array(rows, MESSAGES))])

    def close(self, status: str, seconds: float, realtime: Mapping[str, int | float] | None = None) -> None:
        """Write how the run ended and the statistics of real time, and close. RunError if that fails."""
        try:
            with writing(self.path):
                for name, value in {"seconds": seconds, **(realtime or {})}.items():
                    self._file["wall"][name][()] = value
                self._file["status"][()] = np.array(status.encode(), STATUS_TYPE)
                self._file.close()
        except RunError:
            lengthen(self.path)
            raise
