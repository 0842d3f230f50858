"""A worker process that calls functions.

multiprocessing is not used: its processes run the user's script again, which breaks scripts without
`if __name__ == "__main__"`, receive Ctrl-C themselves, and outlive a parent that was killed.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import subprocess
import sys
import traceback
from collections.abc import Callable
from types import FrameType
from typing import Any

from fesloop.errors import InputError, RunError

_BEGIN = """
import pickle, sys
try:
    sys.path[:] = pickle.load(sys.stdin.buffer)
except EOFError:
    sys.exit()
from fesloop.apps.reproduce.worker import serve
serve()
"""
_PATIENCE_S = 5.0
"""Time for a process to remove its temporary files before it is killed (chosen)."""


class Worker:
    """A worker process, which ends with `end`, or after its current call if the parent has ended.

    Its output goes to standard error. Calls and results are pickled through its standard streams.
    """

    __slots__ = ("_asked", "_process")

    def __init__(self) -> None:
        self._asked = False
        # In a session of its own it does not receive a terminal's Ctrl-C.
        # There are as many workers as cores: threads within them would only compete.
        self._process = subprocess.Popen([sys.executable, "-c", _BEGIN], stdin=subprocess.PIPE,
                                         stdout=subprocess.PIPE, start_new_session=True,
                                         env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})
        self._send(sys.path)

    def call(self, function: Callable[[Any], Any], argument: Any) -> Any:
        """Return function(argument), computed in the process; raises its exception here.

        Raises InputError for a function that the process cannot import, RunError if the process has ended.
        """
        try:
            self._send((function, argument))
            assert self._process.stdout is not None
            result, fault = pickle.load(self._process.stdout)
        except (EOFError, BrokenPipeError):
            code = self._process.wait()
            raise RunError(f"a worker process has ended by itself (code {code}); "
                           "fewer processes need less memory") from None
        if fault is not None:
            raise fault
        return result

    def ask_to_end(self) -> None:
        """Interrupt the current call; once only, so as not to interrupt the removal of its files."""
        if not self._asked:
            self._asked = True
            self._process.terminate()

    def end(self) -> None:
        """Interrupt the current call, and wait until the process has ended."""
        self.ask_to_end()
        try:
            self._process.wait(_PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            with contextlib.suppress(OSError):
                assert stream is not None
                stream.close()

    def _send(self, thing: Any) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(pickle.dumps(thing))
        self._process.stdin.flush()


def serve() -> None:
    """Serve calls from standard input until it is closed: the child's side of `Worker`."""
    replies = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    with contextlib.suppress(EOFError, BrokenPipeError, KeyboardInterrupt):
        signal.signal(signal.SIGTERM, _leave)
        while True:
            replies.write(_reply())
            replies.flush()


def _reply() -> bytes:
    """Call a pickled function, and return (result, fault) pickled."""
    try:
        function, argument = pickle.load(sys.stdin.buffer)
    except AttributeError as fault:
        return pickle.dumps((None, InputError(
            "worker", str(fault), "functions of modules", "move it out of the script into a module")))
    try:
        return pickle.dumps((function(argument), None))
    except Exception as fault:  # noqa: BLE001 - raised in the other process
        fault.add_note(f"in a worker process:\n{traceback.format_exc()}")
        try:
            return pickle.dumps((None, fault))
        except Exception:  # noqa: BLE001 - what cannot be pickled says so in many ways
            return pickle.dumps((None, RunError(f"{type(fault).__name__}: {fault}")))


def _leave(number: int, frame: FrameType | None) -> None:
    """Handle SIGTERM as Ctrl-C, so that temporary files are removed."""
    raise KeyboardInterrupt
