"""Decoders of foreign files, run in the reader process of `fesloop.streams.reading`.

Each uses the library of its field and returns plain content: tables by key, lists, text, numbers and arrays.
Memory and time of the process are limited, so that no decoder guards against the sizes that a file declares.
"""

from __future__ import annotations

import json
import logging
import os
import struct
import sys
import threading
import time
import warnings
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import h5py
import numpy as np

from fesloop.errors import InputError
from fesloop.posix import limit_memory, limit_processor_time
from fesloop.streams import hdf5
from fesloop.streams.reading import IDLE
from fesloop.streams.text_table import parse_columns, parse_table

IDLE_S = 30
"""Time without a file after which the process ends (chosen)."""
_NUMERIC = "fiubc"
_CHUNK_LENGTHS = {1: "<B", 4: "<I", 8: "<Q"}
_STREAM_HEADER, _SAMPLES, _CLOCK_OFFSET, _STREAM_FOOTER = 2, 3, 4, 6
_CHUNK_KINDS = range(1, 7)
_UNDAMAGED_XDF = "an undamaged XDF file"


def xdf(path: Path, where: str) -> list[dict[str, Any]]:
    """Streams of an XDF file as pyxdf reads them: stamps on the sender's clock, times on the recorder's.

    pyxdf skips damaged chunks; here whatever it reports, and a chunk whose samples do not fill it, refuses
    the file.
    """
    import pyxdf  # type: ignore[import-untyped]

    starts = _xdf_chunks(path, where)
    with path.open("rb") as file:
        damage = _Damage(file, starts, where)
        logger = logging.getLogger("pyxdf")
        logger.handlers, logger.propagate = [damage], False

        ends, stamps_of = set(starts), defaultdict(list)

        def take(values: Any, stamps: Any, header: Any, stream: int) -> tuple[Any, Any, Any]:
            if file.tell() not in ends:
                raise ValueError("its samples do not fill it")
            stamps_of[stream].append(stamps)
            return values, stamps, header

        streams, _ = pyxdf.load_xdf(file, on_chunk=take, dejitter_timestamps=False, handle_clock_resets=False)
    found = []
    for stream in streams:
        times_s, own = stream["time_stamps"], stamps_of[stream["info"]["stream_id"]]
        found.append({
            "info": stream["info"], "times_s": times_s,
            "stamps_s": np.concatenate([np.zeros(0), *own])[:len(times_s)],
            "values": stream["time_series"] if isinstance(stream["time_series"], np.ndarray) else None,
            "clock_s": stream["clock_times"], "offset_s": stream["clock_values"]})
    return found


class _Damage(logging.Handler):
    """Turns what pyxdf reports of a file into an InputError that names the chunk.

    `starts`: bytes at which chunks begin, and the file's length.
    """

    def __init__(self, file: BinaryIO, starts: list[int], where: str) -> None:
        super().__init__(logging.WARNING)
        self._file, self._starts, self._where = file, starts, where

    def emit(self, record: logging.LogRecord) -> None:
        """Refuse the file for errors, and for clock offsets that pyxdf cannot use and would leave out."""
        if record.levelno >= logging.ERROR:
            chunk = self._starts[max(0, bisect_left(self._starts, self._file.tell()) - 1)]
            raise InputError(f"{self._where}: chunk at byte {chunk}", f"is damaged: {record.getMessage()}",
                             _UNDAMAGED_XDF)
        if "cannot be used" in record.getMessage():
            raise InputError(self._where, record.getMessage(), "clock offsets of different instants")


def _xdf_chunks(path: Path, where: str) -> list[int]:
    """Bytes at which the chunks of an XDF file begin, and its length.

    Raises InputError where lengths do not lead to the file's end, for an unknown kind of chunk, and for a
    stream without exactly one header before its chunks.
    """
    size, at, starts = path.stat().st_size, 4, []
    headers: set[int] = set()
    with path.open("rb") as file:
        while at < size:
            place = f"{where}: chunk at byte {at}"
            file.seek(at)
            head = file.read(15)
            width = head[0]
            if width not in _CHUNK_LENGTHS or len(head) < width + 3:
                raise InputError(place, f"has a length of {width} bytes", _UNDAMAGED_XDF)
            length = struct.unpack_from(_CHUNK_LENGTHS[width], head, 1)[0]
            if length < 2 or at + 1 + width + length > size:
                raise InputError(place, f"has {length} bytes, {size - at - 1 - width} are left",
                                 _UNDAMAGED_XDF,
                                 "copy the file again; if its recording was cut short, cut it here")
            kind = struct.unpack_from("<H", head, 1 + width)[0]
            if kind not in _CHUNK_KINDS:
                raise InputError(place, f"is of the unknown kind {kind}", _UNDAMAGED_XDF)
            if kind in (_STREAM_HEADER, _SAMPLES, _CLOCK_OFFSET, _STREAM_FOOTER):
                if length < 6:
                    raise InputError(place, f"has {length} bytes", _UNDAMAGED_XDF)
                stream = struct.unpack_from("<I", head, 3 + width)[0]
                if (kind == _STREAM_HEADER) == (stream in headers):
                    raise InputError(place, f"describes stream {stream} a second time" if stream in headers
                                     else f"belongs to stream {stream}, which has no header before",
                                     _UNDAMAGED_XDF)
                headers.add(stream)
            starts.append(at)
            at += 1 + width + length
    return [*starts, size]


def matlab(path: Path, where: str) -> dict[str, Any]:
    """Variables of a MATLAB 5 file: numbers, text, cells and structures; others are left out."""
    from scipy.io import loadmat

    content = loadmat(str(path), appendmat=False, simplify_cells=True)
    return {key: value for key, value in content.items()
            if not key.startswith("__") and isinstance(value, (str, list, dict, np.ndarray, float, int))
            and not (isinstance(value, np.ndarray) and value.dtype.kind not in f"{_NUMERIC}UO")}


def npz(path: Path, where: str) -> dict[str, Any]:
    """Arrays of a NumPy archive; InputError for pickled objects."""
    content: dict[str, Any] = {}
    with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
        for key in archive.files:
            try:
                content[key] = archive[key]
            except ValueError as fault:
                if "pickle" not in str(fault):
                    raise
                raise InputError(f"{where}: {key}", "is a pickled object, which could run code",
                                 "plain arrays", "save it without objects") from None
    return content


def hdf5_file(path: Path, where: str) -> dict[str, Any]:
    """Content of an HDF5 file by its attribute `format`.

    A file of fesloop's own recordings of motion or stimulation gives `attributes` and `items` as they are; a
    run's recording nothing more; any other file `content`, read as MATLAB 7.3 writes it.
    """
    with hdf5.open_hdf5(path, "a MATLAB .mat file or any other HDF5 file", where) as file:
        own = hdf5.attributes(file, where)
        form = own.get("format") if isinstance(own.get("format"), (str, bytes)) else ""
        form = hdf5.text(own, "format", where) if form else ""
        if form.startswith("fesloop recording"):
            return {"format": form}
        if form.startswith(("fesloop motion", "fesloop stimulation")):
            return {"format": form, **_group(file, where)}
        content = {key: value for key, value in own.items() if np.asarray(value).dtype.kind in "fiub"}
        for name, item in hdf5.members(file, where).items():
            if not name.startswith("#"):
                content[name] = _matlab_value(file, item, f"{where}: {name}")
        return {"format": form, "content": content}


def _group(group: h5py.Group, where: str) -> dict[str, Any]:
    """Attributes, datasets and groups of a group."""
    items = {name: _group(item, f"{where}: {name}") if isinstance(item, h5py.Group)
             else hdf5.array(item, f"{where}: {name}")
             for name, item in hdf5.members(group, where).items()}
    return {"attributes": hdf5.attributes(group, where), "items": items}


def _matlab_value(file: h5py.File, item: Any, where: str) -> Any:
    """Value of a group or dataset of MATLAB 7.3; axes of length 1 go, as of MATLAB 5 files."""
    if isinstance(item, h5py.Group):
        return {name: _matlab_value(file, part, f"{where}.{name}")
                for name, part in hdf5.members(item, where).items()}
    values = hdf5.array(item, where)
    own = hdf5.attributes(item, where)
    kind = own.get("MATLAB_class", b"")
    kind = kind.decode("ascii", "replace") if isinstance(kind, bytes) else str(kind)
    if own.get("MATLAB_empty", 0):
        return "" if kind == "char" else np.zeros(0)
    if values.dtype == h5py.ref_dtype or values.dtype.kind == "O":
        found = [_cell(file, each, f"{where}[{number}]") for number, each in enumerate(np.ravel(values))]
        return found[0] if values.ndim == 0 and found else found
    if not kind:
        return values
    values = np.squeeze(values.T)
    if kind != "char":
        return values
    if values.dtype.kind not in "ui" or values.ndim > 2:
        raise InputError(where, "is no text, though its MATLAB_class is char", "numbers of characters")
    lines = [np.ravel(line).astype("<u2").tobytes().decode("utf-16-le", "replace")
             for line in ([values] if values.ndim < 2 else values)]
    return lines[0] if values.ndim < 2 else lines


def _cell(file: h5py.File, cell: Any, where: str) -> Any:
    """Value of one cell: text, or what its reference leads to."""
    if isinstance(cell, bytes):
        return cell.decode("utf-8", "replace")
    if not isinstance(cell, h5py.Reference) or not cell:
        raise InputError(where, "leads nowhere", "numbers, text, cells, structures")
    try:
        target = file[cell]
    except (ValueError, KeyError, RuntimeError, OSError) as fault:
        raise InputError(where, f"leads nowhere: {fault}", "an undamaged file") from None
    return _matlab_value(file, target, where)


def table(path: Path, where: str, **form: Any) -> dict[str, Any]:
    """Names and values of a text table; see `fesloop.streams.text_table`."""
    return parse_table(path, where, **form)


def columns(path: Path, where: str, **form: Any) -> dict[str, Any]:
    """Columns of a text table by name, of numbers and texts; see `fesloop.streams.text_table`."""
    return parse_columns(path, where, **form)


DECODERS: dict[str, Callable[..., Any]] = {
    "xdf": xdf, "matlab": matlab, "npz": npz, "hdf5": hdf5_file, "table": table,
    "columns": columns}


def plain(value: Any, arrays: list[np.ndarray[Any, Any]]) -> Any:
    """A value as JSON can hold it; arrays of numbers go to `arrays`, and leave type and shape."""
    if isinstance(value, Mapping):
        return {"table": [[str(key), plain(each, arrays)] for key, each in value.items()]}
    if isinstance(value, np.ndarray) and value.dtype.kind in _NUMERIC:
        arrays.append(np.ascontiguousarray(value))
        return {"array": [value.dtype.str, list(value.shape)]}
    if isinstance(value, np.ndarray):
        return plain(value.tolist(), arrays) if value.dtype.kind in "USO" else f"values of {value.dtype}"
    if isinstance(value, (list, tuple)):
        return {"list": [plain(each, arrays) for each in value]}
    if isinstance(value, np.generic):
        return plain(np.asarray(value) if value.dtype.kind == "c" else value.item(), arrays)
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return value if isinstance(value, (str, int, float, bool, type(None))) else str(type(value).__name__)


def serve() -> None:
    """Answer requests on standard input, a line of JSON each, on standard output, until there is none."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever a library prints is no answer
    idle = _idle()
    for line in sys.stdin.buffer:
        idle.cancel()
        header, arrays = _answer(**json.loads(line))
        text = json.dumps(header).encode()
        answers.write(struct.pack("<Q", len(text)) + text)
        for array in arrays:
            answers.write(array.reshape(-1).view(np.uint8).data)
        answers.flush()
        del arrays
        idle = _idle()


def _idle() -> threading.Timer:
    """Timer that ends this process if no file comes."""
    timer = threading.Timer(IDLE_S, os._exit, (IDLE,))
    timer.daemon = True
    timer.start()
    return timer


def _answer(form: str, path: str, where: str, options: dict[str, Any], memory_bytes: int,
            seconds: int) -> tuple[dict[str, Any], list[np.ndarray[Any, Any]]]:
    """Content of a file or its fault, and the arrays that belong to it."""
    limit_memory(memory_bytes)
    limit_processor_time(int(time.process_time()) + 1 + seconds)
    arrays: list[np.ndarray[Any, Any]] = []
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            content = plain(DECODERS[form](Path(path), where, **options), arrays)
    except InputError as fault:
        return {"fault": [fault.where, fault.found, fault.allowed, fault.remedy]}, []
    except MemoryError:
        return {"fault": [where, f"would take more than {memory_bytes / 1e6:.0f} MB of memory",
                          "an undamaged file", ""]}, []
    except Exception as fault:  # noqa: BLE001 - whatever a decoder raises on a broken file means the same
        reason = str(fault).strip().splitlines()
        return {"fault": [where, "cannot be decoded, it is truncated or corrupt "
                          f"({type(fault).__name__}: {reason[0] if reason else 'no reason given'})",
                          "an undamaged file", "copy the file again"]}, []
    return {"content": content}, arrays
