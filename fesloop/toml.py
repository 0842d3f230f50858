"""TOML as fesloop reads it: what is nested without end and whole numbers that no float holds are none."""

from __future__ import annotations

import sys
import tomllib
from typing import Any


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
        raise TomlError("it is nested too deeply") from None
    except ValueError:  # Python makes no number of more than 4300 digits
        raise TooLargeError(_beyond("a whole number")) from None
    _require_floats(tables)
    return tables


def _require_floats(tables: dict[str, Any]) -> None:
    """Raise TooLargeError, naming the key, for a whole number beyond floats."""
    pending: list[tuple[str, Any]] = list(tables.items())
    while pending:
        path, value = pending.pop()
        if isinstance(value, dict):
            pending += [(f"{path}.{key}", item) for key, item in value.items()]
        elif isinstance(value, list):
            pending += [(f"{path}[{number}]", item) for number, item in enumerate(value)]
        elif isinstance(value, int) and abs(value) > sys.float_info.max:
            raise TooLargeError(_beyond(path))


def _beyond(what: str) -> str:
    return f"{what} is beyond {sys.float_info.max:.2g}"
