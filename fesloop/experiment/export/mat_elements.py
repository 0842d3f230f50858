"""Elements of a MATLAB 5 file, big arrays left open to be filled a span of rows at a time.

MATLAB lies column by column in its files, so an array that comes row by row is known in place, not in order;
`scipy.io.savemat` wants it in memory. (MathWorks, "MAT-File Format", chapter 1, "Level 5".)
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

_INT8, _INT32, _UINT32, _DOUBLE, _INT64, _MATRIX, _UTF8, _UTF16 = 1, 5, 6, 9, 12, 14, 16, 17
_CELL, _STRUCT, _CHAR, _OF_DOUBLES, _OF_INTEGERS = 1, 2, 4, 6, 14
LONGEST_NAME = 63
"""Characters of a MATLAB name; of a field's name, with the zero behind it, 64."""


@dataclass(frozen=True, slots=True, eq=False)
class OpenArray:
    """An array of 8-byte numbers of this shape, its values still to come; integers are int64."""

    shape: tuple[int, ...]
    integers: bool = False


@dataclass(frozen=True, slots=True)
class Struct:
    """A structure: fields in their order."""

    fields: dict[str, Element]


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell array of texts; its shape."""

    texts: tuple[str, ...]
    shape: tuple[int, ...]


Element = OpenArray | Struct | Cell | str | float


def header(text: str) -> bytes:
    """The first 128 bytes of a file."""
    told = f"MATLAB 5.0 MAT-file, {text}"[:116].ljust(116)
    return told.encode("ascii", "replace") + bytes(8) + b"\x00\x01IM"


def size(element: Element, name: str = "") -> int:
    """Bytes of an element with its tag."""
    return sum(part.nbytes if isinstance(part, _Hole) else len(part) for part in _parts(element, name))


@dataclass(frozen=True, slots=True)
class _Hole:
    """Room for the values of an open array, up to a multiple of 8 bytes: all numbers have 8."""

    array: OpenArray

    @property
    def nbytes(self) -> int:
        return 8 * math.prod(self.array.shape)


def write(file: BinaryIO, element: Element, name: str) -> dict[int, int]:
    """Write a variable; where in the file each open array's values belong, by the array's `id`."""
    places = {}
    for part in _parts(element, name):
        if isinstance(part, _Hole):
            places[id(part.array)] = file.tell()
            file.seek(part.nbytes, 1)
        else:
            file.write(part)
    file.truncate()
    return places


def fill(file: BinaryIO, place: int, count: int, first: int, rows: NDArray[Any]) -> None:
    """Write rows (n, ...), the first of which has number `first`, of an open array of `count` rows."""
    columns = rows.T.reshape(math.prod(rows.shape[1:]), len(rows))
    for number, column in enumerate(np.ascontiguousarray(columns)):
        file.seek(place + 8 * (number * count + first))
        file.write(column.astype(column.dtype.newbyteorder("<")).tobytes())


def _parts(element: Element, name: str) -> Iterator[bytes | _Hole]:
    """A matrix element: its tag, what it is, its dimensions, its name, its content."""
    kind, shape, content = _content(element)
    inner = [_tagged(_UINT32, struct.pack("<II", kind, 0)),
             _tagged(_INT32, struct.pack(f"<{len(shape)}i", *shape)),
             _tagged(_INT8, name.encode("ascii")), *content]
    total = sum(part.nbytes if isinstance(part, _Hole) else len(part) for part in inner)
    yield struct.pack("<II", _MATRIX, total)
    yield from inner


def _content(element: Element) -> tuple[int, tuple[int, ...], Sequence[bytes | _Hole]]:
    """Class, dimensions and content of an element."""
    if isinstance(element, str):
        return _CHAR, (1 if element else 0, len(element)), [_text(element)]
    if isinstance(element, float):
        return _OF_DOUBLES, (1, 1), [_tagged(_DOUBLE, struct.pack("<d", element))]
    if isinstance(element, OpenArray):
        kind, number = (_OF_INTEGERS, _INT64) if element.integers else (_OF_DOUBLES, _DOUBLE)
        hole = _Hole(element)
        shape = element.shape if len(element.shape) > 1 else (*element.shape, 1)
        return kind, shape, [struct.pack("<II", number, hole.nbytes), hole]
    if isinstance(element, Cell):
        shape = element.shape if len(element.shape) > 1 else (math.prod(element.shape), 1)
        texts = np.array(element.texts, object).reshape(shape).ravel(order="F")
        return _CELL, shape, [part for text in texts for part in _parts(str(text), "")]
    width = LONGEST_NAME + 1
    names = b"".join(name.encode("ascii").ljust(width, b"\0") for name in element.fields)
    start = [struct.pack("<HHi", _INT32, 4, width), _tagged(_INT8, names)]
    inner = (part for value in element.fields.values() for part in _parts(value, ""))
    return _STRUCT, (1, 1), [*start, *inner]


def _text(text: str) -> bytes:
    """Characters; MATLAB and Octave count units of UTF-16, SciPy characters: what would be two is U+FFFD."""
    if text.isascii():
        return _tagged(_UTF8, text.encode())
    return _tagged(_UTF16, re.sub("[\U00010000-\U0010ffff]", "\ufffd", text).encode("utf-16-le"))


def _tagged(kind: int, content: bytes) -> bytes:
    """A tag, content, and zeros up to a multiple of 8 bytes."""
    return struct.pack("<II", kind, len(content)) + content + bytes(-len(content) % 8)
