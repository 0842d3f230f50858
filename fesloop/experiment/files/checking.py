"""What is wrong with the tables of an experiment file, all of it at once."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from pydantic import TypeAdapter, ValidationError

from fesloop.errors import InputError, InputErrors
from fesloop.experiment import registry
from fesloop.experiment.files.layout import experiment_table, keys_at
from fesloop.forms.faults import faults_of
from fesloop.forms.schema import Kinds

_FORMS = 32
"""Forms kept, the last used: 1.2 MB each, and cells of a study rarely differ in more sets of kinds."""


def kinds_in(document: Any) -> dict[str, type[Any]]:
    """Classes of the kinds that a document names, wherever it does."""
    named: set[str] = set()
    pending = [document.get("blocks")]
    while pending:
        value = pending.pop()
        if isinstance(value, dict):
            pending += value.values()
            if isinstance(value.get("kind"), str):
                named.add(value["kind"])
        elif isinstance(value, list):
            pending += value
    return {kind: registry.find(kind) for kind in sorted(named.intersection(registry.kinds()))}


def check(document: dict[str, Any], kinds: Kinds, faults: list[InputError]) -> None:
    """Raise InputErrors naming everything that is not of the declared form, and the `faults` known before."""
    raise_all(faults + faults_of_form(document, kinds))


def faults_of_form(document: dict[str, Any], kinds: Kinds) -> list[InputError]:
    """Everything that is not of the declared form."""
    unknown = _blocks_of_no_kind(document, kinds)
    faults = [_unknown_kind(name, table) for name, table in unknown]
    hidden = tuple(f"blocks.{name}" for name, _ in unknown)
    faults += [each for each in _faults_of_values(document, kinds) if each.where not in hidden
               and not each.where.startswith(tuple(f"{place}." for place in hidden))]
    return [_with_alias(fault, document) for fault in faults]


def _faults_of_values(document: Any, kinds: Kinds) -> list[InputError]:
    """Unknown and missing keys, and values of another type."""
    table, adapter = _form(tuple(kinds.items()))
    try:
        adapter.validate_json(json.dumps(document))
    except ValidationError as fault:
        return faults_of(fault.errors(include_url=False), document,
                         lambda path: keys_at(table, path, document), tagged=len(kinds) > 1)
    return []


@lru_cache(maxsize=_FORMS)
def _form(kinds: tuple[tuple[str, type[Any]], ...]) -> tuple[Any, TypeAdapter[Any]]:
    """Typed dict of a file whose blocks are of these kinds, and what holds tables against it."""
    table = experiment_table(dict(kinds))
    return table, TypeAdapter(table)


def _with_alias(fault: InputError, document: dict[str, Any]) -> InputError:
    """The fault of a missing key, with the alias by which the command line can give it."""
    aliases = document.get("aliases")
    if fault.found == "is missing" and isinstance(aliases, dict):
        for alias, paths in aliases.items():
            if any(path == fault.where or str(path).startswith(f"{fault.where}.")
                   for path in (paths if isinstance(paths, list) else [paths])):
                return InputError(fault.where, fault.found, fault.allowed, f"give it with --set {alias}=...")
    return fault


def _blocks_of_no_kind(document: dict[str, Any], kinds: Kinds) -> list[tuple[str, Any]]:
    blocks = document.get("blocks")
    tables = blocks.items() if isinstance(blocks, dict) else ()
    known = list(kinds)  # compared, not hashed: what stands there may be a list
    return [(name, table) for name, table in tables
            if isinstance(table, dict) and table.get("kind") not in known]


def _unknown_kind(name: str, table: dict[str, Any]) -> InputError:
    where = f"blocks.{name}.kind"
    if "kind" not in table:
        return InputError(where, "is missing", ", ".join(registry.kinds()), "add it")
    if not isinstance(table["kind"], str):
        return InputError(where, f"{table['kind']!r} is not text", ", ".join(registry.kinds()))
    try:
        registry.find(table["kind"])
    except InputError as fault:
        return InputError(where, fault.found, fault.allowed, fault.remedy)
    raise AssertionError(f"{name} is of a known kind")


def raise_all(faults: Sequence[InputError]) -> None:
    """Raise these faults, if there are any, as one error."""
    if faults:
        raise InputErrors(list(faults)) if len(faults) > 1 else faults[0]
