"""Integration of FMI 2.0 model-exchange FMUs by Runge-Kutta substeps that end at every event.

Dormand and Prince's method of order 8 (Hairer, Norsett, Wanner 1993, section II.5, doi
10.1007/978-3-540-78862-1), with a declared number of equal substeps per communication step. A time event ends
a substep exactly; a state event is a change of sign of an indicator over a substep, located by bisection to
1e-12 s. Two crossings of one indicator within a substep are not detected. A stiff FMU needs substeps of a few
of its shortest time constants at most; with longer ones the integration is unstable.
"""

from __future__ import annotations

import ctypes
import math
from typing import Any

import numpy as np
from fmpy.fmi2 import fmi2EventInfo
from numpy.typing import NDArray
from scipy.integrate import DOP853

from fesloop.errors import RunError
from plants.fmu.library import FmuLibrary, FmuVector

MAX_EVENT_ITERATIONS = 1000
LOCATED_S = 1e-12
SHORTEST_SUBSTEP = 1e-9
"""Fraction of the usual substep; a shorter rest is rounding, and joins the substep before it."""

_NODES, _WEIGHTS = DOP853.C[: DOP853.n_stages], np.ascontiguousarray(DOP853.B)
_STAGES = [np.ascontiguousarray(row[:i]) for i, row in enumerate(DOP853.A[: DOP853.n_stages])]


class ModelExchange2:
    """Communication steps of an FMI 2.0 model-exchange FMU.

    Parameters
    ----------
    library: the instance, initialised before `start` is called.
    inputs: input variables, written in event mode when they change.
    states, indicators: numbers of continuous states and event indicators.
    length_s: length of a communication step. substeps: Runge-Kutta steps in it.
    completes_steps: whether the FMU requires fmi2CompletedIntegratorStep.
    """

    def __init__(self, library: FmuLibrary, inputs: FmuVector, states: int, indicators: int, length_s: float,
                 substeps: int, completes_steps: bool) -> None:
        self._library, self._inputs = library, inputs
        self._substep_s, self._completes_steps = length_s / substeps, completes_steps
        self._component, self._dll = library.component, library.functions.dll
        self._states, self._count = np.zeros(states), states
        self._stage, self._slopes = np.zeros(states), np.zeros((len(_WEIGHTS), states))
        self._stage_pointer = _pointer(self._stage)
        self._rows = [(float(node), weights, self._slopes[:i], _pointer(self._slopes[i]))
                      for i, (node, weights) in enumerate(zip(_NODES, _STAGES, strict=True))]
        self._set_time, self._set_states = self._dll.fmi2SetTime, self._dll.fmi2SetContinuousStates
        self._get_derivatives = self._dll.fmi2GetDerivatives
        self._indicators, self._seen = np.zeros(indicators), np.zeros(indicators)
        self._indicator_pointer = _pointer(self._indicators)
        self._event = fmi2EventInfo()
        self._enter, self._terminate = ctypes.c_int(), ctypes.c_int()
        self._next_event_s = math.inf
        self._now_s = 0.0

    def start(self) -> None:
        """Settle the events of initialisation and enter continuous-time mode."""
        self._settle_events()

    def step(self, start_s: float, stop_s: float, inputs_changed: bool) -> None:
        """Advance from `start_s` to `stop_s`; RunError for anything but success."""
        self._now_s = start_s
        if inputs_changed:
            self._handle_event(push=True)
        shortest = SHORTEST_SUBSTEP * self._substep_s
        while self._now_s < stop_s:
            target = self._now_s + self._substep_s
            if stop_s - target < shortest:
                target = stop_s
            timed = self._next_event_s <= target
            if timed:
                target = max(self._next_event_s, self._now_s)
            if not self._integrate_to(target) and timed:
                self._handle_event()

    def reached_s(self) -> float | None:
        """None: fesloop integrates the FMU, so outputs are never stale."""
        return None

    def memory(self) -> Any:
        """State of the integrator, in addition to the FMU's own."""
        return self._states.copy(), self._seen.copy(), self._next_event_s, self._now_s

    def recall(self, memory: Any) -> None:
        """Resume from the result of `memory`."""
        self._states[:], self._seen[:], self._next_event_s, self._now_s = memory

    def _call(self, function: str, *arguments: Any) -> None:
        status = getattr(self._dll, function)(self._component, *arguments)
        if status:
            self._library.check(function, status, self._now_s)

    def _integrate_to(self, target_s: float) -> bool:
        """Integrate one substep, or less up to a state event; whether an event was handled."""
        if target_s > self._now_s:
            start_s, before = self._now_s, self._states.copy()
            self._runge_kutta(before, start_s, target_s - start_s)
            if self._indicators.size and self._crossed():
                self._locate(before, start_s, target_s - start_s)
                self._complete()
                self._handle_event()
                return True
        return self._complete()

    def _runge_kutta(self, before: NDArray[np.float64], start_s: float, length_s: float) -> None:
        """Compute the states at start + length from those at start, and leave the FMU there."""
        stage, count = self._stage, self._count
        for node, weights, slopes, slope_pointer in self._rows:
            np.dot(weights, slopes, out=stage)
            stage *= length_s
            stage += before
            self._set(start_s + node * length_s)
            if count:
                status = self._get_derivatives(self._component, slope_pointer, count)
                if status:
                    self._library.check("fmi2GetDerivatives", status, start_s)
        np.dot(_WEIGHTS, self._slopes, out=stage)
        stage *= length_s
        stage += before
        self._states[:] = stage
        self._now_s = start_s + length_s
        self._set(self._now_s)

    def _set(self, time_s: float) -> None:
        """Set the FMU's time, and its states to `_stage`."""
        status = self._set_time(self._component, time_s)
        if status:
            self._library.check("fmi2SetTime", status, time_s)
        if self._count:
            status = self._set_states(self._component, self._stage_pointer, self._count)
            if status:
                self._library.check("fmi2SetContinuousStates", status, time_s)

    def _crossed(self) -> bool:
        """Whether an indicator has changed sign since the start of the substep."""
        self._call("fmi2GetEventIndicators", self._indicator_pointer, self._indicators.size)
        return bool(((self._indicators > 0.0) != (self._seen > 0.0)).any())

    def _locate(self, before: NDArray[np.float64], start_s: float, length_s: float) -> None:
        """Bisect to just after the first crossing, and leave the FMU there."""
        calm, crossed = 0.0, length_s
        while crossed - calm > max(LOCATED_S, 4.0 * math.ulp(start_s)):
            middle = 0.5 * (calm + crossed)
            self._runge_kutta(before, start_s, middle)
            calm, crossed = (calm, middle) if self._crossed() else (middle, crossed)
        self._runge_kutta(before, start_s, crossed)

    def _complete(self) -> bool:
        """Report a completed substep to the FMU; whether it requested an event, which is handled here."""
        if not self._completes_steps:
            return False
        self._call("fmi2CompletedIntegratorStep", 1, ctypes.byref(self._enter), ctypes.byref(self._terminate))
        self._check_end(self._terminate.value)
        if self._enter.value:
            self._handle_event()
        return bool(self._enter.value)

    def _handle_event(self, push: bool = False) -> None:
        """Handle an event at the present instant."""
        self._call("fmi2EnterEventMode")
        if push:
            self._inputs.push(self._now_s)
        self._settle_events()

    def _settle_events(self) -> None:
        """Iterate the discrete states until they settle, and enter continuous-time mode."""
        event = self._event
        for _ in range(MAX_EVENT_ITERATIONS):
            self._call("fmi2NewDiscreteStates", ctypes.byref(event))
            self._check_end(event.terminateSimulation)
            if not event.newDiscreteStatesNeeded:
                break
        else:
            raise RunError(f"{self._library.name}: the event at {self._now_s:.9g} s did not settle in "
                           f"{MAX_EVENT_ITERATIONS} iterations")
        self._next_event_s = float(event.nextEventTime) if event.nextEventTimeDefined else math.inf
        self._call("fmi2EnterContinuousTimeMode")
        if self._count:
            self._call("fmi2GetContinuousStates", self._stage_pointer, self._count)
            self._states[:] = self._stage
        if self._indicators.size:
            self._call("fmi2GetEventIndicators", self._indicator_pointer, self._indicators.size)
            self._seen[:] = self._indicators

    def _check_end(self, requested: int) -> None:
        if requested:
            raise RunError(f"{self._library.name}: the FMU requested the end of the run at "
                           f"{self._now_s:.9g} s")


def _pointer(array: NDArray[np.float64]) -> Any:
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
