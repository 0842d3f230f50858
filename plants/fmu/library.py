"""An FMU's code in this process: loaded, instantiated, initialised, heard, ended."""

from __future__ import annotations

import ctypes
import itertools
import re
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fmpy import calloc, fmi2, fmi3, free
from fmpy.fmi1 import FMICallException
from fmpy.logging import addLoggerProxy

from fesloop.errors import RunError
from plants.fmu.description import FmuDescription

Scalar = float | int | bool | str
StartValue = Scalar | tuple[float | int | bool, ...]
WARNING, ERROR, FATAL = 1, 3, 4
STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
MOST_KINDS, LONGEST = 8, 300
"""Chosen: how many kinds of messages of an instance are kept, and how many characters of each."""
_NUMBER = re.compile(r"[-+]?[0-9][0-9.]*(?:[eE][-+]?[0-9]+)?")
_INTEGERS = ("Integer", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")


class NotInstantiatedError(RunError):
    """An FMU's library did not load, or refused to be instantiated."""


class FmuLog:
    """What one instance says.

    Attributes
    ----------
    last: its latest messages, for the reason of a failure.
    fresh: those that nobody has taken, the first of each kind; kinds differ in more than numbers.
    heard: whether there was any since `check` looked.
    """

    __slots__ = ("_kinds", "fresh", "heard", "last")

    def __init__(self) -> None:
        self.last: deque[str] = deque(maxlen=4)
        self.fresh: list[str] = []
        self.heard = False
        self._kinds: set[str] = set()

    def hear(self, message: str) -> None:
        """Take in a message of a warning or worse."""
        text = " ".join(message.split())
        self.last.append(text)
        self.heard = True
        self.note(text)

    def note(self, text: str) -> None:
        """Keep a text of a new kind until it is taken; of very many kinds the first."""
        kind = _NUMBER.sub("0", text)
        if kind in self._kinds or len(self._kinds) > MOST_KINDS:
            return
        self._kinds.add(kind)
        full = len(self._kinds) > MOST_KINDS
        self.fresh.append("more messages, which are left out" if full else text[:LONGEST])


# FMPy's proxy, which formats an FMU's printf-like messages, forwards all of them to the one callback that
# was registered last in the process. So there is one callback for ever, and it finds the instance that a
# message is from by the environment pointer that the instance was given.
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
    description: of the FMU. folder: where it is extracted. name: of the node, for messages.

    Attributes
    ----------
    functions: FMPy's object; its `dll` holds the C functions with their types declared.
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
        """Set start values, and go through initialisation at time 0."""
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
        """Note what a C function returned if it is a warning without a message; `fail` for anything worse."""
        if status > WARNING or status < 0:
            self.fail(function, status, time_s)
        heard, self._log.heard = self._log.heard, False
        if not heard:
            self._log.note(f"{function} returned fmi{self.version}Warning at {time_s:.9g} s")

    def take_messages(self) -> list[str]:
        """Messages since the last call, of warnings and worse, the first of each kind."""
        fresh, self._log.fresh = self._log.fresh, []
        return fresh

    def fail(self, function: str, status: int, time_s: float) -> None:
        """Raise RunError for what a C function returned, with the FMU's own last words."""
        self._worst = max(self._worst, status)
        label = f"fmi{self.version}{STATUS[status]}" if 0 <= status < len(STATUS) else str(status)
        reason = self._reasons("it gave no message")
        raise RunError(f"{self.name}: {function} returned {label} at {time_s:.9g} s: {reason}")

    def _reasons(self, otherwise: str) -> str:
        said = " ".join("; ".join(self._log.last).split()) or otherwise
        return said + (" (it declares that it needs the program that made it)" if self._needs_tool else "")

    def end(self) -> None:
        """Terminate and free the instance, as far as FMI allows after what it last returned."""
        if _LOGS.pop(self._number, None) is None or self._worst >= FATAL:
            return
        try:
            if self._worst < ERROR:
                self.functions.terminate()
        except FMICallException:
            self._worst = ERROR
        self.functions.freeInstance()
