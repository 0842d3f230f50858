"""MATLAB 7.3 files, which are HDF5, as the mappings that MATLAB 5 files give; other HDF5 files likewise.

MATLAB stores arrays with their axes reversed, text as numbers of characters, cells as references, and says
which is which in the attribute MATLAB_class. What lacks it, is taken as it stands, attributes of the file
among the keys.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fesloop.errors import InputError
from fesloop.streams.containers import hdf5
from fesloop.streams.room import Room

_DEEPEST, _MOST = 16, 100_000


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
        if depth > _DEEPEST or self._count > _MOST:
            raise InputError(where, "holds too much in each other", f"{_DEEPEST} levels, {_MOST} items")
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
