"""TOML as fesloop reads it: bounded nesting, whole numbers that a float holds, dates and times as text."""

from __future__ import annotations

import datetime
import sys
import tomllib
from collections.abc import Mapping
from typing import Any

DEEPEST = 64
"""Levels of tables and lists within each other (chosen: ten times what any file has, far from where Python's
own recursion ends)."""
_TOO_DEEP = f"it is nested too deeply, beyond {DEEPEST} levels"


class TomlError(ValueError):
    """A text is no TOML; why, in one line."""


class TooLargeError(TomlError):
    """A whole number is beyond the range of floats; TOML leaves those beyond 64 bits to its readers."""


def tables_of(text: str) -> dict[str, Any]:
    """The tables of TOML text; raises TomlError for other text."""
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as fault:
        raise TomlError(str(fault)) from None
    except RecursionError:
        raise TomlError(_TOO_DEEP) from None
    except ValueError:  # Python makes no number of more than 4300 digits
        raise TooLargeError(_beyond("a whole number")) from None
    return plain_tables(tables)


def plain_tables(tables: Mapping[str, Any]) -> dict[str, Any]:
    """A copy of tables that holds nothing but tables, lists, texts, numbers and booleans.

    Raises TomlError as `tables_of` does, and for a value that TOML has no form for.
    """
    settled: dict[str, Any] = _settled(tables, "", 0)
    return settled


def _settled(value: Any, path: str, depth: int) -> Any:
    """A value with dates and times as the text that they were: no key takes one.

    Raises TomlError, naming the key.
    """
    if depth > DEEPEST:
        raise TomlError(_TOO_DEEP)
    if isinstance(value, Mapping):
        return {str(key): _settled(item, f"{path}.{key}" if path else str(key), depth + 1)
                for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_settled(item, f"{path}[{number}]", depth + 1) for number, item in enumerate(value)]
    if isinstance(value, int) and abs(value) > sys.float_info.max:
        raise TooLargeError(_beyond(path))
    if isinstance(value, (datetime.date, datetime.time)):
        return value.isoformat()
    if isinstance(value, (str, bool, int, float)):
        return value
    raise TomlError(f"{path}: {value!r} is no value of TOML")


def _beyond(what: str) -> str:
    return f"{what} is beyond {sys.float_info.max:.2g}"
