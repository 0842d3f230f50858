"""fesloop's own file of a motion recording: everything that `MotionRecording` holds, bit for bit, but for the
labels of what was left out of its source.

HDF5, form "fesloop motion 1":

    attributes          format, source, source_format, source_units (JSON), sensor_set (left out: none), rate
                        (a ratio such as "2000/7", Hz; "" where they are not evenly spaced), sensors (JSON);
                        resampled_hz (JSON, Hz by stream; left out: samples are as they were taken),
                        origin_s (the first sample on the source's clock; left out: not known)
    stamps_ns           int64 (n,), ns from 0 on
    gyr, acc, mag       float64 (n, sensors, 3), rad/s, m/s^2, T; NaN where lost; mag may be left out
    pairs               int64 (pairs, 2), parent and child
    reference           group, may be left out: stamps_ns int64 (m,), orientation float64 (m, sensors, 4),
                        scored uint8 (m,); attributes sensor_frames, north

Every dataset carries Fletcher's checksum, so that a file that a disk has damaged is refused.
"""

from __future__ import annotations

import json
import secrets
from collections.abc import Mapping
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fesloop.errors import InputError
from fesloop.loop.clock import exact_ratio
from fesloop.streams.containers import hdf5
from fesloop.streams.recording import MotionRecording, Reference
from fesloop.streams.room import Room

FORMAT = "fesloop motion 1"
ALLOWED = "a motion file that fesloop import wrote"
_DTYPES = {"stamps_ns": np.dtype("<i8"), "gyr": np.dtype("<f8"), "acc": np.dtype("<f8"),
           "mag": np.dtype("<f8"), "pairs": np.dtype("<i8"), "orientation": np.dtype("<f8"),
           "scored": np.dtype("u1")}


def write_motion_file(recording: MotionRecording, target: Path) -> None:
    """Write a recording; the file appears whole or not at all.

    Raises InputError where there is a file of this name, or none can be made.
    """
    draft = target.parent / f".{target.name}-{secrets.token_hex(8)}"
    try:
        if target.exists():
            raise InputError(str(target), "exists", "a new name", "remove it, or give another name")
        target.parent.mkdir(parents=True, exist_ok=True)
        with h5py.File(draft, "w-", libver=("v110", "v110")) as file:
            _fill(file, recording)
        draft.rename(target)
    except OSError as fault:
        raise InputError(str(target), f"cannot be written: {fault.strerror or fault}",
                         "a file in a folder that can be written to") from None
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)


def _fill(file: h5py.File, recording: MotionRecording) -> None:
    file.attrs["format"] = FORMAT
    source = recording.source or recording.path.name
    file.attrs["source"] = source.encode("utf-8", "replace").decode()  # names of files can be any bytes
    file.attrs["source_format"] = recording.source_format
    file.attrs["source_units"] = json.dumps(dict(recording.source_units))
    file.attrs["rate"] = "" if recording.rate is None else str(recording.rate)
    file.attrs["sensors"] = json.dumps(recording.sensors)
    if recording.resampled_hz:
        file.attrs["resampled_hz"] = json.dumps(dict(recording.resampled_hz))
    if recording.origin_s is not None:
        file.attrs["origin_s"] = recording.origin_s
    if recording.sensor_set is not None:
        file.attrs["sensor_set"] = recording.sensor_set
    _put(file, "stamps_ns", recording.stamps_ns)
    _put(file, "gyr", recording.gyr)
    _put(file, "acc", recording.acc)
    if recording.mag is not None:
        _put(file, "mag", recording.mag)
    _put(file, "pairs", np.array(recording.pairs, dtype=np.int64).reshape(-1, 2))
    if recording.reference is not None:
        group = file.create_group("reference")
        group.attrs["sensor_frames"] = recording.reference.sensor_frames
        group.attrs["north"] = recording.reference.north
        _put(group, "stamps_ns", recording.reference.stamps_ns)
        _put(group, "orientation", recording.reference.orientation)
        _put(group, "scored", recording.reference.scored)


def _put(group: h5py.Group, name: str, values: Any) -> None:
    checked = {"fletcher32": True, "shuffle": True, "compression": "gzip"} if np.size(values) else {}
    group.create_dataset(name, data=values, dtype=_DTYPES[name], **checked)


def read_motion_file(path: Path, sensor_set: str | None = None) -> MotionRecording:
    """The recording in a motion file.

    Raises InputError for a file that is damaged or not of the form, and for a `sensor_set` that is not the
    file's.
    """
    where = str(path)
    with hdf5.open_hdf5(path, ALLOWED) as file:
        told, items, room = hdf5.attributes(file, where), hdf5.members(file, where), Room(path)
        held = hdf5.text(told, "sensor_set", where) if "sensor_set" in told else None
        if sensor_set not in (None, held):
            raise InputError("sensor_set", f"{where} has no sensor set {sensor_set!r}", held or "none")
        sensors = tuple(_names(told, where))
        stamps = _array(items, "stamps_ns", (None,), room, where)
        shape = (stamps.size, len(sensors), 3)
        gyr, acc = (_array(items, name, shape, room, where) for name in ("gyr", "acc"))
        mag = _array(items, "mag", shape, room, where) if "mag" in items else None
        group = items.get("reference")
        reference = None if group is None else _reference(group, len(sensors), room, where)
        pairs = _array(items, "pairs", (None, 2), room, where)
    _require_increasing(stamps, f"{where}: stamps_ns")
    for name, samples in (("gyr", gyr), ("acc", acc), ("mag", mag)):
        if samples is not None and np.isinf(samples).any():
            raise InputError(f"{where}: {name}", "holds infinite numbers", "finite ones, NaN where lost")
    return MotionRecording(
        path=path, source_format=hdf5.text(told, "source_format", where), sensor_set=held, sensors=sensors,
        rate=_rate(told, where), stamps_ns=stamps, gyr=gyr, acc=acc, mag=mag, reference=reference,
        pairs=tuple((int(parent), int(child)) for parent, child in pairs),
        source=hdf5.text(told, "source", where), source_units=_units(told, where),
        resampled_hz=_resampled(told, where), origin_s=_origin_s(told, where))


def _reference(group: Any, sensors: int, room: Room, where: str) -> Reference:
    place = f"{where}: reference"
    if not isinstance(group, h5py.Group):
        raise InputError(place, "is no group", ALLOWED)
    told, items = hdf5.attributes(group, place), hdf5.members(group, place)
    stamps = _array(items, "stamps_ns", (None,), room, place)
    _require_increasing(stamps, f"{place}: stamps_ns")
    orientation = _array(items, "orientation", (stamps.size, sensors, 4), room, place)
    length = np.linalg.norm(orientation, axis=-1)
    if not (np.isnan(length) | (np.abs(length - 1.0) < 0.01)).all():
        raise InputError(f"{place}: orientation", "holds quaternions that are not of length 1", ALLOWED)
    flags = {}
    for key in ("sensor_frames", "north"):
        if not isinstance(told.get(key), (bool, np.bool_)):
            raise InputError(f"{place}: {key}", "is missing, or no truth value", "true, false")
        flags[key] = bool(told[key])
    return Reference(stamps_ns=stamps, orientation=orientation,
                     scored=_array(items, "scored", (stamps.size,), room, place) > 0, **flags)


def _array(items: Mapping[str, Any], name: str, shape: tuple[int | None, ...], room: Room,
           where: str) -> np.ndarray[Any, Any]:
    """A dataset of the form's type and shape."""
    place = f"{where}: {name}"
    item = items.get(name)
    if isinstance(item, h5py.Dataset):
        fits = len(item.shape) == len(shape) and all(
            wanted in (None, size) for size, wanted in zip(item.shape, shape, strict=True))
        if item.dtype != _DTYPES[name] or not fits:
            raise InputError(place, f"is of {item.dtype} with shape {item.shape}",
                             f"{_DTYPES[name]} {tuple('any' if n is None else n for n in shape)}")
    return hdf5.array(item, room, place)


def _require_increasing(stamps: np.ndarray[Any, Any], place: str) -> None:
    if not stamps.size or stamps[0] < 0 or (stamps[1:] <= stamps[:-1]).any():
        raise InputError(place, "do not increase from 0 on", ALLOWED)


def _json(told: Mapping[str, Any], key: str, kind: type[Any], where: str) -> Any:
    """Names under a key: text, in a list or as keys and values of a table."""
    try:
        value = json.loads(hdf5.text(told, key, where))
    except (ValueError, RecursionError) as fault:
        if isinstance(fault, InputError):
            raise
        raise InputError(f"{where}: {key}", f"is no JSON: {fault}", ALLOWED) from None
    parts = [*value, *(value.values() if isinstance(value, dict) else ())] if isinstance(value, kind) else [0]
    if not all(isinstance(part, str) for part in parts):
        raise InputError(f"{where}: {key}", "does not hold names", ALLOWED)
    return value


def _names(told: Mapping[str, Any], where: str) -> list[str]:
    names: list[str] = _json(told, "sensors", list, where)
    if not names or len(set(names)) < len(names):
        raise InputError(f"{where}: sensors", f"{len(names)} names", "one or more, each once")
    return names


def _units(told: Mapping[str, Any], where: str) -> dict[str, str]:
    units: dict[str, str] = _json(told, "source_units", dict, where)
    return units


def _resampled(told: Mapping[str, Any], where: str) -> dict[str, float]:
    """Rates by stream, Hz; none where the file names none."""
    if "resampled_hz" not in told:
        return {}
    try:
        rates = json.loads(hdf5.text(told, "resampled_hz", where))
        sound = {name: float(hz) for name, hz in rates.items() if 0.0 < hz < np.inf}
    except (ValueError, RecursionError, TypeError, AttributeError) as fault:
        raise InputError(f"{where}: resampled_hz", f"does not hold rates: {fault}", ALLOWED) from None
    if len(sound) < len(rates):
        raise InputError(f"{where}: resampled_hz", "holds what is no rate", ALLOWED)
    return sound


def _origin_s(told: Mapping[str, Any], where: str) -> float | None:
    value = told.get("origin_s")
    if value is None:
        return None
    if not isinstance(value, (float, np.floating)) or not np.isfinite(value):
        raise InputError(f"{where}: origin_s", "is no instant", "a finite number of seconds, or nothing")
    return float(value)


def _rate(told: Mapping[str, Any], where: str) -> Fraction | None:
    stated = hdf5.text(told, "rate", where)
    try:
        rate = exact_ratio(stated) if stated else None
    except (ValueError, ZeroDivisionError):
        rate = Fraction(0)
    if rate is not None and rate <= 0:
        raise InputError(f"{where}: rate", f"{stated!r}", 'a ratio such as "2000/7", or nothing')
    return rate
