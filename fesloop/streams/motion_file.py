"""fesloop's own file of a motion recording: all of `MotionRecording`, bit for bit, but not the
labels of channels that were left out of its source.

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
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fesloop.errors import InputError
from fesloop.loop.clock import exact_ratio
from fesloop.streams import hdf5
from fesloop.streams.reading import read_file
from fesloop.streams.recording import MotionRecording, Reference

FORMAT = "fesloop motion 1"
ALLOWED = "a motion file that fesloop import wrote"
_DTYPES = {"stamps_ns": np.dtype("<i8"), "gyr": np.dtype("<f8"), "acc": np.dtype("<f8"),
           "mag": np.dtype("<f8"), "pairs": np.dtype("<i8"), "orientation": np.dtype("<f8"),
           "scored": np.dtype("u1")}


def write_motion_file(recording: MotionRecording, target: Path) -> None:
    """Write a recording; the file appears whole or not at all.

    Raises InputError where there is a file of this name, or none can be made.
    """
    with hdf5.new_hdf5(target) as file:
        _fill(file, recording)


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
    return recording_in(read_file("hdf5", path), path, sensor_set)


def recording_in(content: Mapping[str, Any], path: Path, sensor_set: str | None) -> MotionRecording:
    """The recording in the content of a motion file; see `read_motion_file`."""
    where = str(path)
    if content["format"] != FORMAT:
        raise InputError(where, f"has the format {content['format']!r}", ALLOWED)
    attributes, items = content["attributes"], content["items"]
    own_set = hdf5.text(attributes, "sensor_set", where) if "sensor_set" in attributes else None
    if sensor_set not in (None, own_set):
        raise InputError("sensor_set", f"{where} has no sensor set {sensor_set!r}", own_set or "none")
    sensors = tuple(_names(attributes, where))
    stamps = _array(items, "stamps_ns", (None,), where)
    shape = (stamps.size, len(sensors), 3)
    gyr, acc = (_array(items, name, shape, where) for name in ("gyr", "acc"))
    mag = _array(items, "mag", shape, where) if "mag" in items else None
    reference = _reference(items["reference"], len(sensors), where) if "reference" in items else None
    pairs = _array(items, "pairs", (None, 2), where)
    _require_increasing(stamps, f"{where}: stamps_ns")
    for name, samples in (("gyr", gyr), ("acc", acc), ("mag", mag)):
        if samples is not None and np.isinf(samples).any():
            raise InputError(f"{where}: {name}", "holds infinite numbers", "finite ones, NaN where lost")
    return MotionRecording(
        path=path, source_format=hdf5.text(attributes, "source_format", where), sensor_set=own_set,
        sensors=sensors, rate=_rate(attributes, where), stamps_ns=stamps, gyr=gyr, acc=acc, mag=mag,
        reference=reference,
        pairs=tuple((int(parent), int(child)) for parent, child in pairs),
        source=hdf5.text(attributes, "source", where), source_units=_units(attributes, where),
        resampled_hz=_resampled(attributes, where), origin_s=_origin_s(attributes, where))


def _reference(group: Any, sensors: int, where: str) -> Reference:
    place = f"{where}: reference"
    if not isinstance(group, Mapping):
        raise InputError(place, "is no group", ALLOWED)
    attributes, items = group["attributes"], group["items"]
    stamps = _array(items, "stamps_ns", (None,), place)
    _require_increasing(stamps, f"{place}: stamps_ns")
    orientation = _array(items, "orientation", (stamps.size, sensors, 4), place)
    length = np.linalg.norm(orientation, axis=-1)
    if not (np.isnan(length) | (np.abs(length - 1.0) < 0.01)).all():
        raise InputError(f"{place}: orientation", "holds quaternions that are not of length 1", ALLOWED)
    flags = {}
    for key in ("sensor_frames", "north"):
        if not isinstance(attributes.get(key), bool):
            raise InputError(f"{place}: {key}", "is missing, or no truth value", "true, false")
        flags[key] = attributes[key]
    return Reference(stamps_ns=stamps, orientation=orientation,
                     scored=_array(items, "scored", (stamps.size,), place) > 0, **flags)


def _array(items: Mapping[str, Any], name: str, shape: tuple[int | None, ...],
           where: str) -> np.ndarray[Any, Any]:
    """A dataset of the form's type and shape, None for any length."""
    place, values = f"{where}: {name}", items.get(name)
    if not isinstance(values, np.ndarray):
        raise InputError(place, "is missing" if values is None else "is no dataset of numbers", ALLOWED)
    fits = values.ndim == len(shape) and all(
        length in (None, size) for size, length in zip(values.shape, shape, strict=True))
    if values.dtype != _DTYPES[name] or not fits:
        raise InputError(place, f"is of {values.dtype} with shape {values.shape}",
                         f"{_DTYPES[name]} {tuple('any' if n is None else n for n in shape)}")
    return values


def _require_increasing(stamps: np.ndarray[Any, Any], place: str) -> None:
    if not stamps.size or stamps[0] < 0 or (stamps[1:] <= stamps[:-1]).any():
        raise InputError(place, "do not increase from 0 on", ALLOWED)


def _json(attributes: Mapping[str, Any], key: str, kind: type[Any], where: str) -> Any:
    """Names under a key: text, in a list or as keys and values of a table."""
    try:
        value = json.loads(hdf5.text(attributes, key, where))
    except (ValueError, RecursionError) as fault:
        if isinstance(fault, InputError):
            raise
        raise InputError(f"{where}: {key}", f"is no JSON: {fault}", ALLOWED) from None
    parts = [*value, *(value.values() if isinstance(value, dict) else ())] if isinstance(value, kind) else [0]
    if not all(isinstance(part, str) for part in parts):
        raise InputError(f"{where}: {key}", "does not hold names", ALLOWED)
    return value


def _names(attributes: Mapping[str, Any], where: str) -> list[str]:
    names: list[str] = _json(attributes, "sensors", list, where)
    if not names or len(set(names)) < len(names):
        raise InputError(f"{where}: sensors", f"{len(names)} names", "one or more, each once")
    return names


def _units(attributes: Mapping[str, Any], where: str) -> dict[str, str]:
    units: dict[str, str] = _json(attributes, "source_units", dict, where)
    return units


def _resampled(attributes: Mapping[str, Any], where: str) -> dict[str, float]:
    """Rates by stream, Hz; none where the file names none."""
    if "resampled_hz" not in attributes:
        return {}
    try:
        rates = json.loads(hdf5.text(attributes, "resampled_hz", where))
        sound = {name: float(hz) for name, hz in rates.items() if 0.0 < hz < np.inf}
    except (ValueError, RecursionError, TypeError, AttributeError) as fault:
        raise InputError(f"{where}: resampled_hz", f"does not hold rates: {fault}", ALLOWED) from None
    if len(sound) < len(rates):
        raise InputError(f"{where}: resampled_hz", "holds what is no rate", ALLOWED)
    return sound


def _origin_s(attributes: Mapping[str, Any], where: str) -> float | None:
    value = attributes.get("origin_s")
    if value is None:
        return None
    if not isinstance(value, float) or not np.isfinite(value):
        raise InputError(f"{where}: origin_s", "is no instant", "a finite number of seconds, or nothing")
    return value


def _rate(attributes: Mapping[str, Any], where: str) -> Fraction | None:
    stated = hdf5.text(attributes, "rate", where)
    try:
        rate = exact_ratio(stated) if stated else None
    except (ValueError, ZeroDivisionError):
        rate = Fraction(0)
    if rate is not None and rate <= 0:
        raise InputError(f"{where}: rate", f"{stated!r}", 'a ratio such as "2000/7", or nothing')
    return rate
