"""Values of several FMU variables as one vector, exchanged without allocation."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import RunError
from plants.fmu.description import FmuVariable
from plants.fmu.library import FmuLibrary

_FMI2: dict[str, tuple[str, type[Any]]] = {
    "Real": ("Real", np.float64), "Integer": ("Integer", np.int32), "Enumeration": ("Integer", np.int32),
    "Boolean": ("Boolean", np.int32)}
_FMI3: dict[str, tuple[str, type[Any]]] = {
    "Float64": ("Float64", np.float64), "Float32": ("Float32", np.float32), "Int8": ("Int8", np.int8),
    "UInt8": ("UInt8", np.uint8), "Int16": ("Int16", np.int16), "UInt16": ("UInt16", np.uint16),
    "Int32": ("Int32", np.int32), "UInt32": ("UInt32", np.uint32), "Int64": ("Int64", np.int64),
    "UInt64": ("UInt64", np.uint64), "Enumeration": ("Int64", np.int64), "Boolean": ("Boolean", np.bool_)}


def integer_range(version: int, kind: str) -> tuple[int, int] | None:
    """Lowest and highest value of an FMU's integer type; None of another type."""
    dtype = (_FMI2 if version == 2 else _FMI3).get(kind, ("", np.float64))[1]
    if kind == "Boolean" or np.dtype(dtype).kind not in "iu":
        return None
    return int(np.iinfo(dtype).min), int(np.iinfo(dtype).max)


class _Group:
    """The variables of one C type: references and buffer made once, the C functions looked up once."""

    __slots__ = ("arguments", "boolean", "buffer", "getter", "names", "places", "references", "setter")

    def __init__(self, library: FmuLibrary, kind: str, dtype: type[Any],
                 variables: list[tuple[int, FmuVariable]], values: NDArray[np.float64]) -> None:
        prefix, dll = f"fmi{library.version}", library.functions.dll
        self.names = f"{prefix}Get{kind}", f"{prefix}Set{kind}"
        self.getter, self.setter = (getattr(dll, name) for name in self.names)
        self.boolean = kind == "Boolean"
        self.references = (ctypes.c_uint * len(variables))(*(v.reference for _, v in variables))
        self.places = np.concatenate([np.arange(start, start + v.size) for start, v in variables])
        whole = dtype is np.float64 and self.places.size == values.size
        self.buffer: NDArray[Any] | None = None if whole else np.zeros(self.places.size, dtype)
        target = values if self.buffer is None else self.buffer
        pointer = target.ctypes.data_as(self.setter.argtypes[3])
        count = (target.size,) if library.version == 3 else ()
        self.arguments = (library.component, self.references, len(variables), pointer, *count)


def as_type(values: NDArray[np.float64], dtype: np.dtype[Any], boolean: bool) -> NDArray[Any]:
    """Values as an FMU's type has them; OverflowError for one that no integer of that type is near."""
    if boolean:
        return values > 0.5
    if dtype.kind == "f":
        return values
    rounded, limits = np.rint(values), np.iinfo(dtype)
    # Compared as floats, the highest integer of 64 bits is rounded up, out of the type.
    fits = (rounded >= float(limits.min)) & (rounded < float(limits.max + 1))
    if not fits.all():
        raise OverflowError(f"is {values[~fits][0]:g}, which does not fit its type ({dtype})")
    return rounded


class FmuVector:
    """A flat vector of the values of variables, in their order; (elements,), float64.

    An integer is rounded to, a boolean is true above 0.5.
    """

    __slots__ = ("_groups", "_library", "values")

    def __init__(self, library: FmuLibrary, variables: Sequence[FmuVariable]) -> None:
        self._library = library
        kinds = _FMI2 if library.version == 2 else _FMI3
        self.values: NDArray[np.float64] = np.zeros(sum(v.size for v in variables))
        by_kind: dict[tuple[str, type[Any]], list[tuple[int, FmuVariable]]] = {}
        start = 0
        for variable in variables:
            by_kind.setdefault(kinds[variable.type], []).append((start, variable))
            start += variable.size
        self._groups = [_Group(library, kind, dtype, members, self.values)
                        for (kind, dtype), members in by_kind.items()]

    def push(self, time_s: float) -> None:
        """Give the values to the FMU; RunError where it refuses."""
        for group in self._groups:
            buffer = group.buffer
            if buffer is not None:
                try:
                    buffer[:] = as_type(self.values[group.places], buffer.dtype, group.boolean)
                except OverflowError as fault:
                    raise RunError(f"{self._library.name}: an input at {time_s:.9g} s {fault}") from None
            status = group.setter(*group.arguments)
            if status:
                self._library.check(group.names[1], status, time_s)

    def pull(self, time_s: float) -> None:
        """Take the values from the FMU; RunError where it refuses."""
        for group in self._groups:
            status = group.getter(*group.arguments)
            if status:
                self._library.check(group.names[0], status, time_s)
            if group.buffer is not None:
                self.values[group.places] = group.buffer
