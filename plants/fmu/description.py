"""Model descriptions of FMUs: the part of modelDescription.xml that running an FMU needs, and its units."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal
from xml.etree import ElementTree

from fesloop.errors import InputError

POWERS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True, slots=True)
class BaseUnit:
    """A unit in SI base units: a value in them is `factor` times the value in this unit, plus `offset`.

    Attributes
    ----------
    powers: exponent of each of POWERS. FMI counts rad as a base unit, so rad/s is not Hz.
    """

    powers: tuple[int, ...]
    factor: float = 1.0
    offset: float = 0.0

    def like(self, other: BaseUnit) -> BaseUnit:
        """This unit, with the exponent of rad and the zero of another unit of the same name.

        Many tools omit rad in definitions, and a difference of temperatures has no offset.
        """
        rad = (*self.powers[:-1], other.powers[-1])
        return replace(self, powers=rad, offset=self.offset if other.offset else 0.0)

    def to(self, other: BaseUnit) -> tuple[float, float] | None:
        """Scale and offset from a value in this unit to one in another; None for another quantity."""
        if self.powers != other.powers or other.factor == 0.0:
            return None
        found = self.factor / other.factor, (self.offset - other.offset) / other.factor
        return found if found[0] != 0.0 and all(map(math.isfinite, found)) else None


def _base(factor: float = 1.0, offset: float = 0.0, **powers: int) -> BaseUnit:
    return BaseUnit(tuple(powers.get(name, 0) for name in POWERS), factor, offset)


_ATOMS = {
    "1": _base(), "%": _base(0.01), "rad": _base(rad=1), "deg": _base(math.pi / 180.0, rad=1),
    "s": _base(s=1), "ms": _base(1e-3, s=1), "us": _base(1e-6, s=1), "min": _base(60.0, s=1),
    "Hz": _base(s=-1),
    "m": _base(m=1), "mm": _base(1e-3, m=1), "cm": _base(1e-2, m=1), "kg": _base(kg=1),
    "A": _base(A=1), "mA": _base(1e-3, A=1), "C": _base(A=1, s=1), "uC": _base(1e-6, A=1, s=1),
    "V": _base(kg=1, m=2, s=-3, A=-1), "mV": _base(1e-3, kg=1, m=2, s=-3, A=-1), "T": _base(kg=1, s=-2, A=-1),
    "N": _base(kg=1, m=1, s=-2), "J": _base(kg=1, m=2, s=-2), "W": _base(kg=1, m=2, s=-3),
    "Pa": _base(kg=1, m=-1, s=-2), "K": _base(K=1), "degC": _base(1.0, 273.15, K=1)}
_POWER = re.compile(r"([A-Za-z]+|1|%)(?:\^(-?[1-9]))?")


def unit_of(text: str) -> BaseUnit | None:
    """Parse a port's unit, such as "rad/s^2" or "N m"; None if it is unknown."""
    if text in _ATOMS:
        return _ATOMS[text]
    unit = _base()
    for number, part in enumerate(text.split("/")):
        for piece in re.split(r"[ *.]+", part):
            match = _POWER.fullmatch(piece)
            atom = _ATOMS.get(match[1]) if match else None
            if match is None or atom is None or atom.offset:
                return None
            power = int(match[2] or 1) * (-1 if number else 1)
            unit = replace(unit, factor=unit.factor * atom.factor**power,
                           powers=tuple(a + power * b for a, b in zip(unit.powers, atom.powers, strict=True)))
    return unit


Interface = Literal["co_simulation", "model_exchange"]
SUPPORTED = "FMI 2.0 co-simulation, FMI 2.0 model exchange, FMI 3.0 co-simulation"
NUMERIC = ("Real", "Integer", "Boolean", "Enumeration", "Float64", "Float32", "Int8", "UInt8", "Int16",
           "UInt16", "Int32", "UInt32", "Int64", "UInt64")


@dataclass(frozen=True, slots=True)
class FmuVariable:
    """A variable of an FMU.

    Attributes
    ----------
    name, reference, type, causality, variability: as in FMI; type such as "Real" or "Float64".
    shape: () for a scalar, the dimensions of an FMI 3.0 array.
    unit: the FMU's name of the unit, or "". base: the FMU's definition of that unit, or None.
    start: start value; for an array one for all elements or one for each, last index fastest; nan without a
        numeric start.
    low, high: `min` and `max`, infinite if not given.
    """

    name: str
    reference: int
    type: str
    causality: str
    variability: str
    shape: tuple[int, ...]
    unit: str
    start: float | tuple[float, ...]
    base: BaseUnit | None = None
    low: float = -math.inf
    high: float = math.inf

    @property
    def size(self) -> int:
        """Number of elements."""
        product = 1
        for length in self.shape:
            product *= length
        return product


@dataclass(frozen=True, slots=True)
class FmuDescription:
    """An FMU and the interface of it that is used.

    Attributes
    ----------
    version: version of FMI, 2 or 3.
    interface: co-simulation or model exchange.
    identifier: name of the shared library. token: GUID (FMI 2) or instantiation token (FMI 3).
    variables: variables by name.
    states, indicators: numbers of continuous states and event indicators (model exchange).
    completes_steps: whether the FMU requires fmi2CompletedIntegratorStep.
    saves: whether the FMU declares that its state can be serialised.
    once: whether the FMU can be instantiated only once in a process.
    needs_tool: whether the FMU declares that it needs the program that made it.
    internal_step_s: fixed internal step, 0 if none is declared (FMI 3).
    has_sources: whether the archive contains C sources.
    preferred_step_s: communication step of its default experiment, 0 if none is declared.
    """

    version: int
    interface: Interface
    identifier: str
    token: str
    variables: dict[str, FmuVariable]
    states: int
    indicators: int
    completes_steps: bool
    saves: bool
    once: bool
    needs_tool: bool
    internal_step_s: float
    has_sources: bool
    preferred_step_s: float = 0.0


def read_description(folder: Path, path: Path, requested: Literal["auto"] | Interface) -> FmuDescription:
    """Read and check the description of an extracted FMU.

    Raises InputError for an invalid description, an unsupported FMI version or interface, or a missing
    binary for this platform.
    """
    model = _read_xml(folder, path)
    version = {"2.0": 2, "3.0": 3}.get(str(model.fmiVersion)[:3], 0)
    if version == 0:
        raise InputError("path", f"{path} has FMI version {model.fmiVersion}", SUPPORTED)
    available = [name for name, part in (("co_simulation", model.coSimulation),
                                         ("model_exchange", model.modelExchange if version == 2 else None))
                 if part is not None]
    if not available or requested not in ("auto", *available):
        found = f"{path} (FMI {model.fmiVersion}) has "
        if available:
            raise InputError("interface", f"{found}{', '.join(available)}, not {requested}", SUPPORTED)
        raise InputError("path", f"{found}no supported interface", SUPPORTED)
    exchange = "model_exchange" in (requested, available[0])
    interface: Interface = "model_exchange" if exchange else "co_simulation"
    part = model.modelExchange if exchange else model.coSimulation
    if not str(part.modelIdentifier).isidentifier():
        raise InputError("path", f"{path} has the modelIdentifier {part.modelIdentifier!r}", "a C identifier",
                         "do not use this file")
    sources = (folder / "sources").is_dir()
    relative = _relative(folder)
    units = {str(unit.name): _base_unit(unit.baseUnit) for unit in model.unitDefinitions if unit.baseUnit}
    _check_binary(folder, path, version, str(part.modelIdentifier), sources)
    return FmuDescription(
        version=version, interface=interface, identifier=str(part.modelIdentifier), token=str(model.guid),
        variables={v.name: _variable(v, units, v.name in relative) for v in model.modelVariables},
        states=len(model.derivatives), indicators=int(model.numberOfEventIndicators or 0),
        completes_steps=bool(getattr(part, "needsCompletedIntegratorStep", False)),
        saves=bool(part.canGetAndSetFMUstate and part.canSerializeFMUstate),
        once=bool(part.canBeInstantiatedOnlyOncePerProcess), needs_tool=bool(part.needsExecutionTool),
        internal_step_s=float(getattr(part, "fixedInternalStepSize", None) or 0.0),
        has_sources=sources,
        preferred_step_s=float(getattr(model.defaultExperiment, "stepSize", None) or 0.0))


def direct_dependencies(folder: Path, path: Path) -> dict[str, tuple[str, ...]] | None:
    """Inputs that each output depends on at the same instant, by name; None if any does not declare them.

    Raises InputError for an invalid description.
    """
    model = _read_xml(folder, path)
    found: dict[str, tuple[str, ...]] = {}
    for unknown in model.outputs:
        if unknown.dependencies is None:
            return None
        found[str(unknown.variable.name)] = tuple(
            str(each.name) for each in unknown.dependencies if each.causality == "input")
    return found


def _read_xml(folder: Path, path: Path) -> Any:
    """Read the description with FMPy."""
    from fmpy.model_description import ValidationError, read_model_description

    try:
        return read_model_description(str(folder))
    except ValidationError as fault:
        problem = str(fault.problems[0]) if fault.problems else "no reason given"
        raise InputError("path", f"modelDescription.xml of {path} is invalid: {problem}", "valid FMI",
                         "have the FMU's maker export it again") from None
    except Exception as fault:  # noqa: BLE001 - FMPy and lxml raise whatever a malformed description provokes
        raise InputError("path", f"modelDescription.xml of {path} cannot be read: {fault}", "valid FMI",
                         "have the FMU's maker export it again") from None


def _check_binary(folder: Path, path: Path, version: int, identifier: str, sources: bool) -> None:
    """Raise InputError if the library for this platform is missing, naming the platforms present."""
    import fmpy

    ours = fmpy.platform if version == 2 else fmpy.platform_tuple
    if (folder / "binaries" / ours / (identifier + fmpy.sharedLibraryExtension)).is_file():
        return
    present = sorted(entry.name for entry in folder.glob("binaries/*"))
    remedy = (f"compile its C sources: `fmpy compile {path}` (needs cmake and a compiler)"
              if sources else "export it for this platform")
    found = ", ".join(present) or "none"
    raise InputError("path", f"{path} contains no binary for {ours}; it contains {found}",
                     f"binaries/{ours}/{identifier}{fmpy.sharedLibraryExtension}", remedy)


def _base_unit(base: Any) -> BaseUnit:
    """Convert FMPy's definition of a unit."""
    powers = tuple(int(getattr(base, name)) for name in POWERS)
    return BaseUnit(powers, float(base.factor), float(base.offset))


def _relative(folder: Path) -> set[str]:
    """Names of variables declared as relative quantities, an attribute that FMPy ignores."""
    variables = ElementTree.parse(folder / "modelDescription.xml").getroot().find("ModelVariables")
    return {str(variable.get("name")) for variable in (variables if variables is not None else ())
            if any(each.get("relativeQuantity") in ("true", "1") for each in (variable, *variable))}


def _variable(variable: Any, units: Mapping[str, BaseUnit], relative: bool) -> FmuVariable:
    declared = variable.declaredType
    unit = str(variable.unit or (declared.unit if declared is not None else None) or "")
    base = units.get(unit)
    if base is not None and (relative or getattr(declared, "relativeQuantity", False)):
        base = replace(base, offset=0.0)  # a difference of temperatures has no zero of its own
    shape = tuple(int(n) for n in variable.shape or ())
    return FmuVariable(
        variable.name, int(variable.valueReference), str(variable.type), str(variable.causality),
        str(variable.variability), shape, unit, _start(variable, math.prod(shape)), base,
        _limit(variable.min, getattr(declared, "min", None), -math.inf),
        _limit(variable.max, getattr(declared, "max", None), math.inf))


def _start(variable: Any, size: int) -> float | tuple[float, ...]:
    """Start value; an array has one for all elements, or one for each, separated by blanks.

    Raises InputError for an array of numbers with another number of them.
    """
    words = str(variable.start).split() if variable.start is not None and variable.type in NUMERIC else []
    try:
        starts = tuple(float({"true": "1", "false": "0"}.get(word, word)) for word in words)
    except ValueError:
        return math.nan
    if len(starts) not in (0, 1, size):
        raise InputError("path", f"modelDescription.xml gives {len(starts)} start values for the {size} "
                         f"elements of {variable.name!r}", f"1 or {size}",
                         "have the FMU's maker export it again")
    return starts if len(starts) > 1 else starts[0] if starts else math.nan


def _limit(own: str | None, of_type: str | None, none: float) -> float:
    """Limit of a variable, or else of its type; `none` without a numeric one."""
    try:
        limit = float(own if own is not None else of_type if of_type is not None else none)
    except ValueError:
        return none
    return none if math.isnan(limit) else limit
