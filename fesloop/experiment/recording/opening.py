"""Opening a recording's file, whatever became of its writer."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import h5py

from fesloop.errors import InputError
from fesloop.experiment.recording.form import ALLOWED, require_form, undamaged
from fesloop.given_files import is_file
from fesloop.streams.containers.hdf5 import require_sound_heaps

_LOOKS, _BETWEEN_S = 3, 0.02
"""How often a file that is too short is looked at again, and how long between (chosen: writers need less)."""


def open_file(path: Path) -> h5py.File:
    """The file, for reading; InputError for one that is missing, damaged or no recording."""
    if not is_file(path):
        raise InputError(str(path), "there is no such recording", ALLOWED)
    try:
        require_sound_heaps(path)
        file = _open_anyhow(path)
    except (OSError, RuntimeError) as fault:
        raise InputError(str(path), f"is no HDF5 file, or a damaged one: {fault}", ALLOWED) from None
    try:
        with undamaged(path):
            form = str(file.attrs.get("format", ""))
        if not form.startswith("fesloop recording"):
            raise InputError(str(path), "is an HDF5 file, but no recording of fesloop", ALLOWED)
        require_form(file, path)
    except InputError:
        file.close()
        raise
    return file


def _open_anyhow(path: Path) -> h5py.File:
    """A file whose writer lives or was killed still says "open for write" and opens in SWMR mode only."""
    try:
        return _open_when_long_enough(path)
    except OSError as fault:
        if not any(sign in str(fault) for sign in ("already open for", "unable to lock")):
            raise
    file = h5py.File(path, "r", swmr=True)
    needed, size = _end_of_data(file), path.stat().st_size
    if needed > size:
        file.close()
        raise OSError(f"cut short: {size} bytes of {needed}")
    return file


def _open_when_long_enough(path: Path) -> h5py.File:
    """A writer says how long its file is a moment before it is so long."""
    for _ in range(_LOOKS):
        try:
            return h5py.File(path, "r")
        except OSError as fault:
            if "truncated file" not in str(fault):
                raise
        time.sleep(_BETWEEN_S)
    return h5py.File(path, "r")


def _end_of_data(file: h5py.File) -> int:
    """Where the last chunk ends: in SWMR mode HDF5 itself does not look for a missing end."""
    ends = [0]

    def note(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.chunks:
            item.id.chunk_iter(lambda chunk: ends.append(chunk.byte_offset + chunk.size))

    file.visititems(note)
    return max(ends)
