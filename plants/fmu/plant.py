"""Any functional mock-up unit as a plant, through FMPy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from fesloop.errors import InputError
from fesloop.loop.block import Context
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import Port, Value
from plants.fmu.archive import SHIPPED, ExtractedFmu
from plants.fmu.description import NUMERIC, FmuDescription, FmuVariable, read_description
from plants.fmu.internal_step import fits, misfit, stepped_alike
from plants.fmu.library import StartValue
from plants.fmu.ports import FmuPort, bind_ports
from plants.fmu.probe import Probed, probe
from plants.fmu.process import Isolation
from plants.fmu.running import FmuSetup
from plants.fmu.state import FmuState
from plants.fmu.vector import integer_range

_SHORTEST_S, _LONGEST_S, _MOST_MB = 1e-3, 3600.0, 10**6
"""Chosen; the system's clock ends no wait that is much shorter."""
_TEXTS = ("String", "Binary")
_DIVERGES, _COARSE = 0.5, 0.01
"""Chosen: parts of their motion by which outputs may not differ with twice as many substeps, and by which
that is a caution."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fmu:
    """An FMU of FMI 2.0 (co-simulation, model exchange) or FMI 3.0 (co-simulation).

    It advances by communication steps of a declared rate. Inputs are latched at their starts and held;
    outputs are those of the last communication point. An FMU is native code: nothing is loaded but the file
    named here. It is checked when the plant is made, in a process of its own: that it initialises, that its
    outputs are not stale (the communication step is a whole multiple of its internal step), whether it
    replays from a saved state. Without that a run with it can go on, but not be snapshotted.

    In a run an FMU has a process of its own, too: where it crashes, exits or hangs, or takes more memory than
    allowed, the run fails in one line and what was recorded is kept. What it prints goes nowhere. Results are
    the same in fesloop's process, and quicker, unless instances of the FMU share memory (global variables).

    Attributes
    ----------
    path: the .fmu file; "shipped:finger" is the default finger, exported anew
        (which takes a compiler).
    step_rate: communication points, Hz.
    interface: "auto" takes co-simulation where there is the choice.
    input_ports, output_ports: how variables make ports; without any, `bind_ports` tells how they are made.
    starts: start values by variable name, parameters above all, of an array (FMI 3.0) a number for each
        element, last index fastest; an input's holds until its first message.
    substeps: Runge-Kutta steps of order 8 in a communication step (model exchange only).
    isolate: whether it runs in a process of its own. By default all do but "shipped:finger", which is
        compiled from fesloop's own sources: no file is taken for one of these by what it says of itself.
        False is refused for an FMU that can be instantiated only once in a process.
    probe_timeout_s: how long the check may take, and initialisation in a process of its own.
    step_timeout_s: how long a step may take in a process of its own, in s, 0.001 at least.
    memory_mb: how much data it may allocate in a process of its own.
    fingerprint: SHA-256 of the file; left out: it is filled in. Where it is given, as in the recording of a
        run that is run again, the file must still be the same.

    Raises
    ------
    InputError: for a file that is no FMU, is of an unsupported kind, has no binary for this platform, would
        escape its folder, is another than `fingerprint` says, crashes or refuses initialisation, or is stale;
        and for ports that do not fit it.
    """

    path: str
    step_rate: str = "1000"
    interface: Literal["auto", "co_simulation", "model_exchange"] = "auto"
    input_ports: tuple[FmuPort, ...] = ()
    output_ports: tuple[FmuPort, ...] = ()
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
        grid = RateClock.from_rate(self.step_rate, where="step_rate")
        extracted = ExtractedFmu(Path(self.path))
        try:
            self._require_the_same(extracted.digest)
            setup = self._fit(extracted, grid)
            probed = probe(setup, extracted.folder, extracted.path, self._isolation)
            if not fits(setup.period_s, probed.internal.length_s):
                raise misfit(setup.period_s, probed.internal)
            if probed.coarse >= _DIVERGES:
                raise InputError("substeps", f"{self.substeps} are too few: outputs differ with twice as "
                                 "many by as much as they move, or the integration diverges",
                                 "enough for the FMU's shortest time constant",
                                 "raise substeps or step_rate, or take the FMU's co-simulation")
            setup = replace(stepped_alike(setup, probed.internal.length_s), tells=probed.tells)
        except BaseException:
            extracted.close()
            raise
        derived = {"fingerprint": extracted.digest, "_grid": grid, "_extracted": extracted, "_setup": setup,
                   "_probed": probed}
        for name, value in derived.items():
            object.__setattr__(self, name, value)

    def _require_the_same(self, found: str) -> None:
        """InputError for a file that is not the one of the fingerprint."""
        if self.fingerprint not in ("", found):
            raise InputError("path", f"{self.path} has changed, its fingerprint is {found[:12]}",
                             f"{self.fingerprint[:12]}",
                             'bring the file back, or set fingerprint to "" to run with this one')

    def _fit(self, extracted: ExtractedFmu, grid: RateClock) -> FmuSetup:
        """These parameters on that FMU."""
        description = read_description(extracted.folder, extracted.path, self.interface)
        if description.once and not self._isolated:
            raise InputError("isolate", f"{self.isolate}, but {self.path} says that it can be instantiated "
                             "only once in a process, and each node and trial instantiates it",
                             "true", "leave isolate out")
        starts = _checked_starts(description, self.starts)
        description = _started(description, starts)
        setup = FmuSetup(
            description, bind_ports(description, "input", self.input_ports, "input_ports"),
            bind_ports(description, "output", self.output_ports, "output_ports"),
            starts, grid.period_num, grid.period_den, self.substeps)
        declared_s = description.internal_step_s
        return stepped_alike(setup, declared_s) if fits(setup.period_s, declared_s) else setup

    @property
    def _isolated(self) -> bool:
        return self.path != SHIPPED if self.isolate is None else self.isolate

    @property
    def _isolation(self) -> Isolation:
        return Isolation(self.memory_mb, self.probe_timeout_s, self.step_timeout_s)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """A port an input variable or group of them."""
        return tuple(bound.port for bound in self._setup.inputs)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """A port an output variable or group of them."""
        return tuple(bound.port for bound in self._setup.outputs)

    @property
    def for_open_inputs(self) -> str:
        """What else can be done about an input without a wire."""
        return "or leave it out of input_ports (declare the others): its start value then holds"

    @property
    def grid(self) -> RateClock:
        """Communication points."""
        return self._grid

    @property
    def feedthrough(self) -> bool:
        """False: outputs are those of the last communication point, inputs act from the next step on."""
        return False

    @property
    def can_snapshot(self) -> bool:
        """Whether the FMU was seen to replay from a saved state."""
        return self._probed.replays

    def cautions(self, context: Context) -> tuple[tuple[str, str], ...]:
        """Substeps that are too long, and outputs of which nothing shows whether they are stale."""
        _, _, names, why = self._probed.internal
        if self._probed.coarse > _COARSE:
            return (("substeps_too_few", f"outputs differ by {self._probed.coarse:.2g} of what they move "
                     f"with twice as many substeps as {self.substeps}: raise substeps or step_rate"),)
        if not names:
            return ()
        named = ", ".join(names[:5]) + (f" and {len(names) - 5} more" if names[5:] else "")
        return (("staleness_unchecked",
                 f"whether outputs are stale could not be checked for {named}: {why}"),)

    def init(self, context: Context) -> FmuState:
        """A new instance, initialised."""
        return FmuState(self._setup, self._extracted, context.name, self._probed.why_not,
                        self._isolation if self._isolated else None)

    def next_trial(self, state: FmuState, context: Context) -> FmuState:
        """A new instance; the old one is freed."""
        state.end()
        return self.init(context)

    def close(self, state: FmuState) -> None:
        """Terminate the FMU and free it."""
        state.end()

    def advance(self, state: FmuState, inputs: Sequence[Value], start_ns: int, stop_ns: int) -> None:
        """One communication step; RunError with time and message where the FMU fails."""
        state.step(inputs)

    def reports(self, state: FmuState) -> list[tuple[str, str]]:
        """Warnings and worse that the FMU has logged, or returned, since the last call."""
        return state.reports()

    def read(self, state: FmuState, inputs: Sequence[Value]) -> tuple[Value, ...]:
        """Outputs of the last communication point."""
        return state.read()


def _checked_starts(
    description: FmuDescription, starts: dict[str, StartValue]
) -> tuple[tuple[str, StartValue], ...]:
    """Start values as pairs; InputError for a variable that is not there or a value of the wrong type."""
    for name, value in starts.items():
        variable = description.variables.get(name)
        allowed = [v.name for causality in ("parameter", "input") for v in description.variables.values()
                   if v.causality == causality and v.variability != "constant"]
        if variable is not None and variable.causality == "structuralParameter":
            raise InputError(f"starts.{name}", "is a structural parameter, which sets the sizes of arrays",
                             ", ".join(allowed[:30]) or "none",
                             "have the FMU exported with that size")
        if (variable is None or variable.variability == "constant"
                or variable.causality in ("output", "independent", "calculatedParameter")):
            raise InputError(f"starts.{name}", "is no variable of the FMU that can be set",
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
    """InputError for an element of a start value that is not of the variable's type or beyond its limits."""
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
                         f"{variable.low:g} to {variable.high:g}, which are the FMU's min and max")


def _started(description: FmuDescription, starts: tuple[tuple[str, StartValue], ...]) -> FmuDescription:
    """The description with start values in place of its own, which ports have before the first message."""
    variables = dict(description.variables)
    for name, value in starts:
        if not isinstance(value, str):
            start = tuple(map(float, value)) if isinstance(value, tuple) else float(value)
            variables[name] = replace(variables[name], start=start)
    return replace(description, variables=variables)
