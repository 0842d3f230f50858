"""An FMU's native code in this process: its instance, its messages, and vectors of its variables."""

from __future__ import annotations

import ctypes
import itertools
import re
from collections import deque
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import calloc, fmi2, fmi3, free
from fmpy.fmi1 import FMICallException
from fmpy.logging import addLoggerProxy
from numpy.typing import NDArray

from fesloop.errors import RunError
from plants.fmu.description import FmuDescription, FmuVariable

Scalar = float | int | bool | str
StartValue = Scalar | tuple[float | int | bool, ...]
WARNING, ERROR, FATAL = 1, 3, 4
STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
MOST_KINDS, LONGEST = 8, 300
"""Chosen: number of kinds of messages that are kept of an instance, and of characters of each."""
_NUMBER = re.compile(r"[-+]?[0-9][0-9.]*(?:[eE][-+]?[0-9]+)?")
_INTEGERS = ("Integer", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")


class NotInstantiatedError(RunError):
    """An FMU's library does not load, or refuses to be instantiated."""


class FmuLog:
    """Messages of one instance.

    Attributes
    ----------
    last: the latest messages, shown as the reason of a failure.
    fresh: messages not yet taken, the first of each kind; messages of one kind differ in numbers alone.
    heard: whether a message arrived since the last `check`.
    """

    __slots__ = ("_kinds", "fresh", "heard", "last")

    def __init__(self) -> None:
        self.last: deque[str] = deque(maxlen=4)
        self.fresh: list[str] = []
        self.heard = False
        self._kinds: set[str] = set()

    def hear(self, message: str) -> None:
        """Add a message of a warning or worse."""
        text = " ".join(message.split())
        self.last.append(text)
        self.heard = True
        self.note(text)

    def note(self, text: str) -> None:
        """Keep a text of a new kind until it is taken; at most MOST_KINDS kinds."""
        kind = _NUMBER.sub("0", text)
        if kind in self._kinds or len(self._kinds) > MOST_KINDS:
            return
        self._kinds.add(kind)
        full = len(self._kinds) > MOST_KINDS
        self.fresh.append("further messages are left out" if full else text[:LONGEST])


# FMPy's proxy, which formats an FMU's printf-like messages, forwards all of them to the callback that was
# registered last in the process. So a single callback serves all instances, and finds the sender of a message
# by the environment pointer that the instance received.
_LOGS: dict[int, FmuLog] = {}
_NUMBERS = itertools.count(1)


def _receive(
    environment: int | None, _name: bytes, status: int, _category: bytes, message: bytes | None
) -> None:
    log = _LOGS.get(environment or 0)
    if log is not None and message and status >= WARNING:
        log.hear(message.decode("utf-8", "replace"))


_LOGGER = fmi2.fmi2CallbackLoggerTYPE(_receive)
_ALLOCATE = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
_FREE = fmi2.fmi2CallbackFreeMemoryTYPE(free)


class FmuLibrary:
    """One instance of an FMU.

    Parameters
    ----------
    description: description of the FMU. folder: its extracted files. name: name of the node, for messages.

    Attributes
    ----------
    functions: FMPy's object; its `dll` has the C functions with declared types.
    component: the C instance.

    Raises
    ------
    NotInstantiatedError: if the library does not load or the FMU refuses to be instantiated.
    """

    def __init__(self, description: FmuDescription, folder: Path, name: str) -> None:
        self.name, self.version = name, description.version
        self._needs_tool = description.needs_tool
        self._number = next(_NUMBERS)
        self._log = FmuLog()
        self._worst = 0
        _LOGS[self._number] = self._log
        made = {(2, "co_simulation"): fmi2.FMU2Slave, (2, "model_exchange"): fmi2.FMU2Model,
                (3, "co_simulation"): fmi3.FMU3Slave}[description.version, description.interface]
        try:
            self.functions: Any = made(guid=description.token, modelIdentifier=description.identifier,
                                       unzipDirectory=str(folder), instanceName=name)
            self._instantiate()
        except Exception as fault:  # noqa: BLE001 - FMPy raises bare Exception, and ctypes its own
            _LOGS.pop(self._number)
            reason = self._reasons(str(fault))
            raise NotInstantiatedError(f"{name}: the FMU could not be instantiated: {reason}") from None
        self.component = ctypes.c_void_p(self.functions.component)

    def _instantiate(self) -> None:
        if self.version == 2:
            callbacks = fmi2.fmi2CallbackFunctions()
            callbacks.logger, callbacks.allocateMemory, callbacks.freeMemory = _LOGGER, _ALLOCATE, _FREE
            callbacks.componentEnvironment = self._number
            addLoggerProxy(ctypes.byref(callbacks))
            self.functions.instantiate(callbacks=callbacks, loggingOn=False)
        else:
            self.functions.instantiate(logMessage=self._receive_message)

    def _receive_message(
        self, _environment: Any, status: int, _category: bytes, message: bytes | None
    ) -> None:
        if message and status >= WARNING:
            self._log.hear(message.decode("utf-8", "replace"))

    def initialise(self, starts: Mapping[str, StartValue], description: FmuDescription) -> None:
        """Set start values and initialise at time 0."""
        try:
            for name, value in starts.items():
                self._set_start(description, name, value)
            if self.version == 2:
                self.functions.setupExperiment(startTime=0.0)
            self.functions.enterInitializationMode()
            self.functions.exitInitializationMode()
        except FMICallException as fault:
            self.fail(fault.function, fault.status, 0.0)

    def _set_start(self, description: FmuDescription, name: str, value: StartValue) -> None:
        variable = description.variables[name]
        kind = {"Enumeration": "Integer" if self.version == 2 else "Int64"}.get(variable.type, variable.type)
        convert = {"String": str, "Boolean": bool}.get(kind, int if kind in _INTEGERS else float)
        values = value if isinstance(value, tuple) else (value,)
        getattr(self.functions, f"set{kind}")([variable.reference], [convert(each) for each in values])

    def check(self, function: str, status: int, time_s: float) -> None:
        """Note a returned warning without a message; `fail` for anything worse."""
        if status > WARNING or status < 0:
            self.fail(function, status, time_s)
        heard, self._log.heard = self._log.heard, False
        if not heard:
            self._log.note(f"{function} returned fmi{self.version}Warning at {time_s:.9g} s")

    def take_messages(self) -> list[str]:
        """Messages of warnings and worse since the last call, the first of each kind."""
        fresh, self._log.fresh = self._log.fresh, []
        return fresh

    def fail(self, function: str, status: int, time_s: float) -> None:
        """Raise RunError for the status of a C function, with the FMU's last messages."""
        self._worst = max(self._worst, status)
        label = f"fmi{self.version}{STATUS[status]}" if 0 <= status < len(STATUS) else str(status)
        reason = self._reasons("it gave no message")
        raise RunError(f"{self.name}: {function} returned {label} at {time_s:.9g} s: {reason}")

    def _reasons(self, otherwise: str) -> str:
        said = " ".join("; ".join(self._log.last).split()) or otherwise
        return said + (" (it declares that it needs the program that made it)" if self._needs_tool else "")

    def end(self) -> None:
        """Terminate and free the instance, as far as FMI allows after its worst status."""
        if _LOGS.pop(self._number, None) is None or self._worst >= FATAL:
            return
        try:
            if self._worst < ERROR:
                self.functions.terminate()
        except FMICallException:
            self._worst = ERROR
        self.functions.freeInstance()


_FMI2: dict[str, tuple[str, type[Any]]] = {
    "Real": ("Real", np.float64), "Integer": ("Integer", np.int32), "Enumeration": ("Integer", np.int32),
    "Boolean": ("Boolean", np.int32)}
_FMI3: dict[str, tuple[str, type[Any]]] = {
    "Float64": ("Float64", np.float64), "Float32": ("Float32", np.float32), "Int8": ("Int8", np.int8),
    "UInt8": ("UInt8", np.uint8), "Int16": ("Int16", np.int16), "UInt16": ("UInt16", np.uint16),
    "Int32": ("Int32", np.int32), "UInt32": ("UInt32", np.uint32), "Int64": ("Int64", np.int64),
    "UInt64": ("UInt64", np.uint64), "Enumeration": ("Int64", np.int64), "Boolean": ("Boolean", np.bool_)}


def integer_range(version: int, kind: str) -> tuple[int, int] | None:
    """Lowest and highest value of an FMU's integer type; None for another type."""
    dtype = (_FMI2 if version == 2 else _FMI3).get(kind, ("", np.float64))[1]
    if kind == "Boolean" or np.dtype(dtype).kind not in "iu":
        return None
    return int(np.iinfo(dtype).min), int(np.iinfo(dtype).max)


class _Group:
    """Variables of one C type, with references, buffer and C functions prepared."""

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
    """Convert values to an FMU's type; OverflowError for a value beyond an integer type."""
    if boolean:
        return values > 0.5
    if dtype.kind == "f":
        return values
    rounded, limits = np.rint(values), np.iinfo(dtype)
    # As a float, the highest integer of 64 bits would be rounded up, beyond the type.
    fits = (rounded >= float(limits.min)) & (rounded < float(limits.max + 1))
    if not fits.all():
        raise OverflowError(f"is {values[~fits][0]:g}, which does not fit its type ({dtype})")
    return rounded


class FmuVector:
    """Values of variables as one flat vector (elements,), float64, in the order of the variables.

    Integers are rounded; a boolean is true above 0.5. Values are exchanged without allocation.
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
        """Write the values to the FMU; RunError if it refuses."""
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
        """Read the values from the FMU; RunError if it refuses."""
        for group in self._groups:
            status = group.getter(*group.arguments)
            if status:
                self._library.check(group.names[0], status, time_s)
            if group.buffer is not None:
                self.values[group.places] = group.buffer
