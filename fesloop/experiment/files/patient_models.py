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
from fesloop.experiment.files.patients import describe
from fesloop.experiment.files.schema import Kinds, hints_of, plain
from fesloop.models.error_process import ErrorProcess, error_process_table
from fesloop.models.linear_model import LinearModel
from fesloop.models.patient_model import (
    PatientModel,
    electrodes_in_words,
    load_patient_model,
    require_same,
    require_usable,
)

_SWITCHES = ("any_patient", "any_fit")
_KEYS = {"file", *_SWITCHES}


def with_models(document: dict[str, Any], kinds: Kinds, *, patient_known: bool = True) -> dict[str, Any]:
    """The document with the models of files in place of their names.

    A block that does not say `current_ma` gets the file's. What is not of the right form is left for the
    document's check. Models are held against the patient only where it is known. Raises InputErrors, a line
    for each file that is no model, or one of something else.
    """
    blocks = document.get("blocks")
    if not isinstance(blocks, dict):
        return document
    told: dict[str, Any] = {}
    notes: list[str] = []
    faults = []
    for name, table in blocks.items():
        try:
            told[name] = _with_model(f"blocks.{name}", table, document, kinds, notes, patient_known)
        except InputError as fault:
            faults.append(fault)
    if faults:
        raise InputErrors(faults)
    return {**document, "blocks": told, **_noted(document.get("experiment"), notes)}


def _noted(about: Any, notes: list[str]) -> dict[str, Any]:
    """The table [experiment] with more notes; nothing where there are none."""
    if not notes or not isinstance(about, dict) or not isinstance(about.get("notes", []), list):
        return {}
    return {"experiment": {**about, "notes": [*about.get("notes", []), *notes]}}


def _with_model(where: str, table: Any, document: dict[str, Any], kinds: Kinds, notes: list[str],
                patient_known: bool) -> Any:
    """A block's table with the models of its files; what is to be known of them is added to `notes`."""
    if not isinstance(table, dict) or table.get("kind") not in kinds:
        return table
    made = dict(table)
    for key, hint in hints_of(kinds[table["kind"]]).items():
        value = table.get(key)
        if hint is LinearModel and _is_file(value):
            made[key] = _model(f"{where}.{key}", value, made, document, notes, patient_known)
        elif hint is ErrorProcess and isinstance(value, dict) and set(value) == {"file"}:
            made[key] = _process(f"{where}.{key}", value["file"])
        elif LinearModel in get_args(hint) and isinstance(value, list):
            made[key] = [_model(f"{where}.{key}[{i}]", item, made, document, notes, patient_known)
                         if _is_file(item) else item for i, item in enumerate(value)]
    return made


def _process(where: str, file: Any) -> dict[str, Any]:
    """The plain table of a file's error process."""
    if not isinstance(file, str):
        raise InputError(f"{where}.file", f"{file!r}", "the path of a file")
    try:
        return error_process_table(Path(file))
    except InputError as fault:
        raise InputError(f"{where}: {fault.where}", fault.found, fault.allowed, fault.remedy) from None


def _is_file(value: Any) -> TypeGuard[dict[str, Any]]:
    return (isinstance(value, dict) and "file" in value and set(value) <= _KEYS
            and isinstance(value["file"], str)
            and all(isinstance(value.get(switch, False), bool) for switch in _SWITCHES))


def _model(where: str, value: Mapping[str, Any], table: dict[str, Any],
           document: Mapping[str, Any], notes: list[str], patient_known: bool) -> dict[str, Any]:
    """The plain table of a file's model; the block's `current_ma` is added to `table` if it has none."""
    try:
        model = load_patient_model(Path(value["file"]))
        wanted = _wanted(table, document, model)
        if value.get("any_patient") or not patient_known:
            del wanted["patient"]
        require_same(value["file"], model, wanted)
        if not value.get("any_fit"):
            require_usable(value["file"], model)
    except InputError as fault:
        raise InputError(f"{where}: {fault.where}", fault.found, fault.allowed, fault.remedy) from None
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
        "patient": describe({key: item for key, item in choice.items() if key != "day"})
        if isinstance(choice, dict) and "file" in choice else ""}
    for other in blocks.values():
        if isinstance(other, dict) and other.get("kind") == "stimulator":
            wanted["electrodes"] = electrodes_in_words(other, len(model.current_ma))
        if isinstance(other, dict) and other.get("kind") == "synergies" and "rows" in other:
            wanted["outputs"] = tuple(other["rows"])
    if "current_ma" in table:
        wanted["current_ma"] = tuple(float(value) for value in table["current_ma"])
    return wanted
