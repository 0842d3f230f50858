"""XDF export: a stream for each signal, one for the stamps of each node, and one for events.

Stamps of samples are s from the trial's start. A stream `NODE.stamps` of integers holds what a double in s
cannot: number of the tick, ns at which values were put out and left, ns of their oldest and newest
capture. Channels are described as in the XDF wiki's page on motion
capture. Chunks follow XDF 1.0 (github.com/sccn/xdf/wiki/Specifications), little-endian throughout.
"""

from __future__ import annotations

import heapq
import re
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.export.channels import Channel, Quantity, quantity
from fesloop.experiment.export.rates import rate_of_stamps
from fesloop.experiment.export.selection import Selection
from fesloop.experiment.export.target import file_name
from fesloop.experiment.recording.reading import Piece, SignalTable, TableSignal
from fesloop.loop.clock import NS_PER_S

MAGIC = b"XDF:"
_FILE_HEADER, _STREAM_HEADER, _SAMPLES, _CLOCK_OFFSET, _BOUNDARY, _STREAM_FOOTER = range(1, 7)
_BOUNDARY_MARK = bytes.fromhex("43a546dccbf5410fb30ed5467383cbe4")
_STAMPED = 8
"""Byte before a sample whose stamp follows in eight bytes."""
_NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
Xml = Sequence[tuple[str, "str | Xml"]]
"""Elements, each with its text or with elements of its own."""
STAMPS = ("index", "time_ns", "left_ns", "oldest_ns", "newest_ns")
_TYPES: dict[Quantity, str] = {"acceleration": "IMU", "rate": "IMU", "field": "IMU", "orientation": "MoCap",
                               "joint_angle": "MoCap", "position": "MoCap", "velocity": "MoCap",
                               "other": "Signal"}
_CHANNEL_TYPES: dict[Quantity, tuple[str, str]] = {
    "acceleration": ("Acceleration", "XYZ"), "rate": ("AngularVelocity", "XYZ"),
    "field": ("MagneticField", "XYZ"), "orientation": ("Orientation", "ABCD"), "joint_angle": ("Angle", ""),
    "position": ("Position", "XYZ"), "velocity": ("Velocity", "XYZ"), "other": ("", "")}
"""Types and axes. Orientation is A, B, C, D, where B, C, D are the axial parts (XDF wiki, MoCap meta-data);
Position has X, Y, Z; the others are named alike."""
_UNITS = {"m": "meters", "1": "normalized"}
"""Names of units from the same page; other units are SI symbols."""


@dataclass(slots=True)
class _Stream:
    """A stream under way."""

    number: int
    header: Xml
    first_s: float = 0.0
    last_s: float = 0.0
    count: int = 0

    def note(self, times_s: NDArray[np.float64]) -> None:
        """Count samples that are written."""
        if not self.count:
            self.first_s = float(times_s[0])
        self.last_s = float(times_s[-1])
        self.count += len(times_s)


@dataclass(slots=True)
class _Writer:
    """The file of one trial."""

    file: BinaryIO
    selection: Selection
    trial: int
    streams: list[_Stream] = field(default_factory=list)

    def add(self, name: str, kind: str, rate_hz: float, number_format: str,
            described: list[Xml], sensors: Xml | None = None) -> _Stream:
        """Begin a stream on the clock of all others; `sensors` is added to its description."""
        recording = self.selection.recording
        header: Xml = [
            ("name", name), ("type", kind), ("channel_count", str(len(described))),
            ("nominal_srate", repr(rate_hz)), ("channel_format", number_format),
            ("source_id", f"{recording.fingerprint[:16]}-{recording.seed}-{self.trial}-{name}"),
            ("version", "1.1"), ("created_at", "0.0"), ("session_id", recording.name), ("hostname", ""),
            ("desc", [("channels", [("channel", channel) for channel in described]), *(sensors or []),
                      ("acquisition", [("manufacturer", "fesloop"), ("model", recording.name)])])]
        stream = _Stream(len(self.streams) + 1, header)
        self.streams.append(stream)
        self.file.write(stream_header(stream.number, header))
        self.file.write(clock_offset(stream.number, 0.0, 0.0))
        return stream

    def put(self, stream: _Stream, times_s: NDArray[np.float64], values: NDArray[Any]) -> None:
        """Write samples of a stream."""
        self.file.write(samples(stream.number, times_s, values))
        stream.note(times_s)

    def finish(self) -> None:
        """Write the summary of every stream."""
        for stream in self.streams:
            length = stream.last_s - stream.first_s
            rate = (stream.count - 1) / length if length > 0.0 else 0.0
            self.file.write(stream_footer(stream.number, [
                ("first_timestamp", repr(stream.first_s)), ("last_timestamp", repr(stream.last_s)),
                ("sample_count", str(stream.count)), ("measured_srate", repr(rate)),
                ("clock_offsets", [("offset", [("time", "0.0"), ("value", "0.0")])])]))


def write(selection: Selection, folder: Path) -> list[str]:
    """Write a file for each trial."""
    for trial in selection.trials:
        path = folder / f"{selection.prefix(trial)}{file_name(selection.recording.path.stem)}.xdf"
        with path.open("wb") as file:
            _write_trial(_Writer(file, selection, trial))
    return []


def _write_trial(writer: _Writer) -> None:
    selection, trial = writer.selection, writer.trial
    about = [("version", "1.0"), ("datetime", selection.onset(trial))]
    writer.file.write(MAGIC + file_header(about))
    tables = selection.tables(trial)
    streams = {id(table): _streams(writer, table) for table in tables}
    events = writer.add("events", "Markers", 0.0, "string", [[("label", "where: status: detail")]])
    ordered = heapq.merge(*(_dated(selection, table) for table in tables), key=lambda dated: dated[0])
    for _, table, piece in ordered:
        times = piece.times_ns / NS_PER_S
        *of_signals, of_stamps = streams[id(table)]
        for stream, values in zip(of_signals, piece.values, strict=True):
            writer.put(stream, times, values.reshape(len(values), -1))
        stamps = (piece.indices, piece.times_ns, piece.left_ns, piece.oldest_ns, piece.newest_ns)
        writer.put(of_stamps, times, np.stack(stamps, axis=1))
        writer.file.write(boundary())
    _write_events(writer, events)
    writer.finish()


def _dated(selection: Selection, table: SignalTable) -> Iterator[tuple[int, SignalTable, Piece]]:
    """Yield (first instant, table, piece), by which the pieces of all tables are interleaved."""
    return ((int(piece.times_ns[0]), table, piece) for piece in selection.pieces(table))


def _streams(writer: _Writer, table: SignalTable) -> list[_Stream]:
    """A stream for each signal of a table, and one for its stamps."""
    rate = rate_of_stamps(table.times_ns())
    nominal = rate.hertz if rate.even else 0.0
    streams = []
    for signal in table.signals:
        found = writer.selection.channels(signal)
        described = [_channel(signal, each) for each in found]
        streams.append(writer.add(signal.name, _TYPES[quantity(signal)], nominal, "double64", described,
                                  _sensors(signal, found)))
    described = [[("label", stamp), ("type", "Stamp"), ("unit", "1" if stamp == "index" else "nanoseconds")]
                 for stamp in STAMPS]
    name = f"{writer.selection.name_of(table)}.stamps"
    streams.append(writer.add(name, "Stamps", nominal, "int64", described))
    return streams


def _sensors(signal: TableSignal, described: Sequence[Channel]) -> Xml:
    """Names and pairs of the sensors whose samples a signal contains; none for other signals.

    Names can be any text; labels made of them may differ.
    """
    inertial = quantity(signal) in ("acceleration", "rate", "field")
    return [("sensors", [("sensor", channel.point) for channel in described[::3]] if inertial else []),
            ("pairs", [("pair", [("parent", parent), ("child", child)])
                       for parent, child in signal.named_pairs if inertial])]


def _channel(signal: TableSignal, channel: Channel) -> Xml:
    """Description of a channel."""
    kind, letters = _CHANNEL_TYPES[quantity(signal)]
    if letters:
        kind += letters["wxyz".index(channel.component) if len(letters) == 4
                        else "xyz".index(channel.component)]
    label = f"{signal.port}.{channel.label}" if channel.label else signal.port
    unit = "quaternion" if letters == "ABCD" else _UNITS.get(channel.unit, channel.unit)
    return [("label", label), ("marker", channel.point or signal.port), ("object", signal.node),
            ("type", kind or signal.port), ("unit", unit)]


def _write_events(writer: _Writer, stream: _Stream) -> None:
    """Write all events of the trial."""
    found = writer.selection.events(writer.trial)
    if found:
        times = np.array([event.time_ns for event in found]) / NS_PER_S
        said = [f"{event.where}: {event.status}: {event.detail}" for event in found]
        writer.file.write(texts(stream.number, times.tolist(), said))
        stream.note(times)


def file_header(elements: Xml) -> bytes:
    """First chunk of a file."""
    return _chunk(_FILE_HEADER, _document(elements))


def stream_header(stream: int, elements: Xml) -> bytes:
    """Chunk that describes a stream, before its first samples."""
    return _chunk(_STREAM_HEADER, struct.pack("<I", stream) + _document(elements))


def stream_footer(stream: int, elements: Xml) -> bytes:
    """Chunk that summarises a stream, after its last samples."""
    return _chunk(_STREAM_FOOTER, struct.pack("<I", stream) + _document(elements))


def boundary() -> bytes:
    """Chunk at which a reader of a damaged file resumes."""
    return _chunk(_BOUNDARY, _BOUNDARY_MARK)


def clock_offset(stream: int, time_s: float, offset_s: float) -> bytes:
    """Chunk with the offset to add to a stream's stamps, as measured at a time."""
    return _chunk(_CLOCK_OFFSET, struct.pack("<Idd", stream, time_s, offset_s))


def samples(stream: int, times_s: NDArray[np.float64], values: NDArray[Any]) -> bytes:
    """Chunk of stamped samples (n, channels) of 8-byte numbers, n above 0."""
    kind = np.dtype([("size", "u1"), ("time", "<f8"), ("values", values.dtype.newbyteorder("<"),
                                                       values.shape[1:])])
    rows = np.empty(len(values), kind)
    rows["size"], rows["time"], rows["values"] = _STAMPED, times_s, values
    return _samples(stream, len(rows), rows.tobytes())


def texts(stream: int, times_s: Sequence[float], values: Sequence[str]) -> bytes:
    """Chunk of stamped samples of one text each, n above 0."""
    content = []
    for time, value in zip(times_s, values, strict=True):
        encoded = value.encode()
        content.append(struct.pack("<Bd", _STAMPED, time) + _length(len(encoded)) + encoded)
    return _samples(stream, len(content), b"".join(content))


def _samples(stream: int, count: int, content: bytes) -> bytes:
    return _chunk(_SAMPLES, struct.pack("<I", stream) + _length(count) + content)


def _chunk(tag: int, content: bytes) -> bytes:
    body = struct.pack("<H", tag) + content
    return _length(len(body)) + body


def _length(number: int) -> bytes:
    """A length, after the number of its own bytes."""
    if number < 2**8:
        return struct.pack("<BB", 1, number)
    return struct.pack("<BI", 4, number) if number < 2**32 else struct.pack("<BQ", 8, number)


def _document(elements: Xml) -> bytes:
    return f'<?xml version="1.0"?>{_xml([("info", elements)])}'.encode()


def _xml(elements: Xml) -> str:
    """Elements as text; characters that XML cannot hold become question marks."""
    inner = ((tag, escape(_NO_XML.sub("?", content)) if isinstance(content, str) else _xml(content))
             for tag, content in elements)
    return "".join(f"<{tag}>{content}</{tag}>" for tag, content in inner)
