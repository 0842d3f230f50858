"""XDF, the file of Lab Streaming Layer: a stream a signal, one of stamps a node, and one of events.

Stamps of samples are s from the trial's start. A stream `NODE.stamps` of integers holds what a double in s
does not say: number of the tick, ns at which values were put out and left, ns of their oldest and newest
capture. Channels are described as the XDF wiki's page on motion capture asks for.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.export import xdf_chunks as chunks
from fesloop.experiment.export.channels import Channel, Quantity, quantity
from fesloop.experiment.export.rates import rate_of_stamps
from fesloop.experiment.export.selection import Selection
from fesloop.experiment.export.target import file_name
from fesloop.experiment.recording.signal_table import Piece, SignalTable, TableSignal
from fesloop.loop.clock import NS_PER_S

STAMPS = ("index", "time_ns", "left_ns", "oldest_ns", "newest_ns")
_TYPES: dict[Quantity, str] = {"acceleration": "IMU", "rate": "IMU", "field": "IMU", "orientation": "MoCap",
                               "joint_angle": "MoCap", "position": "MoCap", "velocity": "MoCap",
                               "other": "Signal"}
_CHANNEL_TYPES: dict[Quantity, tuple[str, str]] = {
    "acceleration": ("Acceleration", "XYZ"), "rate": ("AngularVelocity", "XYZ"),
    "field": ("MagneticField", "XYZ"), "orientation": ("Orientation", "ABCD"), "joint_angle": ("Angle", ""),
    "position": ("Position", "XYZ"), "velocity": ("Velocity", "XYZ"), "other": ("", "")}
"""Orientation is A, B, C, D, of which B, C, D are the axial parts (XDF wiki, MoCap meta-data); Position X, Y,
Z too; the others are named alike."""
_UNITS = {"m": "meters", "1": "normalized"}
"""As that page has them; others SI."""


@dataclass(slots=True)
class _Stream:
    """A stream that is being written."""

    number: int
    header: chunks.Xml
    first_s: float = 0.0
    last_s: float = 0.0
    count: int = 0

    def note(self, times_s: NDArray[np.float64]) -> None:
        """Samples have been written."""
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
            described: list[chunks.Xml], sensors: chunks.Xml | None = None) -> _Stream:
        """A new stream; its stamps are on the clock of all others; `sensors` is more of its description."""
        recording = self.selection.recording
        header: chunks.Xml = [
            ("name", name), ("type", kind), ("channel_count", str(len(described))),
            ("nominal_srate", repr(rate_hz)), ("channel_format", number_format),
            ("source_id", f"{recording.fingerprint[:16]}-{recording.seed}-{self.trial}-{name}"),
            ("version", "1.1"), ("created_at", "0.0"), ("session_id", recording.name), ("hostname", ""),
            ("desc", [("channels", [("channel", channel) for channel in described]), *(sensors or []),
                      ("acquisition", [("manufacturer", "fesloop"), ("model", recording.name)])])]
        stream = _Stream(len(self.streams) + 1, header)
        self.streams.append(stream)
        self.file.write(chunks.stream_header(stream.number, header))
        self.file.write(chunks.clock_offset(stream.number, 0.0, 0.0))
        return stream

    def put(self, stream: _Stream, times_s: NDArray[np.float64], values: NDArray[Any]) -> None:
        """Samples of a stream."""
        self.file.write(chunks.samples(stream.number, times_s, values))
        stream.note(times_s)

    def finish(self) -> None:
        """What every stream was."""
        for stream in self.streams:
            length = stream.last_s - stream.first_s
            rate = (stream.count - 1) / length if length > 0.0 else 0.0
            self.file.write(chunks.stream_footer(stream.number, [
                ("first_timestamp", repr(stream.first_s)), ("last_timestamp", repr(stream.last_s)),
                ("sample_count", str(stream.count)), ("measured_srate", repr(rate)),
                ("clock_offsets", [("offset", [("time", "0.0"), ("value", "0.0")])])]))


def wanted(signal: TableSignal) -> bool:
    """Every signal."""
    return True


def write(selection: Selection, folder: Path) -> list[str]:
    """A file a trial."""
    for trial in selection.trials:
        path = folder / f"{selection.prefix(trial)}{file_name(selection.recording.path.stem)}.xdf"
        with path.open("wb") as file:
            _write_trial(_Writer(file, selection, trial))
    return []


def _write_trial(writer: _Writer) -> None:
    selection, trial = writer.selection, writer.trial
    about = [("version", "1.0"), ("datetime", selection.onset(trial))]
    writer.file.write(chunks.MAGIC + chunks.file_header(about))
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
        writer.file.write(chunks.boundary())
    _write_events(writer, events)
    writer.finish()


def _dated(selection: Selection, table: SignalTable) -> Iterator[tuple[int, SignalTable, Piece]]:
    """Pieces behind the instants at which they begin, by which those of all tables are interleaved."""
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
    name = f"{writer.selection.told(table)}.stamps"
    streams.append(writer.add(name, "Stamps", nominal, "int64", described))
    return streams


def _sensors(signal: TableSignal, described: Sequence[Channel]) -> chunks.Xml:
    """Names and pairs of the sensors whose samples a signal holds; none of other signals.

    Names can be any text, of which labels that are made of them can say something else.
    """
    inertial = quantity(signal) in ("acceleration", "rate", "field")
    return [("sensors", [("sensor", channel.point) for channel in described[::3]] if inertial else []),
            ("pairs", [("pair", [("parent", parent), ("child", child)])
                       for parent, child in signal.named_pairs if inertial])]


def _channel(signal: TableSignal, channel: Channel) -> chunks.Xml:
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
    """All events of the trial."""
    found = writer.selection.events(writer.trial)
    if found:
        times = np.array([event.time_ns for event in found]) / NS_PER_S
        told = [f"{event.where}: {event.status}: {event.detail}" for event in found]
        writer.file.write(chunks.texts(stream.number, times.tolist(), told))
        stream.note(times)
