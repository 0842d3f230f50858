"""Plain tables as the text of a TOML file, from which the same tables are read."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(tables: Mapping[str, Any]) -> str:
    """Text of a TOML file. Values are text, truth, numbers, lists of such, and tables; None has no place."""
    return "\n".join(_lines(tables, ())) + "\n"


def _lines(table: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    own = [f"{_key(key)} = {toml_value(value)}" for key, value in table.items()
           if not isinstance(value, Mapping)]
    below = [(key, value) for key, value in table.items() if isinstance(value, Mapping)]
    lines = own
    if path and (own or not below):
        lines = ["", f"[{'.'.join(_key(part) for part in path)}]", *own]
    for key, value in below:
        lines += _lines(value, (*path, key))
    return lines


def _key(key: str) -> str:
    return key if _BARE.fullmatch(key) else _text(key)


def _text(text: str) -> str:
    """A basic string; JSON escapes as TOML does, but for DEL."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def toml_value(value: Any) -> str:
    """Text of one value that is no table."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(toml_value(item) for item in value)}]"
    if isinstance(value, (int, float)):
        return repr(value)
    raise TypeError(f"{value!r} has no place in TOML")
