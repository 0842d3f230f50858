"""Recordings in files that a layout describes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from fractions import Fraction
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from fesloop.errors import InputError
from fesloop.hand.quaternion import multiply
from fesloop.loop.clock import NS_PER_S, exact_ratio
from fesloop.streams import checks
from fesloop.streams.checks import Array
from fesloop.streams.formats.channels import Part, recording_of, time_base
from fesloop.streams.formats.layout import Layout, Place, ReferenceLayout, SensorLayout, read_layout
from fesloop.streams.formats.rates import hold, onto_one_rate
from fesloop.streams.formats.sources import Source, source_of
from fesloop.streams.labels import SI, factor
from fesloop.streams.recording import MotionRecording, Reference, Stamps
from fesloop.streams.timebase import exact_rate, stamps_of_rate, stamps_of_times

_LEAST = 3
"""Least number of instants of a sensor that has its own."""
_RATES_AGREE = 1e-3
"""Relative difference allowed between the lengths of samples and of as many orientations (chosen: a rate
written with four digits is within it, 59.94 for 60 Hz is not)."""


def read_described(path: Path, layout_path: Path) -> MotionRecording:
    """The recording in a file that a layout describes.

    Raises InputError, InputErrors: faults of the layout with its key, faults of the file with the key or the
    line and column.
    """
    layout = read_layout(layout_path)
    source_format, source = source_of(path, layout, layout_path)
    units = {"gyr": layout.units.gyr, "acc": layout.units.acc, "mag": layout.units.mag}
    scales = {kind: factor(kind, unit, f"{layout_path}: units.{kind}",
                           "leave the magnetometers out if theirs is unknown" if kind == "mag" else "")
              for kind, unit in units.items()}
    sensors: dict[str, dict[str, Array]] = {}
    for name, sensor in layout.sensors.items():
        for kind, place in (("gyr", sensor.gyr), ("acc", sensor.acc), ("mag", sensor.mag)):
            if place is not None:
                samples = source.columns(place, 3, f"{layout_path}: sensors.{name}.{kind}")
                sensors.setdefault(name, {})[kind] = sensor.turned(samples * scales[kind], kind)
    _require_single(source, layout, layout_path)
    names = list(layout.sensors)
    pairs = [(names.index(parent), names.index(child)) for parent, child in layout.pairs]
    source_units = {kind: units[kind] for kind in SI if kind in units and (
        kind != "mag" or "mag" in next(iter(sensors.values())))}
    if source_format != "xdf" and (layout.resample is not None or any(
            each.time is not None for each in layout.sensors.values())):
        sensors, base, origin_s, resampled_hz = _brought_together(source, sensors, layout, layout_path)
        return recording_of(path, source_format, sensors, *base, pairs=pairs, source_units=source_units,
                            resampled_hz=resampled_hz, origin_s=origin_s)
    sensors = {name: hold(samples, asdict(layout.sensors[name].every or layout.every))
               for name, samples in sensors.items()}
    length = len(next(iter(sensors.values()))["gyr"])
    stamps, rate = _time_base(source, layout.rate, layout.time, length, layout, f"{layout_path}: ")
    checks.equal_lengths({f"sensors.{name}.{kind}": len(samples) for name, each in sensors.items()
                          for kind, samples in each.items()}, str(layout_path))
    return recording_of(
        path, source_format, sensors, stamps, rate, reference=_reference(source, layout, stamps, layout_path),
        pairs=pairs, source_units=source_units, resampled_hz=source.resampled_hz,
        origin_s=_origin_s(source, layout, f"{layout_path}: "))


def _brought_together(
    source: Source, sensors: Mapping[str, Mapping[str, Array]], layout: Layout, layout_path: Path
) -> tuple[dict[str, dict[str, Array]], tuple[Stamps, Fraction | None], float, dict[str, float]]:
    """Sensors at common instants: samples, stamps and rate, first instant, s, and each one's rate before, Hz.

    Raises InputError for sensors of different instants without `resample`.
    """
    unit_s = factor("time", layout.units.time, f"{layout_path}: units.time", "")
    parts, kinds = [], {name: list(samples) for name, samples in sensors.items()}
    for name, samples in sensors.items():
        own = layout.sensors[name].time
        key = f"sensors.{name}.time" if own is not None else "time"
        place = own if own is not None else layout.time
        assert place is not None
        times = source.columns(place, 1, f"{layout_path}: {key}")[:, 0] * unit_s
        checks.equal_lengths({key: times.size, **{f"sensors.{name}.{kind}": len(each)
                                                  for kind, each in samples.items()}}, str(layout_path))
        there = np.isfinite(times)
        if there.sum() < _LEAST:
            raise InputError(f"{layout_path}: {key}", f"holds {there.sum()} instants", f"{_LEAST} or more")
        parts.append(Part(f"sensor {name}", name, times[there],
                          np.concatenate(list(samples.values()), axis=1)[there], {}))
    resampled_hz: dict[str, float] = {}
    if layout.resample is not None:
        parts, resampled_hz = onto_one_rate(parts, layout.resample, str(layout_path))
    base = time_base(parts, str(layout_path), "write `resample = HZ` into the layout")
    split = {part.key: dict(zip(kinds[part.key], np.split(part.values, len(kinds[part.key]), axis=1),
                                strict=True)) for part in parts}
    return split, base, float(parts[0].times_s[0]), resampled_hz


def _origin_s(source: Source, layout: Layout, where: str) -> float | None:
    """First instant of the samples by the clock of the file, s; None where the file gives none."""
    if layout.time is None:
        return None
    first = float(source.columns(layout.time, 1, f"{where}time")[0, 0])
    return first * factor("time", layout.units.time, f"{where}units.time", "")


def _require_single(source: Source, layout: Layout, layout_path: Path) -> None:
    """Raise InputError where the layout uses a column of samples elsewhere, as after copying a line.

    Sensors on one segment may share its orientation.
    """
    places: list[tuple[str, Place | None, int]] = [("time", layout.time, 1)]
    places += [(f"sensors.{name}.time", time, 1) for name, time in _own_times(layout).items()]
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


def _own_times(layout: Layout) -> dict[str, Place]:
    """Places of sensors' own instants, each once: sensors may share them."""
    found: dict[str, Place] = {}
    for name, sensor in layout.sensors.items():
        if sensor.time is not None and sensor.time not in (layout.time, *found.values()):
            found[name] = sensor.time
    return found


def _twice(layout_path: Path, key: str, column: tuple[str, int], other: str) -> InputError:
    named = f"column {column[1] + 1}" + (f" of {column[0]}" if column[0] else "")
    return InputError(f"{layout_path}: {key}", f"names {named} "
                      + ("twice" if other == key else f"as well as {other}"), "each column once")


def _time_base(source: Source, rate: str | int | float | None, time: Place | None, length: int,
               layout: Layout, where: str) -> tuple[Stamps, Fraction | None]:
    """Stamps and exact rate of a layout's rate or time."""
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
    stated: ReferenceLayout = layout.reference
    places = {name: sensor.orientation for name, sensor in layout.sensors.items()
              if sensor.orientation is not None}
    if not places:
        return None
    each = []
    for name, place in places.items():
        where = f"{layout_path}: sensors.{name}.orientation"
        quaternions = source.columns(place, 4, where)
        if stated.order == "xyzw":
            quaternions = quaternions[:, [3, 0, 1, 2]]
        if stated.direction == "reference_to_segment":
            quaternions[:, 1:] *= -1.0
        unit = checks.orientations(quaternions, where)
        each.append(_turned(unit, layout.sensors[name]) if stated.sensor_frames else unit)
    checks.equal_lengths({f"{name}.orientation": len(rows) for name, rows in zip(places, each, strict=True)},
                         str(layout_path))
    if stated.rate is not None or stated.time is not None:
        own, _ = _time_base(source, stated.rate, stated.time, len(each[0]), layout,
                            f"{layout_path}: reference.")
        _require_same_pace(own, stamps, layout, str(layout_path))
        stamps = own
    if len(each[0]) != stamps.size:
        raise InputError(f"{layout_path}: reference", f"has {len(each[0])} orientations for {stamps.size} "
                         "instants", "one each", "state reference.rate or reference.time")
    scored = np.ones(stamps.size, dtype=bool)
    if stated.scored is not None:
        where = f"{layout_path}: reference.scored"
        marks = source.columns(stated.scored, 1, where)[:, 0]
        if marks.size != stamps.size or not np.isin(marks, (0.0, 1.0)).all():
            raise InputError(where, "does not mark instants", f"{stamps.size} numbers, 0 or 1 each")
        scored = marks > 0.0
    reference = Reference(stamps_ns=stamps, orientation=np.stack(each, axis=1), scored=scored,
                          sensor_frames=stated.sensor_frames, north=stated.north)
    return _on_one_clock(reference, source, layout, str(layout_path))


def _turned(orientations: Array, sensor: SensorLayout) -> Array:
    """Orientations of a segment from those of its sensor (n, 4)."""
    x, y, z, w = Rotation.from_matrix(sensor.turned(np.eye(3))).as_quat()
    return multiply(orientations, [w, x, y, z])


def _on_one_clock(reference: Reference, source: Source, layout: Layout, where: str) -> Reference:
    """The reference from the first sample on, where both have instants; else both begin together.

    Raises InputError where fewer than two of its instants are within the span of the samples.
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
    """Raise InputError where a stated rate makes orientations last longer or shorter than as many samples.

    Rows of a table, and matrices of as many rows, have the same instants. Another number of rows, or stamps
    of their own, belong to another system, which may have begun and ended at other instants.
    """
    key = "reference.rate" if layout.reference.rate is not None else "rate"
    if (layout.rate is None and layout.reference.rate is None) or reference.size != samples.size:
        return
    lasting_s, samples_s = int(reference[-1]) / NS_PER_S, int(samples[-1]) / NS_PER_S
    if abs(lasting_s - samples_s) > _RATES_AGREE * samples_s:
        raise InputError(f"{where}: {key}", f"lets {reference.size} orientations last {lasting_s:.6g} s and "
                         f"as many samples {samples_s:.6g} s", f"the same, within {100.0 * _RATES_AGREE:g} %",
                         "mend the rate; the reference takes that of the samples where none is given")
