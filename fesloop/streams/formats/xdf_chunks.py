"""The chunks of an XDF file, read strictly (XDF 1.0 specification, github.com/sccn/xdf/wiki/Specifications).

pyxdf skips what it cannot read and goes on at the next boundary, and allocates what a damaged length says;
here a chunk must be what its lengths say, or the file is refused where it is damaged. Nothing is read past
the file's end, and no more is held than the file has samples.
"""

from __future__ import annotations

import mmap
import struct
import xml.etree.ElementTree as Xml
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError

SIGNATURE = b"XDF:"
_FILE_HEADER, _STREAM_HEADER, _SAMPLES, _CLOCK_OFFSET, _BOUNDARY, _STREAM_FOOTER = range(1, 7)
_LENGTHS = {1: "<B", 4: "<I", 8: "<Q"}
_FORMATS = {"int8": "i1", "int16": "<i2", "int32": "<i4", "int64": "<i8", "float32": "<f4",
            "double64": "<f8"}
_TEXT = "string"
_MOST_CHANNELS = 10_000
_HEADER_BYTES = 2**22
_STRAY = 10.0
"""A clock offset is far off where it, or the time since the one before, is by so many times (pyxdf 1.17)."""
_ALLOWED = "an undamaged XDF file"


@dataclass(slots=True, eq=False)
class XdfStream:
    """A stream as it stands in the file.

    Attributes
    ----------
    name, type: as the header says; rate_hz: nominal, 0 for an irregular one.
    labels, units, types: of each channel; empty text where the header says nothing.
    sensors, pairs: of a stream that fesloop exported: names of its sensors, and of (parent, child) ones;
        None where the header lists none.
    drops: whether the header says that its sender can drop samples.
    times_s: (n,), on the sender's clock.
    values: (n, channels); of a stream of text nothing is kept.
    clock_s, offset_s: instants on the recorder's clock, and by how much the sender's clock was behind then.
    counted: samples that the footer tells, -1 where it tells none.
    key: by which a user chooses it: its name, of the second stream of one name "imu#2".
    """

    name: str
    type: str
    rate_hz: float
    dtype: np.dtype[Any] | None
    labels: tuple[str, ...]
    units: tuple[str, ...]
    types: tuple[str, ...]
    drops: bool
    sensors: tuple[str, ...] | None = None
    pairs: tuple[tuple[str, str], ...] = ()
    times_s: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    values: NDArray[Any] = field(default_factory=lambda: np.zeros((0, 0)))
    clock_s: list[float] = field(default_factory=list)
    offset_s: list[float] = field(default_factory=list)
    counted: int = -1
    key: str = ""
    pieces: list[tuple[NDArray[np.float64], NDArray[Any]]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.key = self.key or self.name

    @property
    def channels(self) -> int:
        """How many."""
        return len(self.labels)


def read_streams(path: Path) -> list[XdfStream]:
    """Every stream of a file, those of text without their samples.

    Raises InputError for a file that is damaged, naming the byte.
    """
    streams: dict[int, XdfStream] = {}
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        if content[:4] != SIGNATURE:
            raise InputError(str(path), "is no XDF file", _ALLOWED)
        for at, tag, body in _chunks(content, str(path)):
            where = f"{path}: chunk at byte {at}"
            try:
                _take(streams, tag, body, where)
            except (struct.error, IndexError, ValueError, OverflowError) as fault:
                if isinstance(fault, InputError):
                    raise
                raise InputError(where, f"is damaged: {fault}", _ALLOWED) from None
    for stream in streams.values():
        if stream.pieces:
            times, values = zip(*stream.pieces, strict=True)
            stream.times_s, stream.values = np.concatenate(times), np.concatenate(values)
            stream.pieces.clear()
        drop_stray_end(stream)
    found = list(streams.values())
    names = [stream.name for stream in found]
    for number, stream in enumerate(found):
        if names.count(stream.name) > 1:
            stream.key = f"{stream.name}#{names[:number].count(stream.name) + 1}"
    return found


def _chunks(content: mmap.mmap, where: str) -> Iterator[tuple[int, int, bytes]]:
    """Place, tag and body of each chunk."""
    at = len(SIGNATURE)
    while at < len(content):
        place = f"{where}: chunk at byte {at}"
        length_bytes = content[at]
        start = at + 1 + length_bytes
        if length_bytes not in _LENGTHS or start > len(content):
            raise InputError(place, f"has a length of {length_bytes} bytes", _ALLOWED)
        length = struct.unpack_from(_LENGTHS[length_bytes], content, at + 1)[0]
        if length < 2 or start + length > len(content):
            raise InputError(place, f"has {length} bytes, {len(content) - start} are left", _ALLOWED,
                             "copy the file again; if its recording was cut short, cut it here")
        yield at, struct.unpack_from("<H", content, start)[0], content[start + 2:start + length]
        at = start + length


def _take(streams: dict[int, XdfStream], tag: int, body: bytes, where: str) -> None:
    """What a chunk adds to the streams."""
    if tag in (_FILE_HEADER, _BOUNDARY):
        return
    if tag not in (_STREAM_HEADER, _SAMPLES, _CLOCK_OFFSET, _STREAM_FOOTER):
        raise InputError(where, f"is of the unknown kind {tag}", _ALLOWED)
    number, rest = struct.unpack_from("<I", body)[0], body[4:]
    if tag == _STREAM_HEADER:
        if number in streams:
            raise InputError(where, f"describes stream {number} a second time", _ALLOWED)
        streams[number] = _stream(rest, where)
        return
    if number not in streams:
        raise InputError(where, f"is of stream {number}, which has no header before", _ALLOWED)
    stream = streams[number]
    if tag == _SAMPLES:
        if stream.dtype is not None:
            stream.pieces.append(_samples(rest, stream, where))
    elif tag == _CLOCK_OFFSET:
        instant, offset = struct.unpack("<dd", rest)
        if not np.isfinite([instant, offset]).all():
            raise InputError(where, "holds a clock offset that is no number", _ALLOWED)
        stream.clock_s.append(instant)
        stream.offset_s.append(offset)
    else:
        told = _xml(rest, where).findtext("sample_count")
        stream.counted = int(told) if told and told.strip().isdecimal() else -1


def _xml(text: bytes, where: str) -> Xml.Element:
    """A description; entities are refused, since a few of them can stand for gigabytes."""
    if len(text) > _HEADER_BYTES or b"<!" in text:
        raise InputError(where, "holds a description with declarations, or one too long", _ALLOWED)
    try:
        return Xml.fromstring(text.decode("utf-8", "replace"))
    except Xml.ParseError as fault:
        raise InputError(where, f"holds a description that is no XML: {fault}", _ALLOWED) from None


def _stream(text: bytes, where: str) -> XdfStream:
    """A stream from its header."""
    header = _xml(text, where)
    channels, form = int(header.findtext("channel_count") or 0), header.findtext("channel_format") or ""
    rate = float(header.findtext("nominal_srate") or 0.0)
    if not 1 <= channels <= _MOST_CHANNELS:
        raise InputError(where, f"describes {channels} channels", f"1 to {_MOST_CHANNELS}")
    if form not in _FORMATS and form != _TEXT:
        raise InputError(where, f"has the channel format {form!r}", ", ".join([*_FORMATS, _TEXT]))
    if not 0.0 <= rate < np.inf:
        raise InputError(where, f"has the rate {rate}", "0 or more Hz")
    described = header.findall("desc/channels/channel")
    if described and len(described) != channels:
        raise InputError(where, f"describes {len(described)} channels and has {channels}", "one each")
    told = [tuple((each.findtext(key) or "").strip() for each in described) or ("",) * channels
            for key in ("label", "unit", "type")]
    listed = header.find("desc/sensors")
    return XdfStream(
        name=(header.findtext("name") or "").strip(), type=(header.findtext("type") or "").strip(),
        rate_hz=rate, dtype=np.dtype(_FORMATS[form]) if form != _TEXT else None, labels=told[0],
        units=told[1], types=told[2],
        sensors=None if listed is None else tuple(each.text or "" for each in listed),
        pairs=tuple((each.findtext("parent") or "", each.findtext("child") or "")
                    for each in header.findall("desc/pairs/pair")),
        drops=(header.findtext("desc/synchronization/can_drop_samples") or "").strip().lower() == "true")


def _samples(body: bytes, stream: XdfStream, where: str) -> tuple[NDArray[np.float64], NDArray[Any]]:
    """Instants and values of a chunk of samples."""
    assert stream.dtype is not None
    width = body[0]
    count = struct.unpack_from(_LENGTHS.get(width, "<Q"), body, 1)[0]
    rest = memoryview(body)[1 + width:]
    size = stream.channels * stream.dtype.itemsize
    if width not in _LENGTHS or not count * (1 + size) <= len(rest) <= count * (9 + size):
        raise InputError(where, f"says that it holds {count} samples of {size} bytes, in {len(rest)} bytes",
                         _ALLOWED)
    every = np.dtype([("stamped", "u1"), ("time", "<f8"), ("values", stream.dtype, (stream.channels,))])
    if count and len(rest) == count * every.itemsize:
        rows = np.frombuffer(rest, every)
        if (rows["stamped"] == 8).all():
            return rows["time"].astype(np.float64), rows["values"].copy()
    return _uneven_samples(rest, count, size, stream, where)


def _uneven_samples(rest: memoryview, count: int, size: int, stream: XdfStream,
                    where: str) -> tuple[NDArray[np.float64], NDArray[Any]]:
    """Samples of which some have no stamp: those follow the one before at the nominal rate."""
    times, places = np.empty(count), np.empty(count, np.int64)
    last = float(stream.pieces[-1][0][-1]) if stream.pieces and stream.pieces[-1][0].size else 0.0
    period = 1.0 / stream.rate_hz if stream.rate_hz > 0.0 else 0.0
    at = 0
    for k in range(count):
        stamped = rest[at]
        if stamped not in (0, 8):
            raise InputError(where, f"says that the stamp of sample {k} has {stamped} bytes", "0 or 8")
        last = struct.unpack_from("<d", rest, at + 1)[0] if stamped else last + period
        times[k], places[k] = last, at + 1 + stamped
        at += 1 + stamped + size
    if at != len(rest):
        raise InputError(where, f"holds {len(rest)} bytes, its samples take {at}", _ALLOWED)
    bytes_of = np.frombuffer(rest, np.uint8)[places[:, np.newaxis] + np.arange(size)]
    return times, bytes_of.view(stream.dtype).reshape(count, stream.channels).copy()


def drop_stray_end(stream: XdfStream) -> None:
    """Leave out what liblsl adds by mistake when an outlet is destroyed (github.com/labstreaminglayer/pylsl,
    issue 67), as pyxdf does: samples beyond those that the footer counts, where the last clock offset is far
    off the others too, and that offset.
    """
    clock, offset = np.array(stream.clock_s), np.array(stream.offset_s)
    if not 0 <= stream.counted < stream.times_s.size or clock.size < 3:
        return
    steps = np.diff(clock)
    usual = np.median(steps[:-1])
    late = abs(steps[-1]) > _STRAY * usual if usual > 0.0 else steps[-1] != 0.0
    middle = np.median(offset[:-1])
    deviation = 1.4826 * np.median(np.abs(offset[:-1] - middle))  # that of a normal distribution
    if late or (deviation > np.finfo(float).eps and abs(offset[-1] - middle) > _STRAY * deviation):
        stream.times_s, stream.values = stream.times_s[:stream.counted], stream.values[:stream.counted]
        del stream.clock_s[-1], stream.offset_s[-1]
