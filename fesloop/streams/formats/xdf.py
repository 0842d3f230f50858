"""XDF, the file of Lab Streaming Layer: inertial sensors, found by labels and units of channels."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from fesloop.errors import InputError, did_you_mean
from fesloop.streams.checks import Array
from fesloop.streams.formats.channels import Channel, channel_of_label
from fesloop.streams.formats.joined import Part, joined
from fesloop.streams.formats.one_rate import Rate, onto_one_rate
from fesloop.streams.formats.xdf_chunks import SIGNATURE, XdfStream, read_streams
from fesloop.streams.pace import level_change, on_lines, pace_of, packets, rate_change, set_back
from fesloop.streams.recording import MotionRecording
from fesloop.streams.timebase import require_rate

_WINSOR_S = 1e-4
"""Offsets further from the line than this count less (pyxdf 1.17: winsor_threshold)."""
_LEAST = np.finfo(float).tiny
_ITERATIONS = 1000
_MOST_OFFSETS = 20_000
"""Chosen: LabRecorder measures one each 5 s, so these are of more than a day; the line takes a second."""
_RESET_S, _RESET_DEVIATIONS = (5.0, 1.0), (5.0, 10.0)
"""A clock was reset where the time between offsets and the offsets both jump by more than these s and median
absolute deviations (pyxdf 1.17)."""
_LEAST_JUMP_S, _OFFSETS_AROUND = 0.02, 12
"""A clock was reset as well where its offsets lie at another level than before, by more than so many s and
than their scatter (chosen: measurements over a radio scatter by some ms; those of a minute are compared)."""
_STEEPEST = 1e-3
"""No clock gains more on another (sensors' clocks: 1e-4); a slope above is of scatter between few offsets."""
_RIGHT = 0.9, 1.1
"""Of a stated rate, what packets that share a stamp are at (`require_rate` judges the rest)."""
_STEADY = "streams of steady clocks"
_PARTS = "save the part before it, or after it, as a file of its own"


def instants_s(stream: XdfStream, where: str, trust_header: bool = True) -> Array:
    """Instants of a stream's samples, (n,), s on the recorder's clock.

    Stamps whose rate changes on the way, and those of a sender that can drop samples, keep their jitter.
    `trust_header`: whether the header's nominal rate must be that of the stamps.

    Raises InputError for instants that are no numbers, for a nominal rate that the stamps contradict, and
    for a sender whose clock was reset on the way, as stamps that step back or clock offsets that jump show:
    pyxdf would guess how the parts belong together, and a line through both compresses or stretches time.
    """
    if not np.isfinite(stream.times_s).all():
        raise InputError(where, "has stamps that are no numbers", "an undamaged XDF file")
    times: Array = np.array(stream.times_s)
    back = set_back(times) if stream.rate_hz > 0.0 else None
    if back is not None:
        at, by_s = back
        raise InputError(where, f"has stamps that step back by {by_s:.4g} s at "
                         f"{times[at - 1] - times[0]:.6g} s (sample {at}): the sender's clock was set anew",
                         _STEADY, _PARTS)
    if stream.clock_s:
        times = times + _offsets(stream, times, where)
    if times.size < 2:
        return times
    pace = pace_of(times, stream.rate_hz)
    together = packets(times)
    if together and not _RIGHT[0] < stream.rate_hz * pace.period_s < _RIGHT[1]:
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


def _offsets(stream: XdfStream, times: Array, where: str) -> Array:
    """By how much instants on the sender's clock are behind, (n,), s."""
    clock, offset = np.array(stream.clock_s), np.array(stream.offset_s)
    if clock.size > _MOST_OFFSETS:
        raise InputError(where, f"has {clock.size} clock offsets", f"at most {_MOST_OFFSETS}")
    if clock.size == 1:
        return np.full(times.size, offset[0])
    at = _reset_at(clock, offset)
    if at is not None:
        on_recorder = clock + offset
        raise InputError(where, f"comes from a clock that was set anew: its offset from the recorder's goes "
                         f"from {offset[at - 1]:.6g} s to {offset[at]:.6g} s at "
                         f"{on_recorder[at] - (times[0] + offset[0]):.6g} s", _STEADY, _PARTS)
    first, slope = _robust_line(clock, offset)
    return np.asarray(first + slope * (times - clock.min()))


def _reset_at(clock: Array, offset: Array) -> int | None:
    """Number of the first measurement of its offset after a sender's clock jumped; None for a steady one."""
    steps, changes = np.diff(clock), np.diff(offset)
    if (steps < 0.0).any():
        return int(np.argmax(steps < 0.0)) + 1
    jumps = []
    for differences, limit_s, deviations in zip((steps, changes), _RESET_S, _RESET_DEVIATIONS, strict=True):
        off = np.abs(differences - np.median(differences))
        jumps.append((off > limit_s) & (off > deviations * (np.median(off) + np.finfo(float).eps)))
    if (jumps[0] & jumps[1]).any():
        return int(np.argmax(jumps[0] & jumps[1])) + 1
    far = (np.flatnonzero(np.abs(changes) > 0.5 * _LEAST_JUMP_S) + 1).tolist()
    found = [k for k in far
             if abs(level_change(clock, offset, k, _OFFSETS_AROUND, steepest=_STEEPEST)) > _LEAST_JUMP_S]
    return max(found, key=lambda k: abs(float(changes[k - 1])), default=None)


def _robust_line(clock: Array, offset: Array) -> tuple[float, float]:
    """Offset at the first measurement, and slope, of the line with the least Huber loss.

    Solved by the alternating direction method of multipliers (Boyd et al. 2011, section 6.1.1,
    doi 10.1561/2200000016), as pyxdf does, in units of the loss's threshold.
    """
    design = np.stack([np.ones(clock.size), (clock - clock.min()) / _WINSOR_S], axis=1)
    wanted = offset / _WINSOR_S
    gram = design.T @ design
    if np.linalg.cond(gram) > 1.0 / np.finfo(float).eps:
        return float(np.median(offset)), 0.0
    solve = np.linalg.solve(gram, design.T)
    residual = dual = np.zeros(clock.size)
    line = np.zeros(2)
    for _ in range(_ITERATIONS):
        line = solve @ (wanted + residual - dual)
        off = design @ line - wanted + dual
        size = np.abs(off)
        beyond = np.maximum(0.0, 1.0 - 2.0 / np.maximum(size, _LEAST))
        residual = 0.5 * off + 0.5 * beyond * off
        dual = off - residual
    return float(line[0] * _WINSOR_S), float(line[1])


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
