"""Whether a MATLAB 5 file is what its tags and lengths say, before SciPy decodes it.

SciPy 1.17 allocates what a file declares, so that a damaged one of a few kB can ask for gigabytes of empty
cells or blanks, and ends the process where numbers are of a type that does not exist. Here every element is
followed to its end (MATLAB MAT-File Format, MathWorks 2023, chapter 1); nothing is converted.
"""

from __future__ import annotations

import math
import struct
import zlib
from pathlib import Path

from fesloop.streams.room import Room

_HEADER, _TAG = 128, 8
_MATRIX, _COMPRESSED, _INT32, _NAME_TYPES = 14, 15, 5, (1, 16)
_NUMBER_BYTES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8}
_TEXT_TYPES = (1, 2, 3, 4, 5, 6, 16, 17, 18)
_CELL, _STRUCTURE, _OBJECT, _TEXT = 1, 2, 3, 4
_NUMERIC = range(6, 16)
_COMPLEX = 0x800
_DEEPEST = 32
_ORDER = {b"IM": "<", b"MI": ">"}


class Mat5Error(ValueError):
    """An element that cannot be what it says."""


def sound_variables(path: Path, room: Room) -> list[str]:
    """Names of a file's variables of numbers, text, cells and structures; others are left out.

    Raises Mat5Error for an element that leaves its place or declares more than it holds, InputError for
    content that takes more than there is `room`.
    """
    content = memoryview(path.read_bytes())
    if len(content) < _HEADER or bytes(content[126:128]) not in _ORDER:
        raise Mat5Error("the header is cut short")
    order = _ORDER[bytes(content[126:128])]
    room.take(len(content), str(path))
    at, names = _HEADER, []
    while at < len(content):
        kind, body, at = _element(content, at, order)
        if kind == _COMPRESSED:
            body = _decompressed(body, room, path)
            kind, body, _ = _element(body, 0, order)
        if kind != _MATRIX:
            raise Mat5Error(f"an element of type {kind} where a matrix has to be")
        if _class_of(body, order) in (_CELL, _STRUCTURE, _OBJECT, _TEXT, *_NUMERIC):
            names.append(_follow(body, order, 0))
    return names


def _decompressed(body: memoryview, room: Room, path: Path) -> memoryview:
    stream = zlib.decompressobj()
    try:
        whole = stream.decompress(body, room.left + 1)
    except zlib.error as fault:
        raise Mat5Error(str(fault)) from None
    room.take(len(whole), str(path))
    return memoryview(whole)


def _element(content: memoryview, at: int, order: str) -> tuple[int, memoryview, int]:
    """Type and body of the element at a place, and the place of the next."""
    if at + _TAG > len(content):
        raise Mat5Error("a tag is cut short")
    kind, size = struct.unpack_from(f"{order}II", content, at)
    if kind >> 16:  # a small one: its size and type in one word, its body in the next
        size, kind = kind >> 16, kind & 0xFFFF
        if size > 4:
            raise Mat5Error(f"a small element of {size} bytes")
        return kind, content[at + 4:at + 4 + size], at + _TAG
    start = at + _TAG
    if start + size > len(content):
        raise Mat5Error(f"an element of {size} bytes, {len(content) - start} are left")
    padded = size if kind == _COMPRESSED else -(-size // 8) * 8
    return kind, content[start:start + size], min(start + padded, len(content))


def _class_of(body: memoryview, order: str) -> int:
    """The class of a matrix, as its flags say."""
    _, flags, _ = _element(body, 0, order)
    if len(flags) != 8:
        raise Mat5Error("a matrix without flags")
    return int(struct.unpack_from(f"{order}I", flags)[0] & 0xFF)


def _follow(body: memoryview, order: str, depth: int) -> str:
    """Follow a matrix to its end, and give its name."""
    if not len(body):
        return ""  # an empty cell or field
    if depth > _DEEPEST:
        raise Mat5Error(f"matrices in each other, more than {_DEEPEST} deep")
    matrix = _class_of(body, order)
    _, flags, at = _element(body, 0, order)
    kind, extents, at = _element(body, at, order)
    if kind != _INT32 or len(extents) % 4 or len(extents) < 8:
        raise Mat5Error("a matrix without extents")
    shape = struct.unpack(f"{order}{len(extents) // 4}i", extents)
    if min(shape) < 0 or len(shape) > _DEEPEST:
        raise Mat5Error(f"a matrix of shape {shape[:4]}")
    name, at = _name(body, at, order)
    count = math.prod(shape)
    if matrix in (_CELL, _STRUCTURE, _OBJECT):
        _follow_inner(body, at, order, depth, matrix, count)
    elif matrix in _NUMERIC:
        parts = 2 if struct.unpack_from(f"{order}I", flags)[0] & _COMPLEX else 1
        for _ in range(parts):
            kind, numbers, at = _element(body, at, order)
            if len(numbers) != count * _NUMBER_BYTES.get(kind, -1):
                raise Mat5Error(f"{len(numbers)} bytes of type {kind} in a matrix of shape {shape[:4]}")
    elif matrix == _TEXT:
        kind, letters, at = _element(body, at, order)
        if kind not in _TEXT_TYPES or count > max(len(letters), _TAG):
            raise Mat5Error(f"{len(letters)} bytes of text of type {kind} in a matrix of shape {shape[:4]}")
    else:
        raise Mat5Error(f"a matrix of class {matrix}")
    return name


def _follow_inner(body: memoryview, at: int, order: str, depth: int, matrix: int, count: int) -> None:
    """Follow every matrix of cells or of a structure's fields."""
    if matrix == _OBJECT:
        _, at = _name(body, at, order)
    if matrix != _CELL:
        kind, length, at = _element(body, at, order)
        names_kind, names, at = _element(body, at, order)
        width = struct.unpack(f"{order}i", length)[0] if kind == _INT32 and len(length) == 4 else 0
        if width < 1 or names_kind not in _NAME_TYPES or len(names) % width:
            raise Mat5Error("a structure without names of its fields")
        count *= len(names) // width
    if count * _TAG > len(body):
        raise Mat5Error(f"{count} matrices in {len(body)} bytes")
    for _ in range(count):
        kind, part, at = _element(body, at, order)
        if kind != _MATRIX:
            raise Mat5Error(f"an element of type {kind} where a matrix has to be")
        _follow(part, order, depth + 1)


def _name(body: memoryview, at: int, order: str) -> tuple[str, int]:
    """A name, and the place after it."""
    kind, letters, at = _element(body, at, order)
    if kind not in _NAME_TYPES:
        raise Mat5Error(f"a name of type {kind}")
    return bytes(letters).decode("latin-1"), at
