"""Running FMUs of any version and interface: step, read, save, restore, end."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from fmpy.fmi1 import FMICallException

from fesloop.errors import RunError
from plants.fmu.description import FmuDescription
from plants.fmu.library import WARNING, FmuLibrary, FmuVector, StartValue
from plants.fmu.ports import BoundPort

_LAST_SUCCESSFUL_TIME, _TERMINATED = 2, 3
_DISCARD = 2


class CoSimulation2:
    """Steps of an FMI 2.0 co-simulation FMU, all of one length."""

    __slots__ = ("_component", "_do_step", "_length_s", "_library")

    def __init__(self, library: FmuLibrary, length_s: float) -> None:
        self._library, self._length_s = library, length_s
        self._component, self._do_step = library.component, library.functions.dll.fmi2DoStep

    def start(self) -> None:
        """Do nothing: initialisation suffices."""

    def step(self, start_s: float, stop_s: float, inputs_changed: bool) -> None:
        """One communication step; RunError for anything but success."""
        status = self._do_step(self._component, start_s, self._length_s, 1)
        if status == _DISCARD:
            self._require_no_end(stop_s)
        if status:
            self._library.check("fmi2DoStep", status, start_s)

    def _require_no_end(self, stop_s: float) -> None:
        """Raise RunError if the FMU discarded the step because it requests the end of the run."""
        ends = ctypes.c_int()
        status = self._library.functions.dll.fmi2GetBooleanStatus(
            self._component, _TERMINATED, ctypes.byref(ends))
        if status <= WARNING and ends.value:
            reached_s = self.reached_s()
            at_s = stop_s if reached_s is None else reached_s
            raise RunError(f"{self._library.name}: the FMU requested the end of the run at {at_s:.9g} s")

    def reached_s(self) -> float | None:
        """Last successful time that the FMU reports, or None."""
        value = ctypes.c_double()
        status = self._library.functions.dll.fmi2GetRealStatus(
            self._component, _LAST_SUCCESSFUL_TIME, ctypes.byref(value))
        return value.value if status <= WARNING else None

    def memory(self) -> Any:
        """None: all state is inside the FMU."""
        return None

    def recall(self, memory: Any) -> None:
        """Do nothing: all state is inside the FMU."""


class CoSimulation3:
    """Steps of an FMI 3.0 co-simulation FMU without event mode or early return, all of one length."""

    __slots__ = ("_arguments", "_component", "_do_step", "_early", "_event", "_length_s", "_library",
                 "_reached", "_terminate")

    def __init__(self, library: FmuLibrary, length_s: float) -> None:
        self._library, self._length_s = library, length_s
        self._component, self._do_step = library.component, library.functions.dll.fmi3DoStep
        self._event, self._terminate, self._early = ctypes.c_bool(), ctypes.c_bool(), ctypes.c_bool()
        self._reached = ctypes.c_double()
        self._arguments = tuple(
            ctypes.byref(out) for out in (self._event, self._terminate, self._early, self._reached))

    def start(self) -> None:
        """Do nothing: without event mode an initialised FMU is in step mode."""

    def step(self, start_s: float, stop_s: float, inputs_changed: bool) -> None:
        """One communication step; RunError for anything but success, early return included."""
        status = self._do_step(self._component, start_s, self._length_s, True, *self._arguments)
        if status:
            self._library.check("fmi3DoStep", status, start_s)
        if self._terminate.value:
            raise RunError(f"{self._library.name}: the FMU requested the end of the run at {stop_s:.9g} s")
        if self._early.value:
            raise RunError(f"{self._library.name}: the FMU returned early, at {self._reached.value:.9g} s, "
                           f"from the step to {stop_s:.9g} s, though it was not allowed to")

    def reached_s(self) -> float | None:
        """Last successful time that the FMU reports."""
        return self._reached.value

    def memory(self) -> Any:
        """None: all state is inside the FMU."""
        return None

    def recall(self, memory: Any) -> None:
        """Do nothing: all state is inside the FMU."""


NS_PER_S = 1_000_000_000
SHORT = 0.01
"""Chosen: fraction of a communication step by which the time that an FMU reports may be short by rounding."""


@dataclass(frozen=True, slots=True)
class FmuSetup:
    """Everything needed to run an extracted FMU.

    Attributes
    ----------
    description: description of the FMU.
    inputs, outputs: ports of the plant.
    starts: start values by variable name.
    period_num, period_den: communication step; their ratio is in ns.
    substeps: integration steps in a communication step (model exchange).
    own_step_s: communication step as the FMU counts it, if that differs in rounding, else 0.
    reports_time: whether the FMU reports its last successful time, so that a step that ends early is an
        error.
    """

    description: FmuDescription
    inputs: tuple[BoundPort, ...]
    outputs: tuple[BoundPort, ...]
    starts: tuple[tuple[str, StartValue], ...]
    period_num: int
    period_den: int
    substeps: int
    own_step_s: float = 0.0
    reports_time: bool = False

    @property
    def period_s(self) -> float:
        """Communication step, s."""
        return self.own_step_s or self.period_num / (self.period_den * NS_PER_S)

    def instant_s(self, tick: int) -> float:
        """Instant of communication point `tick`, s; computed without accumulation."""
        if self.own_step_s:
            return tick * self.own_step_s
        return tick * self.period_num / (self.period_den * NS_PER_S)


class Stepper(Protocol):
    """Steps of an FMU of one version and interface from one communication point to the next."""

    def start(self) -> None:
        """Complete initialisation."""

    def step(self, start_s: float, stop_s: float, inputs_changed: bool) -> None:
        """Do one communication step."""

    def reached_s(self) -> float | None:
        """Last successful time that the FMU reports, or None."""

    def memory(self) -> Any:
        """State outside the FMU; picklable."""

    def recall(self, memory: Any) -> None:
        """Resume from the result of `memory`."""


class RunningFmu:
    """An instance at a communication point.

    Attributes
    ----------
    library: the instance. name: name of the node. inputs, outputs: vectors of its variables.
    tick: number of communication steps done.
    """

    __slots__ = ("_pushes", "_stepper", "inputs", "library", "name", "outputs", "setup", "tick")

    def __init__(self, setup: FmuSetup, folder: Path, name: str) -> None:
        self.setup, self.name, self.tick = setup, name, 0
        description = setup.description
        self.library = FmuLibrary(description, folder, name)
        try:
            self.inputs = FmuVector(self.library, [v for bound in setup.inputs for v in bound.variables])
            self.outputs = FmuVector(self.library, [v for bound in setup.outputs for v in bound.variables])
            self._stepper = self._make_stepper()
            self._pushes = description.interface == "co_simulation"
            self.library.initialise(dict(setup.starts), description)
            self._stepper.start()
            self.inputs.pull(0.0)
            self.outputs.pull(0.0)
        except BaseException:
            self.library.end()
            raise

    def _make_stepper(self) -> Stepper:
        setup, description = self.setup, self.setup.description
        if description.interface == "model_exchange":
            from plants.fmu.model_exchange import ModelExchange2  # loads SciPy, which takes a second

            return ModelExchange2(self.library, self.inputs, description.states, description.indicators,
                                  setup.period_s, setup.substeps, description.completes_steps)
        made = CoSimulation2 if description.version == 2 else CoSimulation3
        return made(self.library, setup.period_s)

    def step(self, inputs_changed: bool) -> None:
        """Do one communication step under `inputs.values`; results are in `outputs.values`."""
        instant_s = self.setup.instant_s
        start_s, stop_s = instant_s(self.tick), instant_s(self.tick + 1)
        if inputs_changed and self._pushes:
            self.inputs.push(start_s)
        self._stepper.step(start_s, stop_s, inputs_changed)
        if self.setup.reports_time:
            self._require_reached(stop_s)
        self.outputs.pull(stop_s)
        self.tick += 1

    def _require_reached(self, stop_s: float) -> None:
        """Raise RunError if the FMU returned OK, but reports that it has not reached the end of the step."""
        reached_s = self._stepper.reached_s()
        if reached_s is not None and not reached_s >= stop_s - SHORT * self.setup.period_s:
            raise RunError(f"{self.name}: the FMU returned OK at {reached_s:.9g} s, by its last successful "
                           f"time, from the step to {stop_s:.9g} s: its outputs are of an earlier instant")

    def reached_s(self) -> float | None:
        """Last successful time that the FMU reports, or None."""
        return self._stepper.reached_s()

    def take_messages(self) -> list[str]:
        """Messages since the last call, as from `FmuLibrary.take_messages`."""
        return self.library.take_messages()

    def save(self) -> tuple[bytes, Any, Any, int]:
        """Whole state of the instance; RunError if the FMU refuses."""
        functions = self.library.functions
        try:
            state = functions.getFMUState()
            try:
                content = functions.serializeFMUState(state)
            finally:
                functions.freeFMUState(state)
        except FMICallException as fault:
            raise self._refused("saved", fault) from None
        return content, self._stepper.memory(), self.inputs.values.copy(), self.tick

    def restore(self, saved: tuple[bytes, Any, Any, int]) -> None:
        """Resume from the result of `save` of this or another instance; RunError if the FMU refuses."""
        content, memory, inputs, self.tick = saved
        functions = self.library.functions
        try:
            state = functions.deserializeFMUState(content)
            try:
                functions.setFMUState(state)
            finally:
                functions.freeFMUState(state)
        except FMICallException as fault:
            raise self._refused("restored", fault) from None
        self._stepper.recall(memory)
        self.inputs.values[:] = inputs
        self.outputs.pull(self.setup.instant_s(self.tick))

    def _refused(self, what: str, fault: FMICallException) -> RunError:
        return RunError(f"{self.library.name}: the FMU's state could not be {what}: {fault}")

    def end(self) -> None:
        """Terminate and free."""
        self.library.end()
