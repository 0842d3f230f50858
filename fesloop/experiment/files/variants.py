"""`[variants.NAME.OPTION]`: what else an experiment can be, of which `--set NAME=OPTION` picks one.

    [variants.plant]
    default = "hand"

    [variants.plant.hand]
    description = "the whole hand"

    [variants.plant.finger]
    description = "a finger in its place"
    remove = ["patient", "blocks.hand"]
    wires = [{ from = "safety.stimulation", to = "finger.stimulation" }]
    blocks.finger = { kind = "finger" }

    [variants.plant.fmu]
    like = "finger"
    blocks.finger = { kind = "fmu", path = "shipped:finger" }

An option is a patch over the file (`fesloop.experiment.files.patches`), made after that of the option that
it is `like`. Options of several variants are made together, in whatever order they are picked, or refuse each
other where they would change the same key in two ways. Other settings come after them. Descriptions of the
options that are not the default are added to the experiment's own.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from itertools import combinations
from typing import Any, Required

from pydantic import TypeAdapter, ValidationError

from fesloop.errors import InputError, InputErrors, did_you_mean
from fesloop.experiment.files.layout import option_table
from fesloop.experiment.files.patches import (
    EXTENDING,
    combined,
    cut_off,
    is_patchable,
    keyed,
    overruled,
    patched,
    plain_lists,
)
from fesloop.experiment.files.settings import key_parts, key_text, text_value
from fesloop.forms.faults import faults_of
from fesloop.forms.schema import closed, keys_at

Tables = dict[str, Any]


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
