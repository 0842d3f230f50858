"""Variants of an experiment file: named options, each a patch over the file (`overlay`).

    [variants.tracker]
    default = "vqf"
    [variants.tracker.vqf]
    description = "..."
    [variants.tracker.kortier]
    like = "vqf"                     applied after the patch of that option
    blocks.tracker.kind = "kortier"

The options of several variants are applied together; two options that change the same key are refused.
Where one gives a block another kind and removes parameters of the old kind, what others say of these has no
effect.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from itertools import combinations
from typing import TYPE_CHECKING, Any, Required

from fesloop.errors import InputError, InputErrors, did_you_mean
from fesloop.experiment.files.overlay import (
    ABSENT,
    EXTENDING,
    PATCHED,
    Tables,
    blocks_of,
    is_patchable,
    key_parts,
    key_text,
    keyed,
    patched,
    plain_lists,
    same,
    wire_ends,
)
from fesloop.experiment.files.settings import text_value

if TYPE_CHECKING:
    from pydantic import TypeAdapter


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Picked:
    """An experiment file with the options of its variants applied.

    Attributes
    ----------
    document: its tables, without variants.
    settings: settings that pick no option.
    variants: variants of the file, as `listed` gives them.
    options: the option of each variant.
    name: name for messages, with the options that a setting picked.
    """

    document: Tables
    settings: tuple[str, ...]
    variants: Mapping[str, Any]
    options: Mapping[str, str]
    name: str


def pick(document: Mapping[str, Any], settings: Sequence[str], name: str) -> Picked:
    """Apply an option of each variant: the one of the last setting "NAME=OPTION", or the default.

    Every option is tried on the file, also those that are not picked. A file of the wrong form is left to the
    check of the whole document. Raises InputError, InputErrors for faults of the variants, for an unknown
    option, and for two options that change the same key.
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
    from_settings = _picked_options(variants, settings, name)
    options = {variant: from_settings.get(variant, table["default"]) for variant, table in variants.items()}
    picked = [f"{variant}={option}" for variant, option in options.items() if variant in from_settings]
    full_name = f"{name} with {', '.join(picked)}" if picked else name
    chosen = {key_text(("variants", *pair)): made[pair] for pair in options.items()}
    together = _together(keyed(base), chosen, name)
    for pair in options.items():
        _require_obeyed(keyed(base) | layers, made, variants[pair[0]], pair, pair[0] in from_settings, name)
    tables = plain_lists(together)
    return Picked(document=_described(tables, variants, options), options=options, name=full_name,
                  variants=listed(document), settings=others)


def listed(document: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Variants of a valid document: the default, and each option with its description."""
    return {variant: {"default": table["default"], "options": {
        option: patch.get("description", "") for option, patch in table.items() if option != "default"}}
        for variant, table in document.get("variants", {}).items()}


def named_with_options(fault: InputError, document: Mapping[str, Any], picked: Picked) -> InputError:
    """The fault, or all of several, with the options that leave out a wire whose port does not exist.

    A wire that suits the block of one option stays when a setting replaces that block by another.
    """
    if isinstance(fault, InputErrors):
        return InputErrors([named_with_options(each, document, picked) for each in fault.faults])
    _, is_wire, name = fault.where.rpartition(": wire ")
    if not is_wire or "put port" not in fault.found:
        return fault
    ways = []
    for variant, option in picked.options.items():
        without = [other for other in picked.variants[variant]["options"]
                   if other != option and not _has_wire(document, {**picked.options, variant: other}, name)]
        if without:
            ways.append(f"the wire is there with {variant}={option}; without it: "
                        + ", ".join(f"{variant}={other}" for other in without))
    return InputError(fault.where, fault.found, fault.allowed, "; ".join(ways) or fault.remedy)


def _has_wire(document: Mapping[str, Any], options: Mapping[str, str], name: str) -> bool:
    """Whether an experiment file has a wire with these options of its variants."""
    try:
        tables = pick(document, [f"{variant}={option}" for variant, option in options.items()], "").document
    except InputError:
        return True  # options that do not go together are no remedy
    return any(f"{wire.get('from')}->{wire.get('to')}" == name for wire in tables.get("wires", ()))


def _key(setting: str) -> str:
    return setting.partition("=")[0].strip()


def _picked_options(variants: Tables, settings: Sequence[str], name: str) -> dict[str, str]:
    """Options that settings pick, by variant; raises InputError for an unknown option."""
    picked = {}
    for setting in settings:
        variant = _key(setting)
        if variant in variants:
            option, known = text_value(setting.partition("=")[2].strip()), options_of(variants[variant])
            if option not in known:
                raise InputError(f"--set {setting}", f"{name} has no {variant} of this name",
                                 ", ".join(known), did_you_mean(option, known))
            picked[variant] = option
    return picked


def options_of(table: Mapping[str, Any]) -> list[str]:
    """Names of a variant's options."""
    return [option for option in table if option != "default"]


@cache
def _form() -> tuple[Any, TypeAdapter[Any]]:
    """Typed dict of `[variants]` without its defaults, and its validator."""
    from pydantic import TypeAdapter

    from fesloop.experiment.files.layout import option_table
    from fesloop.forms.schema import closed

    option: Any = option_table()
    form = closed("Variants", {"variants": Required[dict[str, dict[str, option]]]})
    return form, TypeAdapter(form)


def checked_variants(variants: Any, base: Tables) -> Tables:
    """Return the variants; raises InputErrors if they are not of the declared form."""
    from pydantic import ValidationError

    from fesloop.forms.faults import faults_of
    from fesloop.forms.schema import keys_at

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
    """Faults of a variant's name, of its default and of the `like` of its options."""
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
    """Faults of aliases that have the name of a variant, or that name a wire by its number."""
    every = [(name, key_parts(each)) for name, targets in aliases.items()
             for each in (targets if isinstance(targets, list) else [targets])]
    twice = [InputError(f"{where}.{name}", "is the name of a variant too", "one of the two", "rename one")
             for name in aliases if name in variants]
    return twice + [
        InputError(f"{where}.{name}", "names a wire by its number", 'wires."FROM->TO".KEY',
                   "variants change what numbers wires have")
        for name, path in every if path[:1] == ["wires"] and path[1:2] and path[1].isdigit()]


def _made(variants: Tables, base: Tables) -> dict[tuple[str, str], Tables]:
    """Keyed document with each option applied; raises InputErrors for those that cannot be applied."""
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
    """Apply the patches of an option and of those that it is `like`, the last of that chain first."""
    line = [option]
    while "like" in table[line[-1]]:
        line.append(table[line[-1]]["like"])
        if line[-1] in line[:-1]:
            raise InputError(key_text(("variants", variant, option, "like")), "refers back to itself",
                             "an option that is not like this one")
    return reduce(lambda document, each: patched(
        document, table[each], key_text(("variants", variant, each))), reversed(line), base)


def _require_obeyed(base: Tables, made: Mapping[tuple[str, str], Tables], table: Tables,
                    picked: tuple[str, str], is_set: bool, name: str) -> None:
    """Raise InputError where an option of an extended file changes a key that the extending file sets."""
    line = [picked[1]]
    while "like" in table[line[-1]]:
        line.append(table[line[-1]]["like"])
    key = overruled(base, made[picked], picked[0], line, is_set)
    if key:
        place = key_text(("variants", *picked))
        raise InputError(f"{name}: {key}", f"is set by the file, and changed by {place} of what it extends",
                         "one of the two", f"set it under [{place}] too, or remove the variant")


def overruled(document: Mapping[str, Any], changed: Mapping[str, Any], variant: str,
              options: Sequence[str], asked: bool) -> str:
    """First key that an extending file sets and that an option of an extended file changes; "" if none.

    A file may also set the key under the option, or under one that the option is like (`options`). An option
    that a setting selects (`asked`) may remove the key. `document` and `changed` are keyed, before and after
    the option.
    """
    layers = document.get(EXTENDING, ())
    for number, own in enumerate(layers):
        patches = [_by_ends(each.get("variants", {}).get(variant, {}).get(option, {}))
                   for each in layers[number:] for option in options]
        for path in _leaves({key: own[key] for key in own if key in PATCHED and key != "aliases"}):
            was, now = _at(document, path), _at(changed, path)
            if same(was, now) or not same(_at(own, path), was) or (now is ABSENT and asked):
                continue
            if not any(_says(patch, path) for patch in patches):
                return key_text(path)
    return ""


def _says(patch: Mapping[str, Any], path: tuple[str, ...]) -> bool:
    """Return whether a patch sets or removes a key."""
    removed = [key_parts(key) for key in patch.get("remove", ())]
    return _at(patch, path) is not ABSENT or any(list(path[:len(each)]) == each for each in removed)


def _by_ends(patch: Mapping[str, Any]) -> Tables:
    return {**patch, "wires": {wire_ends(wire): wire for wire in patch.get("wires", ())}}


def _leaves(tables: Mapping[str, Any], path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Paths of all values that are no tables."""
    for key, value in tables.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, (*path, key))
        else:
            yield (*path, key)


def _at(tables: Any, path: Sequence[str]) -> Any:
    """Value at a path; ABSENT if there is none."""
    for part in path:
        if not isinstance(tables, Mapping) or part not in tables:
            return ABSENT
        tables = tables[part]
    return tables


def _together(base: Tables, chosen: Mapping[str, Tables], name: str) -> Tables:
    """Apply all options; raises InputError for two that change the same key."""
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


def combined(base: Any, one: Any, other: Any, path: tuple[str, ...] = ()) -> Any:
    """Merge the changes that two documents make to the same base; the order does not matter.

    A parameter that one of them removes with a block's kind is removed, whatever the other one makes of it.
    Raises InputError at the path of a value that they change in two ways.
    """
    if same(one, other) or same(base, other):
        return one
    if same(base, one):
        return other
    old = {} if base is ABSENT else base
    if not all(isinstance(each, dict) for each in (old, one, other)):
        raise InputError(key_text(path), "is changed in two ways")
    found = {}
    for key in dict.fromkeys([*one, *other]):
        was, first, second = (each.get(key, ABSENT) for each in (old, one, other))
        if len(path) == 2 and path[0] == "blocks" and (_goes(key, old, one) or _goes(key, old, other)):
            continue
        found[key] = combined(was, first, second, (*path, key))
    return {key: value for key, value in found.items() if value is not ABSENT}


def _goes(parameter: str, base: Mapping[str, Any], block: Mapping[str, Any]) -> bool:
    """Return whether a block of another kind than in the base is without a parameter of the base."""
    return parameter in base and parameter not in block and block.get("kind") != base.get("kind")


def cut_off(base: Mapping[str, Any], one: Mapping[str, Any], other: Mapping[str, Any]) -> str:
    """First wire that `one` adds to a block that `other` removes; "" if there is none."""
    gone = set(base["blocks"]) - set(other["blocks"])
    return next((ends for ends in one["wires"] if ends not in base["wires"] and gone & blocks_of(ends)), "")


def _described(tables: Tables, variants: Tables, options: Mapping[str, str]) -> Tables:
    """Append the descriptions of options that are not the default to that of the document."""
    added = [f"{variant} {option}: {variants[variant][option]['description']}"
             for variant, option in options.items()
             if option != variants[variant]["default"] and "description" in variants[variant][option]]
    about = tables.get("experiment", {})
    if added and isinstance(about.get("description", ""), str):
        about = {**about, "description": "; ".join(filter(None, [about.get("description", ""), *added]))}
    return {**tables, "experiment": about} if "experiment" in tables else tables
