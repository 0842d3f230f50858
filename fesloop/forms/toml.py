"""TOML with bounded nesting, whole numbers in the range of floats, and dates and times as text."""

from __future__ import annotations

import datetime
import json
import re
import sys
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fesloop.errors import InputError

DEEPEST = 64
"""Levels of tables and lists within each other (chosen: ten times what any file has, far from where Python's
own recursion ends)."""
_TOO_DEEP = f"it is nested too deeply, beyond {DEEPEST} levels"


class TomlError(ValueError):
    """Error for a text that is not TOML, with the reason in one line."""


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


def tables_of_file(path: Path, form: str, what: str, made_by: str) -> dict[str, Any]:
    """Tables of a TOML file whose key `format` is `form`, without that key.

    Raises InputError for a file that cannot be read, is not TOML or has another format. `what` names the
    format, and `made_by` the command that writes it, in messages.
    """
    expected = f"a file written by {made_by}"
    try:
        tables = tables_of(path.read_text(encoding="utf-8"))
    except OSError as fault:
        raise InputError(str(path), f"cannot be read: {fault.strerror}", expected) from None
    except (UnicodeDecodeError, TomlError) as fault:
        raise InputError(str(path), f"is not TOML: {fault}", expected) from None
    if tables.pop("format", None) != form:
        raise InputError(f"{path}: format", f"is not that of {what}", repr(form), f"run {made_by}")
    return tables


def plain_tables(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Copy tables into tables, lists, texts, numbers and booleans.

    Raises TomlError as `tables_of` does, and for a value that has no form in TOML.
    """
    settled: dict[str, Any] = _settled(tables, "", 0)
    return settled


def _settled(value: Any, path: str, depth: int) -> Any:
    """Copy a value, with dates and times as text, because no key takes them.

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


_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(tables: Mapping[str, Any]) -> str:
    """Text of a TOML file. Values are text, booleans, numbers, lists and tables; None is invalid.

    Lists of tables are arrays of tables at the top ("[[wires]]") and inline below.
    """
    return "\n".join(_lines(tables, ())) + "\n"


def write_tables(path: str | Path, tables: Mapping[str, Any]) -> None:
    """Write tables to a TOML file. Raises InputError where it cannot be written."""
    try:
        Path(path).write_text(toml_text(tables), encoding="utf-8")
    except OSError as fault:
        raise InputError(str(path), f"cannot be written: {fault.strerror}", "a file") from None


def _lines(table: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    own = [f"{toml_key(key)} = {_own(value)}" for key, value in table.items()
           if not _stands_below(value, path)]
    below = [(key, value) for key, value in table.items() if _stands_below(value, path)]
    lines = own
    if path and (own or not below):
        lines = ["", f"[{'.'.join(toml_key(part) for part in path)}]", *own]
    for key, value in below:
        if isinstance(value, Mapping):
            lines += _lines(value, (*path, key))
            continue
        for row in value:
            lines += ["", f"[[{toml_key(key)}]]",
                      *(f"{toml_key(name)} = {toml_value(item)}" for name, item in row.items())]
    return lines


def _stands_below(value: Any, path: tuple[str, ...]) -> bool:
    """Return whether a value has a heading of its own."""
    return isinstance(value, Mapping) or (not path and _lists_tables(value))


def _lists_tables(value: Any) -> bool:
    return isinstance(value, (list, tuple)) and bool(value) and all(isinstance(row, Mapping) for row in value)


def _own(value: Any) -> str:
    """A key and its value; tables of a list have a line each."""
    if not _lists_tables(value):
        return toml_value(value)
    return "".join(["[\n", *(f"    {toml_value(row)},\n" for row in value), "]"])


def toml_key(key: str) -> str:
    """A key as TOML writes it, quoted where it must be."""
    return key if _BARE.fullmatch(key) else _text(key)


def _text(text: str) -> str:
    """A basic string; JSON escapes as TOML does, but for DEL."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def toml_value(value: Any) -> str:
    """Text of one value; of a table, inline."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(toml_value(item) for item in value)}]"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, Mapping):
        inner = ", ".join(f"{toml_key(key)} = {toml_value(item)}" for key, item in value.items())
        return f"{{ {inner} }}" if inner else "{}"
    raise TypeError(f"{value!r} has no place in TOML")
