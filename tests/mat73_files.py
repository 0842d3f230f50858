"""MATLAB 7.3 files as MATLAB writes them (`save -v7.3`): HDF5 behind 512 bytes of text, axes reversed."""

from __future__ import annotations

import h5py
import numpy as np

CLASSES = {"f8": "double", "f4": "single", "u1": "uint8", "i8": "int64"}


def _put(file, group, name, value):
    if isinstance(value, dict):
        inner = group.create_group(name)
        inner.attrs["MATLAB_class"] = np.bytes_("struct")
        for key, item in value.items():
            _put(file, inner, key, item)
    elif isinstance(value, str):
        letters = np.frombuffer(value.encode("utf-16-le"), "<u2")[:, np.newaxis]
        group.create_dataset(name, data=letters).attrs["MATLAB_class"] = np.bytes_("char")
    elif isinstance(value, list):
        store = file.require_group("#refs#")
        places = []
        for item in value:
            _put(file, store, f"r{len(store)}", item)
            places.append(store[f"r{len(store) - 1}"].ref)
        cells = group.create_dataset(name, (len(value), 1), dtype=h5py.ref_dtype)
        cells[:, 0] = places
        cells.attrs["MATLAB_class"] = np.bytes_("cell")
    else:
        matrix = np.atleast_2d(np.asarray(value))
        matrix = matrix.T if np.ndim(value) == 1 else matrix
        dataset = group.create_dataset(name, data=matrix.T, compression="gzip", chunks=True)
        dataset.attrs["MATLAB_class"] = np.bytes_(CLASSES[matrix.dtype.str[1:]])


def write_mat73(path, content):
    """A file of numbers, text, lists (cells) and dicts (structures)."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in content.items():
            _put(file, file, name, value)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    return path
