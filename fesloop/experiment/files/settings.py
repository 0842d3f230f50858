"""`--set KEY=VALUE`: changes to an experiment file, made before it is checked."""

from __future__ import annotations

import copy
import re
from collections.abc import Sequence
from pathlib import Path
from types import UnionType
from typing import Any, Union, get_args, get_origin

from fesloop.errors import InputError, did_you_mean
from fesloop.experiment import registry
from fesloop.experiment.files.patients import require_no_other
from fesloop.experiment.files.places import placed_value
from fesloop.forms.schema import hints_of
from fesloop.forms.toml import DEEPEST, TomlError, TooLargeError, tables_of

_TOP = ("experiment", "patient", "record", "blocks", "wires", "score")
_PART = re.compile(r'"([^"]*)"|([^.\[\]"]+)|\[(\d+)\]')


def apply_settings(document: dict[str, Any], settings: Sequence[str], name: str,
                   variants: Sequence[str] = (), folder: Path | None = None) -> dict[str, Any]:
    """A copy of the document with every setting applied, in order.

    KEY is an alias of the file, or a path such as blocks.pid.gain, wires.2.latency_ms or
    wires."imu.gyr->tracker.gyr".latency_ms. VALUE is read as TOML, and as text where it is none or where
    the key takes text. `variants` are keys of the file that are settled already; paths in values start from
    `folder`. Raises InputError for a key that leads nowhere.
    """
    changed = copy.deepcopy(document)
    for setting in settings:
        key, equals, text = setting.partition("=")
        key = key.strip()
        if not equals or not key:
            raise InputError(f"--set {setting}", "has no key" if equals else "has no '='", "KEY=VALUE")
        for path in _paths(changed, key, name, variants):
            if path[0] == "patient":
                require_no_other(document, key, name)
            try:
                _assign(changed, path, text, key, name, folder)
            except TooLargeError as fault:
                raise InputError(f"--set {key}", str(fault)) from None
    return changed


def _paths(document: dict[str, Any], key: str, name: str, variants: Sequence[str]) -> list[list[str]]:
    """The paths that a key stands for."""
    aliases = document.get("aliases")
    aliases = aliases if isinstance(aliases, dict) else {}
    if key in aliases:
        targets = aliases[key] if isinstance(aliases[key], list) else [aliases[key]]
        return [_bounded(key_parts(str(target)), key) for target in targets]
    path = _bounded(key_parts(key), key)
    if len(path) < 2 or path[0] not in _TOP:
        known = [*variants, *aliases, *(f"{top}.KEY" for top in _TOP)]
        raise InputError(f"--set {key}", f"is no key of {name}", ", ".join(known),
                         did_you_mean(key, [*variants, *aliases]))
    return [path]


def _bounded(path: list[str], key: str) -> list[str]:
    """A path that leads no deeper than tables may be nested."""
    if len(path) > DEEPEST:
        raise InputError(f"--set {key}", f"leads through {len(path)} tables", f"at most {DEEPEST}")
    return path


def key_parts(key: str) -> list[str]:
    """A dotted path in its parts; a part may be quoted, an index may stand in brackets."""
    return [quoted or bare or index for quoted, bare, index in _PART.findall(key)]


def key_text(path: Sequence[str]) -> str:
    """The dotted path of these parts."""
    return ".".join(part if part.replace("-", "_").isidentifier() else f'"{part}"' for part in path)


def _assign(document: dict[str, Any], path: list[str], text: str, key: str, name: str,
            folder: Path | None) -> None:
    """Put the value of `text` at a path."""
    here: Any = document
    for depth, part in enumerate(path[:-1]):
        if isinstance(here, dict) and depth != 1:
            here = here.setdefault(part, {})
        else:
            here = here[_step(here, part, key, name)]
        if not isinstance(here, (dict, list)):
            raise InputError(f"--set {key}", f"{part!r} holds no further keys", remedy=f"see {name}")
    last = path[-1]
    if isinstance(here, list):
        here[_step(here, last, key, name)] = placed_value(path, _value(text, False), folder)
    else:
        value = _value(text, _takes_text(document, path, here.get(last)))
        here[last] = placed_value(path, value, folder)


def _step(here: Any, part: str, key: str, name: str) -> Any:
    """The key or index under which a part of a path stands."""
    if isinstance(here, dict):
        if part in here:
            return part
        known = list(here)
    else:
        ends = [f"{wire.get('from')}->{wire.get('to')}" if isinstance(wire, dict) else "" for wire in here]
        if part.isdecimal() and int(part) < len(here):
            return int(part)
        if part in ends:
            return ends.index(part)
        known = [f"0 to {len(here) - 1}", *ends]
    raise InputError(f"--set {key}", f"{name} has no {part!r} there", ", ".join(filter(None, known)),
                     did_you_mean(part, known))


def _value(text: str, is_text: bool) -> Any:
    """TOML value of the text, or the text itself; raises TooLargeError for a number that no float holds."""
    try:
        value = tables_of(f"value = {text}")
    except TomlError as fault:
        if isinstance(fault, TooLargeError) and not is_text:
            raise
        return text
    if len(value) != 1 or (is_text and not isinstance(value["value"], str)):
        return text
    return value["value"]


def text_value(text: str) -> str:
    """The text that stands there, without quotation marks if it is in such."""
    return str(_value(text, True))


def _takes_text(document: dict[str, Any], path: list[str], present: Any) -> bool:
    """Whether the key is known to take text: it holds some, or its block's parameter is declared so."""
    if isinstance(present, str):
        return True
    if path[0] != "blocks" or len(path) != 3:
        return False
    kind = document.get("blocks", {}).get(path[1], {}).get("kind")
    if kind not in registry.kinds():
        return False
    hint = hints_of(registry.find(kind)).get(path[2])
    return hint is str or (get_origin(hint) in (Union, UnionType) and str in get_args(hint))
