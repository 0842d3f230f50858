"""A process of its own for an FMU's code, which may crash, hang, print and allocate there as it likes.

Not multiprocessing's: those run the user's script a second time, and outlive a parent that was killed.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import resource
import select
import signal
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from fesloop.errors import RunError

DONE, FAILED = b".", b"!"
_BEGIN = ("import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
          "from plants.fmu.serving import main; main()")
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
