"""An FMU's code in a separate process, so that a crash, a hang or a flood of output there does no harm here.

Such processes need Linux (`plants.fmu.own_process`). Elsewhere an FMU is tried out and run in this process.
"""

from __future__ import annotations

import json
import math
import pickle
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NoReturn, Protocol

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, RunError
from fesloop.posix import is_linux
from plants.fmu.running import FmuSetup
from plants.fmu.service import (
    CHANGE,
    END,
    RESTORE,
    SAVE,
    START,
    STEP,
    TRY,
    TRY_FINER,
    FmuDiedError,
    Service,
)
from plants.fmu.trial import InternalStep, Probed, continuous


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


class Called(Protocol):
    """Protocol of objects that answer the requests of an FMU."""

    @property
    def alive(self) -> bool:
        """Whether it can be called."""

    def limit(self, timeout_s: float, left: float = 1.0) -> None:
        """Set the longest wait for an answer, of which the fraction `left` remains."""

    def call(self, request: bytes) -> bytes:
        """Answer of a request. Raises RunError, and FmuDiedError where nothing answers any more."""

    def end(self) -> None:
        """End."""


class InThisProcess:
    """Answers in this process, where nothing limits the FMU's time and memory and a crash of it ends all."""

    def __init__(self) -> None:
        self._service = Service(lambda: math.inf)
        self.alive = True

    def limit(self, timeout_s: float, left: float = 1.0) -> None:
        """Nothing."""

    def call(self, request: bytes) -> bytes:
        """Answer of a request."""
        return self._service.answer(request)

    def end(self) -> None:
        """Nothing is called any more."""
        self.alive = False


def started(isolation: Isolation) -> Called:
    """A process of the FMU's own on Linux, else this one."""
    if not is_linux():
        return InThisProcess()
    from plants.fmu.own_process import FmuProcess

    return FmuProcess(isolation.memory_mb)


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
        self._process = started(isolation)
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
    process, began, timeout_s = started(isolation), time.monotonic(), isolation.start_timeout_s

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
