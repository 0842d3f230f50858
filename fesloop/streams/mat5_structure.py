"""Whether a MATLAB 5 file is what its lengths say, before SciPy decodes it.

SciPy allocates what a file declares: a damaged one of a few kB can ask for gigabytes of empty cells or
blanks. Here every element is followed to its end (MATLAB MAT-File Format, MathWorks 2023, chapter 1);
nothing is converted.
"""

from __future__ import annotations

import math
import struct
import zlib
from pathlib import Path

from fesloop.streams.room import Room

_HEADER, _TAG = 128, 8
_MATRIX, _COMPRESSED, _INT32 = 14, 15, 5
_CELL, _STRUCTURE, _OBJECT, _SPARSE = 1, 2, 3, 5
_DEEPEST = 32
_ORDER = {b"IM": "<", b"MI": ">"}


class Mat5Error(ValueError):
    """An element that cannot be what it says."""


def require_sound_mat5(path: Path, room: Room) -> None:
    """Raise Mat5Error for an element that leaves its place or declares more than it holds, InputError for
    content that takes more than there is `room`."""
    content = memoryview(path.read_bytes())
    if len(content) < _HEADER or bytes(content[126:128]) not in _ORDER:
        raise Mat5Error("the header is cut short")
    order = _ORDER[bytes(content[126:128])]
    room.take(len(content), str(path))
    at = _HEADER
    while at < len(content):
        kind, body, at = _element(content, at, order)
        if kind == _COMPRESSED:
            body = _decompressed(body, room, path)
            kind, body, _ = _element(body, 0, order)
        if kind == _MATRIX:
            _follow(body, order, 0)


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


def _follow(body: memoryview, order: str, depth: int) -> None:
    """Follow a matrix to its end."""
    if not len(body):
        return  # an empty cell or field
    if depth > _DEEPEST:
        raise Mat5Error(f"matrices in each other, more than {_DEEPEST} deep")
    _, flags, at = _element(body, 0, order)
    kind, extents, at = _element(body, at, order)
    if len(flags) < 4 or kind != _INT32 or len(extents) % 4 or len(extents) < 8:
        raise Mat5Error("a matrix without flags and extents")
    matrix = struct.unpack_from(f"{order}I", flags)[0] & 0xFF
    shape = struct.unpack(f"{order}{len(extents) // 4}i", extents)
    if min(shape) < 0 or len(shape) > _DEEPEST:
        raise Mat5Error(f"a matrix of shape {shape[:4]}")
    _, _, at = _element(body, at, order)
    count = math.prod(shape)
    if matrix == _OBJECT:
        _, _, at = _element(body, at, order)
    if matrix in (_STRUCTURE, _OBJECT):
        fields, at = _fields(body, at, order)
        count *= fields
    inside = matrix in (_CELL, _STRUCTURE, _OBJECT)
    if matrix != _SPARSE and count * (_TAG if inside else 1) > len(body):
        raise Mat5Error(f"a matrix of shape {shape[:4]} in {len(body)} bytes")
    for _ in range(count if inside else 0):
        kind, part, at = _element(body, at, order)
        if kind != _MATRIX:
            raise Mat5Error(f"an element of type {kind} where a matrix has to be")
        _follow(part, order, depth + 1)


def _fields(body: memoryview, at: int, order: str) -> tuple[int, int]:
    """Number of a structure's fields, and the place after their names."""
    _, length, at = _element(body, at, order)
    _, names, at = _element(body, at, order)
    if len(length) != 4 or not 0 < struct.unpack(f"{order}i", length)[0] <= max(len(names), 64):
        raise Mat5Error("a structure without names of its fields")
    return len(names) // struct.unpack(f"{order}i", length)[0], at
