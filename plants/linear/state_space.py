"""`state_space`: a linear time-invariant system as a plant, with an optional static nonlinearity before
it."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, Self, cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.forms.schema import require_positive, require_shape
from fesloop.loop.block import Context
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import Port, Value
from fesloop.models.linear_form import ContinuousForm, PlantToControl, uncovered
from fesloop.models.linear_model import LinearModel, Recruitment, continuous_matrices
from plants.linear.system import HeldLinearSystem, step_held

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, slots=True, kw_only=True)
class InputNonlinearity:
    """Static nonlinearity v = f(u), the same for every input of the plant.

        none         v = u
        saturation   v = u, limited to lower and upper
        deadzone     v = 0 between lower and upper, u - upper above, u - lower below
        logistic     v = lower + (upper - lower) / (1 + exp(-(u - centre) / width))
        table        straight lines between (table_input, table_output), constant beyond its ends

    Attributes
    ----------
    kind: one of these functions.
    lower, upper, centre, width: as above; lower below upper, width above 0.
    table_input: strictly increasing, two values or more; table_output: as many.
    """

    kind: Literal["none", "saturation", "deadzone", "logistic", "table"] = "none"
    lower: float = 0.0
    upper: float = 1.0
    centre: float = 0.5
    width: float = 0.1
    table_input: tuple[float, ...] = ()
    table_output: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not self.lower < self.upper:
            raise InputError("nonlinearity.lower", f"{self.lower}", f"below upper, {self.upper}")
        require_positive("nonlinearity", self, "width")
        if not math.isfinite(self.centre):
            raise InputError("nonlinearity.centre", f"{self.centre}", "a finite number")
        if self.kind == "table":
            self._check_table()

    def _check_table(self) -> None:
        """Raise InputError unless the table can be read."""
        points, values = np.asarray(self.table_input), np.asarray(self.table_output)
        if points.size < 2 or not np.isfinite(points).all() or not (np.diff(points) > 0.0).all():
            raise InputError("nonlinearity.table_input", f"{self.table_input}",
                             "two finite numbers or more, strictly increasing")
        if values.size != points.size or not np.isfinite(values).all():
            raise InputError("nonlinearity.table_output", f"{self.table_output}",
                             f"{points.size} finite numbers, one for each of table_input")

    def apply(self, value: float) -> float:
        """Apply f to one input."""
        if self.kind == "saturation":
            return min(max(value, self.lower), self.upper)
        if self.kind == "deadzone":
            return value - min(max(value, self.lower), self.upper)
        if self.kind == "logistic":
            # The hyperbolic form does not overflow far below the centre.
            rise = 0.5 * (1.0 + math.tanh(0.5 * (value - self.centre) / self.width))
            return self.lower + (self.upper - self.lower) * rise
        if self.kind == "table":
            return self._interpolate(value)
        return value

    def _interpolate(self, value: float) -> float:
        """The table at `value`."""
        points, values = self.table_input, self.table_output
        above = bisect_right(points, value)
        if above == 0:
            return values[0]
        if above == len(points):
            return values[-1]
        share = (value - points[above - 1]) / (points[above] - points[above - 1])
        return values[above - 1] + share * (values[above] - values[above - 1])


Array = NDArray[np.float64]
Rows = tuple[tuple[float, ...], ...]
_NO_NONLINEARITY = InputNonlinearity()


class StateSpaceState:
    """State z = [x; v] (n + m,), with the input v after the nonlinearity; `held` is the input before it."""

    __slots__ = ("held", "z")

    def __init__(self, z: Array) -> None:
        self.z = z
        self.held: Value | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class StateSpace(PlantToControl):
    """A linear system x' = a x + b f(u), y = c x + d f(u) + output_offset, Hammerstein with `recruitment`.

    Exact at any instant under zero-order hold or, with `grid_rate`, a plant of fixed steps that latches u at
    the ticks of its grid, each with the exact period. Input `u` and output `y` are vectors, or a float if
    there is only one, which a block reads as a vector of one. With `recruitment` the input is `stimulation`
    (m, 2), A and s, and u is the recruited fraction of each muscle: with the parameters of a file written by
    `fesloop identify` that patient becomes a plant (the delay belongs to a wire).

    Attributes
    ----------
    a, b, c, d: rows, (n, n), (n, m), (p, n), (p, m), time in s; an empty d is zero.
    initial_state: (n,), output_offset: (p,); zero if empty.
    nonlinearity: f, applied to each input.
    recruitment: curves of the m muscles.
    grid_rate: rate of fixed steps in hertz, such as "1000"; None for an exact plant.
    input_unit, output_unit: units of the ports.
    """

    a: Rows
    b: Rows
    c: Rows
    d: Rows = ()
    initial_state: tuple[float, ...] = ()
    output_offset: tuple[float, ...] = ()
    nonlinearity: InputNonlinearity = _NO_NONLINEARITY
    recruitment: Recruitment | None = None
    grid_rate: str | None = None
    input_unit: str = "1"
    output_unit: str = "1"
    _system: HeldLinearSystem = field(init=False, repr=False, compare=False)
    _grid: RateClock | None = field(init=False, repr=False, compare=False)
    _step_t: Array = field(init=False, repr=False, compare=False)
    _feedthrough: bool = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        states = len(self.a)
        inputs = len(self.b[0]) if self.b else 0
        outputs = len(self.c)
        if not (states and inputs and outputs):
            raise InputError("state_space", f"{states} states, {inputs} inputs, {outputs} outputs",
                             "one or more of each")
        require_shape("state_space", self, (states, states), "states by states", "a")
        require_shape("state_space", self, (states, inputs), "states (rows of a) by inputs", "b")
        require_shape("state_space", self, (outputs, states), "outputs by states (rows of a)", "c")
        for key, shape, meaning in (("d", (outputs, inputs), "outputs by inputs"),
                                    ("initial_state", (states,), "one a state"),
                                    ("output_offset", (outputs,), "one an output")):
            if getattr(self, key):
                require_shape("state_space", self, shape, f"{meaning}, or left out", key)
        if self.recruitment is not None and self.recruitment.muscles != inputs:
            raise InputError("state_space.recruitment", f"{self.recruitment.muscles} muscles",
                             f"{inputs}, as b has columns")
        d = np.array(self.d, dtype=np.float64) if self.d else np.zeros((outputs, inputs))
        offset = np.array(self.output_offset or (0.0,) * outputs, dtype=np.float64)
        a, b, c = (np.array(rows, dtype=np.float64) for rows in (self.a, self.b, self.c))
        system = HeldLinearSystem(a, b, c, d, offset)
        rate = self.grid_rate
        grid = None if rate is None else RateClock.from_rate(rate, where="state_space.grid_rate")
        object.__setattr__(self, "_system", system)
        object.__setattr__(self, "_grid", grid)
        object.__setattr__(self, "_step_t", system.step_matrix(0.0 if grid is None else grid.period_s))
        object.__setattr__(self, "_feedthrough", bool(d.any()))

    @classmethod
    def from_control(cls, system: control.StateSpace, **parameters: Any) -> Self:
        """Make a plant of a continuous-time `control.StateSpace`; `parameters` are the other attributes.

        Raises InputError for a discrete-time system and for objects without A, B, C, D.
        """
        a, b, c, d = (_rows(each) for each in continuous_matrices("state_space", system))
        return cls(a=a, b=b, c=c, d=d, **parameters)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Port `u`, or `stimulation`."""
        count = len(self.b[0])
        if self.recruitment is not None:
            return (Port("stimulation", (count, 2), "A,s"),)
        return (Port("u", () if count == 1 else (count,), self.input_unit),)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Port `y`."""
        count = len(self.c)
        return (Port("y", () if count == 1 else (count,), self.output_unit),)

    @property
    def grid(self) -> RateClock | None:
        """Clock of the fixed steps, None for an exact plant."""
        return self._grid

    @property
    def feedthrough(self) -> bool:
        """Whether d is not zero."""
        return self._feedthrough

    def init(self, context: Context) -> StateSpaceState:
        """The initial state, before the first input."""
        z = np.zeros(len(self.a) + len(self.b[0]))
        if self.initial_state:
            z[: len(self.a)] = self.initial_state
        return StateSpaceState(z)

    def advance(self, state: StateSpaceState, inputs: Sequence[Value], start_ns: int, stop_ns: int) -> None:
        """Advance exactly, or by one grid step."""
        if inputs[0] is not state.held:
            state.z, state.held = self._under(state.z, inputs[0]), inputs[0]
        if self._grid is not None:
            step_held(self._step_t, state.z)
        else:
            self._system.advance(state.z, stop_ns - start_ns)

    def read(self, state: StateSpaceState, inputs: Sequence[Value]) -> tuple[Value, ...]:
        """The output (y,)."""
        z = state.z
        if self._feedthrough and inputs[0] is not state.held:
            z = self._under(z, inputs[0])
        if len(self.c) == 1:
            return (self._system.read_first(z),)
        return (self._system.read(z),)

    def observe(
        self, state: StateSpaceState, inputs: Sequence[Value], start_ns: int, times_ns: Sequence[int]
    ) -> tuple[Array, ...]:
        """Output (y,) of an exact plant at `times_ns`, ascending; the state is not changed."""
        z = state.z if inputs[0] is state.held else self._under(state.z, inputs[0])
        rows = np.empty((len(times_ns), len(self.c)))
        self._system.read_ahead(z, start_ns, np.array(times_ns, dtype=np.int64), rows)
        return (rows[:, 0] if len(self.c) == 1 else rows,)

    def _under(self, z: Array, value: Value) -> Array:
        """A copy of z under another input."""
        copy, states = z.copy(), len(self.a)
        if self.recruitment is not None:
            value = self.recruitment.fraction(cast(Array, value))
        given = (value,) if isinstance(value, float) else value
        for i, number in enumerate(given):
            copy[states + i] = self.nonlinearity.apply(float(number))
        return copy

    def linear_model(self, outputs: Literal["y"] = "y") -> LinearModel:
        """Model for controllers: the linear part after recruitment, without the nonlinearity.

        Raises InputError if d is not zero, as a LinearModel has no direct feedthrough.
        """
        if self._feedthrough:
            raise InputError("state_space.d", "a direct feedthrough", "zero, for a linear model")
        system = self._system
        return LinearModel(a=system.a, b=system.b, c=system.c, offset=system.offset,
                           recruitment=self.recruitment)

    def linear_form(self, output: Literal["y"]) -> ContinuousForm:
        """The linear part after recruitment."""
        for key, found in (("nonlinearity", self.nonlinearity.kind), ("grid_rate", self.grid_rate)):
            if found not in ("none", None):
                raise uncovered(key, f"{found}", "none")
        return ContinuousForm.of(self.linear_model(), self.inputs[0].name, output)


def _rows(matrix: Any) -> Rows:
    """A matrix as nested tuples."""
    return tuple(tuple(float(value) for value in row) for row in np.asarray(matrix))
