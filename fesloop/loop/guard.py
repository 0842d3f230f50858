"""Checks of outputs: shapes and finite numbers.

NaN passes where a port declares gaps: there it is a lost sample. Outputs of a block are checked at every tick
and copied: whatever the block does to its arrays later, what it sent stays as it was.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import RunError
from fesloop.loop.signals import Port, Value

_FLOAT64 = np.dtype(np.float64)


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
            if value.shape != shape or value.dtype is not _FLOAT64:
                check_shapes(self._name, self._ports, values)
            before = self._taken[number]
            same = value is self._given[number] and value.tobytes() == before.tobytes()
            taken[number] = before if same else value.copy()
        self._given, self._taken = values, taken
        return tuple(taken)

    def save(self) -> Any:
        """All that changes, for a snapshot."""
        return self._given, self._taken

    def restore(self, saved: Any) -> None:
        """Back to what `save` gave."""
        self._given, self._taken = saved
