"""fesloop's own file of a recording of stimulated muscle: all of `StimulationRecording`, bit for bit.

HDF5, form "fesloop stimulation 1":

    attributes      format; the recording's names, texts and numbers, each as JSON under its name
    arrays          float64 or int64 datasets under their names in `StimulationRecording`, SI units
    steady          group of `SteadyTrials`: its arrays as datasets, the rest as attributes. `posture` holds
                    numbers of the codes in the attribute `posture_codes`
    courses, movements, forces
                    groups of numbered groups "0", "1", ...: `TorqueCourse`, `Movement`, `ForceCourse`

A dataset is left out where the array is None. Every dataset carries Fletcher's checksum.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, get_type_hints

import h5py
import numpy as np
from pydantic import ConfigDict, TypeAdapter, ValidationError

from fesloop.errors import InputError
from fesloop.streams import hdf5
from fesloop.streams.stimulation.recording import (
    ARRAYS,
    ForceCourse,
    Form,
    Movement,
    SteadyTrials,
    StimulationRecording,
    TorqueCourse,
)

FORMAT = "fesloop stimulation 1"
ALLOWED = "a file that fesloop import --stimulation wrote"
_LISTS: dict[str, type[Any]] = {"courses": TorqueCourse, "movements": Movement, "forces": ForceCourse}
_CODES = "posture_codes"


def write_stimulation(recording: StimulationRecording, target: Path) -> None:
    """Write a recording; the file appears whole or not at all.

    Raises InputError where there is a file of this name, or none can be made.
    """
    with hdf5.new_hdf5(target) as file:
        file.attrs["format"] = FORMAT
        _fill(file, recording)
        if recording.steady is not None:
            _fill(file.create_group("steady"), recording.steady)
        for kind in _LISTS:
            group = file.create_group(kind)
            for number, part in enumerate(getattr(recording, kind)):
                _fill(group.create_group(str(number)), part)


def _fill(group: h5py.Group, part: Any) -> None:
    arrays = ARRAYS[type(part)]
    for each in fields(part):
        name, value = each.name, getattr(part, each.name)
        if value is None or name == "steady" or name in _LISTS:
            continue
        if name not in arrays:
            group.attrs[name] = json.dumps(dict(value) if isinstance(value, Mapping) else value)
            continue
        dtype = arrays[name].dtype
        if dtype.kind == "U":
            codes, value = np.unique(value, return_inverse=True)
            group.attrs[_CODES], dtype = json.dumps(codes.tolist()), np.dtype("i8")
        checked = {"fletcher32": True, "shuffle": True, "compression": "gzip"} if np.size(value) else {}
        group.create_dataset(name, data=value, dtype=dtype.newbyteorder("<"), **checked)


def recording_in(content: Mapping[str, Any], path: Path) -> StimulationRecording:
    """The recording in the content of a file, as the reader process gives it.

    Raises InputError for content that is not of the form.
    """
    where = str(path)
    if content["format"] != FORMAT:
        raise InputError(where, f"has the format {content['format']!r}", ALLOWED)
    items = content["items"]
    parts: dict[str, Any] = {"steady": _part(SteadyTrials, items["steady"], f"{where}: steady")
                             if "steady" in items else None}
    for kind, made in _LISTS.items():
        groups = _group(items.get(kind), f"{where}: {kind}")["items"]
        if set(groups) != {str(number) for number in range(len(groups))}:
            raise InputError(f"{where}: {kind}", "are not numbered from 0 on", ALLOWED)
        parts[kind] = tuple(_part(made, groups[str(number)], f"{where}: {kind}: {number}")
                            for number in range(len(groups)))
    try:
        recording: StimulationRecording = _part(StimulationRecording, content, where, **parts)
    except InputError as fault:
        raise fault if fault.where.startswith(where) else fault.within(where) from None
    return recording


def _group(found: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(found, Mapping) or "items" not in found:
        raise InputError(where, "is missing, or no group", ALLOWED)
    return found


def _part(kind: type[Any], found: Any, where: str, **parts: Any) -> Any:
    """A part of a recording from the attributes and datasets of its group."""
    group, values = _group(found, where), dict(parts)
    arrays = ARRAYS[kind]
    for name, adapter in _ADAPTERS[kind].items():
        if name in arrays:
            values[name] = _array(group, name, arrays[name], where)
        elif name not in parts:
            text = hdf5.text(group["attributes"], name, where)
            try:
                values[name] = adapter.validate_json(text, strict=True)
            except ValidationError as fault:
                raise InputError(f"{where}: {name}", f"is not of its form: {fault.errors()[0]['msg']}",
                                 ALLOWED) from None
    return kind(**values)


def _array(group: Mapping[str, Any], name: str, form: Form, where: str) -> Any:
    dtype, _, optional = form
    values = group["items"].get(name)
    if values is None and optional:
        return None
    coded = dtype.kind == "U"
    stored = np.dtype("<i8") if coded else dtype.newbyteorder("<")
    if not isinstance(values, np.ndarray) or values.dtype != stored:
        found = "is missing" if values is None else f"is of {getattr(values, 'dtype', 'no numbers')}"
        raise InputError(f"{where}: {name}", found, f"a dataset of {stored}")
    if not coded:
        return values.copy()
    try:
        codes = np.array(json.loads(hdf5.text(group["attributes"], _CODES, where)), str)
        if codes.ndim != 1 or (values.size and not 0 <= values.min() <= values.max() < codes.size):
            raise ValueError
    except (ValueError, RecursionError):
        raise InputError(f"{where}: {_CODES}", "do not fit their numbers", ALLOWED) from None
    return codes[values]


def _adapters(kind: type[Any]) -> dict[str, TypeAdapter[Any]]:
    """Checks of a part's attributes by name, in the order of its fields."""
    hints, own = get_type_hints(kind), ConfigDict(arbitrary_types_allowed=True)
    plain = {each.name for each in fields(kind)} - {"steady", *ARRAYS[kind], *_LISTS}
    return {each.name: TypeAdapter(hints[each.name] if each.name in plain else Any, config=own)
            for each in fields(kind)}


_ADAPTERS = {kind: _adapters(kind) for kind in ARRAYS}
