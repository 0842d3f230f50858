"""`model = { file = "..." }` under a controller: the patient's model that identification left, in its place.

So too `process = { file = "..." }` under a tracker: the error process that fesloop fit-error left.

It is put in when the experiment is read, so that a recording holds the model itself and needs no file. What
the file was made for is held against the experiment: patient, electrodes, currents, outputs.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeGuard, get_args

from fesloop.errors import InputError, InputErrors
from fesloop.experiment.files.patients import describe, patient_fingerprint
from fesloop.forms.schema import Kinds, hints_of, plain
from fesloop.models.error_process import ErrorProcess, error_process_table
from fesloop.models.linear_model import LinearModel
from fesloop.models.patient_model import (
    PatientModel,
    electrodes_in_words,
    load_patient_model,
    require_same,
    require_usable,
)


def with_models(document: dict[str, Any], kinds: Kinds, *, patient_known: bool = True) -> dict[str, Any]:
    """The document with the models of files in place of their names.

    A block that does not say `current_ma` gets the file's. The document's form must be the declared one, but
    for parameters that are missing. Models are held against the patient only where it is known. Raises
    InputErrors, a line for each file that is no model, or one of something else.
    """
    told: dict[str, Any] = {}
    notes: list[str] = []
    faults: list[InputError] = []
    for name, table in document["blocks"].items():
        try:
            told[name] = _with_model(f"blocks.{name}", table, document, kinds, notes, patient_known)
        except InputErrors as several:
            faults += several.faults
        except InputError as fault:
            faults.append(fault)
    if faults:
        raise InputErrors(faults)
    return {**document, "blocks": told, **_noted(document["experiment"], notes)}


def _noted(about: dict[str, Any], notes: list[str]) -> dict[str, Any]:
    """The table [experiment] with more notes; nothing where there are none."""
    return {"experiment": {**about, "notes": [*about.get("notes", []), *notes]}} if notes else {}


def _with_model(where: str, table: Mapping[str, Any], document: dict[str, Any], kinds: Kinds,
                notes: list[str], patient_known: bool) -> dict[str, Any]:
    """A block's table with the models of its files; what is to be known of them is added to `notes`."""
    made = dict(table)
    for key, hint in hints_of(kinds[table["kind"]]).items():
        value = table.get(key)
        if hint is LinearModel and _is_file(value):
            made[key] = _model(f"{where}.{key}", value, made, document, notes, patient_known)
        elif hint is ErrorProcess and _is_file(value):
            made[key] = _process(f"{where}.{key}", value["file"])
        elif LinearModel in get_args(hint) and isinstance(value, list):
            made[key] = [_model(f"{where}.{key}[{i}]", item, made, document, notes, patient_known)
                         if _is_file(item) else item for i, item in enumerate(value)]
    return made


def _process(where: str, file: str) -> dict[str, Any]:
    """The plain table of a file's error process."""
    try:
        return error_process_table(Path(file))
    except InputError as fault:
        raise fault.within(where) from None


def _is_file(value: Any) -> TypeGuard[dict[str, Any]]:
    return isinstance(value, dict) and "file" in value


def _model(where: str, value: Mapping[str, Any], table: dict[str, Any],
           document: Mapping[str, Any], notes: list[str], patient_known: bool) -> dict[str, Any]:
    """The plain table of a file's model; the block's `current_ma` is added to `table` if it has none."""
    try:
        model = load_patient_model(Path(value["file"]))
        wanted = _wanted(table, document, model)
        if value.get("any_patient") or not patient_known:
            del wanted["patient"]
            wanted.pop("patient_fingerprint", None)
        require_same(value["file"], model, wanted)
        if not value.get("any_fit"):
            require_usable(value["file"], model)
    except InputError as fault:
        raise fault.within(where) from None
    poor = model.weaknesses()
    if poor:
        much = "little" if model.usable else "too little to control by"
        notes.append(f"{where.removeprefix('blocks.')} explains {much}: {'; '.join(poor)}")
    table.setdefault("current_ma", list(model.current_ma))
    found: dict[str, Any] = plain(model.model)
    return found


def _wanted(table: Mapping[str, Any], document: Mapping[str, Any], model: PatientModel) -> dict[str, Any]:
    """What the experiment says of all that a model is made for, as far as it does."""
    choice, blocks = document.get("patient"), document["blocks"]
    wanted: dict[str, Any] = {
        "patient": describe({key: item for key, item in choice.items() if key != "day"}) if choice else ""}
    if choice and model.patient_fingerprint:
        wanted["patient_fingerprint"] = patient_fingerprint(choice)
    for other in blocks.values():
        if other["kind"] == "stimulator":
            wanted["electrodes"] = electrodes_in_words(other, len(model.current_ma))
        if other["kind"] == "synergies" and "rows" in other:
            wanted["outputs"] = tuple(other["rows"])
    if "current_ma" in table:
        wanted["current_ma"] = tuple(float(value) for value in table["current_ma"])
    return wanted
