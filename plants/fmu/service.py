"""Answers to the requests of one FMU, in whatever process it runs."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np

from fesloop.errors import RunError
from plants.fmu.library import NotInstantiatedError
from plants.fmu.running import FmuSetup, RunningFmu
from plants.fmu.trial import try_finer_steps, try_out

START, STEP, CHANGE, SAVE, RESTORE, END, TRY, TRY_FINER = b"i", b"s", b"c", b"g", b"r", b"e", b"t", b"f"
"""Requests. START takes (setup, folder, name), pickled; CHANGE the inputs; RESTORE the answer of SAVE. START
and RESTORE return inputs and outputs, STEP and CHANGE outputs, each followed by the FMU's messages as JSON,
if any; TRY and TRY_FINER return JSON."""


class Service:
    """Answers to the requests of one FMU, from START to END.

    `room_mb`: memory that the process may still allocate; infinite without a limit.
    """

    def __init__(self, room_mb: Callable[[], float]) -> None:
        self._room_mb, self._running = room_mb, cast(Any, None)
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
            self._start = setup, folder, name = pickle.loads(content)
            self._running = _instantiated(setup, folder, name, self._room_mb())
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


def _instantiated(setup: FmuSetup, folder: Path, name: str, room: float) -> RunningFmu:
    """Instantiate the FMU; the message of a failure includes the memory that it had, MB."""
    try:
        return RunningFmu(setup, folder, name)
    except NotInstantiatedError as fault:
        raise RunError(f"{fault}; memory may be too small: memory_mb left it {room:.1f} MB") from None


class FmuDiedError(RunError):
    """An FMU's process ended, or was killed because it did not answer."""
