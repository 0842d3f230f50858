"""Tables of the same instants, side by side: streams and tracking systems that are one set of sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from fesloop.errors import InputError
from fesloop.streams.checks import Array
from fesloop.streams.formats.channels import Channel, recording_of, sensors_of, units_of
from fesloop.streams.pace import pace_of
from fesloop.streams.recording import MotionRecording, Reference, Stamps
from fesloop.streams.timebase import stamps_of_times

_SAME_S = 1e-6
"""Instants that differ by no more are the same (chosen: far below a sampling period, above what a line
through clock offsets is uncertain)."""


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """One stream or tracking system.

    Attributes
    ----------
    name: for messages, "stream imu".
    key: by which `sensor_set` chooses it.
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
    resampled unasked. `remedy` is what to do then, where it is not the import that chooses; "HZ" in it stands
    for a rate that fits.
    """
    first = parts[0]
    for part in parts[1:]:
        if part.times_s.size == first.times_s.size and np.abs(part.times_s - first.times_s).max() <= _SAME_S:
            continue
        told = ", ".join(f"{each.name} ({each.times_s.size} samples{_rate(each)})" for each in parts)
        apart = "" if part.times_s.size != first.times_s.size else (
            f", by up to {1e3 * float(np.abs(part.times_s - first.times_s).max()):.3g} ms")
        choices = ", ".join(repr(each.key) for each in parts)
        raise InputError(f"{where}: {part.name}",
                         f"has other instants than {first.name}{apart}; there are {told}",
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
