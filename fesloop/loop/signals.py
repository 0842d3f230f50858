"""Ports, the samples with stamps that travel between them, and checks of outputs: shapes and finite numbers.

NaN passes where a port declares gaps: there it is a lost sample. Outputs of a block are checked at every tick
and copied: whatever the block does to its arrays later, what it sent stays as it was.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, RunError
from fesloop.loop.clock import FOREVER

Value = float | NDArray[np.float64]
"""A float on a scalar port, on any other a float64 array that is never written to again."""

NEVER = -1
"""Stamp of the initial value of a port, before any message has arrived."""


@dataclass(frozen=True, slots=True)
class Sensors:
    """The sensors that the rows of a signal belong to.

    Attributes
    ----------
    names: one a row, all different.
    pairs: (parent, child) rows of sensors on neighbouring segments; empty where it is not known.
    """

    names: tuple[str, ...]
    pairs: tuple[tuple[int, int], ...] = ()

    def __post_init__(self) -> None:
        for name in self.names:
            if self.names.count(name) > 1:
                raise InputError("sensors", f"{self.names.count(name)} sensors are named {name!r}",
                                 "different names")
        require_pairs(self.pairs, self.names, "pairs")

    def pair_name(self, pair: tuple[int, int]) -> str:
        """"parent-child"."""
        return f"{self.names[pair[0]]}-{self.names[pair[1]]}"


def require_pairs(pairs: Sequence[tuple[int, int]], names: Sequence[str], where: str) -> None:
    """Raise InputError for (parent, child) numbers of sensors that do not exist, listed twice, or in a loop.

    A child may have several parents: the nearest, and others further towards the root.
    """
    parents: dict[int, set[int]] = {}
    for parent, child in pairs:
        if not (0 <= parent < len(names) and 0 <= child < len(names)):
            raise InputError(where, f"[{parent}, {child}] names a sensor that does not exist",
                             f"0 to {len(names) - 1}")
        named = f"{names[parent]!r} and {names[child]!r}"
        if parent == child:
            raise InputError(where, f"{names[parent]!r} is paired with itself", "two different sensors")
        if parent in parents.get(child, ()):
            raise InputError(where, f"{named} are listed twice", "each pair once")
        above, seen = [parent], {parent}
        while above:
            further = parents.get(above.pop(), set()) - seen
            seen |= further
            above += further
        if child in seen:
            raise InputError(where, f"{named} close a loop", "(parent, child), parents towards the root",
                             "remove a pair, or swap its two names")
        parents.setdefault(child, set()).add(parent)


@dataclass(frozen=True, slots=True)
class Port:
    """One input or output of a block or plant.

    Attributes
    ----------
    name: as wires name it.
    shape: () for a float; None is a size that the source of the wire decides.
    unit: SI, as text ("rad", "m/s^2"; "1" for a ratio); a wire joins equal units only.
    initial: what an input reads before its first message, and what an output gives in place of a
        non-finite value (its safe output); a float fills the shape.
    optional: an input that may be left without a wire; it then reads `initial` for ever.
    gaps: an output that may contain NaN, where the sample of one sensor of several was lost. Infinite values
        are replaced as everywhere.
    every: an input that must read each message, such as pulses: its block must step as often as its source
        sends them, and the effect of a pulse lasts until the next of its train.
    sensors: of an output, the sensors that its rows are samples of; blocks that are wired to it receive
        them (`with_sensors`).
    rows: of an output, names of its rows, such as joints; empty: those of `sensors`, or numbers.
    """

    name: str
    shape: tuple[int | None, ...] = ()
    unit: str = "1"
    initial: float | tuple[float, ...] = 0.0
    optional: bool = False
    gaps: bool = False
    every: bool = False
    sensors: Sensors | None = None
    rows: tuple[str, ...] = ()

    @property
    def row_names(self) -> tuple[str, ...]:
        """Names of the rows, as far as they are stated; empty where they are not."""
        return self.rows or (self.sensors.names if self.sensors is not None else ())

    @property
    def resolved(self) -> bool:
        """True if every size is known."""
        return None not in self.shape

    def initial_value(self) -> Value:
        """The initial value in the port's shape."""
        if self.shape == ():
            return float(np.asarray(self.initial).reshape(()))
        sizes = tuple(size for size in self.shape if size is not None)
        value = np.broadcast_to(np.asarray(self.initial, dtype=np.float64), sizes).copy()
        value.flags.writeable = False
        return value


class Sample(NamedTuple):
    """A value on a wire with its stamps, all ns.

    `oldest_ns` and `newest_ns` are the physical instants of the oldest and the newest capture that the
    value derives from, through any number of blocks; `arrived_ns` is when it reached this port.
    Before the first message all three are NEVER.
    """

    value: Value
    oldest_ns: int
    newest_ns: int
    arrived_ns: int

    @property
    def present(self) -> bool:
        """True once a message has arrived."""
        return self.arrived_ns >= 0

    def age_ns(self, now_ns: int) -> int:
        """Time since the oldest capture behind this value; FOREVER before the first message.

        A value without a capture is older than any limit.
        """
        return now_ns - self.oldest_ns if self.arrived_ns >= 0 else FOREVER


_FLOAT64 = np.dtype(np.float64)
_OURS = ("fesloop", "plants", "estimators", "controllers")


def is_ours(part: object) -> bool:
    """True if a block or plant is of this library.

    Its own parts keep the contract, and are spared what makes sure that others do: Numba would compile their
    functions anew for arrays that cannot be written to.
    """
    return type(getattr(part, "__wrapped__", part)).__module__.partition(".")[0] in _OURS


def read_only(value: Value) -> Value:
    """The value, an array as a view that cannot be written to: the record and other readers have it, too."""
    if not isinstance(value, np.ndarray) or not value.flags.writeable:
        return value
    view = value.view()
    view.flags.writeable = False
    return view


def is_finite(value: Value) -> bool:
    """True if every number is finite; the sum of squares is the quick test."""
    if isinstance(value, float):
        return isfinite(value)
    return isfinite(np.vdot(value, value)) or bool(np.isfinite(value).all())


def finite_check(port: Port) -> Callable[[Any], bool]:
    """The quickest `is_finite` for the values of a port; NaN is allowed where the port declares gaps."""
    if port.gaps:
        return _is_finite_but_for_gaps
    if port.shape == ():
        return isfinite
    return _is_finite_vector if len(port.shape) == 1 else is_finite


def _is_finite_vector(value: NDArray[np.float64]) -> bool:
    return isfinite(value.dot(value)) or bool(np.isfinite(value).all())


def _is_finite_but_for_gaps(value: Value) -> bool:
    return is_finite(value) or not bool(np.isinf(value).any())


def check_shapes(name: str, ports: Sequence[Port], values: Sequence[Value]) -> None:
    """Raise RunError where the values are not what the ports declare."""
    if not isinstance(values, tuple):
        raise RunError(f"{name}: put out {type(values).__name__}, declared is a tuple of {len(ports)}, "
                       "a value for each output port")
    if len(values) != len(ports):
        raise RunError(f"{name}: put out {len(values)} values for its {len(ports)} output ports")
    for port, value in zip(ports, values, strict=True):
        if port.shape == ():
            if not isinstance(value, float):
                raise RunError(f"{name}.{port.name}: put out {type(value).__name__}, declared is a float")
        elif not isinstance(value, np.ndarray) or value.shape != port.shape or value.dtype != np.float64:
            found = f"{value.dtype} {value.shape}" if isinstance(value, np.ndarray) else type(value).__name__
            raise RunError(f"{name}.{port.name}: put out {found}, declared is float64 {port.shape}")


def require_stacks(name: str, ports: Sequence[Port], stacks: Any, count: int) -> None:
    """Raise RunError where `stacks` are not outputs of `count` ticks, as the ports declare them."""
    if not isinstance(stacks, tuple) or len(stacks) != len(ports):
        found = f"{len(stacks)} stacks" if isinstance(stacks, tuple) else type(stacks).__name__
        raise RunError(f"{name}: put out {found} for {count} ticks, declared is a tuple of {len(ports)}, "
                       "a stack for each output port")
    for port, stack in zip(ports, stacks, strict=True):
        if port.shape == () and isinstance(stack, list):
            sound = len(stack) == count and all(isinstance(value, float) for value in stack)
        else:
            sound = (isinstance(stack, np.ndarray) and stack.dtype == _FLOAT64
                     and port.shape != () and stack.shape == (count, *port.shape))
        if not sound:
            size = f"{stack.dtype} {stack.shape}" if isinstance(stack, np.ndarray) else (
                f"{len(stack)} values" if isinstance(stack, list) else type(stack).__name__)
            raise RunError(f"{name}.{port.name}: put out {size} for {count} ticks, declared is "
                           + (f"a list of {count} floats" if port.shape == () else
                              f"float64 {(count, *port.shape)}"))


class Outputs:
    """Outputs of a block, copied at each tick.

    A block may write to its arrays again. One that is put out again with the same content stays the same
    copy, so that readers need no comparison to see that nothing has changed.
    """

    __slots__ = ("_arrays", "_given", "_name", "_ports", "_taken", "_types")

    def __init__(self, name: str, ports: Sequence[Port]) -> None:
        self._name, self._ports = name, tuple(ports)
        self._types = [float if port.shape == () else np.ndarray for port in self._ports]
        self._arrays = [(number, port.shape) for number, port in enumerate(self._ports) if port.shape != ()]
        self._given: Sequence[Any] = (None,) * len(self._ports)
        self._taken: Sequence[Any] = self._given

    def take(self, values: tuple[Value, ...]) -> tuple[Value, ...]:
        """The values, arrays as copies; () if the block puts out nothing at this tick.

        Raises RunError where they are not what the ports declare.
        """
        if type(values) is not tuple or [*map(type, values)] != self._types:
            if type(values) is tuple and not values:
                return ()
            check_shapes(self._name, self._ports, values)
        if not self._arrays:
            return values
        taken: list[Any] = [*values]
        for number, shape in self._arrays:
            value: Any = values[number]
            dtype = value.dtype
            # Arrays that numba or MuJoCo made have an equal type that is another object.
            if value.shape != shape or (dtype is not _FLOAT64 and dtype != _FLOAT64):
                check_shapes(self._name, self._ports, values)
            before = self._taken[number]
            same = value is self._given[number] and value.tobytes() == before.tobytes()
            taken[number] = before if same else value.copy()
        self._given, self._taken = values, taken
        return tuple(taken)

    @property
    def newest(self) -> Sequence[Any]:
        """Values taken last; None for each before the first."""
        return self._taken

    def save(self) -> Any:
        """Return everything that changes, for a snapshot."""
        return self._given, self._taken

    def restore(self, saved: Any) -> None:
        """Restore what `save` returned."""
        self._given, self._taken = saved
