"""XDF, the file of Lab Streaming Layer: inertial sensors, found by labels and units of channels."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from fesloop.errors import InputError, did_you_mean
from fesloop.streams.formats.channels import Channel, channel_of_label
from fesloop.streams.formats.joined import Part, joined
from fesloop.streams.formats.one_rate import Rate, onto_one_rate
from fesloop.streams.formats.xdf_chunks import SIGNATURE, XdfStream, read_streams
from fesloop.streams.formats.xdf_clock import instants_s
from fesloop.streams.recording import MotionRecording

__all__ = ["FORMAT", "SIGNATURE", "read"]

FORMAT = "xdf"
_INERTIAL = re.compile(r"imu|inertial|gyro|accel|magnet", re.IGNORECASE)


def read(path: Path, sensor_set: str | None, resample: Rate | None = None) -> MotionRecording:
    """The recording of one stream, or of several of the same instants, or brought to them.

    Parameters
    ----------
    sensor_set: names of the streams, with commas between, "imu#1" and "imu#2" for two of one name; None takes
        every stream with channels of gyroscopes, accelerometers or magnetometers.

    What is not understood of these, or of a stream that says it is of inertial sensors, is in `left_out`.

    Raises InputError for a damaged file, for a channel without a known unit, and for streams of different
    instants without `resample`.
    """
    where = str(path)
    streams = [stream for stream in read_streams(path) if stream.dtype is not None]
    described = {number: _channels(stream) for number, stream in enumerate(streams)}
    chosen = _chosen(streams, described, sensor_set, where)
    parts: list[Part] = []
    for number in chosen:
        stream = streams[number]
        name = f"stream {stream.key}"
        if not stream.times_s.size:
            raise InputError(f"{where}: {name}", "holds no sample", "samples")
        parts.append(Part(name, stream.key, instants_s(stream, f"{where}: {name}"),
                          np.asarray(stream.values, dtype=np.float64), described[number]))
    meant = chosen if sensor_set is not None else [
        number for number, stream in enumerate(streams)
        if number in chosen or _INERTIAL.search(f"{stream.type} {stream.name}")]
    left_out = [label for number in meant for label in _others(streams[number], described[number])]
    parts, resampled_hz = (parts, {}) if resample is None else onto_one_rate(parts, resample, where)
    return joined(path, FORMAT, parts, sensor_set, left_out=left_out, resampled_hz=resampled_hz,
                  pairs=[pair for number in chosen for pair in streams[number].pairs])


def _channels(stream: XdfStream) -> dict[int, Channel]:
    """The channels of inertial sensors of a stream, by number: as labels say, or types beside them.

    A stream that lists its sensors, as fesloop exports them, has three channels of each, of the quantity that
    their types say; one that lists none is of something else, whatever its labels are like.
    """
    if stream.sensors is not None and 3 * len(stream.sensors) in (0, stream.channels):
        if not stream.sensors:
            return {}
        stated = {number: channel_of_label("xyz"[number % 3], unit, kind)
                  for number, (unit, kind) in enumerate(zip(stream.units, stream.types, strict=True))}
        return {number: replace(channel, sensor=stream.sensors[number // 3])
                for number, channel in stated.items() if channel is not None}
    described = zip(stream.labels, stream.units, stream.types, strict=True)
    found = {number: channel_of_label(*each) for number, each in enumerate(described)}
    return {number: channel for number, channel in found.items() if channel is not None}


def _others(stream: XdfStream, understood: Mapping[int, Channel]) -> list[str]:
    """Labels of a stream's other channels."""
    return [label or f"{stream.name} channel {number + 1}" for number, label in enumerate(stream.labels)
            if number not in understood]


def _chosen(streams: list[XdfStream], described: dict[int, dict[int, Channel]], sensor_set: str | None,
            where: str) -> list[int]:
    """Numbers of the streams that are wanted."""
    names = [stream.key for stream in streams]
    if sensor_set is None:
        wanted = [number for number, channels in described.items() if channels]
        if not wanted:
            raise InputError(where, "holds no stream whose channels are of inertial sensors, but "
                             + (", ".join(f"{each.key} ({each.type})" for each in streams[:8]) or "none"),
                             "channels labelled like F2p_gyr_x, with units")
        return wanted
    wanted = []
    for name in (part.strip() for part in sensor_set.split(",")):
        if name not in names:
            alike = [stream.key for stream in streams if stream.name == name]
            raise InputError("sensor_set", f"{where}: {len(alike)} streams are named {name!r}" if alike else
                             f"{where}: has no stream {name!r}", ", ".join(alike or names) or "none",
                             did_you_mean(name, names))
        if not described[names.index(name)]:
            raise InputError("sensor_set", f"{where}: stream {name!r} has no channel of an inertial sensor",
                             "channels labelled like F2p_gyr_x, with units")
        wanted.append(names.index(name))
    return list(dict.fromkeys(wanted))
