"""Settings `KEY=VALUE` of the command line, applied to the tables of an experiment file.

KEY is an alias of the file, or a dotted path such as blocks.pid.gain, wires.2.latency_ms,
wires."imu.gyr->tracker.gyr".latency_ms or blocks.reference.phases.close.duration_s. VALUE is read as TOML,
and as text where it is no TOML or where the key takes text.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import UnionType
from typing import Any, Union, get_args, get_origin

from fesloop.errors import InputError, InputErrors, did_you_mean
from fesloop.experiment import registry
from fesloop.experiment.files.overlay import key_parts
from fesloop.experiment.files.source import placed_value
from fesloop.forms.toml import DEEPEST, TomlError, TooLargeError, tables_of, toml_value

_TOP = ("experiment", "patient", "electrodes", "record", "blocks", "links", "wires", "score")


Settings = Sequence[str] | Mapping[str, Any]


def setting_texts(settings: Settings) -> Sequence[str]:
    """Settings as "KEY=VALUE" each. Raises InputError for values that no setting has."""
    if isinstance(settings, str):
        raise InputError("settings", f"{settings!r} is one text", f"a list, such as [{settings!r}]")
    if not isinstance(settings, Mapping):
        return settings
    try:
        return [f"{key}={value if isinstance(value, (str, Path)) else toml_value(value)}"
                for key, value in settings.items()]
    except TypeError as fault:
        raise InputError("settings", str(fault), "numbers, text, lists and tables of them",
                         'give a block as a table, such as {"kind": "pid", "rate": "50"}') from None


def apply_settings(document: dict[str, Any], settings: Sequence[str], name: str,
                   variants: Sequence[str] = (), folder: Path | None = None) -> dict[str, Any]:
    """Return a copy of the document with every setting applied, in order.

    `name` is that of the file in messages; `variants` are keys of the file whose options are already
    applied; paths in values are relative to `folder`. Raises InputError for a key that does not exist.
    """
    changed = copy.deepcopy(document)
    for setting in settings:
        key, equals, text = setting.partition("=")
        key = key.strip()
        if not equals or not key:
            raise InputError(f"--set {setting}", "has no key" if equals else "has no '='", "KEY=VALUE")
        for path in _paths(changed, key, name, variants):
            if path[0] == "patient" and "drawn" in _table(document, "patient"):
                raise InputError(f"--set {key}", f"{name} already contains the patient of its run",
                                 remedy="set it on the experiment file, and run that")
            try:
                _assign(changed, path, text, key, name, folder)
            except TooLargeError as fault:
                raise InputError(f"--set {key}", str(fault)) from None
    return _described(document, changed)


def _described(before: Mapping[str, Any], changed: dict[str, Any]) -> dict[str, Any]:
    """Say in the experiment's description which blocks are of another kind than it speaks of."""
    was, now, about = (_table(document, key) for document, key in (
        (before, "blocks"), (changed, "blocks"), (changed, "experiment")))
    replaced = [f"{name} is {_table(now, name).get('kind')}" for name in was
                if name in now and _table(was, name).get("kind") != _table(now, name).get("kind")]
    if replaced and isinstance(about.get("description"), str):
        about["description"] += f"; by --set {', '.join(replaced)}"
    return changed


def _paths(document: dict[str, Any], key: str, name: str, variants: Sequence[str]) -> list[list[str]]:
    """Paths that a key means: those of an alias, or the key itself."""
    aliases = _table(document, "aliases")
    if key in aliases:
        targets = aliases[key] if isinstance(aliases[key], list) else [aliases[key]]
        return [_bounded(key_parts(str(target)), key) for target in targets]
    path = _bounded(key_parts(key), key)
    if len(path) < 2 or path[0] not in _TOP:
        known = [*variants, *aliases, *(f"{top}.KEY" for top in _TOP)]
        within = list(_ending(document, key))
        raise InputError(f"--set {key}", f"is no key of {name}", ", ".join(known),
                         f"did you mean {' or '.join(map(repr, within[:3]))}?" if within else
                         did_you_mean(key, [*variants, *aliases]))
    return [path]


def _ending(table: Mapping[str, Any], key: str, above: tuple[str, ...] = ()) -> Iterator[str]:
    """Dotted paths within the tables that may be set, whose last key it is."""
    for name, value in table.items():
        path = (*above, name)
        if path[0] not in _TOP:
            continue
        if above and name == key:
            yield ".".join(path)
        elif isinstance(value, Mapping):
            yield from _ending(value, key, path)


def named_as_set(fault: InputError, start: str, document: Mapping[str, Any],
                 settings: Sequence[str]) -> InputError:
    """The fault, or all of several, with the setting by an alias that wrote the value at its place.

    `start` is how places begin: with the file's name. `document` has the aliases.
    """
    if isinstance(fault, InputErrors):
        return InputErrors([named_as_set(each, start, document, settings) for each in fault.faults])
    start = start if fault.where.startswith(start) else ""
    where, colon, rest = fault.where.removeprefix(start).partition(": ")
    place = key_parts(where)
    for setting in settings:
        key, _, value = setting.partition("=")
        targets = _table(document, "aliases").get(key.strip(), [])
        for path in map(key_parts, targets if isinstance(targets, list) else [targets]):
            # A fault of a list is at the key that has it, one of two keys names the other.
            whole = path[:-1] if path[-1].isdecimal() else path
            beside = place[:-1] == path[:-1] and path[-1] in fault.found.split()
            named = colon and rest.partition(": ")[0] in value  # the file that was set has the fault
            if (place[:len(whole)] == whole or beside) and not named:
                return InputError(f"{start}{where} (--set {setting}){colon}{rest}", fault.found,
                                  fault.allowed, fault.remedy)
    return fault


def _table(document: Mapping[str, Any], key: str) -> dict[str, Any]:
    table = document.get(key)
    return table if isinstance(table, dict) else {}


def _bounded(path: list[str], key: str) -> list[str]:
    """Return the path; raises InputError if it is deeper than tables may be nested."""
    if len(path) > DEEPEST:
        raise InputError(f"--set {key}", f"leads through {len(path)} tables", f"at most {DEEPEST}")
    return path


def _assign(document: dict[str, Any], path: list[str], text: str, key: str, name: str,
            folder: Path | None) -> None:
    """Set the value of `text` at a path."""
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
    """Key or index that a part of a path means in a table or list."""
    if isinstance(here, dict):
        if part in here:
            return part
        known = list(here)
    else:
        names = [_member_name(member) for member in here]
        if part.isdecimal() and int(part) < len(here):
            return int(part)
        if part in names and names.count(part) == 1:
            return names.index(part)
        known = [f"0 to {len(here) - 1}", *(each for each in names if names.count(each) == 1)]
    raise InputError(f"--set {key}", f"{name} has no {part!r} there", ", ".join(filter(None, known)),
                     did_you_mean(part, known))


def _member_name(member: Any) -> str:
    """Name of a list's member: the ends of a wire, or its `name`, as of a phase; "" for one without."""
    if not isinstance(member, dict):
        return ""
    if {"from", "to"} <= set(member):
        return f"{member['from']}->{member['to']}"
    return str(member.get("name", ""))


def _value(text: str, is_text: bool) -> Any:
    """TOML value of a text, or the text itself; raises TooLargeError for a number that no float holds."""
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
    """The text, without its quotation marks if it has any."""
    return str(_value(text, True))


def _takes_text(document: dict[str, Any], path: list[str], present: Any) -> bool:
    """Return whether a key takes text: its value is text, or its block's parameter is declared so."""
    from fesloop.forms.schema import hints_of

    if isinstance(present, str):
        return True
    if path[0] != "blocks" or len(path) != 3:
        return False
    kind = document.get("blocks", {}).get(path[1], {}).get("kind")
    if kind not in registry.kinds():
        return False
    hint = hints_of(registry.find(kind)).get(path[2])
    return hint is str or (get_origin(hint) in (Union, UnionType) and str in get_args(hint))
