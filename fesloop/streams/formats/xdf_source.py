"""Columns of an XDF file's streams, for a layout: where they do not label channels or state no units.

    time = "imu"                    # the instants of this stream
    [units]
    gyr = "deg/s"
    acc = "g"
    [sensors.hand]
    gyr = ["wx", "wy", "wz"]        # channels of that stream by label, or by number from 1
    acc = {variable = "acc", columns = [1, 2, 3]}       # of another one, of the same instants or resampled
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fesloop.errors import InputError, did_you_mean
from fesloop.streams.checks import Array
from fesloop.streams.formats.joined import Part, time_base
from fesloop.streams.formats.layout import Columns, Place
from fesloop.streams.formats.one_rate import Rate, onto_one_rate
from fesloop.streams.formats.xdf import instants_s
from fesloop.streams.formats.xdf_chunks import XdfStream, read_streams


class XdfSource:
    """The numeric streams of a file, by name.

    Parameters
    ----------
    path: of the file.
    timed: the layout's `time`: the stream whose instants are the recording's, and whose channels are meant
        where none is named.
    where: the layout, for messages.
    resample: the layout's `resample`: a rate of common instants to bring the streams to, Hz.
    named: the other streams that the layout takes channels of.

    Attributes
    ----------
    resampled_hz: rate of each stream before it was brought to common instants, Hz; empty where none was.

    Raises InputError for a damaged file.
    """

    def __init__(self, path: Path, timed: Place | None, where: str, resample: Rate | None = None,
                 named: Sequence[str] = ()) -> None:
        self._where = str(path)
        self._streams = [stream for stream in read_streams(path) if stream.dtype is not None]
        if not isinstance(timed, str):
            raise InputError(f"{where}: time", "names no stream of the XDF file", ", ".join(
                stream.name for stream in self._streams), "the instants of a stream are in the file")
        self._timed = self._stream(timed, f"{where}: time")
        self._used = {self._timed.key: self._timed}
        self._brought: dict[str, Part] = {}
        self.resampled_hz: dict[str, float] = {}
        if resample is not None:
            streams = [self._timed, *(self._stream(name, f"{where}: sensors") for name in named)]
            used = {stream.key: stream for stream in streams}
            parts, self.resampled_hz = onto_one_rate(
                [self._part(stream) for stream in used.values()], resample, self._where)
            self._brought = {part.key: part for part in parts}

    def columns(self, place: Place, count: int, where: str) -> Array:
        """Channels, (n, count); of a stream's name alone its instants, (n, 1), s.

        Raises InputError for a stream or channel that is not there, and, where instants are asked for, if
        streams that were used before have others.
        """
        if isinstance(place, str) and count == 1:
            return self._instants()[:, np.newaxis]
        channels = self.numbers(place, count, where)
        stream = self._stream(channels[0][0], where)
        self._used[stream.key] = stream
        values = self._brought[stream.key].values if self._brought else stream.values
        return np.asarray(values, dtype=np.float64)[:, [number for _, number in channels]]

    def numbers(self, place: Place, count: int, where: str) -> list[tuple[str, int]]:
        """Stream and number from 0 of each channel; none where a stream's name means its instants."""
        if isinstance(place, str) and count == 1:
            return []
        stream, wanted = self._timed, place if isinstance(place, tuple) else ()
        if isinstance(place, Columns):
            stream, wanted = self._stream(place.variable, where), place.columns
        if len(wanted) != count:
            raise InputError(where, f"names {len(wanted)} channels", f"{count}")
        return [(stream.key, _number(each, stream, where)) for each in wanted]

    def _instants(self) -> Array:
        parts = list(self._brought.values()) or [self._part(stream) for stream in self._used.values()]
        time_base(parts, self._where, "write `resample = HZ` into the layout, or take the sensors of each "
                  "stream in a layout and a block of their own")
        return np.asarray(parts[0].times_s)

    def _part(self, stream: XdfStream) -> Part:
        name = f"stream {stream.key}"
        # A layout names the stamps as the time: what the header says of a rate does not matter.
        times = instants_s(stream, f"{self._where}: {name}", trust_header=False)
        return Part(name, stream.key, times, np.asarray(stream.values, dtype=np.float64), {})

    def _stream(self, name: str, where: str) -> XdfStream:
        found = [stream for stream in self._streams if stream.key == name]
        names = [stream.key for stream in self._streams]
        if not found:
            alike = [stream.key for stream in self._streams if stream.name == name]
            raise InputError(where, f"{len(alike)} streams of {self._where} are named {name!r}",
                             ", ".join(alike or names) or "none", did_you_mean(name, names))
        if not found[0].times_s.size:
            raise InputError(where, f"stream {name!r} of {self._where} holds no sample", "samples")
        return found[0]


def _number(channel: str | int, stream: XdfStream, where: str) -> int:
    """Number of a channel, from 0."""
    if isinstance(channel, int):
        if not 1 <= channel <= stream.channels:
            raise InputError(where, f"channel {channel}", f"1 to {stream.channels} of stream {stream.name}")
        return channel - 1
    if stream.labels.count(channel) != 1:
        found = f"{stream.labels.count(channel)} channels of stream {stream.name} are labelled {channel!r}"
        raise InputError(where, found, ", ".join(stream.labels[:12]), did_you_mean(channel, stream.labels))
    return stream.labels.index(channel)
