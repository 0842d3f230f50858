"""Writes HDF5 files whole, and reads those that others wrote, or that are damaged, without harm.

Of 7500 recordings of fesloop's own form, changed at random, HDF5 2.0 hung for ever on 9, each time in a
global heap, where it keeps text of any length (and on none of 7500 files of MATLAB's form): the heap is the
one structure without a checksum, and HDF5 never gets past an object of size 0 in it. Recordings of runs are
read where they are, not in the reader process, so that heaps are walked here first.
"""

from __future__ import annotations

import secrets
import struct
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

import h5py
import numpy as np

from fesloop.errors import InputError

_HEAP = b"GCOL"
_HEAP_HEADER = struct.Struct("<4sB3xQ")
_OBJECT = struct.Struct("<HH4xQ")
_LARGEST_HEAP = 2**26
_BLOCK_BYTES = 2**20


@contextmanager
def new_hdf5(target: Path) -> Iterator[h5py.File]:
    """A new file to write to, which appears whole or not at all.

    Raises InputError where there is a file of this name, or none can be made.
    """
    draft = target.parent / f".{target.name}-{secrets.token_hex(8)}"
    try:
        if target.exists():
            raise InputError(str(target), "exists", "a new name", "remove it, or give another name")
        target.parent.mkdir(parents=True, exist_ok=True)
        with h5py.File(draft, "w-", libver=("v110", "v110")) as file:
            yield file
        draft.rename(target)
    except OSError as fault:
        raise InputError(str(target), f"cannot be written: {fault.strerror or fault}",
                         "a file in a folder that can be written to") from None
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)


def open_hdf5(path: Path, allowed: str, where: str = "") -> h5py.File:
    """The file, for reading.

    Raises InputError, with what is `allowed`, for one that is missing, cut short or damaged; `where` names it
    there in place of its path.
    """
    try:
        require_sound_heaps(path)
        return h5py.File(path, "r")
    except (OSError, RuntimeError, ValueError) as fault:
        raise InputError(where or str(path), f"is no HDF5 file, or a damaged one: {fault}", allowed) from None


def require_sound_heaps(path: Path) -> None:
    """Raise OSError where walking a global heap of the file would not end.

    A heap has the form of HDF5 File Format Specification 3.0, III.E. Text that starts like a heap but has not
    the version and size of one is passed over.
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
                _require_sound_heap(file, end - len(text) + found, size)
                file.seek(end)
                found = text.find(_HEAP, found + 1)
            before = text[1 - len(_HEAP):]


def _require_sound_heap(file: BinaryIO, start: int, file_size: int) -> None:
    """Check the objects of the heap at `start`: each must be inside it and take some bytes."""
    file.seek(start)
    header = file.read(_HEAP_HEADER.size)
    if len(header) < _HEAP_HEADER.size:
        return
    _, version, size = _HEAP_HEADER.unpack(header)
    if version != 1 or not _HEAP_HEADER.size <= size <= min(file_size - start, _LARGEST_HEAP):
        return  # HDF5 itself refuses those
    file.seek(start)
    heap, at = file.read(size), _HEAP_HEADER.size
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
    """Return whether text has surrogates, which replace bytes that are not UTF-8."""
    return any("\ud800" <= letter <= "\udfff" for letter in value)


def members(group: h5py.Group, where: str) -> dict[str, h5py.Group | h5py.Dataset]:
    """Groups and datasets in a group itself; InputError for a link that leads elsewhere."""
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


def array(item: Any, where: str) -> np.ndarray[Any, Any]:
    """Return all values of a dataset.

    Raises InputError for an item that is no dataset, has its values in other files, or is damaged.
    """
    if not isinstance(item, h5py.Dataset):
        raise InputError(where, "is missing" if item is None else "is no dataset", "a dataset")
    try:
        if item.external or item.is_virtual:
            raise InputError(where, "lies in another file", "a file of its own")
        values: np.ndarray[Any, Any] = np.asarray(item[()])
    except InputError:
        raise
    except (OSError, RuntimeError, ValueError, TypeError, MemoryError, OverflowError) as fault:
        raise InputError(where, f"cannot be read: {fault}", "an undamaged file") from None
    return values
