"""Sensors of three axes out of single channels, and parts of the same instants side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from fesloop.errors import InputError
from fesloop.hand.skeleton import pairs_of_names
from fesloop.streams import checks
from fesloop.streams.checks import Array
from fesloop.streams.labels import factor, not_understood, read_label
from fesloop.streams.pace import pace_of
from fesloop.streams.recording import MotionRecording, Reference, Stamps
from fesloop.streams.timebase import stamps_of_times

_PLAUSIBLE = {"gyr": checks.plausible_gyr, "acc": checks.plausible_acc, "mag": checks.plausible_mag}
_LONE_SENSOR = "imu"
_GIVE_OR_LEAVE = "give it, or leave the sensor or the magnetometers out in a layout"


@dataclass(frozen=True, slots=True)
class Channel:
    """Quantity that a channel measures.

    Attributes
    ----------
    sensor: name of the sensor, "imu" where the label names none.
    quantity: "gyr", "acc" or "mag".
    axis: 0, 1, 2.
    unit: as the file names it.
    """

    sensor: str
    quantity: str
    axis: int
    unit: str


def channel_of_label(label: str, unit: str, channel_type: str = "") -> Channel | None:
    """The channel of a label, or of a type beside it (`read_label`); None of something else."""
    read = read_label(label, channel_type)
    if read is None:
        return None
    return Channel(read.sensor or _LONE_SENSOR, read.quantity, "xyz".index(read.axis), unit)


def sensors_of(channels: Mapping[int, Channel], table: Array, where: str,
               left_out: Sequence[str] = (), choose: str = "") -> dict[str, dict[str, Array]]:
    """Samples in SI of each sensor, {sensor: {quantity: (n, 3)}}, from the columns of a table (n, columns).

    Raises InputError for an axis that is missing or there twice, or a unit that is not known; a missing axis
    may be among the channels that were left out. `choose` is the remedy for two of one axis.
    """
    columns: dict[tuple[str, str], dict[int, int]] = {}
    for number, channel in channels.items():
        axes = columns.setdefault((channel.sensor, channel.quantity), {})
        if channel.axis in axes:
            raise InputError(f"{where}: {channel.sensor}", f"has two channels of {channel.quantity} "
                             f"{'xyz'[channel.axis]}", "one an axis", choose)
        axes[channel.axis] = number
    sensors: dict[str, dict[str, Array]] = {}
    for (sensor, quantity), axes in columns.items():
        place = f"{where}: {sensor}: {quantity}"
        if len(axes) < 3:
            raise InputError(place, f"has no axis {next('xyz'[i] for i in range(3) if i not in axes)}",
                             "x, y and z", not_understood(left_out))
        scales = [factor(quantity, channels[axes[i]].unit, place) for i in range(3)]
        sensors.setdefault(sensor, {})[quantity] = table[:, [axes[i] for i in range(3)]] * scales
    return sensors


def recording_of(
    path: Path, source_format: str, sensors: Mapping[str, Mapping[str, Array]], stamps_ns: Stamps,
    rate: Fraction | None, *, sensor_set: str | None = None, reference: Reference | None = None,
    pairs: Sequence[tuple[int, int]] = (), source_units: Mapping[str, str] | None = None,
    left_out: Sequence[str] = (), resampled_hz: Mapping[str, float] | None = None,
    origin_s: float | None = None,
) -> MotionRecording:
    """The recording of sensors that all have `gyr` and `acc`, and all or none `mag`, each (n, 3) in SI.

    Raises InputError naming the sensor for what is missing, of another length or not plausible in SI.
    """
    if not sensors:
        raise InputError(str(path), "holds no inertial sensor", "gyroscopes and accelerometers")
    with_mag = {name for name, quantities in sensors.items() if "mag" in quantities}
    kinds = ("gyr", "acc", "mag") if with_mag else ("gyr", "acc")
    stacked: dict[str, list[Array]] = {kind: [] for kind in kinds}
    for name, quantities in sensors.items():
        for kind in kinds:
            place = f"{path}: {name}: {kind}"
            if kind not in quantities:
                raise InputError(place, "is missing" + (f", {min(with_mag)} has it" if kind == "mag" else ""),
                                 remedy="; ".join(filter(None, (_GIVE_OR_LEAVE, not_understood(left_out)))))
            samples = quantities[kind]
            if samples.shape != (stamps_ns.size, 3):
                raise InputError(place, f"has shape {samples.shape}", f"({stamps_ns.size}, 3)")
            _PLAUSIBLE[kind](samples, place)
            stacked[kind].append(samples)
    # Columns of a table are strided in memory, and filters take contiguous samples.
    gyr, acc, mag = (np.ascontiguousarray(np.stack(stacked[kind], axis=1)) if kind in stacked else None
                     for kind in ("gyr", "acc", "mag"))
    assert gyr is not None
    assert acc is not None
    return MotionRecording(
        path=path, source_format=source_format, sensor_set=sensor_set, sensors=tuple(sensors), rate=rate,
        stamps_ns=stamps_ns, gyr=gyr, acc=acc, mag=mag, reference=reference,
        pairs=tuple(pairs) or pairs_of_names(tuple(sensors)),
        source_units=dict(source_units or {}), left_out=tuple(left_out),
        resampled_hz=dict(resampled_hz or {}), origin_s=origin_s)


def units_of(channels: Mapping[int, Channel]) -> dict[str, str]:
    """Unit of each quantity as the file names it; several are joined by commas."""
    found: dict[str, list[str]] = {}
    for channel in channels.values():
        units = found.setdefault(channel.quantity, [])
        if channel.unit not in units:
            units.append(channel.unit)
    return {quantity: ", ".join(units) for quantity, units in found.items()}


_SAME_S = 1e-6
"""Instants that differ by no more are the same (chosen: far below a sampling period, above what a line
through clock offsets is uncertain)."""


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """One stream or tracking system.

    Attributes
    ----------
    name: for messages, "stream imu".
    key: its name in `sensor_set`.
    times_s: (n,), on a clock that all parts share.
    values: (n, columns).
    channels: of inertial sensors, by number of the column.
    """

    name: str
    key: str
    times_s: Array
    values: Array
    channels: dict[int, Channel]


def suggested_hz(parts: Sequence[Part]) -> int:
    """A rate that all parts can be brought to: the fastest one's between its gaps, in whole Hz."""
    return max(1, *(round(pace_of(part.times_s).rate_hz) for part in parts if part.times_s.size > 2), 1)


def time_base(parts: Sequence[Part], where: str, remedy: str = "") -> tuple[Stamps, Fraction | None]:
    """Stamps from the first sample on, ns, and exact rate, which all parts share.

    Raises InputError for parts of different instants, as of devices that sample by themselves: nothing is
    resampled without a rate. `remedy` replaces that of the import; "HZ" in it becomes a rate that fits.
    """
    first = parts[0]
    for part in parts[1:]:
        if part.times_s.size == first.times_s.size and np.abs(part.times_s - first.times_s).max() <= _SAME_S:
            continue
        rates = ", ".join(f"{each.name} ({each.times_s.size} samples{_rate(each)})" for each in parts)
        apart = "" if part.times_s.size != first.times_s.size else (
            f", by up to {1e3 * float(np.abs(part.times_s - first.times_s).max()):.3g} ms")
        choices = ", ".join(repr(each.key) for each in parts)
        raise InputError(f"{where}: {part.name}",
                         f"has other instants than {first.name}{apart}; there are {rates}",
                         "the same instants: nothing is resampled unasked",
                         (remedy or "import them at common instants with `--resample HZ`, or play each by "
                          f"itself, with sensor_set one of {choices}").replace(
                              "HZ", str(suggested_hz(parts)), 1))
    return stamps_of_times(first.times_s - first.times_s[0], 1.0, f"{where}: {first.name}")


def _rate(part: Part) -> str:
    """The mean rate of a part, for messages."""
    lasts_s = float(part.times_s[-1] - part.times_s[0])
    return f" at {(part.times_s.size - 1) / lasts_s:.4g} Hz" if lasts_s > 0.0 else ""


def joined(path: Path, source_format: str, parts: Sequence[Part], sensor_set: str | None,
           reference: Reference | None = None, left_out: Sequence[str] = (),
           pairs: Sequence[tuple[str, str]] = (),
           resampled_hz: Mapping[str, float] | None = None) -> MotionRecording:
    """The recording of all sensors of all parts; `left_out` are labels of channels that are in none.

    `pairs`: names of (parent, child) sensors, as the parts state them; those of absent sensors do not count.

    Raises InputError as `time_base`, and for sensors that lack a channel or a known unit.
    """
    channels: dict[int, Channel] = {}
    first = 0
    for part in parts:
        channels |= {first + number: channel for number, channel in part.channels.items()}
        first += part.values.shape[1]
    stamps, rate = time_base(parts, str(path))
    table = np.concatenate([part.values for part in parts], axis=1)
    choices = ", ".join(repr(part.key) for part in parts)
    sensors = sensors_of(channels, table, str(path), left_out, f"choose with sensor_set, of {choices}")
    names = list(sensors)
    stated = [(names.index(parent), names.index(child)) for parent, child in dict.fromkeys(pairs)
              if parent in sensors and child in sensors]
    return recording_of(path, source_format, sensors, stamps, rate, sensor_set=sensor_set,
                        reference=reference, pairs=stated, source_units=units_of(channels), left_out=left_out,
                        resampled_hz=resampled_hz, origin_s=float(parts[0].times_s[0]))
