"""Ports of an FMU: declared, or formed from the names and dimensions of its variables."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.signals import Port
from plants.fmu.description import NUMERIC, FmuDescription, FmuVariable, unit_of

DIGITS = 1e-6
"""Chosen: units whose definitions differ by less are the same, written with fewer digits."""
_INDEXED = re.compile(r"(?P<base>.+)\[(?P<index>\d+(?:\s*,\s*\d+)*)\]")


@dataclass(frozen=True, slots=True, kw_only=True)
class FmuPort:
    """Declaration of a port made of an FMU's variables.

    Attributes
    ----------
    name: name of the port.
    variables: names of the FMU's variables, in the order of the port's elements (last index fastest).
    shape: shape of the port; () gives a vector for several variables, and a float for a single scalar one.
    unit: unit of the port, or one for each place of the last index ("A,s"); "" takes the variables' own.
    scale: ratio of the FMU's value to the port's, such as 57.29577951308232 for an FMU in degrees; one for
        all elements, or one for each place of the last index, such as [1e3, 1e6] for mA and us. Default: 1,
        or the ratio by the FMU's unit definitions if its units differ from the port's.
    offset: with a scale, what is added: the FMU's value is the port's times the scale, plus the offset.
    sampled: whether the values of an output port hold between samples of the FMU; holding values are then no
        sign of stale outputs.
    """

    name: str
    variables: tuple[str, ...]
    shape: tuple[int, ...] = ()
    unit: str = ""
    scale: float | tuple[float, ...] | None = None
    offset: float = 0.0
    sampled: bool = False


@dataclass(frozen=True, slots=True)
class BoundPort:
    """A port with its variables.

    Attributes
    ----------
    scales, offsets: one per element, flat: the FMU's value is the port's times the scale, plus the offset.
    sampled: as in `FmuPort`.
    """

    port: Port
    variables: tuple[FmuVariable, ...]
    scales: tuple[float, ...]
    offsets: tuple[float, ...]
    sampled: bool = False

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the port, which is always known."""
        return tuple(size for size in self.port.shape if size is not None)


def bind_ports(
    description: FmuDescription, causality: str, declared: Sequence[FmuPort], where: str,
    held: Sequence[str] = (),
) -> tuple[BoundPort, ...]:
    """Make ports for inputs or outputs of an FMU, but for variables that are `held` at their start values.

    If none are declared, each numeric variable becomes a port; `u[1]`, `u[2]`, ... or `m[1,1]`, `m[1,2]`, ...
    are joined into one array port `u` or `m`; a dot or bracket in a name becomes an underscore. If the units
    of a joined port differ by its last index, its unit lists them ("A,s").

    Raises InputError, naming `where`, for a variable that is missing, of another causality or not numeric,
    for a shape that does not fit the variables, for a unit that cannot be converted to the FMU's, for a
    variable that is listed twice, and for two ports of one name.
    """
    for i, each in enumerate(declared):
        if not isinstance(each, FmuPort):
            raise InputError(f"{where}[{i}]", f"is a {type(each).__name__}", "an FmuPort of plants.fmu",
                             "make one: FmuPort(name=..., variables=(...,))")
    if declared:
        ports = tuple(
            _declared(description, causality, each, f"{where}[{i}]") for i, each in enumerate(declared))
    else:
        free = [variable for variable in _numeric(description, causality) if variable.name not in held]
        ports = tuple(_automatic(free, where))
    names = [bound.port.name for bound in ports]
    for name in names:
        if names.count(name) > 1:
            raise InputError(where, f"two ports are named {name!r}", "unique names", f"declare {where}")
    set_by: dict[str, str] = {}
    for bound in ports if causality == "input" else ():
        for variable in bound.variables:
            if set_by.setdefault(variable.name, bound.port.name) != bound.port.name:
                raise InputError(where, f"{variable.name!r} is in {set_by[variable.name]!r} and in "
                                 f"{bound.port.name!r}", "each variable in one port", "remove one")
    return ports


def limits(ports: Sequence[BoundPort]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Min and max of each element, flat, in the FMU's units."""
    elements = [v for bound in ports for v in bound.variables for _ in range(v.size)]
    return np.array([v.low for v in elements]), np.array([v.high for v in elements])


def _numeric(description: FmuDescription, causality: str) -> list[FmuVariable]:
    return [v for v in description.variables.values() if v.causality == causality and v.type in NUMERIC]


def _declared(description: FmuDescription, causality: str, declared: FmuPort, where: str) -> BoundPort:
    allowed = [variable.name for variable in _numeric(description, causality)]
    for name in declared.variables:
        if name not in allowed:
            close = get_close_matches(name, allowed, 1)
            raise InputError(
                f"{where}.variables", f"the FMU has no numeric {causality} {name!r}",
                ", ".join(allowed[:20]) or "none", f"did you mean {close[0]!r}?" if close else "")
        if declared.variables.count(name) > 1:
            raise InputError(f"{where}.variables", f"{name!r} is listed twice", "each variable once",
                             "remove one")
    if not declared.name.isidentifier():
        raise InputError(f"{where}.name", f"{declared.name!r}", "letters, digits and underscores")
    variables = tuple(description.variables[name] for name in declared.variables)
    count = sum(v.size for v in variables)
    natural = variables[0].shape if len(variables) == 1 else (count,)
    shape = declared.shape or natural
    if math.prod(shape) != count or count == 0:
        raise InputError(f"{where}.shape", f"{list(shape)} for {count} elements",
                         "a shape with as many elements")
    scales, offsets = _conversion(variables, shape, declared, where)
    bound = _bound(declared.name, variables, shape, declared.unit, scales, offsets)
    return replace(bound, sampled=declared.sampled)


def _conversion(variables: Sequence[FmuVariable], shape: tuple[int, ...], declared: FmuPort,
                where: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Scales and offsets of a declared port's elements: as declared, or by the units."""
    columns = (shape or (1,))[-1]
    elements = [variable for variable in variables for _ in range(variable.size)]
    if not math.isfinite(declared.offset):
        raise InputError(f"{where}.offset", f"{declared.offset}", "a finite number")
    if declared.scale is not None:
        given = declared.scale if isinstance(declared.scale, tuple) else (declared.scale,)
        if not all(math.isfinite(scale) and scale != 0.0 for scale in given):
            raise InputError(f"{where}.scale", f"{declared.scale}", "finite numbers other than 0")
        if isinstance(declared.scale, tuple) and len(given) != columns:
            raise InputError(f"{where}.scale", f"{len(given)} scales",
                             f"one, or {columns}, one for each place of the last index")
        named = next((v for v in elements if v.unit), None)
        if named is not None and not declared.unit and set(given) != {1.0}:
            raise InputError(f"{where}.unit", f"is not given, but the scale converts {named.name!r} from its "
                             f"unit {named.unit!r}", "the unit of the scaled values")
        return tuple(np.resize(given, len(elements)).tolist()), (declared.offset,) * len(elements)
    if declared.offset:
        raise InputError(f"{where}.offset", f"{declared.offset:g} is given without a scale", "both, or none",
                         "add scale = 1.0 if units are equal")
    units = declared.unit.split(",")
    units = units if len(units) == columns else [declared.unit]
    pairs = [_converted(variable, units[place % len(units)], where)
             for place, variable in enumerate(elements)]
    return tuple(scale for scale, _ in pairs), tuple(offset for _, offset in pairs)


def _converted(variable: FmuVariable, unit: str, where: str) -> tuple[float, float]:
    """Scale and offset from a port's unit to a variable's."""
    ours = unit_of(unit)
    if variable.unit in ("", unit) or not unit:
        if not variable.unit or not unit or ours is None or variable.base is None:
            return 1.0, 0.0
        ours = ours.like(variable.base)
        same = ours.to(variable.base)
        if same and abs(same[0] - 1.0) <= DIGITS and abs(same[1]) <= DIGITS:
            return 1.0, 0.0
    found = ours.to(variable.base) if ours is not None and variable.base is not None else None
    if found is None:
        why = ("the FMU does not define its unit" if variable.base is None
               else f"the FMU defines that as another quantity than {unit!r}" if variable.unit == unit
               else f"{unit!r} is unknown" if ours is None else "these are different quantities")
        raise InputError(f"{where}.unit", f"{unit!r}, but {variable.name!r} is in {variable.unit!r}, and "
                         f"{why}", f"{variable.unit!r}",
                         "give the scale from one to the other (1 if both names mean the same)")
    return found


def _automatic(variables: Sequence[FmuVariable], where: str) -> Iterable[BoundPort]:
    """One port per variable or array, in the order of first elements."""
    groups: dict[str, dict[tuple[int, ...], FmuVariable]] = {}
    for variable in variables:
        match = _INDEXED.fullmatch(variable.name)
        base, index = variable.name, tuple[int, ...]()
        if match and variable.shape == ():
            base, index = match["base"], tuple(int(part) for part in match["index"].split(","))
        elements = groups.setdefault(base, {})
        if index in elements or (elements and () in (index, *elements)):
            other = elements.get(index) or next(iter(elements.values()))
            raise InputError(where, f"the FMU has {other.name!r} and {variable.name!r}, which would be one "
                             "port", "distinct names of ports", f"declare {where}")
        elements[index] = variable
    for base, elements in groups.items():
        shape = _full_shape(elements)
        if shape is None:
            for variable in elements.values():
                yield _defined(_identifier(variable.name), (variable,), (), where)
        else:
            ordered = tuple(elements[index] for index in sorted(elements))
            yield _defined(_identifier(base), ordered, shape or ordered[0].shape, where)


def _defined(name: str, variables: tuple[FmuVariable, ...], shape: tuple[int, ...], where: str) -> BoundPort:
    """A port in the units that the variables name, as fesloop defines these."""
    pairs = [_converted(each, each.unit, where) for each in variables for _ in range(each.size)]
    return _bound(name, variables, shape, "", tuple(scale for scale, _ in pairs),
                  tuple(offset for _, offset in pairs))


def _full_shape(elements: dict[tuple[int, ...], FmuVariable]) -> tuple[int, ...] | None:
    """Shape of the array that the indices, from 0 or 1, fill; None if some are missing."""
    if () in elements:
        return ()
    if len({len(index) for index in elements}) != 1:
        return None
    lowest = min(min(index) for index in elements)
    if lowest not in (0, 1):
        return None
    shape = tuple(max(axis) - lowest + 1 for axis in zip(*elements, strict=True))
    full = set(itertools.product(*(range(lowest, lowest + length) for length in shape)))
    return shape if full == set(elements) else None


def _identifier(name: str) -> str:
    text = re.sub(r"\W+", "_", name).strip("_")
    return text if text.isidentifier() else f"v_{text}"


def _bound(name: str, variables: tuple[FmuVariable, ...], shape: tuple[int, ...], unit: str = "",
           scales: tuple[float, ...] = (), offsets: tuple[float, ...] = ()) -> BoundPort:
    starts = np.concatenate([np.full(v.size, v.start) for v in variables])
    scales, offsets = scales or (1.0,) * starts.size, offsets or (0.0,) * starts.size
    starts = (np.nan_to_num(starts, nan=0.0, posinf=0.0, neginf=0.0) - offsets) / scales
    initial = float(starts[0]) if (starts == starts[0]).all() else starts.reshape(shape).tolist()
    return BoundPort(Port(name, shape, unit or _unit(variables, shape), cast("float", _tuples(initial))),
                     variables, scales, offsets)


def _tuples(value: object) -> object:
    return tuple(_tuples(item) for item in value) if isinstance(value, list) else value


def _unit(variables: Sequence[FmuVariable], shape: tuple[int, ...]) -> str:
    """Common unit of the variables, or their units by last index."""
    units = [unit for v in variables for unit in [v.unit or "1"] * v.size]
    columns = units[: shape[-1]] if shape else units[:1]
    if len(set(units)) > 1 and units == columns * (len(units) // len(columns)):
        return ",".join(columns)
    return units[0] if len(set(units)) == 1 else ",".join(units)
