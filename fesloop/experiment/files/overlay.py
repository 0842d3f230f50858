"""A patch over the tables of an experiment file, and several patches at once.

    remove = ["patient", "blocks.hand.object"]   first of all; with a block go its wires and its signals in
                                                 [record]; last of all go aliases that lead to
                                                 what is not there any more
    blocks.tracker.kind = "vqf"                  tables are merged key by key, here and in all tables below;
                                                 any other value, a list too, takes the place of the old one,
                                                 and so does a table within a block or wire that
                                                 is of another `kind`, or of a `file` in place of a kind
    wires = [{ from = "a.b", to = "c.d" }]       added; merged into a wire between the same ports

Keys are dotted paths as in --set; that of a wire is `wires."a.b->c.d"`.
"""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from itertools import combinations
from pathlib import Path
from types import UnionType
from typing import Any, Required, Union, get_args, get_origin

from pydantic import TypeAdapter, ValidationError

from fesloop.errors import InputError, InputErrors, did_you_mean
from fesloop.experiment import registry
from fesloop.experiment.files.layout import option_table
from fesloop.experiment.files.patients import require_no_other
from fesloop.experiment.files.source import placed_value
from fesloop.forms.faults import faults_of
from fesloop.forms.schema import closed, hints_of, keys_at
from fesloop.forms.toml import DEEPEST, TomlError, TooLargeError, tables_of

_TOP = ("experiment", "patient", "record", "blocks", "links", "wires", "score")
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


BESIDE = ("guide", "variants")
"""Tables of a file that no variant changes, and a file that extends another may."""
EXTENDING = "said by files that extend others"
"""Key under which a document has what each file said that it is made of, but the first."""
PATCHED = ("experiment", "patient", "record", "blocks", "links", "wires", "score", "aliases")
"""Tables of a file that a patch may change."""
_SIGNALS = ("timed", "leave_out")
"""Lists of [record] that name blocks and signals."""
_MEMBER = ("kind", "file")
"""Keys that say which of several forms a table has."""
_ABSENT = object()
Tables = dict[str, Any]


def keyed(document: Mapping[str, Any]) -> Tables:
    """A copy of a document whose wires stand under their ends and whose lists of signals under the signals,
    so that patches find them wherever they stand. Its form must be that of `is_patchable`."""
    return _named(copy.deepcopy(dict(document)))


def _named(made: Tables) -> Tables:
    """As `keyed`, tables that nobody else has."""
    wires = made.get("wires", [])
    made["wires"] = _by_name(wires, [_ends(wire) for wire in wires])
    for key in _SIGNALS:
        if key in made.get("record", {}):
            made["record"][key] = _by_name(made["record"][key], made["record"][key])
    return made


def plain_lists(document: Mapping[str, Any]) -> Tables:
    """A keyed document as a file has it."""
    made = {**document, "wires": list(document["wires"].values())}
    if "record" in made:
        made["record"] = {key: list(value.values()) if isinstance(value, dict) else value
                          for key, value in made["record"].items()}
    return made


def is_patchable(document: Mapping[str, Any]) -> bool:
    """Whether tables are tables and wires have ends; all else is for the document's check."""
    tables = [document.get(key, {}) for key in PATCHED if key != "wires"]
    wires = document.get("wires", [])
    if not isinstance(wires, list) or not all(isinstance(each, dict) for each in tables + wires):
        return False
    record = document.get("record", {})
    texts = [value for key in _SIGNALS for value in _listed(record.get(key, []))]
    texts += [wire.get(end) for wire in wires for end in ("from", "to")]
    texts += [target for value in document.get("aliases", {}).values()
              for target in (value if isinstance(value, list) else [value])]
    return (all(isinstance(text, str) for text in texts)
            and all(isinstance(block, dict) for block in document.get("blocks", {}).values()))


def _listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [None]


def patched(document: Mapping[str, Any], patch: Mapping[str, Any], where: str) -> Tables:
    """A keyed document with a patch made to it; `where` the patch stands leads every fault.

    Raises InputError for a removal of what is not there.
    """
    made = copy.deepcopy(dict(document))
    place = f"{where}.remove" if where else "remove"
    gone = [path for number, key in enumerate(patch.get("remove", ()))
            for path in _remove(made, key_parts(key), f"{place}[{number}]")]
    for key in PATCHED:
        if key in patch and key != "wires":
            made[key] = merged(made.get(key, {}), patch[key], 0 if key in ("blocks", "links") else 1)
    for wire in patch.get("wires", ()):
        made["wires"][_ends(wire)] = merged(made["wires"].get(_ends(wire), {}), wire, 1)
    _drop_aliases(made, [path for path in gone if not _stands(made, path)])
    return _named(plain_lists(made))


def extended(base: Mapping[str, Any], document: Mapping[str, Any]) -> Tables:
    """Tables of a file over those of the one that it extends: a patch that may change [guide] and [variants].

    Raises InputError for tables that are of no form to be laid over each other, or a removal of what is not
    there.
    """
    for each, told in ((base, "what it extends"), (document, "this file")):
        if not is_patchable({key: value for key, value in each.items() if key not in BESIDE}):
            raise InputError(told, "has no such form that one can be laid over the other",
                             "blocks, wires with from and to, and other tables of an experiment file")
    removed = document.get("remove", [])
    if not isinstance(removed, list) or not all(isinstance(key, str) for key in removed):
        raise InputError("remove", f"{removed!r}", "a list of key paths")
    beside = [key for key in removed if key_parts(key)[:1] and key_parts(key)[0] in BESIDE]
    made = plain_lists(patched(keyed({key: base[key] for key in PATCHED if key in base}), {
        **document, "remove": [key for key in removed if key not in beside]}, ""))
    rest = {key: copy.deepcopy(base[key]) for key in base if key not in PATCHED}
    for number, key in enumerate(beside):
        _take_out(rest, key_parts(key), f"remove[{number}]")
    rest |= {key: merged(rest.get(key, {}), value) for key, value in document.items()
             if key not in (*PATCHED, "remove", EXTENDING)}
    own = {key: value for key, value in keyed(document).items() if key in (*PATCHED, *BESIDE)}
    return made | rest | {EXTENDING: [*base.get(EXTENDING, []), own]}


def of_its_own(document: Mapping[str, Any]) -> Tables:
    """A document without the description and [guide] of what it extends, which say nothing of it."""
    made = dict(document)
    if EXTENDING not in document:
        return made
    own = document[EXTENDING][-1]
    if "description" not in own.get("experiment", {}) and "experiment" in made:
        made["experiment"] = {key: value for key, value in made["experiment"].items() if key != "description"}
    if "guide" not in own:
        made.pop("guide", None)
    return made


def overruled(document: Mapping[str, Any], changed: Mapping[str, Any], variant: str,
              options: Sequence[str], asked: bool) -> str:
    """The first key that a file says over those that it extends, and that an option of theirs changes.

    An option that somebody has `asked` for may take the key out.

    Parameters
    ----------
    document, changed: keyed, before and after the option. A file that says of the key what it is to be with
        the option, or with one that the option is like (`options`), is obeyed.
    """
    layers = document.get(EXTENDING, ())
    for number, own in enumerate(layers):
        patches = [_by_ends(each.get("variants", {}).get(variant, {}).get(option, {}))
                   for each in layers[number:] for option in options]
        for path in _leaves({key: own[key] for key in own if key in PATCHED and key != "aliases"}):
            was, now = _at(document, path), _at(changed, path)
            if _same(was, now) or not _same(_at(own, path), was) or (now is _ABSENT and asked):
                continue
            if not any(_says(patch, path) for patch in patches):
                return key_text(path)
    return ""


def _says(patch: Mapping[str, Any], path: tuple[str, ...]) -> bool:
    """Whether a patch gives a key or takes it out."""
    removed = [key_parts(key) for key in patch.get("remove", ())]
    return _at(patch, path) is not _ABSENT or any(list(path[:len(each)]) == each for each in removed)


def _by_ends(patch: Mapping[str, Any]) -> Tables:
    return {**patch, "wires": {_ends(wire): wire for wire in patch.get("wires", ())}}


def _leaves(tables: Mapping[str, Any], path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Paths of all that is no table."""
    for key, value in tables.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, (*path, key))
        else:
            yield (*path, key)


def _at(tables: Any, path: Sequence[str]) -> Any:
    """What stands at a path."""
    for part in path:
        if not isinstance(tables, Mapping) or part not in tables:
            return _ABSENT
        tables = tables[part]
    return tables


def merged(old: Any, new: Any, depth: int = 0) -> Any:
    """What is new over what is old: tables merged, all else in the old one's place.

    `depth`: of the tables; a block is at 1. A table within one that is of another kind, or is made from a
    file where the old one has a kind, takes the old one's place: keys of one kind are none of another.
    """
    if not (isinstance(old, dict) and isinstance(new, Mapping)) or (depth > 1 and _is_another(old, new)):
        return copy.deepcopy(new)
    return {**old, **{key: merged(old.get(key), value, depth + 1) for key, value in new.items()}}


def _is_another(old: Mapping[str, Any], new: Mapping[str, Any]) -> bool:
    """Whether a table is of another kind than the one that it is laid over."""
    told, had = ({key for key in _MEMBER if key in table} for table in (new, old))
    return bool(told) and bool(had) and (told != had or new.get("kind") != old.get("kind"))


def _remove(document: Tables, path: list[str], where: str) -> list[list[str]]:
    """Take out what stands at a path, and what cannot be without it; their paths."""
    _take_out({key: document[key] for key in PATCHED if key in document}, path, where)
    if len(path) == 1:
        del document[path[0]]
    document.setdefault("wires", {})
    return [path, *(_detach(document, path[1]) if path[0] == "blocks" and len(path) == 2 else [])]


def _take_out(tables: Tables, path: Sequence[str], where: str) -> None:
    """Take out what stands at a path; raises InputError if there is nothing."""
    holder: Any = {}
    here: Any = tables
    for depth, part in enumerate(path or [""]):
        if not isinstance(here, dict) or part not in here:
            known = list(here) if isinstance(here, dict) else []
            raise InputError(where, f"there is no {key_text(path[:depth + 1])!r}", ", ".join(known),
                             did_you_mean(part, known))
        holder, here = here, here[part]
    del holder[path[-1]]


def _stands(here: Any, path: Sequence[str]) -> bool:
    for part in path:
        if not isinstance(here, dict) or part not in here:
            return False
        here = here[part]
    return True


def _detach(document: Tables, block: str) -> list[list[str]]:
    """Take a block's signals out of wires and record; the paths of the wires."""
    touching = [ends for ends in document["wires"] if block in blocks_of(ends)]
    for ends in touching:
        del document["wires"][ends]
    for key in _SIGNALS:
        if key in document.get("record", {}):
            document["record"][key] = {name: signal for name, signal in document["record"][key].items()
                                       if signal.partition(".")[0] != block}
    return [["wires", ends] for ends in touching]


def _drop_aliases(document: Tables, gone: Sequence[list[str]]) -> None:
    """Take out aliases, or what of them leads to a path that is gone."""
    left = {}
    for name, targets in document.get("aliases", {}).items():
        listed = targets if isinstance(targets, list) else [targets]
        kept = [each for each in listed
                if not any(key_parts(each)[:len(path)] == path for path in gone)]
        if kept:
            left[name] = kept if isinstance(targets, list) else kept[0]
    if "aliases" in document:
        document["aliases"] = left


def combined(base: Any, one: Any, other: Any, path: tuple[str, ...] = ()) -> Any:
    """The changes of both, each made to the same base, whichever of them is first.

    Raises InputError at the path of what they change in two ways.
    """
    if _same(one, other) or _same(base, other):
        return one
    if _same(base, one):
        return other
    old = {} if base is _ABSENT else base
    if not all(isinstance(each, dict) for each in (old, one, other)):
        raise InputError(key_text(path), "is changed in two ways")
    found = {}
    for key in dict.fromkeys([*one, *other]):
        was, first, second = (each.get(key, _ABSENT) for each in (old, one, other))
        found[key] = combined(was, first, second, (*path, key))
    return {key: value for key, value in found.items() if value is not _ABSENT}


def cut_off(base: Mapping[str, Any], one: Mapping[str, Any], other: Mapping[str, Any]) -> str:
    """The first wire that `one` adds to a block that `other` takes out; "" if there is none."""
    gone = set(base["blocks"]) - set(other["blocks"])
    return next((ends for ends in one["wires"] if ends not in base["wires"] and gone & blocks_of(ends)), "")


def blocks_of(ends: str) -> set[str]:
    """Names of the two blocks of a wire's ends, `a.b->c.d`."""
    return {end.partition(".")[0] for end in ends.split("->")}


def _ends(wire: Mapping[str, str]) -> str:
    return f"{wire['from']}->{wire['to']}"


def _by_name(items: Sequence[Any], names: Sequence[str]) -> dict[str, Any]:
    """Items by their names; the second of a name and later ones are numbered, for the check to find."""
    made: dict[str, Any] = {}
    for name, item in zip(names, items, strict=True):
        again = sum(1 for other in made if other.partition(" ")[0] == name)
        made[f"{name} ({again + 1})" if again else name] = item
    return made


def _same(one: Any, other: Any) -> bool:
    """Whether two values are written alike: 1, 1.0 and true are not."""
    if one is _ABSENT or other is _ABSENT:
        return one is other
    return json.dumps(one, sort_keys=True) == json.dumps(other, sort_keys=True)


def options_of(table: Mapping[str, Any]) -> list[str]:
    """Names of a variant's options."""
    return [option for option in table if option != "default"]


@cache
def _form() -> tuple[Any, TypeAdapter[Any]]:
    """Typed dict of `[variants]` without its defaults, and what holds tables against it."""
    option: Any = option_table()
    form = closed("Variants", {"variants": Required[dict[str, dict[str, option]]]})
    return form, TypeAdapter(form)


def checked_variants(variants: Any, base: Tables) -> Tables:
    """The variants, if they are of the declared form; raises InputErrors."""
    if not isinstance(variants, dict) or not all(isinstance(table, dict) for table in variants.values()):
        raise InputErrors([InputError("variants", "is no table of tables", "[variants.NAME.OPTION]")])
    patches = {"variants": {variant: {option: table[option] for option in options_of(table)}
                            for variant, table in variants.items()}}
    form, adapter = _form()
    faults = []
    try:
        adapter.validate_json(json.dumps(patches))
    except ValidationError as fault:
        faults = faults_of(fault.errors(include_url=False), patches,
                           lambda path: keys_at(form, path, patches), tagged=False)
    for variant, table in variants.items():
        faults += _faults_of_names(variant, table)
    faults += faults_of_aliases("aliases", base.get("aliases", {}), variants)
    if faults:
        raise InputErrors(faults)
    return variants


def _faults_of_names(variant: str, table: Tables) -> list[InputError]:
    """What is wrong with a variant's name, its default and what its options are like."""
    where, known, faults = key_text(("variants", variant)), options_of(table), []
    if key_text(("variants", variant)) != f"variants.{variant}":
        faults.append(InputError(where, "is no name for --set", "letters, digits, - and _"))
    for key, named in (("default", table.get("default")),
                       *((f"{option}.like", patch["like"]) for option, patch in table.items()
                         if isinstance(patch, dict) and "like" in patch)):
        if named is None:
            faults.append(InputError(f"{where}.{key}", "is missing", ", ".join(known), "add it"))
        elif named not in known:
            faults.append(InputError(f"{where}.{key}", f"{named!r} is no option of {variant}",
                                     ", ".join(known), did_you_mean(str(named), known)))
    return faults


def faults_of_aliases(where: str, aliases: Mapping[str, str | list[str]],
                      variants: Tables) -> list[InputError]:
    """Aliases that are variants as well, and those that tell wires by their numbers."""
    every = [(name, key_parts(each)) for name, targets in aliases.items()
             for each in (targets if isinstance(targets, list) else [targets])]
    twice = [InputError(f"{where}.{name}", "is the name of a variant too", "one of the two", "rename one")
             for name in aliases if name in variants]
    return twice + [
        InputError(f"{where}.{name}", "names a wire by its number", 'wires."FROM->TO".KEY',
                   "variants change what numbers wires have")
        for name, path in every if path[:1] == ["wires"] and path[1:2] and path[1].isdigit()]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Picked:
    """An experiment file with its variants settled.

    Attributes
    ----------
    document: its tables, without variants.
    settings: what of the settings picks no option.
    variants: of the file, as `listed`.
    options: the option of each variant.
    name: for messages; it tells options that are not the file's defaults.
    """

    document: Tables
    settings: tuple[str, ...]
    variants: Mapping[str, Any]
    options: Mapping[str, str]
    name: str


def pick(document: Mapping[str, Any], settings: Sequence[str], name: str) -> Picked:
    """Settle the variants of a file by settings "NAME=OPTION", the last of a name, or by their defaults.

    Every option is made to the file, also those that are not picked. A file of the wrong form is left for its
    check. Raises InputError, InputErrors: what is wrong with the variants, with an option asked for, or
    with two options together.
    """
    base = {key: value for key, value in document.items() if key not in ("variants", EXTENDING)}
    declared = document.get("variants", {})
    others = tuple(each for each in settings if not isinstance(declared, dict) or _key(each) not in declared)
    if "variants" not in document or not is_patchable(base):
        return Picked(document=base, settings=others, variants={}, options={}, name=name)
    try:
        variants = checked_variants(declared, base)
        layers = {EXTENDING: document[EXTENDING]} if EXTENDING in document else {}
        made = _made(variants, keyed(base))
    except InputErrors as several:
        raise several.within(name) from None
    asked = _asked(variants, settings, name)
    options = {variant: asked.get(variant, table["default"]) for variant, table in variants.items()}
    told = [f"{variant}={option}" for variant, option in options.items() if variant in asked]
    full_name = f"{name} with {', '.join(told)}" if told else name
    chosen = {key_text(("variants", *pair)): made[pair] for pair in options.items()}
    together = _together(keyed(base), chosen, name)
    for pair in options.items():
        _require_obeyed(keyed(base) | layers, made, variants[pair[0]], pair, pair[0] in asked, name)
    tables = plain_lists(together)
    return Picked(document=_described(tables, variants, options), options=options, name=full_name,
                  variants=listed(document), settings=others)


def listed(document: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """The variants of a sound document: default, and each option with its description."""
    return {variant: {"default": table["default"], "options": {
        option: patch.get("description", "") for option, patch in table.items() if option != "default"}}
        for variant, table in document.get("variants", {}).items()}


def _key(setting: str) -> str:
    return setting.partition("=")[0].strip()


def _asked(variants: Tables, settings: Sequence[str], name: str) -> dict[str, str]:
    """Options that settings pick, by variant; raises InputError for one that is not there."""
    asked = {}
    for setting in settings:
        variant = _key(setting)
        if variant in variants:
            option, known = text_value(setting.partition("=")[2].strip()), options_of(variants[variant])
            if option not in known:
                raise InputError(f"--set {setting}", f"{name} has no {variant} of this name",
                                 ", ".join(known), did_you_mean(option, known))
            asked[variant] = option
    return asked


def _made(variants: Tables, base: Tables) -> dict[tuple[str, str], Tables]:
    """The keyed document that each option makes of the file; raises InputErrors for those that cannot be."""
    made, faults = {}, []
    for variant, table in variants.items():
        for option in options_of(table):
            faults += faults_of_aliases(key_text(("variants", variant, option, "aliases")),
                                        table[option].get("aliases", {}), variants)
            try:
                made[variant, option] = _with_option(base, variant, table, option)
            except InputError as fault:
                faults.append(fault)
    if faults:
        raise InputErrors(list({str(fault): fault for fault in faults}.values()))
    return made


def _with_option(base: Tables, variant: str, table: Tables, option: str) -> Tables:
    """The document with the patches of an option and of those that it is like, first of them first."""
    line = [option]
    while "like" in table[line[-1]]:
        line.append(table[line[-1]]["like"])
        if line[-1] in line[:-1]:
            raise InputError(key_text(("variants", variant, option, "like")), "leads round in a circle",
                             "an option that is not like this one")
    return reduce(lambda document, each: patched(
        document, table[each], key_text(("variants", variant, each))), reversed(line), base)


def _require_obeyed(base: Tables, made: Mapping[tuple[str, str], Tables], table: Tables,
                    picked: tuple[str, str], asked: bool, name: str) -> None:
    """Raise InputError where an option of what a file extends changes what the file says itself."""
    line = [picked[1]]
    while "like" in table[line[-1]]:
        line.append(table[line[-1]]["like"])
    key = overruled(base, made[picked], picked[0], line, asked)
    if key:
        place = key_text(("variants", *picked))
        raise InputError(f"{name}: {key}", f"is said by the file, and changed by {place} of what it extends",
                         "one of the two", f"say it under [{place}] too, or remove the variant")


def _together(base: Tables, chosen: Mapping[str, Tables], name: str) -> Tables:
    """The changes of all options; raises InputError for two that refuse each other."""
    for (one, first), (other, second) in combinations(chosen.items(), 2):
        cut = cut_off(base, first, second) or cut_off(base, second, first)
        try:
            combined(base, first, second)
            key = key_text(("wires", cut)) if cut else ""
        except InputError as fault:
            key = fault.where
        if key:
            raise InputError(f"{name}: {one}", f"does not go with {other}: both change {key}",
                             "options that change different keys", "pick another one of the two")
    return reduce(lambda document, each: combined(base, document, each), chosen.values(), base)


def _described(tables: Tables, variants: Tables, options: Mapping[str, str]) -> Tables:
    """The document, its description followed by those of the options that are not the default."""
    told = [f"{variant} {option}: {variants[variant][option]['description']}"
            for variant, option in options.items()
            if option != variants[variant]["default"] and "description" in variants[variant][option]]
    about = tables.get("experiment", {})
    if told and isinstance(about.get("description", ""), str):
        about = {**about, "description": "; ".join(filter(None, [about.get("description", ""), *told]))}
    return {**tables, "experiment": about} if "experiment" in tables else tables
