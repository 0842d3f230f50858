"""`fmu`: an FMU as a plant, and its state, a live instance that can be saved if the FMU really replays."""

from __future__ import annotations

import os
import weakref
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import isfinite
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, RunError, SnapshotError
from fesloop.loop.block import Context
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import Port, Value
from fesloop.posix import is_linux, require_linux
from plants.fmu.archive import SHIPPED, ExtractedFmu
from plants.fmu.description import NUMERIC, FmuDescription, FmuVariable, read_description
from plants.fmu.library import StartValue, integer_range
from plants.fmu.ports import BoundPort, FmuPort, bind_ports, limits
from plants.fmu.process import IsolatedFmu, Isolation, probe
from plants.fmu.running import FmuSetup, RunningFmu
from plants.fmu.trial import Probed, fits, misfit, stepped_alike


class Scale(NamedTuple):
    """Conversion from ports to the FMU: its value is the port's times `factor`, plus `offset`."""

    factor: NDArray[np.float64]
    offset: NDArray[np.float64]


class Place(NamedTuple):
    """Place of an output in the flat vector, and its shape unless it is flat."""

    where: int | slice
    shape: tuple[int, ...] | None


class FmuState:
    """A live FMU, whose native code keeps the state.

    Pickling or copying makes a second instance that continues from the same state; SnapshotError if the FMU
    does not really replay. Freed by `end`, or by garbage collection.
    """

    __slots__ = ("__weakref__", "_end", "_high", "_isolation", "_low", "_outside", "_owner", "_places",
                 "_reports", "_scale", "extracted", "inputs", "latched", "running", "why_not")

    def __init__(self, setup: FmuSetup, extracted: ExtractedFmu, name: str, why_not: str,
                 isolation: Isolation | None) -> None:
        self.extracted, self.why_not, self._isolation = extracted, why_not, isolation
        self.running: RunningFmu | IsolatedFmu
        if isolation is None:
            self.running = RunningFmu(setup, extracted.folder, name)
        else:
            self.running = IsolatedFmu(setup, extracted.folder, name, extracted.path.name, isolation)
        self._owner = os.getpid()
        self._end = weakref.finalize(self, _end_collected, self.running, extracted, self._owner)
        scales = [_scale([bound], bound.shape) for bound in setup.inputs]
        self.inputs = list(zip(_views(self.running.inputs.values, setup.inputs), scales, strict=True))
        self.latched: list[Value | None] = [None] * len(setup.inputs)
        self._low, self._high = limits(setup.inputs)
        self._outside = np.zeros(self._low.size, bool)
        self._reports: list[tuple[str, str]] = []
        self._places, self._scale = _places(setup.outputs), _scale(setup.outputs, (-1,))

    def step(self, inputs: Sequence[Value]) -> None:
        """Do one communication step; only changed inputs are written to the FMU."""
        changed = False
        latched = self.latched
        for i, value in enumerate(inputs):
            if value is not latched[i]:
                latched[i] = value
                view, scale = self.inputs[i]
                scaled = value if scale is None else value * scale.factor + scale.offset
                if (view != scaled).any():
                    view[...] = scaled
                    changed = True
        if changed:
            self._check_range()
        self.running.step(changed)
        values = self.running.outputs.values
        if not isfinite(np.vdot(values, values)) and not np.isfinite(values).all():
            self._raise_not_finite()

    def _check_range(self) -> None:
        """Report inputs beyond the FMU's min and max; they are written to it unchanged."""
        low, high, values = self._low, self._high, self.running.inputs.values
        outside = (values < low) | (values > high)
        fresh = np.flatnonzero(outside & ~self._outside)
        self._outside = outside
        ports = self.running.setup.inputs
        names = [v.name for bound in ports for v in bound.variables for _ in range(v.size)]
        latched_ms = 1e3 * self.running.setup.instant_s(self.running.tick)
        self._reports.extend(("out_of_range", f"{names[i]!r}, latched at {latched_ms:.6f} ms, is "
                           f"{values[i]:g} in the FMU's unit, outside "
                           f"its min and max, {low[i]:g} to {high[i]:g}") for i in fresh.tolist())

    def _raise_not_finite(self) -> None:
        """Raise RunError naming the first output that is not finite."""
        setup, values = self.running.setup, self.running.outputs.values
        elements = [(bound.port.name, v.name) for bound in setup.outputs for v in bound.variables
                    for _ in range(v.size)]
        first = int(np.argmin(np.isfinite(values)))
        port, variable = elements[first]
        time_ms = 1e3 * setup.instant_s(self.running.tick)
        hint = ("; if its integration diverges, raise substeps or step_rate"
                if setup.description.interface == "model_exchange" else "")
        raise RunError(f"{self.running.name}.{port} is not finite at {time_ms:.6f} ms: "
                       f"the FMU puts out {values[first]:g} for {variable!r}{hint}")

    def reports(self) -> list[tuple[str, str]]:
        """Statuses, and messages of the FMU, since the last call."""
        reports, self._reports = self._reports, []
        return reports + [("fmu_warning", f"the FMU says: {text}") for text in self.running.take_messages()]

    def read(self) -> tuple[Value, ...]:
        """New values of the outputs."""
        values = self.running.outputs.values
        values = (values.copy() if self._scale is None
                  else (values - self._scale.offset) / self._scale.factor)
        return tuple([values.item(where) if isinstance(where, int) else values[where] if shape is None
                      else values[where].reshape(shape) for where, shape in self._places])

    def end(self) -> None:
        """Terminate and free the FMU; RunError if it crashes."""
        if self._end.detach() is not None and os.getpid() == self._owner:
            self.running.end()

    def __reduce__(self) -> tuple[object, tuple[object, ...]]:
        if self.why_not:
            raise SnapshotError(f"{self.running.name}: the state of {self.extracted.path.name} "
                                f"cannot be saved: {self.why_not}")
        try:
            saved = self.running.save()
        except RunError as fault:
            raise SnapshotError(str(fault)) from fault
        return _resumed, (self.running.setup, self.extracted, self.running.name,
                          self._isolation, saved, self._outside)


def _resumed(setup: FmuSetup, extracted: ExtractedFmu, name: str, isolation: Isolation | None,
             saved: Any, outside: NDArray[np.bool_]) -> FmuState:
    """Make a new instance in a saved state."""
    state = FmuState(setup, extracted, name, "", isolation)
    state.running.restore(saved)
    state._outside = outside
    return state


def _end_collected(running: RunningFmu | IsolatedFmu, extracted: ExtractedFmu, owner: int) -> None:
    """Free an instance, and then its files, on garbage collection; a forked child leaves its parent's."""
    if os.getpid() == owner:
        with suppress(RunError):
            running.end()
    del extracted


def _slices(ports: Sequence[BoundPort]) -> list[slice]:
    stops = np.cumsum([sum(v.size for v in bound.variables) for bound in ports], dtype=int).tolist()
    return [slice(start, stop) for start, stop in zip([0, *stops], stops, strict=False)]


def _views(values: Any, ports: Sequence[BoundPort]) -> list[Any]:
    """Views of each port's part of a flat vector, in the port's shape."""
    return [values[part].reshape(bound.shape) for part, bound in zip(_slices(ports), ports, strict=True)]


def _places(ports: Sequence[BoundPort]) -> list[Place]:
    """Place of each output in the flat vector."""
    return [Place(int(part.start), None) if not bound.shape
            else Place(part, None if len(bound.shape) == 1 else bound.shape)
            for part, bound in zip(_slices(ports), ports, strict=True)]


def _scale(ports: Sequence[BoundPort], shape: tuple[int, ...]) -> Scale | None:
    """Conversion of all elements, in a shape; None if there is nothing to convert."""
    factors = np.array([scale for bound in ports for scale in bound.scales])
    offsets = np.array([offset for bound in ports for offset in bound.offsets])
    same = (factors == 1.0).all() and (offsets == 0.0).all()
    return None if same else Scale(factors.reshape(shape), offsets.reshape(shape))


_SHORTEST_S, _LONGEST_S, _MOST_MB = 1e-3, 3600.0, 10**6
"""Chosen: ranges of the timeouts and of memory_mb; the system cannot time much shorter waits."""
_TEXTS = ("String", "Binary")
_DIVERGES, _COARSE = 0.5, 0.01
"""Chosen: difference of outputs with twice as many substeps, relative to their movement, from which the FMU
is refused, and above which `check` warns."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fmu:
    """An FMU of FMI 2.0 (co-simulation, model exchange) or FMI 3.0 (co-simulation).

    The FMU advances by communication steps of a declared rate. Inputs are latched at their starts and held;
    outputs are those of the last communication point. An FMU is native code: only the file named here is
    loaded. It is tried out when the plant is made, in a process of its own: whether it initialises, whether
    its outputs are stale (the communication step must be a whole multiple of its internal step), and whether
    it replays from a saved state. An FMU that does not replay can be run, but not snapshotted.

    In a run, too, an FMU has a process of its own: if it crashes, exits, hangs or exceeds its memory, the run
    fails with one line and keeps its recording. The FMU's output is discarded. In fesloop's own process runs
    are faster with the same results, unless instances of the FMU share memory (global variables).

    Attributes
    ----------
    path: the .fmu file; "shipped:finger" is the default finger, exported on demand (which needs a compiler).
    step_rate: rate of communication points, Hz.
    interface: interface to use; "auto" prefers co-simulation.
    input_ports, output_ports: ports made of variables; by default formed as in `bind_ports`.
    held_inputs: names of inputs that keep their start values, so that no port is formed of them; only where
        `input_ports` are not declared.
    starts: start values of variables, mainly parameters, by name; for an array (FMI 3.0) a number for each
        element, last index fastest. The start value of an input holds until its first message.
    substeps: Runge-Kutta steps of order 8 in a communication step (model exchange only).
    isolate: whether the FMU runs in a process of its own, which needs Linux. Default there: true, except for
        "shipped:finger", which is compiled from fesloop's own sources; no other file is trusted like it.
        Elsewhere an FMU that crashes ends the run's process. False is refused for an FMU that can be
        instantiated only once in a process.
    probe_timeout_s: time limit of the trial at load, and of initialisation in a process of its own.
    step_timeout_s: time limit of a step in a process of its own, at least 0.001 s.
    memory_mb: limit of the data that the FMU allocates in a process of its own.
    fingerprint: SHA-256 of the file; filled in by default. If given, as in a recording that is run again, the
        file must be the same.

    Raises
    ------
    InputError: for a file that is not an FMU, is of an unsupported kind, has no binary for this platform,
        would write outside its folder, differs from `fingerprint`, crashes or refuses initialisation, or has
        stale outputs; and for ports that do not fit the FMU.
    """

    path: str
    step_rate: str = "1000"
    interface: Literal["auto", "co_simulation", "model_exchange"] = "auto"
    input_ports: tuple[FmuPort, ...] = ()
    output_ports: tuple[FmuPort, ...] = ()
    held_inputs: tuple[str, ...] = ()
    starts: dict[str, float | int | bool | str | tuple[float | int | bool, ...]] = field(default_factory=dict)
    substeps: int = 5
    isolate: bool | None = None
    probe_timeout_s: float = 30.0
    step_timeout_s: float = 30.0
    memory_mb: int = 4096
    fingerprint: str = ""
    _grid: RateClock = field(init=False, repr=False)
    _extracted: ExtractedFmu = field(init=False, repr=False)
    _setup: FmuSetup = field(init=False, repr=False)
    _probed: Probed = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.substeps < 1:
            raise InputError("substeps", f"{self.substeps}", "1 or more")
        for name in ("probe_timeout_s", "step_timeout_s"):
            if not _SHORTEST_S <= getattr(self, name) <= _LONGEST_S:
                raise InputError(name, f"{getattr(self, name):g}", f"{_SHORTEST_S:g} to {_LONGEST_S:g} s")
        if not 1 <= self.memory_mb <= _MOST_MB:
            raise InputError("memory_mb", f"{self.memory_mb}", f"1 to {_MOST_MB}")
        if self.isolate:
            require_linux("isolate", "a process of the FMU's own", "remove isolate: the FMU then runs in the "
                          "process of the run, which its crash ends")
        grid = RateClock.from_rate(self.step_rate, where="step_rate")
        extracted = ExtractedFmu(Path(self.path))
        try:
            if self.fingerprint not in ("", extracted.digest):
                found = extracted.digest[:12]
                raise InputError("path", f"{self.path} has changed, its fingerprint is {found}",
                                 f"{self.fingerprint[:12]}",
                                 'restore the file, or set fingerprint to "" to run with this one')
            setup = self._fit(extracted, grid)
            probed = probe(setup, extracted.folder, extracted.path, self._isolation)
            if not fits(setup.period_s, probed.internal.length_s):
                raise misfit(setup.period_s, probed.internal)
            if probed.coarse >= _DIVERGES:
                raise InputError("substeps", f"{self.substeps} are too few: with twice as many, outputs "
                                 "differ by as much as they move, or the integration diverges",
                                 "enough for the FMU's shortest time constant",
                                 "raise substeps or step_rate, or use the FMU's co-simulation")
            setup = replace(stepped_alike(setup, probed.internal.length_s),
                            reports_time=probed.reports_time)
        except BaseException:
            extracted.close()
            raise
        derived = {"fingerprint": extracted.digest, "_grid": grid, "_extracted": extracted, "_setup": setup,
                   "_probed": probed}
        for name, value in derived.items():
            object.__setattr__(self, name, value)

    def _fit(self, extracted: ExtractedFmu, grid: RateClock) -> FmuSetup:
        """Apply these parameters to an extracted FMU."""
        description = read_description(extracted.folder, extracted.path, self.interface)
        if description.once and not self._isolated:
            raise InputError("isolate", f"{self.isolate}, but {self.path} declares that it can be "
                             "instantiated only once in a process, and each node and trial instantiates it",
                             "true", "remove isolate")
        for name in self.held_inputs:
            variable = description.variables.get(name)
            if self.input_ports or variable is None or variable.causality != "input":
                raise InputError(
                    "held_inputs",
                    f"{name!r} is given beside input_ports"
                    if self.input_ports
                    else f"{name!r} is no input of the FMU",
                    "inputs, where input_ports are not declared",
                    "remove it: an input that input_ports omit is held",
                )
        starts = _checked_starts(description, self.starts)
        description = _started(description, starts)
        setup = FmuSetup(
            description, bind_ports(description, "input", self.input_ports, "input_ports", self.held_inputs),
            bind_ports(description, "output", self.output_ports, "output_ports"),
            starts, grid.period_num, grid.period_den, self.substeps)
        declared_s = description.internal_step_s
        return stepped_alike(setup, declared_s) if fits(setup.period_s, declared_s) else setup

    @property
    def _isolated(self) -> bool:
        return is_linux() and self.path != SHIPPED if self.isolate is None else self.isolate

    @property
    def _isolation(self) -> Isolation:
        return Isolation(self.memory_mb, self.probe_timeout_s, self.step_timeout_s)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """One port for each input variable or group of these."""
        return tuple(bound.port for bound in self._setup.inputs)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """One port for each output variable or group of these."""
        return tuple(bound.port for bound in self._setup.outputs)

    @property
    def for_open_inputs(self) -> str:
        """Remedy for an input without a wire."""
        return "or name its variable in held_inputs, or omit it from input_ports: its start value then holds"

    @property
    def grid(self) -> RateClock:
        """Communication points."""
        return self._grid

    @property
    def own_step_s(self) -> float:
        """Step of the FMU's default experiment, s; 0 where it has none."""
        return self._setup.description.preferred_step_s

    @property
    def feedthrough(self) -> bool:
        """False: outputs are those of the last communication point; inputs act from the next step on."""
        return False

    @property
    def can_snapshot(self) -> bool:
        """Whether the FMU replayed from a saved state in the trial at load."""
        return self._probed.replays

    def cautions(self, context: Context) -> tuple[tuple[str, str], ...]:
        """Warnings of too few substeps, and of outputs that could not be checked for staleness."""
        names, why = self._probed.internal.unchecked, self._probed.internal.why
        if self._probed.coarse > _COARSE:
            return (("substeps_too_few", f"with twice as many substeps as {self.substeps}, outputs differ by "
                     f"{self._probed.coarse:.2g} of their movement: raise substeps or step_rate"),)
        if not names:
            return ()
        named = ", ".join(names[:5]) + (f" and {len(names) - 5} more" if names[5:] else "")
        return (("staleness_unchecked",
                 f"whether outputs are stale could not be checked for {named}: {why}"),)

    def init(self, context: Context) -> FmuState:
        """Make and initialise an instance."""
        return FmuState(self._setup, self._extracted, context.name, self._probed.why_not,
                        self._isolation if self._isolated else None)

    def next_trial(self, state: FmuState, context: Context) -> FmuState:
        """Free the instance and make a new one."""
        state.end()
        return self.init(context)

    def close(self, state: FmuState) -> None:
        """Terminate and free the FMU."""
        state.end()

    def advance(self, state: FmuState, inputs: Sequence[Value], start_ns: int, stop_ns: int) -> None:
        """Do one communication step; RunError with time and message if the FMU fails."""
        state.step(inputs)

    def reports(self, state: FmuState) -> list[tuple[str, str]]:
        """Warnings and errors of the FMU, and inputs out of range, since the last call."""
        return state.reports()

    def read(self, state: FmuState, inputs: Sequence[Value]) -> tuple[Value, ...]:
        """Outputs at the last communication point."""
        return state.read()


def _checked_starts(
    description: FmuDescription, starts: dict[str, StartValue]
) -> tuple[tuple[str, StartValue], ...]:
    """Check start values; InputError for a missing variable or a value of the wrong type."""
    for name, value in starts.items():
        variable = description.variables.get(name)
        allowed = [v.name for causality in ("parameter", "input") for v in description.variables.values()
                   if v.causality == causality and v.variability != "constant"]
        if variable is not None and variable.causality == "structuralParameter":
            raise InputError(f"starts.{name}", "is a structural parameter, which sets the sizes of arrays",
                             ", ".join(allowed[:30]) or "none", "export the FMU with that size")
        if (variable is None or variable.variability == "constant"
                or variable.causality in ("output", "independent", "calculatedParameter")):
            raise InputError(f"starts.{name}", "is not a settable variable of the FMU",
                             ", ".join(allowed[:30]) or "none")
        if variable.shape != () and variable.type not in NUMERIC:
            raise InputError(f"starts.{name}", f"is an array of type {variable.type}",
                             "scalars, and arrays of numbers")
        if variable.shape != () and not (isinstance(value, (tuple, list)) and len(value) == variable.size):
            raise InputError(f"starts.{name}", f"{value!r} for an array of shape {list(variable.shape)}",
                             f"a list of {variable.size} numbers, last index fastest")
        for each in value if isinstance(value, (tuple, list)) and variable.shape else (value,):
            _check_start(f"starts.{name}", variable, each, description.version)
    return tuple((name, tuple(value) if isinstance(value, list) else value)
                 for name, value in starts.items())


def _check_start(where: str, variable: FmuVariable, value: object, version: int) -> None:
    """Raise InputError for an element of a start value of the wrong type or beyond its limits."""
    if (not isinstance(value, (float, int, str)) or isinstance(value, str) != (variable.type in _TEXTS)
            or (isinstance(value, bool) and variable.type != "Boolean")):
        raise InputError(where, f"{value!r}", f"a value of type {variable.type}")
    if isinstance(value, str):
        return
    if variable.type == "Boolean" and value not in (0, 1):
        raise InputError(where, f"{value!r}", "true or false")
    limits = integer_range(version, variable.type)
    if limits and not (limits[0] <= value <= limits[1] and value == int(value)):
        raise InputError(where, f"{value!r}", f"a whole number from {limits[0]} to {limits[1]}")
    if not variable.low <= value <= variable.high:
        raise InputError(where, f"{value!r}",
                         f"{variable.low:g} to {variable.high:g}, the FMU's min and max")


def _started(description: FmuDescription, starts: tuple[tuple[str, StartValue], ...]) -> FmuDescription:
    """The description with the given start values, which ports have before the first message."""
    variables = dict(description.variables)
    for name, value in starts:
        if not isinstance(value, str):
            start = tuple(map(float, value)) if isinstance(value, tuple) else float(value)
            variables[name] = replace(variables[name], start=start)
    return replace(description, variables=variables)
