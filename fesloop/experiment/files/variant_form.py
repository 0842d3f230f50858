"""The form of `[variants]`: what is wrong with it before any option is made to the file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from typing import Any, Required

from pydantic import TypeAdapter, ValidationError

from fesloop.errors import InputError, InputErrors, did_you_mean
from fesloop.experiment.files.layout import keys_at, option_table
from fesloop.experiment.files.settings import key_parts, key_text
from fesloop.forms.faults import faults_of
from fesloop.forms.schema import closed

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
