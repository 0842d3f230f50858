"""The two containers that recordings come in, MATLAB 5 and NumPy npz, as plain mappings.

Both decoders belong to other projects and raise nearly anything on a broken file; here that becomes one
line. Neither runs code from the file: pickled objects are refused.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.errors import InputError

_ZIP, _HDF5, _MATLAB = b"PK\x03\x04", b"\x89HDF\r\n\x1a\n", b"MATLAB 5.0"
FORMATS = "a MATLAB 5 .mat or a NumPy .npz recording"


def read_container(path: Path) -> Mapping[str, Any]:
    """Everything in the file, by key.

    Raises InputError where there is no such file, it is neither of the two, or it cannot be decoded.
    """
    where = str(path)
    try:
        with path.open("rb") as file:
            head = file.read(128)
    except FileNotFoundError:
        raise InputError(where, "there is no such file", FORMATS) from None
    except (OSError, ValueError) as fault:
        reason = "is a folder" if path.is_dir() else f"cannot be read: {fault}"
        raise InputError(where, reason, FORMATS) from None
    if head.startswith(_HDF5) or b"MATLAB 7.3" in head:
        raise InputError(where, "is a MATLAB 7.3 (HDF5) file", FORMATS, "save it with -v7")
    if head.startswith(_ZIP):
        return _decoded(path, _read_npz)
    if head.startswith(_MATLAB):
        return _decoded(path, _read_mat)
    raise InputError(where, "is empty" if not head else "is neither a .mat nor an .npz file", FORMATS)


def _decoded(path: Path, decode: Callable[[Path], dict[str, Any]]) -> Mapping[str, Any]:
    try:  # whatever the decoder raises on a broken file means the same to the user
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            content = decode(path)
    except InputError:
        raise
    except Exception as fault:
        reason = str(fault).strip().splitlines()
        raise InputError(str(path), "cannot be decoded, it is truncated or corrupt "
                         f"({type(fault).__name__}: {reason[0] if reason else 'no reason given'})",
                         FORMATS, "fetch the file again") from fault
    return content


def _read_npz(path: Path) -> dict[str, Any]:
    with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
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


def _read_mat(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    content = loadmat(str(path), appendmat=False, simplify_cells=True)
    return {key: value for key, value in content.items() if not key.startswith("__")}
