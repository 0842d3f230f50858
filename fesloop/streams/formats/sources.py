"""Sources of a layout's columns: text tables, variables of containers, and streams of XDF files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from fesloop.errors import InputError, did_you_mean
from fesloop.streams import checks
from fesloop.streams.checks import Array
from fesloop.streams.formats.channels import Part, time_base
from fesloop.streams.formats.layout import Columns, Layout, Place
from fesloop.streams.formats.rates import Rate, onto_one_rate
from fesloop.streams.formats.xdf import SIGNATURE, XdfStream, instants_s, read_streams
from fesloop.streams.reading import head_of, is_container, read_container
from fesloop.streams.text_table import TextTable, read_table

_OTHER_FILE = 'columns of another file are {file = "NAME", columns = [...]}'
_ALLOWED = "a text file with a table of numbers, a .mat, .npz, HDF5 or XDF file"


class Source(Protocol):
    """A file that a layout takes columns from.

    Attributes
    ----------
    resampled_hz: rate of each stream before all were brought to common instants, Hz; empty where none was.
    """

    resampled_hz: dict[str, float]

    def columns(self, place: Place, count: int, where: str) -> Array:
        """The columns of a place, (n, count), a fresh array."""

    def numbers(self, place: Place, count: int, where: str) -> list[tuple[str, int]]:
        """Variable and number from 0 of each of these columns, however the place names them."""


def source_of(path: Path, layout: Layout, layout_path: Path) -> tuple[str, Source]:
    """The form of a file, "xdf", "variables" or "table", and the source of its numbers.

    Columns of other files are read from these. Raises InputError for files that cannot be read.
    """
    places = [place for each in layout.sensors.values()
              for place in (each.gyr, each.acc, each.mag, each.orientation)]
    places += [layout.time, layout.reference.time, layout.reference.scored]
    places += [each.time for each in layout.sensors.values()]
    chosen = [place for place in places if isinstance(place, Columns)]
    others = {place.file: path.parent / place.file for place in chosen if place.file}
    source_format, source = _source(path, layout, layout_path, chosen)
    if not others:
        return source_format, source
    return source_format, _Several(source, {
        name: _source(other, layout, layout_path, chosen)[1] for name, other in others.items()})


def _source(path: Path, layout: Layout, layout_path: Path, chosen: Sequence[Columns]) -> tuple[str, Source]:
    """The form of one file, and the source of its numbers."""
    head = head_of(path, _ALLOWED)
    if head.startswith(SIGNATURE):
        if any(each.time is not None for each in layout.sensors.values()):
            raise InputError(f"{layout_path}: sensors", "a sensor has a time of its own",
                             "streams, which have instants", "name its stream with `variable`")
        if any(place.file for place in chosen):
            raise InputError(f"{layout_path}: file", f"{path} is an XDF file", "tables and variables",
                             "name its streams with `variable`")
        return "xdf", XdfSource(path, layout.time, str(layout_path), layout.resample, [
            place.variable for place in chosen])
    if layout.resample is not None and layout.rate is not None:
        raise InputError(f"{layout_path}: resample", f"{path} has one rate, which the layout states",
                         "an XDF file of several streams, or instants (`time`)", "leave it out")
    if is_container(head):
        return "variables", _Variables(read_container(path), str(path))
    return "table", _Table(read_table(path, layout.text), str(path))


class _Several:
    """Columns of several files of the same rows: of `main`, and of `others` by name."""

    def __init__(self, main: Source, others: Mapping[str, Source]) -> None:
        self._main, self._others = main, others
        self.resampled_hz = main.resampled_hz

    def columns(self, place: Place, count: int, where: str) -> Array:
        """See `Source`."""
        source, own, _ = self._of(place)
        return source.columns(own, count, where)

    def numbers(self, place: Place, count: int, where: str) -> list[tuple[str, int]]:
        """See `Source`."""
        source, own, name = self._of(place)
        return [(f"{name} {variable}".strip(), number)
                for variable, number in source.numbers(own, count, where)]

    def _of(self, place: Place) -> tuple[Source, Place, str]:
        """Source of a place, the place in it, and the name of its file, "" for `main`."""
        if not isinstance(place, Columns) or not place.file:
            return self._main, place, ""
        # Without a variable, columns are those of a table, or variables by name.
        own = replace(place, file="") if place.variable else place.columns
        return self._others[place.file], own, place.file


class _Table:
    """Columns of a text table, by name or by number from 1."""

    def __init__(self, table: TextTable, where: str) -> None:
        self._table, self._where = table, where
        self.resampled_hz: dict[str, float] = {}

    def columns(self, place: Place, count: int, where: str) -> Array:
        """See `Source`."""
        return self._table.values[:, [number for _, number in self.numbers(place, count, where)]]

    def numbers(self, place: Place, count: int, where: str) -> list[tuple[str, int]]:
        """See `Source`."""
        if isinstance(place, Columns):
            raise InputError(where, "names a variable, but a text file is one table", "columns alone",
                             _OTHER_FILE)
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
            found = "is listed twice in" if column in names else "is no column of"
            raise InputError(where, f"{column!r} {found} {self._where}", ", ".join(names[:12]) or "numbers",
                             "; ".join(filter(None, (did_you_mean(column, names), _OTHER_FILE))))
        return names.index(column)


class _Variables:
    """Variables of a container, structures by dots."""

    def __init__(self, content: Mapping[str, Any], where: str) -> None:
        self._content, self._where = content, where
        self.resampled_hz: dict[str, float] = {}

    def columns(self, place: Place, count: int, where: str) -> Array:
        """See `Source`; a whole variable is (n, count) or, where that leaves no doubt, (count, n)."""
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
                                 "; ".join(filter(None, (did_you_mean(part, known), _OTHER_FILE))))
            here = here[part]
        values = np.asarray(here) if not isinstance(here, (Mapping, list, str)) else np.zeros(0, "U1")
        if values.dtype.kind not in "fiub" or values.ndim > 3 or values.size < 2:
            raise InputError(where, f"{name!r} of {self._where} is no table of samples",
                             "numbers, (n, columns)")
        matrix = np.array(values, dtype=np.float64)
        return matrix if matrix.ndim == 2 else matrix.reshape(len(matrix), -1)


class XdfSource:
    """Streams of an XDF file by name, where they do not label channels or state no units.

        time = "imu"                    # the instants of this stream
        [units]
        gyr = "deg/s"
        acc = "g"
        [sensors.hand]
        gyr = ["wx", "wy", "wz"]        # channels of that stream by label, or by number from 1
        acc = {variable = "acc", columns = [1, 2, 3]}   # of another one, of the same instants or resampled

    Parameters
    ----------
    path: of the file.
    timed: the layout's `time`: the stream whose instants are the recording's, and whose channels a place
        without a stream names.
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
        self._streams = read_streams(path)
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
        """Channels, (n, count); for a stream's name alone its instants, (n, 1), s.

        Raises InputError for a stream or channel that is not there, and for instants that differ from those
        of a stream that was used before.
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
        stream, channels = self._timed, place if isinstance(place, tuple) else ()
        if isinstance(place, Columns):
            stream, channels = self._stream(place.variable, where), place.columns
        if len(channels) != count:
            raise InputError(where, f"names {len(channels)} channels", f"{count}")
        return [(stream.key, _number(each, stream, where)) for each in channels]

    def _instants(self) -> Array:
        parts = list(self._brought.values()) or [self._part(stream) for stream in self._used.values()]
        time_base(parts, self._where, "write `resample = HZ` into the layout, or take the sensors of each "
                  "stream in a layout and a block of their own")
        return np.asarray(parts[0].times_s)

    def _part(self, stream: XdfStream) -> Part:
        name = f"stream {stream.key}"
        # A layout names the stamps as the time, so that the header's rate does not matter.
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
        if not 1 <= channel <= len(stream.labels):
            raise InputError(where, f"channel {channel}",
                             f"1 to {len(stream.labels)} of stream {stream.name}")
        return channel - 1
    if stream.labels.count(channel) != 1:
        found = f"{stream.labels.count(channel)} channels of stream {stream.name} are labelled {channel!r}"
        raise InputError(where, found, ", ".join(stream.labels[:12]), did_you_mean(channel, stream.labels))
    return stream.labels.index(channel)
