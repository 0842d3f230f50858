"""Patients from TOML files: presets by name, and users' files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fesloop.errors import InputError, InputErrors, did_you_mean
from fesloop.forms.toml import TomlError, tables_of
from fesloop.given_files import read_whole

if TYPE_CHECKING:
    from pydantic import TypeAdapter

    from plants.patients.patient import Patient


def names() -> list[str]:
    """Names of the presets."""
    folder = resources.files("plants") / "patients"
    return sorted(file.name.removesuffix(".toml") for file in folder.iterdir() if file.name.endswith(".toml"))


def presets() -> dict[str, str]:
    """Names of the presets, with a description each."""
    return {name: str(_tables(name, _preset(name)).get("description", "")) for name in names()}


def load(file: str | Path) -> Patient:
    """Load a preset by name, or the patient of a TOML file.

    Raises InputError or InputErrors with every fault of the file.
    """
    text = str(file)
    if isinstance(file, str) and not text.endswith(".toml") and "/" not in text:
        if text not in names():
            raise InputError(text, "no patient has this name", ", ".join(names()),
                             did_you_mean(text, names()) or "or give the path of a .toml file")
        content = _preset(text)
    else:
        content = read_whole(text, "a patient's file")
    return from_table(_tables(text, content), text)


def _preset(name: str) -> bytes:
    return (resources.files("plants") / "patients" / f"{name}.toml").read_bytes()


def _tables(name: str, content: bytes) -> dict[str, Any]:
    """Parse a patient's file; `name` begins every fault."""
    try:
        return tables_of(content.decode("utf-8-sig"))
    except UnicodeDecodeError as fault:
        raise InputError(name, f"is not UTF-8 text (byte {fault.start})", "a TOML file") from None
    except TomlError as fault:
        raise InputError(name, f"is not TOML: {fault}", remedy="correct the line") from None


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
