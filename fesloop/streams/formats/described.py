"""Files that a layout describes: text tables, variables of .mat, .npz and HDF5 files, streams of XDF."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from fesloop.errors import InputError, did_you_mean
from fesloop.hand.quaternion import multiply
from fesloop.loop.clock import NS_PER_S, exact_ratio
from fesloop.streams import checks
from fesloop.streams.checks import Array
from fesloop.streams.containers.reading import head_of, is_container, read_container
from fesloop.streams.containers.text_table import TextTable, read_table
from fesloop.streams.formats import xdf_chunks
from fesloop.streams.formats.channels import recording_of
from fesloop.streams.formats.layout import (
    Columns,
    Layout,
    Place,
    ReferenceLayout,
    SensorLayout,
    read_layout,
)
from fesloop.streams.formats.xdf_source import XdfSource
from fesloop.streams.mixed_rates import hold
from fesloop.streams.recording import MotionRecording, Reference, Stamps
from fesloop.streams.timebase import exact_rate, stamps_of_rate, stamps_of_times
from fesloop.streams.units import SI, factor

_RATES_AGREE = 1e-3
"""By how much samples and as many orientations may differ in length (chosen: a rate written with four digits
is within it, 59.94 for 60 Hz is not)."""
_ALLOWED = "a text file with a table of numbers, a .mat, .npz, HDF5 or XDF file"


class Source(Protocol):
    """What numbers are taken from."""

    def columns(self, place: Place, count: int, where: str) -> Array:
        """The columns of a place, (n, count), a fresh array."""

    def numbers(self, place: Place, count: int, where: str) -> list[tuple[str, int]]:
        """Variable and number from 0 of each of these columns, however the place names them."""


def read_described(path: Path, layout_path: Path) -> MotionRecording:
    """The recording in a file that a layout describes.

    Raises InputError, InputErrors: faults of the layout with its key, faults of the file with the key or the
    line and column.
    """
    layout = read_layout(layout_path)
    source_format, source = _source(path, layout, layout_path)
    units = {"gyr": layout.units.gyr, "acc": layout.units.acc, "mag": layout.units.mag}
    scales = {kind: factor(kind, unit, f"{layout_path}: units.{kind}", "") for kind, unit in units.items()}
    sensors: dict[str, dict[str, Array]] = {}
    for name, sensor in layout.sensors.items():
        for kind, place in (("gyr", sensor.gyr), ("acc", sensor.acc), ("mag", sensor.mag)):
            if place is not None:
                samples = source.columns(place, 3, f"{layout_path}: sensors.{name}.{kind}")
                sensors.setdefault(name, {})[kind] = sensor.turned(samples * scales[kind])
    _require_single(source, layout, layout_path)
    every = asdict(layout.every)
    sensors = {name: hold(samples, every) for name, samples in sensors.items()}
    length = len(next(iter(sensors.values()))["gyr"])
    stamps, rate = _time_base(source, layout.rate, layout.time, length, layout, f"{layout_path}: ")
    names = list(layout.sensors)
    return recording_of(
        path, source_format, sensors, stamps, rate, reference=_reference(source, layout, stamps, layout_path),
        pairs=[(names.index(parent), names.index(child)) for parent, child in layout.pairs],
        source_units={kind: units[kind] for kind in SI if kind in units and (
            kind != "mag" or "mag" in next(iter(sensors.values())))},
        resampled_hz=source.resampled_hz if isinstance(source, XdfSource) else {},
        origin_s=_origin_s(source, layout, f"{layout_path}: "))


def _origin_s(source: Source, layout: Layout, where: str) -> float | None:
    """The first instant that the file gives its samples, by the clock of the file."""
    if layout.time is None:
        return None
    first = float(source.columns(layout.time, 1, f"{where}time")[0, 0])
    return first * factor("time", layout.units.time, f"{where}units.time", "")


def _require_single(source: Source, layout: Layout, layout_path: Path) -> None:
    """Raise InputError where samples are of a column that the layout uses elsewhere, as after copying a line.

    Sensors on one segment may share its orientation.
    """
    places: list[tuple[str, Place | None, int]] = [("time", layout.time, 1)]
    for name, sensor in layout.sensors.items():
        places += [(f"sensors.{name}.{kind}", getattr(sensor, kind), 3) for kind in ("gyr", "acc", "mag")]
    used: dict[tuple[str, int], str] = {}
    for key, place, count in places:
        for column in source.numbers(place, count, f"{layout_path}: {key}") if place is not None else ():
            if column in used:
                raise _twice(layout_path, key, column, used[column])
            used[column] = key
    for name, sensor in layout.sensors.items():
        key, own = f"sensors.{name}.orientation", dict(used)
        if sensor.orientation is not None:
            for column in source.numbers(sensor.orientation, 4, f"{layout_path}: {key}"):
                if column in own:
                    raise _twice(layout_path, key, column, own[column])
                own[column] = key


def _twice(layout_path: Path, key: str, column: tuple[str, int], other: str) -> InputError:
    named = f"column {column[1] + 1}" + (f" of {column[0]}" if column[0] else "")
    return InputError(f"{layout_path}: {key}", f"names {named} "
                      + ("twice" if other == key else f"as well as {other}"), "each column once")


def _source(path: Path, layout: Layout, layout_path: Path) -> tuple[str, Source]:
    """What kind of file it is, and where its numbers are taken from."""
    head = head_of(path, _ALLOWED)
    if head.startswith(xdf_chunks.SIGNATURE):
        places = [place for each in layout.sensors.values() for place in (each.gyr, each.acc, each.mag)]
        return "xdf", XdfSource(path, layout.time, str(layout_path), layout.resample, [
            place.variable for place in places if isinstance(place, Columns)])
    if layout.resample is not None:
        raise InputError(f"{layout_path}: resample", f"{path} has one time base",
                         "an XDF file of several streams", "leave it out")
    if is_container(head):
        return "variables", _Variables(read_container(path), str(path))
    return "table", _Table(read_table(path, layout.text), str(path))


def _time_base(source: Source, rate: str | int | float | None, time: Place | None, length: int,
               layout: Layout, where: str) -> tuple[Stamps, Fraction | None]:
    """Stamps and exact rate from what the layout says of time."""
    if time is not None:
        unit_s = factor("time", layout.units.time, f"{where}units.time", "")
        return stamps_of_times(source.columns(time, 1, f"{where}time")[:, 0], unit_s, f"{where}time")
    try:
        stated = exact_ratio(str(rate))
    except (ValueError, ZeroDivisionError):
        raise InputError(f"{where}rate", f"{rate!r}", '100, "2000/7", "285.714" Hz') from None
    exact_rate(float(stated), f"{where}rate")
    return stamps_of_rate(length, stated), stated


def _reference(source: Source, layout: Layout, stamps: Stamps, layout_path: Path) -> Reference | None:
    """Orientations of all sensors, w x y z, segment to reference; None where the layout names none."""
    wanted: ReferenceLayout = layout.reference
    places = {name: sensor.orientation for name, sensor in layout.sensors.items()
              if sensor.orientation is not None}
    if not places:
        return None
    each = []
    for name, place in places.items():
        where = f"{layout_path}: sensors.{name}.orientation"
        quaternions = source.columns(place, 4, where)
        if wanted.order == "xyzw":
            quaternions = quaternions[:, [3, 0, 1, 2]]
        if wanted.direction == "reference_to_segment":
            quaternions[:, 1:] *= -1.0
        unit = checks.orientations(quaternions, where)
        each.append(_turned(unit, layout.sensors[name]) if wanted.sensor_frames else unit)
    checks.equal_lengths({f"{name}.orientation": len(rows) for name, rows in zip(places, each, strict=True)},
                         str(layout_path))
    if wanted.rate is not None or wanted.time is not None:
        own, _ = _time_base(source, wanted.rate, wanted.time, len(each[0]), layout,
                            f"{layout_path}: reference.")
        _require_same_pace(own, stamps, layout, str(layout_path))
        stamps = own
    if len(each[0]) != stamps.size:
        raise InputError(f"{layout_path}: reference", f"has {len(each[0])} orientations for {stamps.size} "
                         "instants", "one each", "state reference.rate or reference.time")
    scored = np.ones(stamps.size, dtype=bool)
    if wanted.scored is not None:
        where = f"{layout_path}: reference.scored"
        marks = source.columns(wanted.scored, 1, where)[:, 0]
        if marks.size != stamps.size or not np.isin(marks, (0.0, 1.0)).all():
            raise InputError(where, "does not mark instants", f"{stamps.size} numbers, 0 or 1 each")
        scored = marks > 0.0
    told = Reference(stamps_ns=stamps, orientation=np.stack(each, axis=1), scored=scored,
                     sensor_frames=wanted.sensor_frames, north=wanted.north)
    return _on_one_clock(told, source, layout, str(layout_path))


def _turned(orientations: Array, sensor: SensorLayout) -> Array:
    """Of the segment, from those of its sensor (n, 4)."""
    x, y, z, w = Rotation.from_matrix(sensor.turned(np.eye(3))).as_quat()
    return multiply(orientations, [w, x, y, z])


def _on_one_clock(reference: Reference, source: Source, layout: Layout, where: str) -> Reference:
    """The reference from the first sample on, where both bring their instants; else both begin together.

    Raises InputError where fewer than two of its instants lie within those of the samples.
    """
    if layout.time is None or layout.reference.time is None:
        return reference
    unit_s = factor("time", layout.units.time, f"{where}: units.time", "")
    samples, own = (source.columns(place, 1, where)[:, 0] for place in (layout.time, layout.reference.time))
    stamps = reference.stamps_ns + round(float(own[0] - samples[0]) * unit_s * NS_PER_S)
    kept = stamps >= 0
    if (kept & (own <= samples[-1])).sum() < 2:
        raise InputError(f"{where}: reference.time", f"is {own[0]:.9g} to {own[-1]:.9g}, of the samples "
                         f"{samples[0]:.9g} to {samples[-1]:.9g}", "instants by one clock",
                         "take the reference's own off, or state reference.rate to have both begin together")
    return replace(reference, stamps_ns=stamps[kept], orientation=reference.orientation[kept],
                   scored=reference.scored[kept])


def _require_same_pace(reference: Stamps, samples: Stamps, layout: Layout, where: str) -> None:
    """Raise InputError where a stated rate lets orientations take longer, or less long, than as many samples.

    Rows of a table, and matrices of as many rows, are of the same instants; what has another number of rows
    is another system's, which may have begun and ended at other instants. So is what brings stamps of its
    own, in the file, beside samples that do.
    """
    key = "reference.rate" if layout.reference.rate is not None else "rate"
    if (layout.rate is None and layout.reference.rate is None) or reference.size != samples.size:
        return
    lasting_s, samples_s = int(reference[-1]) / NS_PER_S, int(samples[-1]) / NS_PER_S
    if abs(lasting_s - samples_s) > _RATES_AGREE * samples_s:
        raise InputError(f"{where}: {key}", f"lets {reference.size} orientations last {lasting_s:.6g} s and "
                         f"as many samples {samples_s:.6g} s", f"the same, within {100.0 * _RATES_AGREE:g} %",
                         "mend the rate; the reference takes that of the samples where none is given")


class _Table:
    """Columns of a text table, by name or by number from 1."""

    def __init__(self, table: TextTable, where: str) -> None:
        self._table, self._where = table, where

    def columns(self, place: Place, count: int, where: str) -> Array:
        """See `Source`."""
        return self._table.values[:, [number for _, number in self.numbers(place, count, where)]]

    def numbers(self, place: Place, count: int, where: str) -> list[tuple[str, int]]:
        """See `Source`."""
        if isinstance(place, Columns):
            raise InputError(where, "names a variable, but a text file is one table", "columns alone")
        each = place if isinstance(place, tuple) else (place,)
        if len(each) != count:
            raise InputError(where, f"names {len(each)} columns", f"{count}")
        return [("", self._number(column, where)) for column in each]

    def _number(self, column: str | int, where: str) -> int:
        names, most = self._table.names, self._table.values.shape[1]
        if isinstance(column, int):
            if not 1 <= column <= most:
                raise InputError(where, f"column {column}", f"1 to {most} of {self._where}")
            return column - 1
        if names.count(column) != 1:
            found = "stands twice in" if column in names else "is no column of"
            raise InputError(where, f"{column!r} {found} {self._where}",
                             ", ".join(names[:12]) or "numbers", did_you_mean(column, names))
        return names.index(column)


class _Variables:
    """Variables of a container, structures by dots."""

    def __init__(self, content: Mapping[str, Any], where: str) -> None:
        self._content, self._where = content, where

    def columns(self, place: Place, count: int, where: str) -> Array:
        """See `Source`; of a whole variable (n, count) or, where that is no doubt, (count, n)."""
        if isinstance(place, Columns):
            matrix = self._matrix(place.variable, where)
            most = matrix.shape[1]
            numbers = [each - 1 for each in place.columns if isinstance(each, int) and 1 <= each <= most]
            if not len(numbers) == len(place.columns) == count:
                raise InputError(where, f"columns {place.columns}", f"{count} of 1 to {most}")
            return matrix[:, numbers]
        each = place if isinstance(place, tuple) else (place,)
        if not all(isinstance(name, str) for name in each):
            raise InputError(where, "a number without its variable", "{variable = ..., columns = [...]}")
        if len(each) == 1:
            matrix = self._matrix(str(each[0]), where)
            if matrix.shape[1] != count and matrix.shape[0] == count:
                return np.ascontiguousarray(matrix.T)
            if matrix.shape[1] != count:
                raise InputError(where, f"{each[0]} has shape {matrix.shape}", f"(any, {count})")
            return matrix
        matrices = {str(name): self._matrix(str(name), where) for name in each}
        checks.equal_lengths({name: len(matrix) for name, matrix in matrices.items()}, where)
        if len(matrices) != count or any(matrix.shape[1] != 1 for matrix in matrices.values()):
            raise InputError(where, f"names {len(each)} variables", f"{count} different ones of one column")
        return np.concatenate(list(matrices.values()), axis=1)

    def numbers(self, place: Place, count: int, where: str) -> list[tuple[str, int]]:
        """See `Source`."""
        if isinstance(place, Columns):
            return [(place.variable, int(column) - 1) for column in place.columns]
        names = place if isinstance(place, tuple) else (place,)
        return [(str(name), k) for name in names for k in range(count if len(names) == 1 else 1)]

    def _matrix(self, name: str, where: str) -> Array:
        """A variable as a matrix of samples, (n, columns); of three axes the last runs fastest."""
        here: Any = self._content
        for part in name.split("."):
            if not isinstance(here, Mapping) or part not in here:
                known = list(here) if isinstance(here, Mapping) else []
                raise InputError(where, f"{name!r} is not in {self._where}", ", ".join(known[:12]),
                                 did_you_mean(part, known))
            here = here[part]
        values = np.asarray(here) if not isinstance(here, (Mapping, list, str)) else np.zeros(0, "U1")
        if values.dtype.kind not in "fiub" or values.ndim > 3 or values.size < 2:
            raise InputError(where, f"{name!r} of {self._where} is no table of samples",
                             "numbers, (n, columns)")
        matrix = np.array(values, dtype=np.float64)
        return matrix if matrix.ndim == 2 else matrix.reshape(len(matrix), -1)
