"""From single channels, each a number a sample, to sensors with three axes each."""

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
from fesloop.streams.labels import not_understood, read_label
from fesloop.streams.recording import MotionRecording, Reference, Stamps
from fesloop.streams.units import factor

_PLAUSIBLE = {"gyr": checks.plausible_gyr, "acc": checks.plausible_acc, "mag": checks.plausible_mag}
_LONE_SENSOR = "imu"
_GIVE_OR_LEAVE = "give it, or leave the sensor or the magnetometers out in a layout"


@dataclass(frozen=True, slots=True)
class Channel:
    """What a channel measures.

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

    Raises InputError for an axis that is missing or there twice, or a unit that is not known; what is
    missing may be among the channels that were left out. `choose` is what to do about what is there twice.
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
    # Columns of a table lie apart in memory, and filters take samples that lie together.
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
