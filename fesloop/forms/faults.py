"""One-line faults from the errors of pydantic: key path, value found, values allowed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from fesloop.errors import InputError, did_you_mean
from fesloop.forms.toml import toml_key

_MISSING, _UNKNOWN = "missing", "extra_forbidden"
_LIST = "a list"
_ALLOWED = {
    "float_type": "a number",
    "int_type": "an integer",
    "int_from_float": "an integer",
    "bool_type": "true or false",
    "string_type": "text",
    "finite_number": "a finite number",
    "tuple_type": _LIST,
    "list_type": _LIST,
    "dict_type": "a table",
    "path_type": "text",
    "none_required": "",
}
_NOTHING = object()


def faults_of(errors: Iterable[Any], document: Any, keys_at: Any, tagged: bool) -> list[InputError]:
    """Faults of a document, one per key, in its order.

    Parameters
    ----------
    errors: of a pydantic ValidationError.
    document: what was checked.
    keys_at: from a path (tuple of keys) to the keys that are valid there.
    tagged: whether pydantic names the kind of a block after its name, as it does where there are several.
    """
    gathered: dict[tuple[Any, ...], list[Any]] = {}
    for error in errors:
        path = _path(error["loc"], document, error["type"] == _MISSING, tagged)
        gathered.setdefault(path, []).append(error)
    return [_fault(path, group, document, keys_at) for path, group in gathered.items()]


def key_path(path: Sequence[Any]) -> str:
    """Text of a path: blocks.pid.gain, score.joints[2]."""
    text = ""
    for key in path:
        text += f"[{key}]" if isinstance(key, int) else f".{toml_key(key)}" if text else toml_key(key)
    return text or "the file"


def wire_place(number: int, wires: Sequence[Any]) -> str:
    """Key path of a wire by its ends, as in --set, or by its number if they are missing or not unique.

    Wires of a file that extends others are numbered together, which nobody can count in one of the files.
    """
    ends = [(wire.get("from"), wire.get("to")) if isinstance(wire, dict) else None for wire in wires]
    own = ends[number]
    if own is None or not all(isinstance(end, str) for end in own) or ends.count(own) > 1:
        return key_path(("wires", number))
    return key_path(("wires", f"{own[0]}->{own[1]}"))


def _where(path: tuple[Any, ...], document: Any) -> str:
    if path[:1] == ("wires",) and len(path) > 1 and isinstance(path[1], int):
        rest = key_path(path[2:]) if len(path) > 2 else ""
        return f"{wire_place(path[1], document['wires'])}.{rest}".rstrip(".")
    return key_path(path)


def _path(loc: Sequence[Any], document: Any, missing: bool, tagged: bool) -> tuple[Any, ...]:
    """The part of a location that is a path into the document, without pydantic's union tags."""
    path: list[Any] = []
    here = document
    for position, key in enumerate(loc):
        below = _below(here, key)
        if below is not _NOTHING and not (tagged and position == 2 and loc[0] == "blocks"):
            path.append(key)
            here = below
        elif missing and position == len(loc) - 1:
            path.append(key)
    return tuple(path)


def _below(here: Any, key: Any) -> Any:
    if isinstance(here, dict):
        return here.get(key, _NOTHING)
    if isinstance(here, list) and isinstance(key, int) and key < len(here):
        return here[key]
    return _NOTHING


def _fault(path: tuple[Any, ...], group: list[Any], document: Any, keys_at: Any) -> InputError:
    """One fault from all errors about one key."""
    where = _where(path, document)
    kind = group[0]["type"]
    if kind == _MISSING:
        return InputError(where, "is missing", remedy="add it")
    if kind == _UNKNOWN:
        known = sorted(keys_at(path[:-1]))
        return InputError(where, "unknown key", ", ".join(known), did_you_mean(str(path[-1]), known))
    found: Any = document
    for key in path:
        found = _below(found, key)
    allowed = dict.fromkeys(text for text in (_allowed(error) for error in group) if text)
    remedy = ""
    if list(allowed) == [_LIST] and type(found) in (int, float, str):
        remedy = f"write a list of one as [{_shown(found)}]"
    elif isinstance(found, str) and "a table" in allowed and "file" in keys_at(path):
        remedy = f"to name a file: {{ file = {_shown(found)} }}"
    return InputError(where, f"{_shown(found)} is {_name(found)}" if _is_type(group) else f"{_shown(found)}",
                      " or ".join(allowed), remedy)


def _is_type(group: list[Any]) -> bool:
    return all(error["type"].endswith("_type") or error["type"] == "none_required" for error in group)


def _allowed(error: Any) -> str:
    kind, context = error["type"], error.get("ctx", {})
    if kind == "literal_error":
        return str(context["expected"])
    if kind in ("too_short", "too_long"):
        bound = context.get("min_length", context.get("max_length"))
        return f"{'at least' if kind == 'too_short' else 'at most'} {bound} values"
    if kind == "missing":
        return "a longer list"
    if kind in ("model_type", "dataclass_type", "model_attributes_type"):
        return "a table"
    if kind == "union_tag_invalid":
        return f"kind {context['expected_tags']}"
    return _ALLOWED.get(kind, str(error["msg"]))


def _name(value: Any) -> str:
    names = {bool: "a boolean", int: "an integer", float: "a number", str: "text", list: "a list",
             dict: "a table"}
    return names.get(type(value), type(value).__name__)


def _shown(value: Any) -> str:
    """A value as TOML would write it, cut to a line's worth."""
    if isinstance(value, bool):
        return "true" if value else "false"
    text = f'"{value}"' if isinstance(value, str) else repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
