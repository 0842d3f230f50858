"""Whether a file has the form of a recording (`fesloop.experiment.recording.writing`) when it is opened."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NotRequired

import h5py
import numpy as np
from pydantic import TypeAdapter, ValidationError
from typing_extensions import TypedDict

from fesloop.errors import InputError
from fesloop.experiment.recording.rows import BLOCK_STAMPS, EVENT, INPUT_STAMPS, MESSAGES, PLANT_STAMPS
from fesloop.forms.toml import TomlError, plain_tables
from fesloop.loop.signals import require_pairs
from fesloop.streams.containers import hdf5

ALLOWED = "a file that fesloop run wrote"
_TABLES = {"events": EVENT, "messages": MESSAGES}
_STAMPS = {"blocks": BLOCK_STAMPS, "plants": PLANT_STAMPS, "inputs": INPUT_STAMPS}
_TEXTS, _NAMES = TypeAdapter(dict[str, str]), TypeAdapter(list[str])
_ROWS, _PAIRS = TypeAdapter(dict[str, list[str]]), TypeAdapter(dict[str, list[tuple[int, int]]])
_UNUSED_BYTES = 2**26
"""Chunks that are begun but not full, of all datasets together (chosen: 2000 datasets of 32 kB)."""



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
    """What every version's tables of an experiment hold, whatever the kinds of its blocks."""

    experiment: _About
    blocks: dict[str, _Block]
    wires: list[_Wire]
    score: NotRequired[_Score]
    record: NotRequired[dict[str, Any]]
    patient: NotRequired[_Patient]


_EXPERIMENT = TypeAdapter(_Experiment)


@contextmanager
def undamaged(where: Path | str) -> Iterator[None]:
    """Within, what HDF5 cannot read of a file is an InputError that says so."""
    try:
        yield
    except InputError:
        raise
    except (OSError, RuntimeError, KeyError, TypeError, ValueError) as fault:
        raise InputError(str(where), f"is damaged: {' '.join(str(fault).split())}", ALLOWED,
                         "read an earlier copy of it") from None


def require_form(file: h5py.File, path: Path) -> None:
    """Raise InputError unless all that reading relies on is there, of its type, no larger than the file."""
    with undamaged(path):
        _require_described(file, str(path))
        _require_tables(file, path)


def _require_described(file: h5py.File, where: str) -> None:
    """What is told of the run as a whole."""
    told = hdf5.attributes(file, where)
    for key in ("name", "fingerprint"):
        hdf5.text(told, key, where)
    _json(told, "versions", _TEXTS, where)
    _json(told, "wires", _NAMES, where)
    if not isinstance(told.get("seed"), (int, np.integer)):
        raise InputError(f"{where}: seed", "is missing, or no number", ALLOWED)


def _require_tables(file: h5py.File, path: Path) -> None:
    """What was recorded."""
    where = str(path)
    items = hdf5.members(file, where)
    for name in ("experiment", "status", "wall", *_TABLES):
        if name not in items:
            raise InputError(f"{where}: {name}", "is missing", ALLOWED)
    room = path.stat().st_size + _UNUSED_BYTES
    for name, dtype in _TABLES.items():
        room -= _size(items[name], f"{where}: {name}")
        if items[name].dtype != dtype:
            raise InputError(f"{where}: {name}", f"has rows of {items[name].dtype}", ALLOWED)
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


def _json(told: dict[str, Any], key: str, form: TypeAdapter[Any], where: str) -> Any:
    text = hdf5.text(told, key, where)
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
    """Bytes that all rows of a dataset take."""
    if not isinstance(dataset, h5py.Dataset) or len(dataset.shape) != 1:
        raise InputError(where, "is no table of rows", ALLOWED)
    if dataset.external or dataset.is_virtual:
        raise InputError(where, "lies in another file", ALLOWED)
    return int(dataset.shape[0]) * int(dataset.dtype.itemsize)


def _require_stream(dataset: h5py.Dataset, stamps: list[tuple[str, str]], where: str) -> None:
    """Raise InputError unless rows are stamps and ports, each of which has a unit."""
    dtype, names = dataset.dtype, dataset.dtype.names or ()
    units = _json(hdf5.attributes(dataset, where), "units", _TEXTS, where)
    ports = names[len(stamps):]
    sound = [(name, dtype[name].str) for name in names[:len(stamps)]] == stamps and set(ports) == set(units)
    if not sound or not all(dtype[port].base == np.dtype("<f8") for port in ports):
        raise InputError(where, f"has rows of {', '.join(names)}", ALLOWED)
    told = hdf5.attributes(dataset, where)
    rows = _json(told, "rows", _ROWS, where) if "rows" in told else {}
    pairs = _json(told, "pairs", _PAIRS, where) if "pairs" in told else {}
    for port, of_port in rows.items():
        if port not in ports or dtype[port].shape[:1] != (len(of_port),):
            raise InputError(f"{where}: rows", f"names {len(of_port)} rows of {port}", ALLOWED)
    for port, of_port in pairs.items():
        require_pairs(of_port, rows.get(port, []), f"{where}: pairs")
