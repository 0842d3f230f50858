"""Patients from TOML files: presets by name, and files of one's own."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from fesloop.errors import InputError, InputErrors, did_you_mean
from fesloop.forms.faults import faults_of
from fesloop.forms.schema import build, hints_of, keys_at, table
from fesloop.forms.toml import TomlError, tables_of
from fesloop.given_files import read_whole
from plants.patients.patient import Patient


def names() -> list[str]:
    """Names of the presets."""
    folder = resources.files("plants") / "patients"
    return sorted(file.name.removesuffix(".toml") for file in folder.iterdir() if file.name.endswith(".toml"))


def load(file: str | Path) -> Patient:
    """A preset by its name, or the patient of a TOML file.

    Raises InputError, InputErrors: every fault of the file, one line each, with file, key, found and allowed.
    """
    text = str(file)
    if isinstance(file, str) and not text.endswith(".toml") and "/" not in text:
        if text not in names():
            raise InputError(text, "there is no patient of this name", ", ".join(names()),
                             did_you_mean(text, names()) or "or give the path of a .toml file")
        content = (resources.files("plants") / "patients" / f"{text}.toml").read_bytes()
    else:
        content = read_whole(text, "a patient's file")
    try:
        tables = tables_of(content.decode("utf-8-sig"))
    except UnicodeDecodeError as fault:
        raise InputError(text, f"is not UTF-8 text (byte {fault.start})", "a TOML file") from None
    except TomlError as fault:
        raise InputError(text, f"is not TOML: {fault}", remedy="mend the line") from None
    return from_table(tables, text)


def from_table(tables: Mapping[str, Any], name: str = "patient") -> Patient:
    """The patient that plain tables describe, such as those of a file; `name` leads every fault."""
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
                every = fault.__cause__  # a section names all its faults; `build` speaks of the first
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
    """Typed dict of a patient's tables, and what holds them against it."""
    form = table(Patient, {})
    return form, TypeAdapter(form)


def _faults_of_form(document: dict[str, Any]) -> list[InputError]:
    """Unknown and missing keys, and values of the wrong type."""
    form, adapter = _form()
    try:
        adapter.validate_json(json.dumps(document))
    except ValidationError as fault:
        return faults_of(fault.errors(include_url=False), document,
                         lambda path: keys_at(form, path, document), tagged=False)
    return []
