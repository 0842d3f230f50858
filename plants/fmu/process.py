"""A process of its own for an FMU's code, which may crash, hang, print and allocate there as it likes.

Not multiprocessing's: those run the user's script a second time, and outlive a parent that was killed.
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

from fesloop.errors import RunError
from plants.fmu.internal_step import InternalStep, excite, find_by_finer_steps, find_internal_step
from plants.fmu.library import NotInstantiatedError
from plants.fmu.running import FmuSetup, RunningFmu

DONE, FAILED = b".", b"!"
_BEGIN = ("import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
          "from plants.fmu.process import main; main()")
_PIPE, _FULL = 2**16, 2**15
_PATIENCE_S = 5.0
"""For a process that has nothing left to do but end (chosen)."""


@dataclass(frozen=True, slots=True)
class Isolation:
    """Limits of an FMU's own process.

    Attributes
    ----------
    memory_mb: data that it may allocate beyond the code that steps it.
    start_timeout_s, step_timeout_s: wall time for initialisation, and for any other call.
    """

    memory_mb: int
    start_timeout_s: float
    step_timeout_s: float


class FmuDiedError(RunError):
    """An FMU's process ended, or was stopped because it did not answer."""


class FmuProcess:
    """A process that answers calls, one at a time.

    Requests and answers are bytes, and no answer is unpickled. What the FMU prints goes nowhere, but for the
    last line on standard error before a crash. The process ends with `end`, or when this one is no more.
    """

    def __init__(self, memory_mb: int) -> None:
        self._memory_mb = memory_mb
        self._socket, theirs = socket.socketpair()
        self._connection = Connection(os.dup(self._socket.fileno()))
        self._words, words = os.pipe()
        for end in (self._words, words):
            os.set_blocking(end, False)  # who prints without end does not wait for a reader
        with theirs:
            # In a session of its own a terminal's Ctrl-C is not heard, and what the FMU starts ends with it.
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
        """How long an answer may take from now on, or what is left of that."""
        seconds = max(0.0, left) * timeout_s
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO,
                                struct.pack("@ll", int(seconds), max(1, int(1e6 * (seconds % 1.0)))))
        self._timeout_s = timeout_s

    def call(self, request: bytes) -> bytes:
        """The answer to a request.

        Raises RunError with what went wrong there, and FmuDiedError with how the process ended.
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
        """Have it end."""
        if self.alive:
            self._close(kill=False)

    def _close(self, kill: bool) -> str:
        """Let go of the process; how it ended, in words."""
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
            words = b""  # the pipe may have been full for long: these are no last words
        return _ending(code, words.decode("utf-8", "replace"), usage.ru_maxrss / 1e3, self._memory_mb)

    def _kill(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)


def _ending(code: int, printed: str, taken_mb: float, memory_mb: int) -> str:
    """How a process ended, in words."""
    if code >= 0:
        text = f"ended by itself with exit code {code}"
    else:
        known = {number.value: number.name for number in signal.Signals}
        text = f"was killed by {known.get(-code, f'signal {-code}')}"
    last_words = printed.strip().splitlines()[-1:]
    text += f", {last_words[0][:200]}" if last_words else ""
    near = taken_mb > 0.5 * memory_mb
    return text + (f" (it had taken {taken_mb:.0f} MB, Python and all code included; memory_mb = {memory_mb} "
                   "limits what the FMU allocates beside these)" if near else "")


def serve(answer: Callable[[bytes], bytes], fd: int, memory_mb: int) -> None:
    """Answer requests until there are no more, and end: the other side of `FmuProcess`."""
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
            except Exception as fault:  # noqa: BLE001 - said in the other process
                reply = FAILED + (str(fault) if isinstance(fault, RunError) else repr(fault)).encode()
            connection.send_bytes(reply)
    os._exit(0)  # not through what the FMU's library does at exit


def room_mb() -> float:
    """How much this process may still allocate; infinite without a limit."""
    most = resource.getrlimit(resource.RLIMIT_DATA)[0]
    return math.inf if most == resource.RLIM_INFINITY else max(0.0, (most - _data_bytes()) / 1e6)


def _data_bytes() -> int:
    """What this process has allocated by now."""
    return int(Path("/proc/self/statm").read_text().split()[5]) * resource.getpagesize()


def _end_with_parent(fd: int) -> None:
    """End this process, whatever it is at, once nobody holds the other end of its socket."""
    poll = select.poll()
    poll.register(fd, select.POLLRDHUP)
    poll.poll()
    os.killpg(0, signal.SIGKILL)


COARSE_S, COARSE_WALL_S, ROUNDED = 1.0, 2.0, 1e-9
"""Chosen: how far substeps are compared with shorter ones, how long that may take, and the part of an output
that differs by rounding."""
REPLAY_STEPS = 20
"""Chosen: how far a saved state is followed, 0.1 s at least."""


def tried(setup: FmuSetup, folder: Path, running: RunningFmu) -> dict[str, object]:
    """Fields of `Probed`, of an FMU that has done its first step; it is ended."""
    stepped = setup.description.interface == "co_simulation"
    internal = find_internal_step(setup, running) if stepped else InternalStep()
    tells = bool(running.reached_s())  # one that leaves it at 0 says nothing
    running.end()
    if not setup.description.saves:
        why_not = "the FMU does not offer it"
    elif setup.description.once:
        why_not = "the FMU can be instantiated only once in a process"
    else:
        why_not = _why_no_replay(setup, folder)
    coarse = 0.0 if stepped or setup.description.once else _coarse(setup, folder)
    return {"internal": internal, "coarse": coarse, "tells": tells, "replays": not why_not,
            "why_not": why_not}


def tried_finer(setup: FmuSetup, folder: Path) -> dict[str, object]:
    """The internal step by finer communication steps, which are not without risk."""
    if setup.description.interface != "co_simulation" or setup.description.once:
        return {}
    return {"internal": find_by_finer_steps(setup, folder)}


def _coarse(setup: FmuSetup, folder: Path) -> float:
    """How far outputs differ with substeps half as long, as part of what they move; 0 where one refuses.

    The largest of all elements, 1 at most, which it is, too, where integration diverges to no number.
    """
    pair: list[RunningFmu] = []
    rows, began = [], time.perf_counter()
    try:
        pair = [RunningFmu(setup, folder, "probe")]
        pair.append(RunningFmu(replace(setup, substeps=2 * setup.substeps), folder, "probe_finer"))
        for step in range(max(REPLAY_STEPS, math.ceil(COARSE_S / setup.period_s))):
            for running in pair:
                if step == 1:
                    excite(setup, running)
                running.step(step == 1)
            rows.append([running.outputs.values.copy() for running in pair])
            if time.perf_counter() - began > COARSE_WALL_S:
                break
    except RunError:
        return 0.0
    finally:
        for running in pair:
            running.end()
    with np.errstate(all="ignore"):
        coarse, fine = np.array(rows).swapaxes(0, 1)
        apart = np.abs(coarse - fine).max(axis=0)
        moved = np.maximum(np.ptp(coarse, axis=0), np.ptp(fine, axis=0))
        worst = np.where(apart > ROUNDED * np.abs(fine).max(axis=0), apart / moved, 0.0)
    finite = np.isfinite(fine).all(axis=0)  # an output that is no number with any step is reported elsewhere
    worst = np.where(np.isfinite(coarse).all(axis=0), worst, 1.0)[finite | np.isfinite(coarse).all(axis=0)]
    return float(min(1.0, np.nan_to_num(worst, nan=1.0).max(initial=0.0)))


def _why_no_replay(setup: FmuSetup, folder: Path) -> str:
    """Why a saved state does not give the same future in a new instance; "" if it does."""
    first, second = RunningFmu(setup, folder, "probe"), RunningFmu(setup, folder, "probe_again")
    try:
        excite(setup, first)
        for step in range(REPLAY_STEPS):
            first.step(step == 0)
        saved = first.save()
        excite(setup, first)
        future = _future(first)
        second.restore(saved)
        excite(setup, second)
        if not np.array_equal(_future(second), future, equal_nan=True):
            return "a restored state did not give the same outputs when it was tried at load"
        if (future == future[0]).all():
            return "no output moved when it was tried at load, so nothing shows that it replays"
    except RunError as fault:
        return str(fault).removeprefix("probe: ").removeprefix("probe_again: ")
    finally:
        first.end()
        second.end()
    return ""


def _future(running: RunningFmu) -> NDArray[np.float64]:
    """Outputs of the steps to come, (steps, elements)."""
    rows = []
    for step in range(max(REPLAY_STEPS, math.ceil(0.1 / running.setup.period_s))):
        running.step(step == 0)
        rows.append(running.outputs.values.copy())
    return np.array(rows)


START, STEP, CHANGE, SAVE, RESTORE, END, TRY, TRY_FINER = b"i", b"s", b"c", b"g", b"r", b"e", b"t", b"f"
"""START takes (setup, folder, name), pickled, CHANGE the inputs, RESTORE what SAVE gave. START and RESTORE
give inputs and outputs, STEP and CHANGE outputs, all four then what the FMU has said, as JSON if it has said
anything; TRY and TRY_FINER give JSON."""


class Service:
    """One FMU, from START to END."""

    def __init__(self) -> None:
        self._running: Any = None
        self._start: tuple[FmuSetup, Path, str] | None = None

    def answer(self, request: bytes) -> bytes:
        """The answer to a request; raises RunError where the FMU refuses."""
        kind, content = request[:1], request[1:]
        running: RunningFmu = self._running
        if kind == STEP:
            running.step(False)
            return running.outputs.values.tobytes() + self._said()
        if kind == CHANGE:
            running.inputs.values[:] = np.frombuffer(content)
            running.step(True)
            return running.outputs.values.tobytes() + self._said()
        return self._seldom(kind, content)

    def _seldom(self, kind: bytes, content: bytes) -> bytes:
        running: RunningFmu = self._running
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
        found = tried(setup, folder, running) if kind == TRY else tried_finer(setup, folder)
        return json.dumps(found).encode()

    def _values(self) -> bytes:
        running: RunningFmu = self._running
        return running.inputs.values.tobytes() + running.outputs.values.tobytes() + self._said()

    def _said(self) -> bytes:
        said = self._running.take_messages()
        return json.dumps(said).encode() if said else b""


def _instantiated(setup: FmuSetup, folder: Path, name: str) -> RunningFmu:
    """The FMU; where it cannot be instantiated, the memory that it had is part of the message."""
    room = room_mb()
    try:
        return RunningFmu(setup, folder, name)
    except NotInstantiatedError as fault:
        raise RunError(f"{fault}; perhaps for want of memory: by memory_mb it had {room:.1f} MB") from None


def main() -> None:
    """The process: socket and memory in the second and third argument."""
    serve(Service().answer, int(sys.argv[2]), int(sys.argv[3]))


class Values:
    """A flat vector; (elements,)."""

    __slots__ = ("values",)

    def __init__(self, values: NDArray[np.float64]) -> None:
        self.values = values


class IsolatedFmu:
    """What `RunningFmu` is, with the FMU in another process: a crash there is a RunError here.

    Parameters
    ----------
    setup, folder, name: as of a RunningFmu.
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
        """One communication step under `inputs.values`, its results in `outputs.values`."""
        try:
            answer = self._process.call(CHANGE + self.inputs.values.tobytes() if inputs_changed else STEP)
        except FmuDiedError as fault:
            self._died(f"the step from {self.setup.instant_s(self.tick):.9g} s", fault)
        self.outputs.values[:] = self._numbers(answer, self.outputs.values.size)
        self.tick += 1

    def take_messages(self) -> list[str]:
        """What it has said since the last call, as `FmuLibrary.take_messages`."""
        said, self._messages = self._messages, []
        return said

    def save(self) -> tuple[bytes, int]:
        """All that it remembers, as only its own kind can read it; RunError where the FMU refuses."""
        return self._call(SAVE, "saving its state"), self.tick

    def restore(self, saved: tuple[bytes, int]) -> None:
        """Go on from what `save` gave, of this or another instance; RunError where the FMU refuses."""
        content, self.tick = saved
        self._take(self._call(RESTORE + content, "restoring its state"))

    def end(self) -> None:
        """Terminate and free; RunError where the FMU crashes there."""
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
        """Inputs and outputs as the FMU has them."""
        values = self._numbers(content, self.inputs.values.size + self.outputs.values.size)
        self.inputs.values[:] = values[: self.inputs.values.size]
        self.outputs.values[:] = values[self.inputs.values.size :]

    def _numbers(self, content: bytes, count: int) -> NDArray[np.float64]:
        """The numbers that an answer begins with; what the FMU has said follows them."""
        if len(content) > 8 * count:
            self._messages += json.loads(content[8 * count :])
        return np.frombuffer(content, count=count)
