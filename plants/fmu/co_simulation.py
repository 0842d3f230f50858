"""Communication steps of co-simulation FMUs, FMI 2.0 and 3.0."""

from __future__ import annotations

import ctypes
from typing import Any

from fesloop.errors import RunError
from plants.fmu.library import WARNING, FmuLibrary

_LAST_SUCCESSFUL_TIME, _TERMINATED = 2, 3
_DISCARD = 2


class CoSimulation2:
    """Steps of an FMI 2.0 co-simulation FMU, all of one length."""

    __slots__ = ("_component", "_do_step", "_length_s", "_library")

    def __init__(self, library: FmuLibrary, length_s: float) -> None:
        self._library, self._length_s = library, length_s
        self._component, self._do_step = library.component, library.functions.dll.fmi2DoStep

    def start(self) -> None:
        """Nothing is left to do after initialisation."""

    def step(self, start_s: float, stop_s: float, inputs_changed: bool) -> None:
        """One communication step; RunError for anything but success."""
        status = self._do_step(self._component, start_s, self._length_s, 1)
        if status == _DISCARD:
            self._require_no_end(stop_s)
        if status:
            self._library.check("fmi2DoStep", status, start_s)

    def _require_no_end(self, stop_s: float) -> None:
        """RunError where a discarded step is the FMU's wish that the run end."""
        ends = ctypes.c_int()
        status = self._library.functions.dll.fmi2GetBooleanStatus(
            self._component, _TERMINATED, ctypes.byref(ends))
        if status <= WARNING and ends.value:
            reached_s = self.reached_s()
            at_s = stop_s if reached_s is None else reached_s
            raise RunError(f"{self._library.name}: the FMU asked at {at_s:.9g} s for the run to end")

    def reached_s(self) -> float | None:
        """The instant that the FMU says it has reached, None if it does not say."""
        value = ctypes.c_double()
        status = self._library.functions.dll.fmi2GetRealStatus(
            self._component, _LAST_SUCCESSFUL_TIME, ctypes.byref(value))
        return value.value if status <= WARNING else None

    def memory(self) -> Any:
        """None: all memory is inside the FMU."""
        return None

    def recall(self, memory: Any) -> None:
        """All memory is inside the FMU."""


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
        """Nothing is left to do after initialisation: without event mode the FMU is in step mode."""

    def step(self, start_s: float, stop_s: float, inputs_changed: bool) -> None:
        """One communication step; RunError for anything but success, early return included."""
        status = self._do_step(self._component, start_s, self._length_s, True, *self._arguments)
        if status:
            self._library.check("fmi3DoStep", status, start_s)
        if self._terminate.value:
            raise RunError(f"{self._library.name}: the FMU asked at {stop_s:.9g} s for the run to end")
        if self._early.value:
            raise RunError(f"{self._library.name}: the FMU returned early, at {self._reached.value:.9g} s, "
                           f"from the step to {stop_s:.9g} s, though it was not allowed to")

    def reached_s(self) -> float | None:
        """The instant that the FMU says it has reached."""
        return self._reached.value

    def memory(self) -> Any:
        """None: all memory is inside the FMU."""
        return None

    def recall(self, memory: Any) -> None:
        """All memory is inside the FMU."""
