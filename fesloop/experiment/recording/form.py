"""Rows of recordings, and the check of an opened file against the form of a recording."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import Any, NotRequired

import h5py
import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError
from typing_extensions import TypedDict

from fesloop.errors import InputError
from fesloop.forms.toml import TomlError, plain_tables
from fesloop.loop.realtime import WallRow
from fesloop.loop.record import BlockRow, EventRow, InputRow, PlantRow
from fesloop.loop.signals import require_pairs
from fesloop.streams import hdf5

Rows = NDArray[np.void] | NDArray[np.int64]
_STAMP = [("trial", "<i4")]
BLOCK_STAMPS = [*_STAMP, ("index", "<i8"), ("time_ns", "<i8"), ("left_ns", "<i8"), ("oldest_ns", "<i8"),
                ("newest_ns", "<i8")]
PLANT_STAMPS = [*_STAMP, ("time_ns", "<i8"), ("captured_ns", "<i8")]
INPUT_STAMPS = [*_STAMP, ("time_ns", "<i8"), ("oldest_ns", "<i8"), ("newest_ns", "<i8")]
EVENT = np.dtype([*_STAMP, ("time_ns", "<i8"), ("where", "S64"), ("status", "S32"), ("detail", "S224")])
INSTANTS = np.dtype([*_STAMP, ("time_ns", "<i8"), ("late_ns", "<i8"), ("took_ns", "<i8"), ("action", "S8")])
ORIGINS = np.dtype([*_STAMP, ("monotonic_ns", "<i8"), ("utc_ns", "<i8")])
MESSAGES = np.dtype([*_STAMP, ("wire", "<i4"), ("sent", "<i8"), ("lost", "<i8"), ("late", "<i8")])


def _filled(column: Sequence[Any], shape: tuple[int, ...]) -> Any:
    """A column of floats or arrays as one array; concatenating is three times as quick as stacking."""
    return np.concatenate(column).reshape(-1, *shape) if shape else column


def block_rows(dtype: np.dtype[np.void], rows: Sequence[BlockRow], trial: int, kept: Sequence[int]) -> Rows:
    """Rows of a block's steps as one structured array, of its outputs those that are `kept`."""
    table = np.empty(len(rows), dtype)
    if rows:
        table["trial"] = trial
        # `zip` of many rows makes an object for each, and so garbage collections.
        stamps: list[list[Any]] = [[row[k] for row in rows] for k in range(len(BLOCK_STAMPS) - 1)]
        columns: list[list[Any]] = [[row[-1][port] for row in rows] for port in kept]
        for name, column in zip((dtype.names or ())[1:], stamps + columns, strict=True):
            table[name] = _filled(column, dtype[name].shape)
    return table


def plant_rows(
    dtype: np.dtype[np.void], stacks: Sequence[PlantRow], trial: int, kept: Sequence[int]
) -> Rows:
    """Stacks of a plant's outputs as one structured array, of its outputs those that are `kept`."""
    if not stacks:
        return np.empty(0, dtype)
    times, captured, values = zip(*stacks, strict=True)
    stamps = [np.array(list(chain.from_iterable(column)), np.int64) for column in (times, captured)]
    table = np.empty(stamps[0].size, dtype)
    table["trial"] = trial
    ports = tuple(zip(*values, strict=True))
    columns = [*stamps, *(np.concatenate(ports[port]) for port in kept)]
    for name, column in zip((dtype.names or ())[1:], columns, strict=True):
        table[name] = column
    return table


def input_rows(dtype: np.dtype[np.void], rows: Sequence[InputRow], trial: int) -> Rows:
    """Changes of one plant input as one structured array."""
    table = np.empty(len(rows), dtype)
    table["trial"] = trial
    for name, k in zip((dtype.names or ())[1:-1], (0, 2, 3), strict=True):
        table[name] = [row[k] for row in rows]
    table["value"] = _filled([row[4] for row in rows], dtype["value"].shape)
    return table


def event_rows(events: Sequence[EventRow], trial: int) -> Rows:
    """Events as one structured array; text too long for its field ends in three dots, no letter cut."""
    def cut(text: str, field: str) -> bytes:
        encoded, size = text.encode(errors="replace"), EVENT[field].itemsize
        if len(encoded) <= size:
            return encoded
        return encoded[:size - 3].decode(errors="ignore").encode() + b"..."

    rows = [(trial, time, cut(where, "where"), cut(status, "status"), cut(detail, "detail"))
            for time, where, status, detail in events]
    return np.array(rows, EVENT)


def instant_rows(rows: Sequence[WallRow], trial: int) -> Rows:
    """Instants of a run in real time as one structured array."""
    return np.array([(trial, *stamps, action.encode()) for *stamps, action in rows], INSTANTS)


ALLOWED = "a file that fesloop run wrote"
_TABLES = {"events": EVENT, "messages": MESSAGES}
_STAMPS = {"blocks": BLOCK_STAMPS, "plants": PLANT_STAMPS, "inputs": INPUT_STAMPS}
_TEXTS, _NAMES = TypeAdapter(dict[str, str]), TypeAdapter(list[str])
_ROWS, _PAIRS = TypeAdapter(dict[str, list[str]]), TypeAdapter(dict[str, list[tuple[int, int]]])
_UNUSED_BYTES = 2**26
"""Bytes of partly filled chunks of all datasets together (chosen: 2000 datasets of 32 kB)."""



class _About(TypedDict):
    name: str
    trials: int
    seed: int


class _Block(TypedDict):
    kind: str


_Wire = TypedDict("_Wire", {"from": str, "to": str})


class _Score(TypedDict):
    truth: NotRequired[str]
    reference: NotRequired[str]
    estimate: NotRequired[str]


class _Patient(TypedDict):
    file: str


class _Experiment(TypedDict):
    """Parts of an experiment's tables that every version writes, whatever the kinds of its blocks."""

    experiment: _About
    blocks: dict[str, _Block]
    wires: list[_Wire]
    score: NotRequired[_Score]
    record: NotRequired[dict[str, Any]]
    patient: NotRequired[_Patient]


_EXPERIMENT = TypeAdapter(_Experiment)


@contextmanager
def undamaged(where: Path | str) -> Iterator[None]:
    """Turn failures of HDF5 to read a file into an InputError."""
    try:
        yield
    except InputError:
        raise
    except (OSError, RuntimeError, KeyError, TypeError, ValueError) as fault:
        raise InputError(str(where), f"is damaged: {' '.join(str(fault).split())}", ALLOWED,
                         "read an earlier copy of it") from None


def require_form(file: h5py.File, path: Path) -> None:
    """Raise InputError unless everything that readers need exists, has its type and fits in the file."""
    with undamaged(path):
        _require_described(file, str(path))
        _require_tables(file, path)


def _require_described(file: h5py.File, where: str) -> None:
    """Check the facts about the run as a whole."""
    attributes = hdf5.attributes(file, where)
    for key in ("name", "fingerprint"):
        hdf5.text(attributes, key, where)
    _json(attributes, "versions", _TEXTS, where)
    _json(attributes, "wires", _NAMES, where)
    if not isinstance(attributes.get("seed"), (int, np.integer)):
        raise InputError(f"{where}: seed", "is missing, or no number", ALLOWED)


def _require_tables(file: h5py.File, path: Path) -> None:
    """Check the recorded rows."""
    where = str(path)
    items = hdf5.members(file, where)
    for name in ("experiment", "status", "wall", *_TABLES):
        if name not in items:
            raise InputError(f"{where}: {name}", "is missing", ALLOWED)
    room = path.stat().st_size + _UNUSED_BYTES
    for name, dtype in _TABLES.items():
        room -= _size(items[name], f"{where}: {name}")
        if (found := items[name].dtype) != dtype:
            raise InputError(f"{where}: {name}", f"has rows of {found}", ALLOWED)
    for kind, stamps in _STAMPS.items():
        for place, dataset in _streams(items.get(kind), f"{where}: {kind}", nested=kind == "inputs"):
            room -= _size(dataset, place)
            _require_stream(dataset, stamps, place)
    if room < 0:
        raise InputError(where, f"has rows of {-room:.3g} bytes more than the file", ALLOWED)


def require_tables(told: Any, where: str) -> dict[str, Any]:
    """The tables of a recorded experiment; InputError where they are damaged."""
    try:
        tables = plain_tables(told if isinstance(told, dict) else {})
        _EXPERIMENT.validate_python(tables, strict=True)
    except TomlError as fault:
        raise InputError(where, f"is damaged: {fault}", ALLOWED) from None
    except ValidationError as fault:
        first = fault.errors(include_url=False)[0]
        raise InputError(".".join([where, *map(str, first["loc"])]), f"is damaged: {first['msg']}",
                         ALLOWED) from None
    return tables


def _json(attributes: dict[str, Any], key: str, form: TypeAdapter[Any], where: str) -> Any:
    text = hdf5.text(attributes, key, where)
    try:
        return form.validate_json(text)
    except ValidationError:
        raise InputError(f"{where}: {key}", "is damaged", ALLOWED) from None


def _streams(group: Any, where: str, *, nested: bool) -> Iterator[tuple[str, h5py.Dataset]]:
    """Datasets of a kind, one level below where they are `nested`, as those of plants' inputs."""
    if group is None:
        return
    if not isinstance(group, h5py.Group):
        raise InputError(where, "is no group", ALLOWED)
    for name, item in hdf5.members(group, where).items():
        if nested and isinstance(item, h5py.Group):
            for port, dataset in hdf5.members(item, f"{where}/{name}").items():
                yield f"{where}/{name}/{port}", dataset
        else:
            yield f"{where}/{name}", item


def _size(dataset: Any, where: str) -> int:
    """Size of all rows of a dataset, bytes."""
    if not isinstance(dataset, h5py.Dataset) or len(dataset.shape) != 1:
        raise InputError(where, "is no table of rows", ALLOWED)
    if dataset.external or dataset.is_virtual:
        raise InputError(where, "lies in another file", ALLOWED)
    return int(dataset.shape[0]) * int(dataset.dtype.itemsize)


def _require_stream(dataset: h5py.Dataset, stamps: list[tuple[str, str]], where: str) -> None:
    """Raise InputError unless rows are stamps and ports, and each port has a unit."""
    dtype, names = dataset.dtype, dataset.dtype.names or ()
    attributes = hdf5.attributes(dataset, where)
    units = _json(attributes, "units", _TEXTS, where)
    ports = names[len(stamps):]
    sound = [(name, dtype[name].str) for name in names[:len(stamps)]] == stamps and set(ports) == set(units)
    if not sound or not all(dtype[port].base == np.dtype("<f8") for port in ports):
        raise InputError(where, f"has rows of {', '.join(names)}", ALLOWED)
    rows = _json(attributes, "rows", _ROWS, where) if "rows" in attributes else {}
    pairs = _json(attributes, "pairs", _PAIRS, where) if "pairs" in attributes else {}
    for port, of_port in rows.items():
        if port not in ports or dtype[port].shape[:1] != (len(of_port),):
            raise InputError(f"{where}: rows", f"names {len(of_port)} rows of {port}", ALLOWED)
    for port, of_port in pairs.items():
        require_pairs(of_port, rows.get(port, []), f"{where}: pairs")
