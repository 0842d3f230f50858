"""Separate process for an FMU's code, so that a crash, a hang or a flood of output there does no harm here.

The process is not one of multiprocessing, whose processes run the user's script again and outlive a killed
parent.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import pickle
import resource
import select
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, RunError
from plants.fmu.library import NotInstantiatedError
from plants.fmu.running import FmuSetup, RunningFmu
from plants.fmu.trial import InternalStep, Probed, continuous, try_finer_steps, try_out

DONE, FAILED = b".", b"!"
_BEGIN = ("import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
          "from plants.fmu.process import main; main()")
_PIPE, _FULL = 2**16, 2**15
_PATIENCE_S = 5.0
"""Longest wait for a process that has only to end (chosen)."""


@dataclass(frozen=True, slots=True)
class Isolation:
    """Limits of an FMU's own process.

    Attributes
    ----------
    memory_mb: limit of allocated data, beyond that of Python and fesloop's code.
    start_timeout_s, step_timeout_s: wall time limits of initialisation, and of any other call.
    """

    memory_mb: int
    start_timeout_s: float
    step_timeout_s: float


class FmuDiedError(RunError):
    """An FMU's process ended, or was killed because it did not answer."""


class FmuProcess:
    """A process that answers calls, one at a time.

    Requests and answers are bytes; no answer is unpickled. The FMU's output is discarded, except the last
    line on standard error before a crash. The process ends with `end`, or when its parent ends.
    """

    def __init__(self, memory_mb: int) -> None:
        self._memory_mb = memory_mb
        self._socket, theirs = socket.socketpair()
        self._connection = Connection(os.dup(self._socket.fileno()))
        self._words, words = os.pipe()
        for end in (self._words, words):
            os.set_blocking(end, False)  # a process that prints without end does not wait for a reader
        with theirs:
            # In its own session it gets no Ctrl-C from the terminal, and processes of the FMU end with it.
            self._process = subprocess.Popen(
                [sys.executable, "-c", _BEGIN, json.dumps(sys.path), str(theirs.fileno()), str(memory_mb)],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=words, start_new_session=True,
                pass_fds=[theirs.fileno()], env={"OPENBLAS_NUM_THREADS": "1", **os.environ})
        os.close(words)

    @property
    def alive(self) -> bool:
        """Whether it can be called."""
        return not self._connection.closed

    def limit(self, timeout_s: float, left: float = 1.0) -> None:
        """Set the longest wait for an answer, of which the fraction `left` remains."""
        seconds = max(0.0, left) * timeout_s
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO,
                                struct.pack("@ll", int(seconds), max(1, int(1e6 * (seconds % 1.0)))))
        self._timeout_s = timeout_s

    def call(self, request: bytes) -> bytes:
        """Send a request and return its answer.

        Raises RunError with the error of the process, and FmuDiedError with the way it ended.
        """
        try:
            self._connection.send_bytes(request)
            answer = self._connection.recv_bytes()
        except BlockingIOError:
            self._close(kill=True)
            raise FmuDiedError(f"did not finish within {self._timeout_s:g} s") from None
        except (EOFError, OSError):
            raise FmuDiedError(self._close(kill=False)) from None
        except BaseException:
            self._close(kill=True)
            raise
        if answer[:1] != DONE:
            raise RunError(answer[1:].decode("utf-8", "replace"))
        return answer[1:]

    def end(self) -> None:
        """End the process."""
        if self.alive:
            self._close(kill=False)

    def _close(self, kill: bool) -> str:
        """Close the connection and wait for the process to end; a description of its end."""
        self._connection.close()
        self._socket.close()
        alarm = threading.Timer(_PATIENCE_S, self._kill)
        if kill:
            self._kill()
        else:
            alarm.start()
        _, status, usage = os.wait4(self._process.pid, 0)
        alarm.cancel()
        code = self._process.returncode = os.waitstatus_to_exitcode(status)
        words = b""
        with contextlib.suppress(BlockingIOError):
            words = os.read(self._words, _PIPE)
        os.close(self._words)
        if len(words) > _FULL:
            words = b""  # the pipe was perhaps full before the end: these may not be the last words
        return _ending(code, words.decode("utf-8", "replace"), usage.ru_maxrss / 1e3, self._memory_mb)

    def _kill(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)


def _ending(code: int, printed: str, taken_mb: float, memory_mb: int) -> str:
    """Describe how a process ended."""
    if code >= 0:
        text = f"ended by itself with exit code {code}"
    else:
        known = {number.value: number.name for number in signal.Signals}
        text = f"was killed by {known.get(-code, f'signal {-code}')}"
    last_words = printed.strip().splitlines()[-1:]
    text += f", {last_words[0][:200]}" if last_words else ""
    near = taken_mb > 0.5 * memory_mb
    return text + (f" (it used {taken_mb:.0f} MB, including Python and all code; memory_mb = {memory_mb} "
                   "limits the FMU's own allocation)" if near else "")


def serve(answer: Callable[[bytes], bytes], fd: int, memory_mb: int) -> None:
    """Answer the requests of an `FmuProcess` until its connection closes, then exit."""
    connection = Connection(fd)
    threading.Thread(target=_end_with_parent, args=(fd,), daemon=True).start()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    most, hardest = _data_bytes() + memory_mb * 10**6, resource.getrlimit(resource.RLIMIT_DATA)[1]
    most = most if hardest == resource.RLIM_INFINITY else min(most, hardest)
    resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    with contextlib.suppress(EOFError, OSError):
        while True:
            request = connection.recv_bytes()
            try:
                reply = DONE + answer(request)
            except Exception as fault:  # noqa: BLE001 - raised again in the parent
                reply = FAILED + (str(fault) if isinstance(fault, RunError) else repr(fault)).encode()
            connection.send_bytes(reply)
    os._exit(0)  # without exit handlers of the FMU's library


def room_mb() -> float:
    """Memory that this process may still allocate; infinite without a limit."""
    most = resource.getrlimit(resource.RLIMIT_DATA)[0]
    return math.inf if most == resource.RLIM_INFINITY else max(0.0, (most - _data_bytes()) / 1e6)


def _data_bytes() -> int:
    """Memory that this process has allocated."""
    return int(Path("/proc/self/statm").read_text().split()[5]) * resource.getpagesize()


def _end_with_parent(fd: int) -> None:
    """Kill this process and its children when the other end of its socket closes."""
    poll = select.poll()
    poll.register(fd, select.POLLRDHUP)
    poll.poll()
    os.killpg(0, signal.SIGKILL)


START, STEP, CHANGE, SAVE, RESTORE, END, TRY, TRY_FINER = b"i", b"s", b"c", b"g", b"r", b"e", b"t", b"f"
"""Requests. START takes (setup, folder, name), pickled; CHANGE the inputs; RESTORE the answer of SAVE. START
and RESTORE return inputs and outputs, STEP and CHANGE outputs, each followed by the FMU's messages as JSON,
if any; TRY and TRY_FINER return JSON."""


class Service:
    """Answers to the requests of one FMU, from START to END."""

    def __init__(self) -> None:
        self._running: Any = None
        self._start: tuple[FmuSetup, Path, str] | None = None

    def answer(self, request: bytes) -> bytes:
        """Answer a request; RunError if the FMU refuses."""
        kind, content = request[:1], request[1:]
        running: RunningFmu = self._running
        if kind == STEP:
            running.step(False)
            return running.outputs.values.tobytes() + self._messages()
        if kind == CHANGE:
            running.inputs.values[:] = np.frombuffer(content)
            running.step(True)
            return running.outputs.values.tobytes() + self._messages()
        if kind == START:
            self._start = pickle.loads(content)
            self._running = _instantiated(*self._start)
            return self._values()
        if kind == SAVE:
            return pickle.dumps(running.save())
        if kind == RESTORE:
            running.restore(pickle.loads(content))
            return self._values()
        if kind == END:
            running.end()
            return b""
        assert self._start is not None
        setup, folder, _ = self._start
        found = try_out(setup, folder, running) if kind == TRY else try_finer_steps(setup, folder)
        return json.dumps(found).encode()

    def _values(self) -> bytes:
        running: RunningFmu = self._running
        return running.inputs.values.tobytes() + running.outputs.values.tobytes() + self._messages()

    def _messages(self) -> bytes:
        messages = self._running.take_messages()
        return json.dumps(messages).encode() if messages else b""


def _instantiated(setup: FmuSetup, folder: Path, name: str) -> RunningFmu:
    """Instantiate the FMU; the message of a failure includes the memory that it had."""
    room = room_mb()
    try:
        return RunningFmu(setup, folder, name)
    except NotInstantiatedError as fault:
        raise RunError(f"{fault}; memory may be too small: memory_mb left it {room:.1f} MB") from None


def main() -> None:
    """Run the process; its arguments are the path, the socket and the memory limit."""
    serve(Service().answer, int(sys.argv[2]), int(sys.argv[3]))


class Values:
    """A flat vector; (elements,)."""

    __slots__ = ("values",)

    def __init__(self, values: NDArray[np.float64]) -> None:
        self.values = values


class IsolatedFmu:
    """A `RunningFmu` in another process, where a crash is a RunError here.

    Parameters
    ----------
    setup, folder, name: as for RunningFmu.
    fmu: file name of the FMU, for messages.
    isolation: limits of the process.
    """

    __slots__ = ("_fmu", "_messages", "_process", "inputs", "name", "outputs", "setup", "tick")

    def __init__(self, setup: FmuSetup, folder: Path, name: str, fmu: str, isolation: Isolation) -> None:
        self.setup, self.name, self.tick, self._fmu = setup, name, 0, fmu
        self._messages: list[str] = []
        self._process = FmuProcess(isolation.memory_mb)
        self._process.limit(isolation.start_timeout_s)
        sizes = (sum(v.size for bound in ports for v in bound.variables)
                 for ports in (setup.inputs, setup.outputs))
        self.inputs, self.outputs = (Values(np.zeros(size)) for size in sizes)
        try:
            self._take(self._call(START + pickle.dumps((setup, folder, name)), "initialisation"))
        except BaseException:
            self._process.end()
            raise
        self._process.limit(isolation.step_timeout_s)

    def step(self, inputs_changed: bool) -> None:
        """Do one communication step under `inputs.values`; results are in `outputs.values`."""
        try:
            answer = self._process.call(CHANGE + self.inputs.values.tobytes() if inputs_changed else STEP)
        except FmuDiedError as fault:
            self._died(f"the step from {self.setup.instant_s(self.tick):.9g} s", fault)
        self.outputs.values[:] = self._numbers(answer, self.outputs.values.size)
        self.tick += 1

    def take_messages(self) -> list[str]:
        """Messages since the last call, as from `FmuLibrary.take_messages`."""
        messages, self._messages = self._messages, []
        return messages

    def save(self) -> tuple[bytes, int]:
        """Whole state, readable by `restore` alone; RunError if the FMU refuses."""
        return self._call(SAVE, "saving its state"), self.tick

    def restore(self, saved: tuple[bytes, int]) -> None:
        """Resume from the result of `save` of this or another instance; RunError if the FMU refuses."""
        content, self.tick = saved
        self._take(self._call(RESTORE + content, "restoring its state"))

    def end(self) -> None:
        """Terminate and free; RunError if the FMU crashes."""
        if self._process.alive:
            self._call(END, "its end, after all its steps")
            self._process.end()

    def _call(self, request: bytes, doing: str) -> bytes:
        try:
            return self._process.call(request)
        except FmuDiedError as fault:
            self._died(doing, fault)

    def _died(self, doing: str, fault: FmuDiedError) -> NoReturn:
        raise RunError(f"{self.name}: in {doing} {self._fmu} {fault}") from None

    def _take(self, content: bytes) -> None:
        """Take over the FMU's inputs and outputs."""
        values = self._numbers(content, self.inputs.values.size + self.outputs.values.size)
        self.inputs.values[:] = values[: self.inputs.values.size]
        self.outputs.values[:] = values[self.inputs.values.size :]

    def _numbers(self, content: bytes, count: int) -> NDArray[np.float64]:
        """Numbers at the start of an answer; the messages after them are kept."""
        if len(content) > 8 * count:
            self._messages += json.loads(content[8 * count :])
        return np.frombuffer(content, count=count)


def probe(setup: FmuSetup, folder: Path, path: Path, isolation: Isolation) -> Probed:
    """Try the FMU out in a process of its own.

    Raises InputError if it crashes, refuses, or takes too long before its first step ends.
    """
    process, began, timeout_s = FmuProcess(isolation.memory_mb), time.monotonic(), isolation.start_timeout_s

    def call(request: bytes) -> bytes:
        process.limit(timeout_s, 1.0 - (time.monotonic() - began) / timeout_s)
        return process.call(request)

    stage = "initialisation"
    try:
        call(START + pickle.dumps((setup, folder, "probe")))
        stage = "its first step"
        call(STEP)
        return _tried(call, setup)
    except FmuDiedError as fault:
        raise InputError("path", f"{path}: in {stage} it {fault}", "an FMU that runs",
                         "ask the FMU's maker to correct it, or raise probe_timeout_s") from None
    except RunError as fault:
        raise InputError("path", f"{path}: {str(fault).removeprefix('probe: ')}",
                         "an FMU that can be initialised", "check its start values and memory_mb") from None
    finally:
        process.end()


def _tried(call: Callable[[bytes], bytes], setup: FmuSetup) -> Probed:
    """Try out an FMU that has done its first step."""
    try:
        probed = Probed(**_answer(call(TRY)))
    except RunError as fault:
        unchecked = () if setup.description.internal_step_s else continuous(setup)
        why = f"in the trial at load, with artificial inputs, it {fault}"
        return Probed(InternalStep(0.0, (), unchecked, why), why_not=why)
    if probed.internal.length_s == 0.0:
        try:
            finer = _answer(call(TRY_FINER)).get("internal", InternalStep())
        except RunError:
            return probed
        return replace(probed, internal=finer) if finer.length_s else probed
    return probed


def _answer(content: bytes) -> dict[str, Any]:
    """Decode fields of `Probed`."""
    found: dict[str, Any] = json.loads(content)
    if "internal" in found:
        length_s, outputs, unchecked, why = found["internal"]
        found["internal"] = InternalStep(length_s, tuple(outputs), tuple(unchecked), why)
    return found
