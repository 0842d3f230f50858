"""XDF, the file of Lab Streaming Layer: inertial sensors, found by labels and units of channels.

pyxdf reads the file and brings stamps to the recorder's clock (`fesloop.streams.decoders`). Three things are
done here instead: clocks that were reset refuse the file, where pyxdf guesses how the parts belong together;
gaps are found whatever their length, where pyxdf fits its line through gaps below a second; and a nominal
rate that the stamps contradict is refused.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.streams.checks import Array
from fesloop.streams.formats.channels import Channel, Part, channel_of_label, joined
from fesloop.streams.formats.rates import Rate, onto_one_rate
from fesloop.streams.pace import level_change, on_lines, pace_of, packets, rate_change, set_back
from fesloop.streams.reading import read_file
from fesloop.streams.recording import MotionRecording
from fesloop.streams.timebase import require_rate

FORMAT = "xdf"
SIGNATURE = b"XDF:"
_INERTIAL = re.compile(r"imu|inertial|gyro|accel|magnet", re.IGNORECASE)
_MOST_CHANNELS = 10_000
_LEAST_RESET_S, _RESET_DEVIATIONS = (5.0, 1.0), (5.0, 10.0)
"""A clock was reset where the time between offsets and the offsets both jump by more than these s and median
absolute deviations (pyxdf 1.17)."""
_LEAST_JUMP_S, _OFFSETS_AROUND = 0.02, 12
"""A clock was also reset where the level of its offsets changes by more than so many s and more than their
scatter (chosen: measurements over a radio scatter by some ms); so many offsets on each side, a minute's, are
compared."""
_STEEPEST = 1e-3
"""Greatest drift of one clock against another (sensors' clocks: 1e-4); few scattered offsets exceed it."""
_PACKET_RATE = 0.9, 1.1
"""Rates of packets that share a stamp, relative to the stated rate (`require_rate` judges the rest)."""
_STEADY = "streams of steady clocks"
_SPLIT = "save the part before it, or after it, as a file of its own"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class XdfStream:
    """A stream of numbers.

    Attributes
    ----------
    name, type: as the header says; rate_hz: nominal, 0 for an irregular one.
    labels, units, types: of each channel; empty text where the header says nothing.
    sensors, pairs: of a stream that fesloop exported: names of its sensors, and of (parent, child) ones;
        None where the header lists none.
    drops: whether the header says that its sender can drop samples.
    stamps_s, times_s: (n,), on the sender's clock, and on the recorder's.
    values: (n, channels).
    clock_s, offset_s: instants on the sender's clock, and the recorder's clock less it then.
    key: name with which a user chooses it; "imu#2" for the second stream named "imu".
    """

    name: str
    type: str
    rate_hz: float
    labels: tuple[str, ...]
    units: tuple[str, ...]
    types: tuple[str, ...]
    sensors: tuple[str, ...] | None
    pairs: tuple[tuple[str, str], ...]
    drops: bool
    stamps_s: Array
    times_s: Array
    values: NDArray[Any]
    clock_s: Array
    offset_s: Array
    key: str = ""


def read_streams(path: Path) -> list[XdfStream]:
    """The streams of numbers in an XDF file; those of text are left out.

    Raises InputError for a file that is damaged, naming the byte.
    """
    return inspect_streams(path)[0]


def inspect_streams(path: Path) -> tuple[list[XdfStream], list[tuple[str, str, int]]]:
    """The streams of numbers in an XDF file, and those of text: name, type and number of samples.

    Raises InputError for a file that is damaged, naming the byte.
    """
    read = read_file("xdf", path)
    found = [_stream(each, f"{path}: stream {number + 1}")
             for number, each in enumerate(read) if each["values"] is not None]
    names = [stream.name for stream in found]
    keys = [f"{name}#{names[:number].count(name) + 1}" if names.count(name) > 1 else name
            for number, name in enumerate(names)]
    return [replace(stream, key=key) for stream, key in zip(found, keys, strict=True)], [
        (_text(each["info"], "name"), _text(each["info"], "type"), len(each["times_s"]))
                   for each in read if each["values"] is None]


def _inner(element: Any, *path: str) -> list[Any]:
    """The elements at a path of an XDF header; pyxdf gives each tag a list."""
    found = [element]
    for key in path:
        found = [each for outer in found if isinstance(outer, dict) for each in outer.get(key, [])]
    return found


def _text(element: Any, *path: str) -> str:
    """The text of the first element at a path, empty where there is none."""
    found = _inner(element, *path)
    return found[0].strip() if found and isinstance(found[0], str) else ""


def _stream(read: Mapping[str, Any], where: str) -> XdfStream:
    info, values = read["info"], read["values"]
    channels, rate = values.shape[1], float(_text(info, "nominal_srate") or 0.0)
    if not 1 <= channels <= _MOST_CHANNELS:
        raise InputError(where, f"describes {channels} channels", f"1 to {_MOST_CHANNELS}")
    if not 0.0 <= rate < np.inf:
        raise InputError(where, f"has the rate {rate}", "0 or more Hz")
    described = _inner(info, "desc", "channels", "channel")
    if described and len(described) != channels:
        raise InputError(where, f"describes {len(described)} channels and has {channels}", "one each")
    labels, units, types = (tuple(_text(each, key) for each in described) or ("",) * channels
                            for key in ("label", "unit", "type"))
    listed = _inner(info, "desc", "sensors")
    return XdfStream(
        name=_text(info, "name"), type=_text(info, "type"), rate_hz=rate, labels=labels, units=units,
        types=types,
        sensors=tuple(str(name or "") for name in _inner(listed[0], "sensor"))
        if listed else None,
        pairs=tuple((_text(pair, "parent"), _text(pair, "child"))
                    for pair in _inner(info, "desc", "pairs", "pair")),
        drops=_text(info, "desc", "synchronization", "can_drop_samples").lower() == "true",
        values=values, stamps_s=np.array(read["stamps_s"]), times_s=np.array(read["times_s"]),
        clock_s=np.array(read["clock_s"], dtype=np.float64),
        offset_s=np.array(read["offset_s"], dtype=np.float64))


def instants_s(stream: XdfStream, where: str, trust_header: bool = True) -> Array:
    """Instants of a stream's samples, (n,), s on the recorder's clock.

    Stamps whose rate changes, and those of a sender that can drop samples, keep their jitter.
    `trust_header`: whether the header's nominal rate must be that of the stamps.

    Raises InputError for instants that are no numbers, for a nominal rate that the stamps contradict, and
    for a sender whose clock was reset, as stamps that step back or clock offsets that jump show: a line
    through both parts compresses or stretches time.
    """
    times, stamps, clock, offset = stream.times_s, stream.stamps_s, stream.clock_s, stream.offset_s
    if not all(np.isfinite(each).all() for each in (times, stamps, clock, offset)):
        raise InputError(where, "has stamps that are no numbers", "an undamaged XDF file")
    back = set_back(stamps) if stream.rate_hz > 0.0 else None
    if back is not None:
        at, by_s = back
        raise InputError(where, f"has stamps that step back by {by_s:.4g} s at "
                         f"{stamps[at - 1] - stamps[0]:.6g} s (sample {at}): the sender's clock was reset",
                         _STEADY, _SPLIT)
    jump = _reset_at(clock, offset) if clock.size > 1 and times.size else None
    if jump is not None:
        raise InputError(where, f"comes from a clock that was reset: its offset from the recorder's goes "
                         f"from {offset[jump - 1]:.6g} s to {offset[jump]:.6g} s at "
                         f"{clock[jump] + offset[jump] - (stamps[0] + offset[0]):.6g} s", _STEADY, _SPLIT)
    if times.size < 2:
        return times
    pace = pace_of(times, stream.rate_hz)
    together = packets(times)
    if together and not _PACKET_RATE[0] < stream.rate_hz * pace.period_s < _PACKET_RATE[1]:
        states = f"a nominal rate of {stream.rate_hz:g} Hz does not fit" if stream.rate_hz > 0.0 else \
            "it states no nominal rate"
        whole = (times.size - together) / float(times[-1] - times[0])
        raise InputError(where, f"has samples in packets of about {together:.3g} that arrived at once, and "
                         f"{states}", "stamps of the samples, or the nominal rate that they were taken at",
                         f"let the sender state its rate (in all {whole:.4g} Hz arrived), or save the "
                         "samples as a table and give `rate` in a layout")
    if stream.rate_hz <= 0.0:
        return times
    if trust_header and not stream.drops:
        require_rate(stream.rate_hz, pace, times.size, where)
    if stream.drops or rate_change(times, pace) is not None:
        return times
    return on_lines(times, pace)


def _reset_at(clock: Array, offset: Array) -> int | None:
    """Number of the first offset measured after a sender's clock was reset; None for a steady one."""
    steps, changes = np.diff(clock), np.diff(offset)
    if (steps < 0.0).any():
        return int(np.argmax(steps < 0.0)) + 1
    jumps = []
    for differences, least_s, deviations in zip((steps, changes), _LEAST_RESET_S, _RESET_DEVIATIONS,
                                                strict=True):
        off = np.abs(differences - np.median(differences))
        jumps.append((off > least_s) & (off > deviations * (np.median(off) + np.finfo(float).eps)))
    if (jumps[0] & jumps[1]).any():
        return int(np.argmax(jumps[0] & jumps[1])) + 1
    far = (np.flatnonzero(np.abs(changes) > 0.5 * _LEAST_JUMP_S) + 1).tolist()
    found = [k for k in far
             if abs(level_change(clock, offset, k, _OFFSETS_AROUND, steepest=_STEEPEST)) > _LEAST_JUMP_S]
    return max(found, key=lambda k: abs(float(changes[k - 1])), default=None)


def read(path: Path, sensor_set: str | None, resample: Rate | None = None) -> MotionRecording:
    """The recording of one stream, or of several of the same instants, or resampled to them.

    Parameters
    ----------
    sensor_set: names of the streams, with commas between, "imu#1" and "imu#2" for two of one name; None takes
        every stream with channels of gyroscopes, accelerometers or magnetometers.

    Labels that are not understood, of these streams or of one that says it is of inertial sensors, are in
    `left_out`.

    Raises InputError for a damaged file, for a channel without a known unit, and for streams of different
    instants without `resample`.
    """
    where = str(path)
    streams = read_streams(path)
    described = [_channels(stream) for stream in streams]
    chosen = _chosen(streams, described, sensor_set, where)
    parts: list[Part] = []
    for number in chosen:
        stream = streams[number]
        name = f"stream {stream.key}"
        if not stream.times_s.size:
            raise InputError(f"{where}: {name}", "holds no sample", "samples")
        parts.append(Part(name, stream.key, instants_s(stream, f"{where}: {name}"),
                          np.asarray(stream.values, dtype=np.float64), described[number]))
    left_out = [label or f"{stream.name} channel {channel + 1}"
                for number, stream in enumerate(streams)
                if number in chosen or (sensor_set is None
                                        and _INERTIAL.search(f"{stream.type} {stream.name}"))
                for channel, label in enumerate(stream.labels) if channel not in described[number]]
    parts, resampled_hz = (parts, {}) if resample is None else onto_one_rate(parts, resample, where)
    return joined(path, FORMAT, parts, sensor_set, left_out=left_out, resampled_hz=resampled_hz,
                  pairs=[pair for number in chosen for pair in streams[number].pairs])


def _channels(stream: XdfStream) -> dict[int, Channel]:
    """The channels of inertial sensors of a stream, by number: as labels say, or types beside them.

    A stream that lists its sensors, as fesloop exports them, has three channels of each, of the quantity that
    their types say; one that lists none is of something else, whatever its labels are like.
    """
    if stream.sensors is not None and 3 * len(stream.sensors) in (0, len(stream.labels)):
        if not stream.sensors:
            return {}
        stated = {number: channel_of_label("xyz"[number % 3], unit, kind)
                  for number, (unit, kind) in enumerate(zip(stream.units, stream.types, strict=True))}
        return {number: replace(channel, sensor=stream.sensors[number // 3])
                for number, channel in stated.items() if channel is not None}
    described = zip(stream.labels, stream.units, stream.types, strict=True)
    found = {number: channel_of_label(*each) for number, each in enumerate(described)}
    return {number: channel for number, channel in found.items() if channel is not None}


def _chosen(streams: Sequence[XdfStream], described: Sequence[Mapping[int, Channel]], sensor_set: str | None,
            where: str) -> list[int]:
    """Numbers of the streams to read."""
    names = [stream.key for stream in streams]
    allowed = "channels labelled like F2p_gyr_x, with units"
    if sensor_set is None:
        inertial = [number for number, channels in enumerate(described) if channels]
        if not inertial:
            raise InputError(where, "holds no stream whose channels are of inertial sensors, but "
                             + (", ".join(f"{each.key} ({each.type})" for each in streams[:8]) or "none"),
                             allowed)
        return inertial
    chosen: dict[int, None] = {}
    for name in (part.strip() for part in sensor_set.split(",")):
        if name not in names:
            alike = [stream.key for stream in streams if stream.name == name]
            raise InputError("sensor_set", f"{where}: {len(alike)} streams are named {name!r}" if alike else
                             f"{where}: has no stream {name!r}", ", ".join(alike or names) or "none",
                             did_you_mean(name, names))
        if not described[names.index(name)]:
            raise InputError("sensor_set", f"{where}: stream {name!r} has no channel of an inertial sensor",
                             allowed)
        chosen[names.index(name)] = None
    return list(chosen)
