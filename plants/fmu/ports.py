"""From an FMU's variables to ports: by declaration, or by the names and dimensions of the variables."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import cast

import numpy as np

from fesloop.errors import InputError
from fesloop.loop.signals import Port
from plants.fmu.description import NUMERIC, FmuDescription, FmuVariable

_INDEXED = re.compile(r"(?P<base>.+)\[(?P<index>\d+(?:\s*,\s*\d+)*)\]")


@dataclass(frozen=True, slots=True, kw_only=True)
class FmuPort:
    """A port made of an FMU's variables.

    Attributes
    ----------
    name: of the port.
    variables: names of the FMU's variables, in the order of the port's elements (last index fastest).
    shape: of the port; () makes a vector of several variables, and a float of a single scalar one.
    unit: of the port; "" takes that of the variables.
    scale: the FMU's value is the port's times this, such as 57.29577951308232 for an FMU in degrees; one
        for all elements, or one for each place of the last index, such as [1e3, 1e6] for mA and us.
    sampled: of an output port, whether its values are meant to hold between samples of the FMU's own; that
        they hold is then no sign that the FMU is stale.
    """

    name: str
    variables: tuple[str, ...]
    shape: tuple[int, ...] = ()
    unit: str = ""
    scale: float | tuple[float, ...] = 1.0
    sampled: bool = False


@dataclass(frozen=True, slots=True)
class BoundPort:
    """A port with the variables behind it; `scales` are those of its elements, flat."""

    port: Port
    variables: tuple[FmuVariable, ...]
    scales: tuple[float, ...]
    sampled: bool = False

    @property
    def shape(self) -> tuple[int, ...]:
        """The port's shape, which an FMU always settles."""
        return tuple(size for size in self.port.shape if size is not None)


def bind_ports(
    description: FmuDescription, causality: str, declared: Sequence[FmuPort], where: str
) -> tuple[BoundPort, ...]:
    """Ports for the inputs or outputs of an FMU.

    Where none are declared: a port for each numeric variable, `u[1]`, `u[2]`, ... or `m[1,1]`, `m[1,2]`, ...
    joined into one array port `u` or `m`; a dot or bracket in a name becomes an underscore. If the units of
    a joined port differ by its last index, its unit lists them ("A,s").

    Raises InputError, naming `where`, for a variable that is not there, of the wrong kind or not numeric,
    for a shape that does not hold the variables, and for two ports of one name.
    """
    if declared:
        ports = tuple(
            _declared(description, causality, each, f"{where}[{i}]") for i, each in enumerate(declared))
    else:
        ports = tuple(_automatic(_numeric(description, causality)))
    names = [bound.port.name for bound in ports]
    for name in names:
        if names.count(name) > 1:
            raise InputError(where, f"there are two ports {name!r}", "unique names",
                             f"declare {where} by hand")
    return ports


def _numeric(description: FmuDescription, causality: str) -> list[FmuVariable]:
    return [v for v in description.variables.values() if v.causality == causality and v.type in NUMERIC]


def _declared(description: FmuDescription, causality: str, wanted: FmuPort, where: str) -> BoundPort:
    allowed = [variable.name for variable in _numeric(description, causality)]
    for name in wanted.variables:
        if name not in allowed:
            close = get_close_matches(name, allowed, 1)
            raise InputError(
                f"{where}.variables", f"the FMU has no numeric {causality} {name!r}",
                ", ".join(allowed[:20]) or "none", f"did you mean {close[0]!r}?" if close else "")
    if not wanted.name.isidentifier():
        raise InputError(f"{where}.name", f"{wanted.name!r}", "letters, digits and underscores")
    if not all(math.isfinite(scale) and scale != 0.0 for scale in _listed(wanted.scale)):
        raise InputError(f"{where}.scale", f"{wanted.scale}", "finite numbers other than 0")
    variables = tuple(description.variables[name] for name in wanted.variables)
    count = sum(v.size for v in variables)
    natural = variables[0].shape if len(variables) == 1 else (count,)
    shape = wanted.shape or natural
    if math.prod(shape) != count or count == 0:
        raise InputError(f"{where}.shape", f"{list(shape)} for {count} elements",
                         "a shape that holds them all")
    if isinstance(wanted.scale, tuple) and len(wanted.scale) != (shape or (1,))[-1]:
        raise InputError(f"{where}.scale", f"{len(wanted.scale)} scales",
                         f"one, or {(shape or (1,))[-1]}, one for each place of the last index")
    bound = _bound(wanted.name, variables, shape, wanted.unit, _listed(wanted.scale))
    return replace(bound, sampled=wanted.sampled)


def _listed(scale: float | tuple[float, ...]) -> tuple[float, ...]:
    return scale if isinstance(scale, tuple) else (scale,)


def _automatic(variables: Sequence[FmuVariable]) -> Iterable[BoundPort]:
    """A port an array, each array at the place of its first element."""
    groups: dict[str, dict[tuple[int, ...], FmuVariable]] = {}
    for variable in variables:
        match = _INDEXED.fullmatch(variable.name)
        if match and variable.shape == ():
            index = tuple(int(part) for part in match["index"].split(","))
            groups.setdefault(match["base"], {})[index] = variable
        else:
            groups[variable.name] = {(): variable}
    for base, elements in groups.items():
        shape = _full_shape(elements)
        if shape is None:
            for variable in elements.values():
                yield _bound(_identifier(variable.name), (variable,), ())
        else:
            ordered = tuple(elements[index] for index in sorted(elements))
            yield _bound(_identifier(base), ordered, shape or ordered[0].shape)


def _full_shape(elements: dict[tuple[int, ...], FmuVariable]) -> tuple[int, ...] | None:
    """Sizes if the indices, from 0 or from 1, fill an array; None if some are missing."""
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
           scale: tuple[float, ...] = (1.0,)) -> BoundPort:
    starts = np.concatenate([np.full(v.size, v.start) for v in variables])
    scales = np.resize(scale, starts.size)
    starts = np.nan_to_num(starts, nan=0.0, posinf=0.0, neginf=0.0) / scales
    initial = float(starts[0]) if (starts == starts[0]).all() else starts.reshape(shape).tolist()
    return BoundPort(Port(name, shape, unit or _unit(variables, shape), cast("float", _tuples(initial))),
                     variables, tuple(scales.tolist()))


def _tuples(value: object) -> object:
    return tuple(_tuples(item) for item in value) if isinstance(value, list) else value


def _unit(variables: Sequence[FmuVariable], shape: tuple[int, ...]) -> str:
    """The variables' common unit, or their units by last index."""
    units = [unit for v in variables for unit in [v.unit] * v.size]
    columns = units[: shape[-1]] if shape else units[:1]
    if len(set(units)) > 1 and units == columns * (len(units) // len(columns)):
        return ",".join(columns)
    return units[0] if len(set(units)) == 1 else ",".join(units)
