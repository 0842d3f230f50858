"""Rescue of recordings whose file is truncated or damaged: a new recording of the rows that are left."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fesloop.errors import InputError
from fesloop.experiment.recording.form import ALLOWED, undamaged
from fesloop.experiment.recording.writing import lengthen

_FLAGS, _CHECKSUM, _LENGTH = 11, 44, 48
"""Offsets in the superblock of the consistency flags and of the checksum of what precedes it; its length."""
_WORD = 2**32 - 1


def mark_closed(path: Path) -> None:
    """Clear the flags of a file that no writer has open any more, so that HDF5 opens it as any other.

    Nothing is done to a superblock that is damaged.
    """
    with path.open("r+b") as file:
        block = bytearray(file.read(_LENGTH))
        if len(block) < _LENGTH or block[_CHECKSUM:] != checksum(bytes(block[:_CHECKSUM])):
            return
        block[_FLAGS] = 0
        block[_CHECKSUM:] = checksum(bytes(block[:_CHECKSUM]))
        file.seek(0)
        file.write(block)


def checksum(content: bytes) -> bytes:
    """Checksum of HDF5 metadata of one byte or more: lookup3, `hashlittle` from 0 (Bob Jenkins, 2006)."""
    state = [(0xDEADBEEF + len(content)) & _WORD] * 3
    while len(content) > 12:
        _add(state, content[:12])
        for one, other, third, by in ((0, 2, 1, 4), (1, 0, 2, 6), (2, 1, 0, 8), (0, 2, 1, 16), (1, 0, 2, 19),
                                      (2, 1, 0, 4)):
            state[one] = (state[one] - state[other]) & _WORD ^ _turned(state[other], by)
            state[other] = (state[other] + state[third]) & _WORD
        content = content[12:]
    _add(state, content.ljust(12, b"\0"))
    for one, other, by in ((2, 1, 14), (0, 2, 11), (1, 0, 25), (2, 1, 16), (0, 2, 4), (1, 0, 14), (2, 1, 24)):
        state[one] = ((state[one] ^ state[other]) - _turned(state[other], by)) & _WORD
    return state[2].to_bytes(4, "little")


def _add(state: list[int], words: bytes) -> None:
    for number in range(3):
        state[number] = (state[number] + int.from_bytes(words[4 * number:4 * number + 4], "little")) & _WORD


def _turned(word: int, by: int) -> int:
    """Rotate the bits of a 32-bit word to the left."""
    return (word << by | word >> 32 - by) & _WORD


_STREAMS = ("blocks", "plants", "inputs", "events", "messages", "wall/step_ns", "wall/instants",
            "wall/origins")
_STATUS = np.array(b"damaged", "S16")
_BEGINNING = b"\x89HDF\r\n\x1a\n\x03"
"""Signature and version of the superblock of a file in SWMR mode (HDF5 File Format Specification, II.A)."""


@dataclass(frozen=True, slots=True)
class Rescued:
    """A valid recording of the rows that are left.

    Attributes
    ----------
    path: of it, whose status is "damaged"; it goes when the context is left.
    losses: what is missing, a sentence each.
    """

    path: Path
    losses: Sequence[str]


@contextmanager
def rescued(path: Path) -> Iterator[Rescued]:
    """Copy a damaged recording, each stream up to its first lost row.

    Every stream is there from a run's first moment on; a truncation removes the ends of some. Raises
    InputError for a file that is no HDF5 file, or has lost its facts about the run as a whole.
    """
    with tempfile.TemporaryDirectory(prefix="fesloop-rescue-") as folder:
        padded, whole = Path(folder) / f"{path.name}.padded", Path(folder) / path.name
        try:
            size = path.stat().st_size
            with path.open("rb") as file:
                if file.read(len(_BEGINNING)) != _BEGINNING:
                    raise InputError(str(path), "does not begin as a recording does", ALLOWED)
            shutil.copyfile(path, padded)
        except OSError as fault:
            raise InputError(str(path), f"cannot be copied to look what is left: {fault}", ALLOWED) from None
        lengthen(padded)
        with undamaged(path):
            losses = _copied(padded, whole, size)
        short = padded.stat().st_size
        cut = [f"The file was cut short: {size:,} of {short:,} bytes are there."] if size < short else []
        padded.unlink()
        yield Rescued(whole, [*cut, *losses])


def _copied(source: Path, target: Path, size: int) -> list[str]:
    """Copy what can be read from the first `size` bytes; return the losses."""
    losses = []
    with _opened(source) as old, h5py.File(target, "w", libver="latest") as new:
        for key, value in old.attrs.items():
            new.attrs[key] = value
        new.create_dataset("experiment", data=old["experiment"][()])
        new.create_dataset("status", data=_STATUS)
        _copy_wall(old, new.create_group("wall"))
        for path, dataset in _datasets(old):
            kept = _copy_rows(dataset, new, path, size)
            if kept < dataset.shape[0]:
                losses.append(f"Of `{path}` {kept:,} of {dataset.shape[0]:,} rows are left.")
        losses += _without_trials(new)
    return losses


def _without_trials(new: h5py.File) -> list[str]:
    """Remove messages and events of trials without any other row; return these losses."""
    last = [int(dataset[-1]["trial"]) for path, dataset in _datasets(new)
            if path.startswith(("blocks/", "plants/", "inputs/")) and dataset.shape[0]]
    begun = max(last, default=-1) + 1
    losses = []
    for name in ("messages", "events"):
        kept = int(np.searchsorted(new[name]["trial"], begun)) if name in new else 0
        if name in new and kept < new[name].shape[0]:
            losses.append(f"Of trials from {begun} on nothing but `{name}` is left, which is not shown.")
            new[name].resize(kept, axis=0)
    return losses


def _opened(path: Path) -> h5py.File:
    """Open the copy of a file, also of one whose writer never closed it.

    Not in SWMR mode: there HDF5 reads damaged parts again and again, for hours, as a writer may repair them.
    """
    mark_closed(path)
    return h5py.File(path, "r")


def _copy_wall(old: h5py.File, wall: h5py.Group) -> None:
    """Copy the numbers and texts about the wall clock that can be read."""
    with suppress(OSError, RuntimeError, KeyError):
        for key, value in old["wall"].attrs.items():
            wall.attrs[key] = value
    for name in list(old["wall"]):
        with suppress(OSError, RuntimeError, KeyError):
            item = old["wall"][name]
            if isinstance(item, h5py.Dataset) and item.shape == ():
                wall.create_dataset(name, data=item[()])


def _datasets(file: h5py.File) -> Iterator[tuple[str, h5py.Dataset]]:
    """Every stream and table, by its path."""
    for start in _STREAMS:
        item = file.get(start)
        if isinstance(item, h5py.Dataset):
            yield start, item
        elif item is not None:
            found: list[str] = []
            item.visit(found.append)
            yield from ((f"{start}/{name}", item[name]) for name in found
                        if isinstance(item[name], h5py.Dataset))


def _copy_rows(dataset: h5py.Dataset, new: h5py.File, path: str, size: int) -> int:
    """Copy rows up to the first lost chunk; return their number."""
    chunk = dataset.chunks[0]
    made = new.create_dataset(path, shape=(0,), maxshape=(None,), chunks=(chunk,), dtype=dataset.dtype)
    for key, value in dataset.attrs.items():
        made.attrs[key] = value
    for first in range(0, dataset.shape[0], chunk):
        rows = _chunk_rows(dataset, first, min(first + chunk, dataset.shape[0]), size)
        if rows is None:
            break
        made.resize(first + len(rows), axis=0)
        made[first:] = rows
    return int(made.shape[0])


def _chunk_rows(dataset: h5py.Dataset, first: int, stop: int, size: int) -> Any:
    """Rows of one chunk; None if it is lost."""
    try:
        place = dataset.id.get_chunk_info_by_coord((first,))
        if place.byte_offset is None or place.byte_offset + place.size > size:
            return None
        return dataset[first:stop]
    except (OSError, RuntimeError, ValueError):
        return None
