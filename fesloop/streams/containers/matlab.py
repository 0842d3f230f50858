"""MATLAB files: structure of version 5 checked before it is read, version 7.3 read as HDF5."""

from __future__ import annotations

import math
import struct
import zlib
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fesloop.errors import InputError
from fesloop.streams.containers import hdf5
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


_DEEPEST_GROUP, _MOST = 16, 100_000


def read_hdf5(path: Path, room: Room, allowed: str) -> dict[str, Any]:
    """Everything in the file, by key: arrays, text, lists of cells, tables of structures.

    Axes of length 1 go, as of MATLAB 5 files. Raises InputError, naming file and key.
    """
    where = str(path)
    with hdf5.open_hdf5(path, allowed) as file:
        reading = _Reading(file, room)
        told = {key: value for key, value in hdf5.attributes(file, where).items()
                if np.asarray(value).dtype.kind in "fiub"}
        found = {name: reading.value(item, f"{where}: {name}", 0)
                 for name, item in hdf5.members(file, where).items() if not name.startswith("#")}
    return told | found


class _Reading:
    """One pass over a file; `_count` items were read, so that references in a ring come to an end."""

    def __init__(self, file: h5py.File, room: Room) -> None:
        self._file, self._room, self._count = file, room, 0

    def value(self, item: Any, where: str, depth: int) -> Any:
        """What a group or dataset stands for."""
        self._count += 1
        if depth > _DEEPEST_GROUP or self._count > _MOST:
            raise InputError(where, "holds too much in each other", f"{_DEEPEST_GROUP} levels, {_MOST} items")
        if isinstance(item, h5py.Group):
            return {name: self.value(part, f"{where}.{name}", depth + 1)
                    for name, part in hdf5.members(item, where).items()}
        if not isinstance(item, h5py.Dataset):
            raise InputError(where, "is neither a group nor a dataset", "numbers, text, cells, structures")
        told = hdf5.attributes(item, where)
        kind = told.get("MATLAB_class", b"")
        name = kind.decode("ascii", "replace") if isinstance(kind, bytes) else str(kind)
        values = hdf5.array(item, self._room, where)
        if told.get("MATLAB_empty", 0):
            return "" if name == "char" else np.zeros(0)
        if values.dtype == h5py.ref_dtype or values.dtype.kind == "O":
            return self._cells(values, where, depth)
        if not name:
            return values
        values = np.squeeze(values.T)
        return _text(values, where) if name == "char" else values

    def _cells(self, values: np.ndarray[Any, Any], where: str, depth: int) -> Any:
        """Texts of any length, or what references lead to, in MATLAB's order."""
        found = []
        for number, each in enumerate(np.ravel(values)):
            if isinstance(each, bytes):
                found.append(each.decode("utf-8", "replace"))
                continue
            if not isinstance(each, h5py.Reference) or not each:
                raise InputError(where, f"cell {number} leads nowhere", "numbers, text, cells, structures")
            try:
                target = self._file[each]
            except (ValueError, KeyError, RuntimeError, OSError) as fault:
                raise InputError(where, f"cell {number} leads nowhere: {fault}",
                                 "an undamaged file") from None
            found.append(self.value(target, f"{where}[{number}]", depth + 1))
        return found[0] if values.ndim == 0 and found else found


def _text(values: np.ndarray[Any, Any], where: str) -> Any:
    """Text from MATLAB's 16-bit numbers of characters; a matrix of characters is a list of lines."""
    if values.dtype.kind not in "ui" or values.ndim > 2:
        raise InputError(where, "is no text, though it says so", "numbers of characters")
    lines = [values] if values.ndim < 2 else list(values)
    texts = [np.ravel(line).astype("<u2").tobytes().decode("utf-16-le", "replace") for line in lines]
    return texts[0] if values.ndim < 2 else texts
