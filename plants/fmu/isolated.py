"""A running FMU in a process of its own."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import RunError
from plants.fmu.process import FmuDiedError, FmuProcess, Isolation
from plants.fmu.running import FmuSetup
from plants.fmu.serving import CHANGE, END, RESTORE, SAVE, START, STEP


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
