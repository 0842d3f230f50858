"""Chunks of an XDF 1.0 file (github.com/sccn/xdf/wiki/Specifications), little-endian throughout."""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence
from typing import Any
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray

MAGIC = b"XDF:"
_FILE_HEADER, _STREAM_HEADER, _SAMPLES, _CLOCK_OFFSET, _BOUNDARY, _STREAM_FOOTER = range(1, 7)
_BOUNDARY_MARK = bytes.fromhex("43a546dccbf5410fb30ed5467383cbe4")
_STAMPED = 8
"""Before a sample: its stamp follows, in eight bytes."""
_NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")

Xml = Sequence[tuple[str, "str | Xml"]]
"""Elements, each with its text or with elements of its own."""


def file_header(elements: Xml) -> bytes:
    """The first chunk."""
    return _chunk(_FILE_HEADER, _document(elements))


def stream_header(stream: int, elements: Xml) -> bytes:
    """What a stream is; before its first samples."""
    return _chunk(_STREAM_HEADER, struct.pack("<I", stream) + _document(elements))


def stream_footer(stream: int, elements: Xml) -> bytes:
    """What a stream was; after its last samples."""
    return _chunk(_STREAM_FOOTER, struct.pack("<I", stream) + _document(elements))


def boundary() -> bytes:
    """Where a reader of a damaged file takes up again."""
    return _chunk(_BOUNDARY, _BOUNDARY_MARK)


def clock_offset(stream: int, time_s: float, offset_s: float) -> bytes:
    """What to add to a stream's stamps, as measured at a time."""
    return _chunk(_CLOCK_OFFSET, struct.pack("<Idd", stream, time_s, offset_s))


def samples(stream: int, times_s: NDArray[np.float64], values: NDArray[Any]) -> bytes:
    """Stamped samples (n, channels) of 8-byte numbers, n above 0."""
    kind = np.dtype([("size", "u1"), ("time", "<f8"), ("values", values.dtype.newbyteorder("<"),
                                                       values.shape[1:])])
    rows = np.empty(len(values), kind)
    rows["size"], rows["time"], rows["values"] = _STAMPED, times_s, values
    return _samples(stream, len(rows), rows.tobytes())


def texts(stream: int, times_s: Sequence[float], values: Sequence[str]) -> bytes:
    """Stamped samples of one text each, n above 0."""
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
    """A length behind the number of its own bytes."""
    if number < 2**8:
        return struct.pack("<BB", 1, number)
    return struct.pack("<BI", 4, number) if number < 2**32 else struct.pack("<BQ", 8, number)


def _document(elements: Xml) -> bytes:
    return f'<?xml version="1.0"?>{_xml([("info", elements)])}'.encode()


def _xml(elements: Xml) -> str:
    """Elements as text; characters that XML cannot hold are question marks."""
    inner = ((tag, escape(_NO_XML.sub("?", content)) if isinstance(content, str) else _xml(content))
             for tag, content in elements)
    return "".join(f"<{tag}>{content}</{tag}>" for tag, content in inner)
