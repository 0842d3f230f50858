"""The file of a recording on its disk: room for it, a hidden draft, and its name once it can be read."""

from __future__ import annotations

import itertools
import re
import secrets
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import h5py

from fesloop.errors import InputError, RunError
from fesloop.experiment.recording.rows import Rows

ROOM_BYTES = 2**24
"""What stays free on the disk (chosen): chunks are written whole, and the end of a run has to be noted."""
_CHUNK_CACHE_BYTES = 2**17
"""Of each dataset: the chunk that rows are added to, and some more. HDF5 keeps up to 8 MB of each by itself,
which are never looked at again, so that a run would grow for minutes."""


_END_OF_FILE = 28
"""Where the superblock says how long the file is."""


def draft_file(folder: Path, name: str) -> tuple[Path, h5py.File]:
    """A file under a hidden name, until it is one that can be read."""
    draft = folder / f".{name}-{secrets.token_hex(8)}.h5"
    try:
        free = free_bytes(folder)
        if free < ROOM_BYTES:
            raise InputError(f"--out {folder}", f"the disk is full, {free / 1e6:.0f} MB are left",
                             f"{ROOM_BYTES / 1e6:.0f} MB or more", "make room, or give another folder")
        folder.mkdir(parents=True, exist_ok=True)
        return draft, h5py.File(draft, "w", libver="latest", rdcc_nbytes=_CHUNK_CACHE_BYTES)
    except OSError as fault:
        raise InputError(f"--out {folder}", f"no recording can be made there: {fault.strerror or fault}",
                         "a folder that can be written to") from None


def publish(draft: Path, folder: Path, name: str) -> Path:
    """Give the draft its name, the first that is free, in one step: nobody ever sees half a file."""
    for number in itertools.count(1):
        path = folder / f"{name}-{number}.h5"
        try:
            path.hardlink_to(draft)
        except FileExistsError:
            continue
        except OSError:  # a file system without links
            if path.exists():
                continue
            return draft.rename(path)
        draft.unlink()
        return path
    raise AssertionError("numbers do not end")


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Within, what HDF5 cannot write (a quota, a cable) is a RunError of one line; both kinds are h5py's."""
    try:
        yield
    except (OSError, RuntimeError) as fault:
        reason = re.search("error message = '([^']*)'", str(fault))
        raise RunError(f"{path}: cannot be written: {reason[1] if reason else fault}") from None


def append(file: h5py.File, tables: Sequence[tuple[h5py.Dataset, Rows]]) -> None:
    """Append rows to datasets and bring them to the disk's care."""
    for dataset, rows in tables:
        if len(rows):
            before = dataset.shape[0]
            dataset.resize(before + len(rows), axis=0)
            dataset[before:] = rows
    file.flush()


def lengthen(path: Path) -> None:
    """Give a file whose end could not be written one of zeros, without which HDF5 opens none of it.

    Where it should end stands in the superblock (HDF5 File Format Specification 3.0, II.A, version 3).
    """
    with suppress(OSError), path.open("r+b") as file:
        file.seek(_END_OF_FILE)
        end = int.from_bytes(file.read(8), "little")
        if path.stat().st_size < end:
            file.truncate(end)


def free_bytes(path: Path) -> int:
    """Room on the disk of a path, or of where it will be made."""
    there = next(each for each in (path, *path.absolute().parents) if each.exists())
    return shutil.disk_usage(there).free
