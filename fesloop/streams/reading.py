"""Reads foreign files in a separate process whose memory and time are limited.

Decoders belong to other projects (pyxdf, SciPy, h5py, NumPy), and a damaged file makes them crash, loop for
ever or allocate more memory than there is. In the reader process (`fesloop.streams.decoders`) each of these
becomes one InputError. Arrays, numbers and text come back through a pipe; nothing in a file is executed or
unpickled. One process serves several files, and ends when none has come for a while.
"""

from __future__ import annotations

import atexit
import json
import math
import os
import signal
import struct
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

import numpy as np

from fesloop.errors import InputError
from fesloop.given_files import exists, is_file, is_folder
from fesloop.posix import ran_out_of_time

ZIP, HDF5, MATLAB, MATLAB_73 = b"PK\x03\x04", b"\x89HDF\r\n\x1a\n", b"MATLAB 5.0", b"MATLAB 7.3"
FORMATS = "a MATLAB .mat or a NumPy .npz recording"
_HEAD_BYTES = 1024
LEAST_BYTES, EXPANSION = 2**29, 40
"""Memory for a file: 512 MB, or 40 times its size if that is more (chosen: samples of real sensors hardly
compress to a third; NumPy takes 260 MB for a text table of 400,000 rows in 1.6 MB)."""
LEAST_S, BYTES_A_SECOND = 10, 10**6
"""Processor time for a file: 10 s and 1 s more a MB (chosen: the slowest decoder, of text, reads 5 MB/s)."""
_BUSY = 10.0
"""Ratio of wall time to the limit of processor time above which the process counts as hanging (chosen: a busy
machine makes it wait)."""
_NUMERIC = "fiubc"
_ENDING_S = 5.0
IDLE = 75
"""Exit code of a process for which there was no file for a while."""


def read_file(form: str, path: Path, **options: Any) -> Any:
    """Content of a file, read in the reader process.

    Parameters
    ----------
    form: name of the decoder, a key of `fesloop.streams.decoders.DECODERS`.
    options: of that decoder.

    Raises InputError for a file that cannot be decoded, or takes more memory or time than its size allows.
    """
    return _READER.ask(form, path, options)


class _Reader:
    """The reader process of this process, started at its first file.

    Attributes
    ----------
    memory_bytes, seconds: limits at their least, for a small file.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._owner = 0
        self._impatient = False
        self.memory_bytes, self.seconds = LEAST_BYTES, LEAST_S

    def ask(self, form: str, path: Path, options: Mapping[str, Any]) -> Any:
        """See `read_file`."""
        where = str(path)
        try:
            size = path.stat().st_size
        except (OSError, ValueError) as fault:
            raise InputError(where, f"cannot be read: {fault}") from None
        memory = max(self.memory_bytes, EXPANSION * size)
        seconds = self.seconds + math.ceil(size / BYTES_A_SECOND)
        request = json.dumps({"form": form, "path": os.path.abspath(path), "where": where,  # noqa: PTH100
                              "options": options, "memory_bytes": memory, "seconds": seconds})
        with self._lock:
            answer = None
            while answer is None:
                try:
                    answer = self._exchange(request.encode() + b"\n", memory, seconds)
                except EOFError:
                    ended = -self.close()
                    if ended == -IDLE:  # it has just ended after waiting too long for a file
                        continue
                    cause = _cause(ended, seconds, self._impatient)
                    raise InputError(where, cause, "an undamaged file",
                                     "copy the file again") from None
        header, arrays = answer
        if "fault" in header:
            raise InputError(*header["fault"])
        return _restored(header["content"], iter(arrays))

    def _exchange(self, request: bytes, memory: int, seconds: int) -> tuple[Any, list[Any]]:
        """Header and arrays of an answer; EOFError where the process ends before them."""
        process = self._running()
        assert process.stdin is not None
        assert process.stdout is not None
        self._impatient = False
        patience = threading.Timer(_BUSY * seconds, self._end_hanging, (process,))
        patience.daemon = True
        patience.start()
        try:
            with suppress(BrokenPipeError):
                process.stdin.write(request)
                process.stdin.flush()
            length = struct.unpack("<Q", _exactly(process.stdout, 8))[0]
            if length > memory:
                raise EOFError
            header = json.loads(_exactly(process.stdout, length))
            arrays = []
            for dtype, shape in _forms_of(header.get("content")):
                kind = np.dtype(dtype)
                memory -= kind.itemsize * math.prod(shape)
                if kind.kind not in _NUMERIC or memory < 0:
                    raise EOFError
                body = _exactly(process.stdout, kind.itemsize * math.prod(shape))
                arrays.append(np.frombuffer(body, kind).reshape(shape))
        finally:
            patience.cancel()
        return header, arrays

    def _end_hanging(self, process: subprocess.Popen[bytes]) -> None:
        self._impatient = True
        process.kill()

    def _running(self) -> subprocess.Popen[bytes]:
        if self._process is not None and self._owner == os.getpid() and self._process.poll() is None:
            return self._process
        if self._process is not None and self._owner == os.getpid():
            self.close()
        command = [sys.executable, "-c", "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
                   "from fesloop.streams.decoders import serve; serve()",
                   json.dumps([os.path.abspath(place) for place in sys.path])]  # noqa: PTH100
        one_thread = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                         stderr=subprocess.DEVNULL, env={**os.environ, **one_thread},
                                         cwd="/")  # the current folder may be removed while it runs
        self._owner = os.getpid()
        return self._process

    def close(self) -> int:
        """End the process; its exit code, negative for the signal that ended it."""
        process, self._process = self._process, None
        if process is None or self._owner != os.getpid():
            return 0
        assert process.stdin is not None
        assert process.stdout is not None
        with suppress(OSError):
            process.stdin.close()
        process.stdout.close()
        try:
            return process.wait(_ENDING_S)
        except subprocess.TimeoutExpired:
            process.kill()
            return process.wait()


def _cause(ended: int, seconds: int, impatient: bool) -> str:
    """Reason why the reader process gave no answer, by the signal that ended it, or that it was hanging."""
    if impatient or ran_out_of_time(ended):
        return f"is not read within {seconds} s"
    return f"crashes its reader ({signal.Signals(ended).name if ended > 0 else f'exit code {-ended}'})"


_READER = _Reader()
atexit.register(_READER.close)


def _exactly(stream: IO[bytes], count: int) -> bytes:
    """So many bytes of a stream; EOFError where it ends before."""
    found = stream.read(count)
    if len(found) < count:
        raise EOFError
    return found


def _forms_of(content: Any) -> Iterator[tuple[str, list[int]]]:
    """Type and shape of each array of an answer, in order."""
    if isinstance(content, dict) and "array" in content:
        yield tuple(content["array"])
    elif isinstance(content, dict):
        for _, each in content.get("table", []):
            yield from _forms_of(each)
        for each in content.get("list", []):
            yield from _forms_of(each)


def _restored(content: Any, arrays: Iterator[Any]) -> Any:
    """Content with its arrays; see `fesloop.streams.decoders.plain`."""
    if not isinstance(content, dict):
        return content
    if "array" in content:
        return next(arrays)
    if "table" in content:
        return {key: _restored(each, arrays) for key, each in content["table"]}
    return [_restored(each, arrays) for each in content["list"]]


def read_container(path: Path) -> Any:
    """Everything in a MATLAB, HDF5 or NumPy file, a mapping by key.

    Raises InputError where there is no such file, it is none of these, or it cannot be decoded.
    """
    head = head_of(path, FORMATS)
    if is_hdf5(head):
        content = read_file("hdf5", path)
        return content.get("content", {"format": content["format"]})
    for start, form in ((ZIP, "npz"), (MATLAB, "matlab")):
        if head.startswith(start):
            return read_file(form, path)
    raise InputError(str(path), "is empty" if not head else "is neither a .mat nor an .npz file", FORMATS)


def is_hdf5(head: bytes) -> bool:
    """Return whether a file with this head is HDF5; MATLAB puts 512 bytes of its own before."""
    return head.startswith(HDF5) or (head.startswith(MATLAB_73) and head[512:].startswith(HDF5))


def is_container(head: bytes) -> bool:
    """Return whether a file with this head is one of the containers."""
    return is_hdf5(head) or head.startswith((ZIP, MATLAB, MATLAB_73))


def head_of(path: Path, allowed: str) -> bytes:
    """First bytes of a file; InputError, with what is `allowed`, where it cannot be read."""
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


def form_of(path: Path) -> str:
    """Attribute `format` of an HDF5 file, which fesloop writes into its own; empty where there is none."""
    form: str = read_file("hdf5", path)["format"]
    return form
