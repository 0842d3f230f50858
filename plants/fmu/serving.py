"""Requests that an FMU's own process answers."""

from __future__ import annotations

import json
import pickle
import sys
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.errors import RunError
from plants.fmu.library import NotInstantiatedError
from plants.fmu.process import room_mb, serve
from plants.fmu.running import FmuSetup, RunningFmu
from plants.fmu.trial import tried, tried_finer

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
