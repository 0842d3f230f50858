"""Reading files that may be spoilt, each in a process of its own whose time, memory and writes are bounded.

A server loads everything that reading takes, once, and forks a child a file: so a file costs milliseconds,
and one that crashes takes nothing with it. Numbers are read with one thread, so that forking is safe.
"""

from __future__ import annotations

import gc
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.errors import InputError
from fesloop.experiment import registry

LONGEST_S = 5.0
MOST_BYTES = 10**9
_FMU_TRIAL_S = 3.0
"""How long a spoilt FMU may take to be tried out: its code may do what it likes, and is stopped."""
_WRITING = {"open", "os.mkdir", "os.rename", "os.link", "os.symlink", "os.truncate", "os.remove", "os.rmdir",
            "os.chmod", "shutil.move"}
_HARMLESS = ("/dev/", "/proc/")
_LOADED = ("scipy.io", "fesloop.experiment.recording.reading", "fesloop.streams.files",
           "fesloop.streams.containers.matlab", "fesloop.streams.formats.described",
           "fesloop.forms.faults", "fesloop.experiment.files.layout")


class Reading:
    """The server of one bench. `read` gives what became of a file; leave it as a context manager."""

    def __init__(self) -> None:
        command = [sys.executable, "-c", "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
                   "from fesloop.apps.bench._fuzz_reading import serve; serve()", json.dumps(sys.path)]
        threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        self._server = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
            env={**os.environ, **threads, "PYTHONDONTWRITEBYTECODE": "1"})

    def __enter__(self) -> Reading:
        return self

    def __exit__(self, *_: object) -> None:
        self._server.communicate()

    def read(self, reader: str, folder: Path, name: str) -> dict[str, Any]:
        """What became of `folder/source/name`: outcome ("read", "refused", or what is wrong), detail, seconds
        and bytes of memory beyond the server's."""
        assert self._server.stdin is not None
        assert self._server.stdout is not None
        self._server.stdin.write(json.dumps([reader, str(folder), name]) + "\n")
        self._server.stdin.flush()
        told: dict[str, Any] = json.loads(self._server.stdout.readline())
        return told


def serve() -> None:
    """Answer a line on standard input with a line on standard output, until there is none."""
    _load()
    gc.freeze()
    for line in sys.stdin:
        reader, folder, name = json.loads(line)
        print(json.dumps(_in_a_child(reader, Path(folder), name)), flush=True)


def _load() -> None:
    """Everything that reading imports."""
    for name in _LOADED:
        import_module(name)
    if "fmu" in registry.kinds():
        registry.find("fmu")
        import_module("fmpy.model_description")


def _in_a_child(reader: str, folder: Path, name: str) -> dict[str, Any]:
    began = time.monotonic()
    tell, told = os.pipe()
    base = _memory("RssAnon")
    child = os.fork()
    if child == 0:
        os.close(tell)
        _child(reader, folder, name, told)
    os.close(told)
    status, usage, late = _ended(child, began + LONGEST_S)
    seconds = time.monotonic() - began
    with os.fdopen(tell, "rb") as pipe:
        answer = pipe.read()
    found = json.loads(answer) if answer else {"outcome": "no answer", "detail": ""}
    if late:
        found = {"outcome": "hang", "detail": f"over {LONGEST_S:g} s"}
    elif os.WIFSIGNALED(status):
        found = {"outcome": "crash", "detail": signal.Signals(os.WTERMSIG(status)).name}
    taken = max(0, 1024 * usage.ru_maxrss - base)
    if taken > MOST_BYTES:
        found = {"outcome": "memory", "detail": f"{taken / 1e6:.0f} MB"}
    return {**found, "seconds": seconds, "bytes": taken}


def _ended(child: int, deadline: float) -> tuple[int, Any, bool]:
    """Status and usage of a child, and whether it had to be killed with all that it started."""
    while time.monotonic() < deadline:
        ended, status, usage = os.wait4(child, os.WNOHANG)
        if ended:
            return status, usage, False
        time.sleep(0.001)
    os.killpg(child, signal.SIGKILL)
    _, status, usage = os.wait4(child, 0)
    return status, usage, True


def _memory(key: str) -> int:
    """Bytes of memory of this process, as /proc says."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(f"{key}:"):
            return 1024 * int(line.split()[1])
    return 0


def _child(reader: str, folder: Path, name: str, told: int) -> None:
    """Read one file, say what came of it, and end."""
    answer: dict[str, Any] = {"outcome": "no answer", "detail": ""}
    try:
        os.setpgid(0, 0)
        os.chdir(folder / "cwd")
        tempfile.tempdir = os.environ["TMPDIR"] = str(folder / "tmp")
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        limit = _memory("VmSize") + MOST_BYTES
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
        with _watched((folder / "target", folder / "tmp")) as writes:
            answer = _outcome(reader, folder, name)
        if writes:
            answer = {"outcome": "write", "detail": writes[0]}
    finally:
        os.write(told, json.dumps(answer).encode()[:4000])
        os._exit(0)


@contextmanager
def _watched(allowed: tuple[Path, ...]) -> Iterator[list[str]]:
    """What is written outside the allowed folders while this holds."""
    writes: list[str] = []
    watching = [True]

    def note(event: str, args: tuple[Any, ...]) -> None:
        if not watching[0] or event not in _WRITING or not isinstance(args[0], (str, bytes, os.PathLike)):
            return
        reads = event == "open" and not args[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
        in_open_folder = event != "open" and args[-1] != -1 and not os.fsdecode(args[0]).startswith("/")
        if reads or in_open_folder:  # rmtree goes from folder to folder by descriptors
            return
        path = os.path.realpath(os.fsdecode(args[0]))
        inside = any(path == str(each) or path.startswith(f"{each}/") for each in allowed)
        if not inside and not path.startswith(_HARMLESS):
            writes.append(f"{event} {path}")

    sys.addaudithook(note)
    yield writes
    watching[0] = False


def _outcome(reader: str, folder: Path, name: str) -> dict[str, Any]:
    """What reading a file comes to, as anybody would read it."""
    try:
        _READERS[reader](folder, name)
    except InputError as fault:
        lines = str(fault).split("\n")
        faults = getattr(fault, "faults", [fault])
        if len(lines) != len(faults) or not all(line.strip() for line in lines):
            return {"outcome": "unclear", "detail": str(fault)[:300]}
        return {"outcome": "refused", "detail": lines[0][:300]}
    except BaseException as fault:  # noqa: BLE001 - whatever else comes out is what this bench is after
        import traceback

        where = traceback.extract_tb(fault.__traceback__)[-1]
        text = " ".join(str(fault).split())[:200]
        return {"outcome": type(fault).__name__, "detail": f"{text} at {where.filename}:{where.lineno}"}
    return {"outcome": "read", "detail": ""}


def _recording(folder: Path, name: str, layout: str | None = None) -> None:
    """Import a recording of motion, and look at what was read."""
    from fesloop.streams.files import import_recording

    described = None if layout is None else folder / "source" / layout
    recording = import_recording(folder / "source" / name, folder / "target" / "motion.h5", described)
    if (np.diff(recording.stamps_ns) <= 0).any() or recording.stamps_ns[0] < 0:
        raise AssertionError("stamps do not increase from 0 on")
    for samples in (recording.gyr, recording.acc, recording.mag):
        if samples is not None and np.isinf(samples).any():
            raise AssertionError("samples are infinite")


def _layout(folder: Path, name: str) -> None:
    _recording(folder, name, "layout.toml")


def _run(folder: Path, name: str) -> None:
    """Read everything that a run's recording holds."""
    from fesloop.experiment.recording.reading import Recording

    with Recording(folder / "source" / name) as recording:
        _ = (recording.status, recording.wall, recording.events, recording.messages, recording.digest(),
             recording.step_times_ns)
        for trial in range(min(recording.trials, 3)):
            for signal_name in recording.signals:
                recording.signal(signal_name, trial)


def _fmu(folder: Path, name: str) -> None:
    """Make a plant of an FMU, which extracts it, reads its description and tries it out."""
    plant: Any = registry.find("fmu")
    made = plant(path=str(folder / "source" / name), probe_timeout_s=_FMU_TRIAL_S)
    del made
    gc.collect()


_READERS = {"recording": _recording, "layout": _layout, "run": _run, "fmu": _fmu}
