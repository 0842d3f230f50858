"""A process of an FMU's own, on Linux.

The process is not one of multiprocessing, whose processes run the user's script again and outlive a killed
parent.
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
from multiprocessing.connection import Connection
from pathlib import Path

from fesloop.errors import RunError
from plants.fmu.service import FmuDiedError, Service

DONE, FAILED = b".", b"!"
_BEGIN = ("import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
          "from plants.fmu.own_process import main; main()")
_PIPE, _FULL = 2**16, 2**15
_PATIENCE_S = 5.0
"""Longest wait for a process that has only to end (chosen)."""


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


def main() -> None:
    """Run the process; its arguments are the path, the socket and the memory limit."""
    serve(Service(room_mb).answer, int(sys.argv[2]), int(sys.argv[3]))
