"""Digests of parameters, equal for equal parts, whatever the parameters are made of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import partial
from hashlib import sha256
from numbers import Rational, Real
from types import CellType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np


def parameter_digests(part: object) -> dict[str, str]:
    """A digest of each parameter of a part, by name; derived fields are not parameters."""
    return {name: sha256("\n".join(_lines(value, ())).encode()).hexdigest()
            for name, value in _parameters(getattr(part, "__wrapped__", part))}


def changed(before: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    """Names of the parameters that differ."""
    return [name for name in {**before, **now} if before.get(name) != now.get(name)]


def _parameters(part: Any) -> Iterator[tuple[str, Any]]:
    """Names and values: init fields of a dataclass, attributes of another object."""
    if is_dataclass(part):
        for field in fields(part):
            if field.init:
                yield field.name, getattr(part, field.name)
    else:
        yield from getattr(part, "__dict__", {}).items()


def _lines(value: Any, within: tuple[int, ...]) -> Iterator[str]:
    """Lines of text that are equal for equal values; `within` are the ids of the enclosing values."""
    if value is None or isinstance(value, str | bytes | Enum):
        yield repr(value)
    elif isinstance(value, Real):
        yield _number(value)
    elif isinstance(value, np.ndarray | np.generic):
        yield f"array {value.dtype} {value.shape}"
        if value.dtype.hasobject:
            yield from _inside("item", value.ravel().tolist(), within)
        else:
            yield value.tobytes().hex()
    elif isinstance(value, type):
        yield f"{value.__module__}.{value.__qualname__}"
    elif id(value) in within:
        yield "again"
    elif isinstance(value, MethodType | FunctionType | CodeType | partial):
        yield from _function(value, (*within, id(value)))
    elif callable(value) and hasattr(value, "__qualname__"):
        yield f"{value.__module__}.{value.__qualname__}"
        for name in ("py_func", "__self__"):  # what numba has compiled; what a method written in C is of
            if not isinstance(bound := getattr(value, name, None), ModuleType):
                yield from _lines(bound, (*within, id(value)))
    else:
        yield from _held(value, (*within, id(value)))


def _function(value: MethodType | FunctionType | CodeType | partial[Any],
              within: tuple[int, ...]) -> Iterator[str]:
    """Lines of a function: its name, its code, and the values bound to it.

    Two functions from one place in a file have one name, such as those of a factory or two lambdas. The path
    of the file and the line make no difference, nor do globals, which belong to the module.
    """
    if isinstance(value, MethodType):
        parts: tuple[Any, ...] = (value.__func__, value.__self__)
    elif isinstance(value, partial):
        parts = (value.func, value.args, value.keywords)
    elif isinstance(value, CodeType):
        parts = (value.co_code, value.co_consts, value.co_names, value.co_varnames, value.co_freevars,
                 value.co_argcount, value.co_kwonlyargcount, value.co_flags)
    else:
        cells = tuple(_content(cell) for cell in value.__closure__ or ())
        parts = (f"{value.__module__}.{value.__qualname__}", value.__code__, value.__defaults__,
                 value.__kwdefaults__, cells)
    yield from _inside("function", parts, within)


def _content(cell: CellType) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # still empty
        return None


def _held(value: Any, within: tuple[int, ...]) -> Iterator[str]:
    """Lines of a container or object."""
    if isinstance(value, Mapping):
        yield f"mapping {len(value)}"
        yield from sorted("\n".join(_inside("item", item, within)) for item in value.items())
    elif isinstance(value, list | tuple):
        yield from _inside("sequence", value, within)
    elif isinstance(value, Set):
        yield f"set {len(value)}"
        yield from sorted("\n".join(_lines(each, within)) for each in value)
    else:
        named = list(_parameters(value))
        yield f"{type(value).__module__}.{type(value).__qualname__} {len(named)}"
        if not named:
            yield from _own_text(value)
        for each in named:
            yield from _inside("item", each, within)


def _own_text(value: object) -> Iterator[str]:
    """`repr` of an object without named parts, unless it contains the address of the object."""
    text = repr(value)
    if hex(id(value)) not in text.lower():
        yield text


def _inside(kind: str, values: Any, within: tuple[int, ...]) -> Iterator[str]:
    yield f"{kind} {len(values)}"
    for each in values:
        yield from _lines(each, within)


def _number(value: Real) -> str:
    """The same text for 1, 1.0 and numpy's 1.0."""
    if isinstance(value, Rational):
        return f"{value.numerator}/{value.denominator}" if value.denominator != 1 else str(value.numerator)
    number = float(value)
    return str(int(number)) if number.is_integer() else repr(number)
