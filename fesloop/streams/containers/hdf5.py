"""Opening HDF5 files that others wrote, or that became damaged, without harm.

Of 7500 recordings of fesloop's own form, changed at random, HDF5 2.0 hung for ever on 9, each time in a
global heap, where it keeps text of any length (and on none of 7500 files of MATLAB's form): that is the one
structure without a checksum, and an object of size 0 in it is walked on the spot. Heaps are therefore walked
here first.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fesloop.errors import InputError
from fesloop.streams.room import Room

SIGNATURE = b"\x89HDF\r\n\x1a\n"
_HEAP = b"GCOL"
_HEAP_HEADER = struct.Struct("<4sB3xQ")
_OBJECT = struct.Struct("<HH4xQ")
_LARGEST_HEAP = 2**26
_BLOCK_BYTES = 2**20


def open_hdf5(path: Path, allowed: str) -> h5py.File:
    """The file, for reading.

    Raises InputError, with what is `allowed`, for one that is missing, cut short or damaged.
    """
    try:
        require_sound_heaps(path)
        return h5py.File(path, "r")
    except (OSError, RuntimeError, ValueError) as fault:
        raise InputError(str(path), f"is no HDF5 file, or a damaged one: {fault}", allowed) from None


def form_of(path: Path, allowed: str) -> str:
    """The attribute `format` of a file, by which fesloop tells its own; "" of any other HDF5 file."""
    with open_hdf5(path, allowed) as file:
        told = attributes(file, str(path))
    return text(told, "format", str(path)) if isinstance(told.get("format"), (str, bytes)) else ""


def require_sound_heaps(path: Path) -> None:
    """Raise OSError where walking a global heap of the file would not end.

    The form of a heap: HDF5 File Format Specification 3.0, III.E. Text that is no heap but starts like one
    is passed over, unless its version and size are those of one.
    """
    size = path.stat().st_size
    if size == 0:
        raise OSError("it is empty")
    with path.open("rb", buffering=0) as file:
        before, end = b"", 0
        while block := file.read(_BLOCK_BYTES):
            text, end = before + block, end + len(block)
            found = text.find(_HEAP)
            while found >= 0:
                _require_sound_heap(file.fileno(), end - len(text) + found, size)
                found = text.find(_HEAP, found + 1)
            before = text[1 - len(_HEAP):]


def _require_sound_heap(file: int, start: int, file_size: int) -> None:
    """Go from object to object of the heap at `start`; each must lie within it and be longer than none."""
    header = os.pread(file, _HEAP_HEADER.size, start)
    if len(header) < _HEAP_HEADER.size:
        return
    _, version, size = _HEAP_HEADER.unpack(header)
    if version != 1 or not _HEAP_HEADER.size <= size <= min(file_size - start, _LARGEST_HEAP):
        return  # HDF5 itself refuses those
    heap, at = os.pread(file, size, start), _HEAP_HEADER.size
    while at + _OBJECT.size <= len(heap):
        index, _, length = _OBJECT.unpack_from(heap, at)
        taken = length if index == 0 else _OBJECT.size + -(-length // 8) * 8
        if taken < _OBJECT.size or at + taken > len(heap):
            raise OSError(f"the heap of texts at byte {start} is damaged")
        at += taken


def attributes(item: Any, where: str) -> dict[str, Any]:
    """Attributes of a file, group or dataset; InputError where they cannot be read."""
    try:
        return dict(item.attrs)
    except (OSError, RuntimeError, TypeError, ValueError, KeyError) as fault:
        raise InputError(f"{where}: attributes", f"cannot be read: {fault}", "an undamaged file") from None


def text(values: Mapping[str, Any], key: str, where: str) -> str:
    """A text attribute."""
    value = values.get(key)
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    if not isinstance(value, str) or _undecoded(value):
        raise InputError(f"{where}: {key}", "is missing" if key not in values else "is no text", "text")
    return value


def _undecoded(value: str) -> bool:
    """Whether text holds what stands for bytes that were no UTF-8."""
    return any("\ud800" <= letter <= "\udfff" for letter in value)


def members(group: h5py.Group, where: str) -> dict[str, h5py.Group | h5py.Dataset]:
    """Groups and datasets that stand in a group itself; InputError for a link that leads elsewhere."""
    found = {}
    try:
        for name in group:
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                raise InputError(f"{where}: {name}", "is a link to somewhere else", "a file of its own")
            found[name] = group[name]
    except InputError:
        raise
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as fault:
        raise InputError(where, f"cannot be read: {fault}", "an undamaged file") from None
    return found


def array(item: Any, room: Room, where: str) -> np.ndarray[Any, Any]:
    """All values of a dataset.

    Raises InputError for what is no dataset, lies in other files, takes more than there is `room`, or is
    damaged.
    """
    if not isinstance(item, h5py.Dataset):
        raise InputError(where, "is missing" if item is None else "is no dataset", "a dataset")
    try:
        if item.external or item.is_virtual:
            raise InputError(where, "lies in another file", "a file of its own")
        room.take(item.size * item.dtype.itemsize if item.size else 0, where)
        values: np.ndarray[Any, Any] = np.asarray(item[()])
    except InputError:
        raise
    except (OSError, RuntimeError, ValueError, TypeError, MemoryError, OverflowError) as fault:
        raise InputError(where, f"cannot be read: {fault}", "an undamaged file") from None
    return values
