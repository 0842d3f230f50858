"""No bad number travels: what blocks and plants put out is checked for its shape and for finiteness.

NaN passes where a port declares gaps: there it is a lost sample, not a bad number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import RunError
from fesloop.loop.signals import Port, Value


def is_finite(value: Value) -> bool:
    """Whether every number is finite. The sum of squares is the quick way to know that all are."""
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
