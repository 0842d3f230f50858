"""XDF, the file of Lab Streaming Layer: inertial sensors, found by labels and units of channels."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from fesloop.errors import InputError, did_you_mean
from fesloop.streams.formats.channels import Channel, channel_of_label
from fesloop.streams.formats.joined import Part, joined
from fesloop.streams.formats.xdf_chunks import SIGNATURE, XdfStream, read_streams
from fesloop.streams.formats.xdf_clock import instants_s
from fesloop.streams.recording import MotionRecording

__all__ = ["FORMAT", "SIGNATURE", "read"]

FORMAT = "xdf"


def read(path: Path, sensor_set: str | None) -> MotionRecording:
    """The recording of one stream, or of several that were sampled at the same instants.

    Parameters
    ----------
    sensor_set: names of the streams, with commas between; None takes every stream with channels of
        gyroscopes, accelerometers or magnetometers.

    Raises InputError for a damaged file, for a channel without a known unit, and for streams of different
    instants: nothing is resampled.
    """
    where = str(path)
    streams = [stream for stream in read_streams(path) if stream.dtype is not None]
    described = {number: _channels(stream) for number, stream in enumerate(streams)}
    chosen = [streams[number] for number in _chosen(streams, described, sensor_set, where)]
    parts = []
    for stream in chosen:
        name = f"stream {stream.name}"
        if not stream.times_s.size:
            raise InputError(f"{where}: {name}", "holds no sample", "samples")
        parts.append(Part(name, instants_s(stream, f"{where}: {name}"),
                          np.asarray(stream.values, dtype=np.float64), _channels(stream)))
    return joined(path, FORMAT, parts, sensor_set)


def _channels(stream: XdfStream) -> dict[int, Channel]:
    """The channels of inertial sensors of a stream, by number: as labels say, or types beside them."""
    found = {}
    for number, (label, unit, kind) in enumerate(zip(stream.labels, stream.units, stream.types, strict=True)):
        channel = channel_of_label(label, unit) or _channel_of_type(label, kind, unit)
        if channel is not None:
            found[number] = channel
    return found


def _channel_of_type(label: str, kind: str, unit: str) -> Channel | None:
    """A channel such as "F2p.x" of the type "AngularVelocityX", or "x" of the type "Gyroscope"."""
    point = re.fullmatch(r"(?P<sensor>.*?)[\W_]*(?P<axis>[xyz])", label.strip(), re.IGNORECASE)
    if point is None or not kind:
        return None
    axis = point["axis"].lower()
    bare = kind[:-1] if kind[-1:].lower() == axis and kind[-2:-1].islower() and kind[-1:].isupper() else kind
    told = channel_of_label(f"{bare}_{axis}", unit)
    return None if told is None else Channel(point["sensor"] or told.sensor, told.quantity, told.axis, unit)


def _chosen(streams: list[XdfStream], described: dict[int, dict[int, Channel]], sensor_set: str | None,
            where: str) -> list[int]:
    """Numbers of the streams that are wanted."""
    names = [stream.name for stream in streams]
    if sensor_set is None:
        wanted = [number for number, channels in described.items() if channels]
        if not wanted:
            raise InputError(where, "holds no stream whose channels are of inertial sensors, but "
                             + (", ".join(f"{each.name} ({each.type})" for each in streams[:8]) or "none"),
                             "channels labelled like F2p_gyr_x, with units")
        return wanted
    wanted = []
    for name in (part.strip() for part in sensor_set.split(",")):
        if names.count(name) != 1:
            found = f"{names.count(name)} streams are named {name!r}" if name in names else (
                f"has no stream {name!r}")
            raise InputError("sensor_set", f"{where}: {found}", ", ".join(names) or "none",
                             did_you_mean(name, names))
        if not described[names.index(name)]:
            raise InputError("sensor_set", f"{where}: stream {name!r} has no channel of an inertial sensor",
                             "channels labelled like F2p_gyr_x, with units")
        wanted.append(names.index(name))
    return list(dict.fromkeys(wanted))
