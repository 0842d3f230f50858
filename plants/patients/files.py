"""Patients from TOML files: presets by name, and users' files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fesloop.errors import InputError, InputErrors
from fesloop.experiment.files.overlay import merged_without
from fesloop.experiment.files.source import Shelf, read_tables

if TYPE_CHECKING:
    from pydantic import TypeAdapter

    from plants.patients.patient import Patient


def _laid_over(base: dict[str, Any], document: Mapping[str, Any]) -> dict[str, Any]:
    base.pop(_EXTENDING, None)
    return merged_without(base, document) | {_EXTENDING: True}


_EXTENDING = "extends another file"
"""Key of tables that are made of several files."""
PATIENTS = Shelf("patient", "plants", _laid_over, folder="patients")


def names() -> list[str]:
    """Names of the presets."""
    return PATIENTS.names()


def presets() -> dict[str, str]:
    """Names of the presets, with a description each."""
    return {name: str(read_tables(name, PATIENTS)[1].get("description", "")) for name in names()}


def load(file: str | Path) -> Patient:
    """Load a preset by name, or the patient of a TOML file.

    A file with a key `extends`, the name of a preset or the path of another file from the folder of this
    one, has the values of that file in place of those that it does not state itself; keys in its list
    `remove` are taken out.

    Raises InputError or InputErrors with every fault of the file.
    """
    name, tables, _ = read_tables(file, PATIENTS)
    return from_table(tables, f"{name} over what it extends" if tables.pop(_EXTENDING, False) else name)


def from_table(tables: Mapping[str, Any], name: str = "patient") -> Patient:
    """Make a patient from plain tables, such as those of a file; `name` begins every fault."""
    from fesloop.forms.schema import build, hints_of
    from plants.patients.patient import Patient

    document = dict(tables)
    faults = _faults_of_form(document)
    wrong = {fault.where.partition(".")[0].partition("[")[0] for fault in faults}
    hints = hints_of(Patient)
    sections: dict[str, Any] = {}
    for key, value in document.items():
        if key in hints and key not in wrong:
            try:
                sections[key] = build(hints[key], value, {}, key)
            except InputError as fault:
                every = fault.__cause__  # a section raises all its faults; `build` raises the first
                faults += every.faults if isinstance(every, InputErrors) else [fault]
    if not faults:
        try:
            return Patient(**sections)
        except InputErrors as several:
            faults = several.faults
    raise InputErrors([InputError(f"{name}: {each.where}", each.found, each.allowed, each.remedy)
                       for each in faults])


@cache
def _form() -> tuple[Any, TypeAdapter[Any]]:
    """Typed dict of a patient's tables, and its validator."""
    from pydantic import TypeAdapter

    from fesloop.forms.schema import table
    from plants.patients.patient import Patient

    form = table(Patient, {})
    return form, TypeAdapter(form)


def _faults_of_form(document: dict[str, Any]) -> list[InputError]:
    """Unknown and missing keys, and values of the wrong type."""
    from pydantic import ValidationError

    from fesloop.forms.faults import faults_of
    from fesloop.forms.schema import keys_at

    form, adapter = _form()
    try:
        adapter.validate_json(json.dumps(document))
    except ValidationError as fault:
        return faults_of(fault.errors(include_url=False), document,
                         lambda path: keys_at(form, path, document), tagged=False)
    return []
