"""Containers that recordings come in, MATLAB 5, HDF5 (MATLAB 7.3) and NumPy npz, as plain mappings.

Their decoders belong to other projects and raise nearly anything on a broken file; here that becomes one
line. None runs code from the file: pickled objects are refused. What a file declares to be in it is held
against its size before it is decoded.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.errors import InputError
from fesloop.given_files import exists, is_file, is_folder
from fesloop.streams.containers.matlab import sound_variables
from fesloop.streams.room import Room

ZIP, HDF5, MATLAB, MATLAB_73 = b"PK\x03\x04", b"\x89HDF\r\n\x1a\n", b"MATLAB 5.0", b"MATLAB 7.3"
FORMATS = "a MATLAB .mat or a NumPy .npz recording"
_HEAD_BYTES = 1024


def read_container(path: Path) -> Mapping[str, Any]:
    """Everything in the file, by key.

    Raises InputError where there is no such file, it is none of these, or it cannot be decoded.
    """
    head = head_of(path, FORMATS)
    if is_hdf5(head):
        return _decoded(path, _read_hdf5)
    if head.startswith(ZIP):
        return _decoded(path, _read_npz)
    if head.startswith(MATLAB):
        return _decoded(path, _read_mat)
    raise InputError(str(path), "is empty" if not head else "is neither a .mat nor an .npz file", FORMATS)


def is_hdf5(head: bytes) -> bool:
    """Whether a file that starts so is HDF5; MATLAB puts 512 bytes of its own before."""
    return head.startswith(HDF5) or (head.startswith(MATLAB_73) and head[512:].startswith(HDF5))


def is_container(head: bytes) -> bool:
    """Whether a file that starts so is one of the containers."""
    return is_hdf5(head) or head.startswith((ZIP, MATLAB, MATLAB_73))


def head_of(path: Path, allowed: str) -> bytes:
    """How a file starts; InputError, with what is `allowed`, where it cannot be read."""
    where = str(path)
    if exists(path) and not is_file(path):  # reading a pipe would wait for its writer
        raise InputError(where, "is a folder" if is_folder(path) else "is no file", allowed)
    try:
        with path.open("rb") as file:
            return file.read(_HEAD_BYTES)
    except FileNotFoundError:
        raise InputError(where, "there is no such file", allowed) from None
    except (OSError, ValueError) as fault:
        raise InputError(where, f"cannot be read: {fault}", allowed) from None


def _decoded(path: Path, decode: Callable[[Path, Room], dict[str, Any]]) -> Mapping[str, Any]:
    try:  # whatever the decoder raises on a broken file means the same to the user
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            content = decode(path, Room(path))
    except InputError:
        raise
    except Exception as fault:
        reason = str(fault).strip().splitlines()
        raise InputError(str(path), "cannot be decoded, it is truncated or corrupt "
                         f"({type(fault).__name__}: {reason[0] if reason else 'no reason given'})",
                         FORMATS, "fetch the file again") from fault
    return content


def _read_npz(path: Path, room: Room) -> dict[str, Any]:
    with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
        for entry in archive.zip.infolist():
            room.take(entry.file_size, f"{path}: {entry.filename}")
        content: dict[str, Any] = {}
        for key in archive.files:
            try:
                content[key] = archive[key]
            except ValueError as fault:
                if "pickle" not in str(fault):
                    raise
                raise InputError(f"{path}: {key}", "is a pickled object, which could run code",
                                 "plain arrays", "save it without objects") from None
        return content


def _read_hdf5(path: Path, room: Room) -> dict[str, Any]:
    from fesloop.streams.containers.matlab import read_hdf5

    return read_hdf5(path, room, FORMATS)


def _read_mat(path: Path, room: Room) -> dict[str, Any]:
    from scipy.io import loadmat

    names = sound_variables(path, room)
    content = loadmat(str(path), appendmat=False, simplify_cells=True, variable_names=names)
    return {key: content[key] for key in names if key in content}
