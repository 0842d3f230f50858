"""The table [patient]: parameters of a patient for the blocks of an experiment, and models made for them.
"""

from __future__ import annotations

import copy
import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NotRequired, Required, TypeGuard, get_args

from fesloop.errors import InputError, InputErrors
from fesloop.experiment import registry
from fesloop.experiment.registry import Patient
from fesloop.forms.schema import Kinds, ReadsFile, closed, hints_of, plain
from fesloop.hand.anthropometry import HandSize
from fesloop.loop.block import is_plant
from fesloop.models.electrode_arrays import arrays_in_words
from fesloop.models.linear_model import LinearModel
from fesloop.models.patient_model import (
    PatientModel,
    electrodes_in_words,
    elements_of,
    load_patient_model,
    require_same,
    require_usable,
)

CHOICE = closed("PatientChoice", {
    "file": Required[str], "cohort": NotRequired[int], "member": NotRequired[int], "day": NotRequired[int],
    "error_scale": NotRequired[float], "drawn": NotRequired[dict[str, Any]]})
"""The table [patient]: a preset's name or a file's path; number of the member and of the cohort (0), and the
day; a factor on the errors of what a tracker knows and senses (1); and `drawn`, the resulting patient, which
a recording keeps in place of the file."""
_OCCASION = ("day", "error_scale")
"""Keys that leave the patient who they are."""


def drawn_patient(choice: Mapping[str, Any]) -> Patient:
    """Make the patient of a table [patient]. Raises InputError, InputErrors."""
    if "drawn" in choice:
        return registry.patient_reader().from_table(choice["drawn"], "patient.drawn")
    if "cohort" in choice and "member" not in choice:
        raise InputError("patient.member", "is missing beside cohort", "an integer", "add it")
    patient = registry.patient_reader().load(choice["file"])
    if "member" in choice:
        patient = patient.member(cohort=choice.get("cohort", 0), number=choice["member"])
    if "day" in choice:
        patient = patient.on_day(choice["day"])
    return patient.with_error_scale(choice["error_scale"]) if "error_scale" in choice else patient


def patient_of(document: Mapping[str, Any], faults: Sequence[InputError]
               ) -> tuple[Patient | None, list[InputError]]:
    """Patient of a document, None without one, and the faults of the patient.

    `faults` are those of the document's form: a table [patient] that is among them makes no patient.
    """
    if "patient" not in document or any(fault.where.partition(".")[0] == "patient" for fault in faults):
        return None, []
    try:
        return drawn_patient(document["patient"]), []
    except InputErrors as several:
        return None, [_of_patient(fault) for fault in several.faults]
    except InputError as fault:
        return None, [_of_patient(fault)]


def with_patient(document: Mapping[str, Any], patient: Patient, kinds: Kinds) -> dict[str, Any]:
    """Add the patient's parameters to the blocks of a document, which overrides them.

    The document's form must be the declared one, but for parameters that are missing. Raises InputError for a
    patient who changes no block and whom no model is compared with: results would carry the wrong name.
    """
    choice, blocks = document["patient"], document["blocks"]
    added = {name: _parameters(table, patient, kinds) for name, table in blocks.items()}
    if "drawn" not in choice and not any(added.values()) and not _of_a_file(blocks):
        raise InputError("patient", f"{choice['file']!r} would change nothing",
                         "an experiment with a block that takes a patient: a hand, muscles, electrodes",
                         "remove it")
    overridden = {name: _merged(more, blocks[name]) if more else blocks[name] for name, more in added.items()}
    return {**document, "blocks": overridden, "patient": {**choice, "drawn": patient.table()}}


def _of_a_file(blocks: Mapping[str, Any]) -> bool:
    """Return whether a controller has a model file, whose patient is compared with the document."""
    models = [table.get("model") for table in blocks.values()]
    return any(isinstance(model, dict) and "file" in model for model in models)


def _of_patient(fault: InputError) -> InputError:
    where = fault.where if fault.where.startswith("patient") else f"patient: {fault.where}"
    return InputError(where, fault.found, fault.allowed, fault.remedy)


def _parameters(table: Mapping[str, Any], patient: Patient, kinds: Kinds) -> dict[str, Any]:
    """Parameters that the patient adds to a block's table."""
    kind = table["kind"]
    added = dict(patient.parameters(kind, table))
    if hints_of(kinds[kind]).get("hand") is HandSize:
        added["hand"] = plain(patient.hand_size if is_plant(kinds[kind]) else patient.measured_hand)
    return added


def _merged(added: dict[str, Any], own: dict[str, Any]) -> dict[str, Any]:
    """Merge two tables at every depth; `own` overrides."""
    merged = copy.deepcopy(own)
    for key, value in added.items():
        if key not in own:
            merged[key] = copy.deepcopy(value)
        elif isinstance(value, dict) and isinstance(own[key], dict):
            merged[key] = _merged(value, own[key])
    return merged


def patient_fingerprint(choice: Mapping[str, Any]) -> str:
    """SHA-256 of the patient of a table [patient], whatever the day, as hexadecimal text.

    "" where that is not known: for a patient who was sampled for a day, or has an error scale, and whose
    file now gives another.
    """
    table = choice.get("drawn")
    try:
        if table is None or any(key in choice for key in _OCCASION):
            whose = {key: choice[key] for key in ("file", "cohort", "member", *_OCCASION) if key in choice}
            if table is not None and _text(drawn_patient(whose).table()) != _text(table):
                return ""
            table = drawn_patient(_without_occasion(whose)).table()
    except (InputError, InputErrors):
        return ""
    return hashlib.sha256(_text(table).encode()).hexdigest()


def _without_occasion(choice: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in choice.items() if key not in _OCCASION}


def _text(table: Mapping[str, Any]) -> str:
    """A patient's table without its description, the same text for the same patient."""
    return json.dumps({key: value for key, value in table.items() if key != "description"}, sort_keys=True)


def describe(choice: Mapping[str, Any]) -> str:
    """A table [patient] in words: sci_c6, member 3 of cohort 1, day 2."""
    text = str(choice["file"])
    if "member" in choice:
        text += f", member {choice['member']} of cohort {choice.get('cohort', 0)}"
    if "day" in choice:
        text += f", day {choice['day']}"
    return f"{text}, errors x {choice['error_scale']:g}" if "error_scale" in choice else text


def identity(choice: Mapping[str, Any] | None) -> dict[str, str]:
    """`patient` in words and `patient_fingerprint` of a table [patient], whatever the day; "" without one."""
    return {"patient": describe(_without_occasion(choice)) if choice else "",
            "patient_fingerprint": patient_fingerprint(choice) if choice else ""}


def with_models(document: dict[str, Any], kinds: Kinds, *, patient_known: bool = True) -> dict[str, Any]:
    """Replace the names of model files in a document by the models.

    A block that does not say `current_ma` gets the file's. The document's form must be the declared one, but
    for parameters that are missing. Models are compared with the patient only where it is known. Raises
    InputErrors, a line for each file that is no model, or is a model of something else.
    """
    loaded: dict[str, Any] = {}
    notes: list[str] = []
    faults: list[InputError] = []
    document = _with_channels(document, kinds)
    for name, table in document["blocks"].items():
        try:
            loaded[name] = _with_model(f"blocks.{name}", table, document, kinds, notes, patient_known)
        except InputErrors as several:
            faults += several.faults
        except InputError as fault:
            faults.append(fault)
    if faults:
        raise InputErrors(faults)
    return {**document, "blocks": loaded, **_noted(document["experiment"], notes)}


def hand_plant(blocks: Mapping[str, Any]) -> str:
    """Kind of the plant that is a hand; "" without one, or for a hand whose size is not a parameter."""
    for _, table in sorted(blocks.items()):
        made = registry.find(table["kind"])
        if "hand" in hints_of(made) and is_plant(made):
            return str(table["kind"])
    return ""


def _with_channels(document: dict[str, Any], kinds: Kinds) -> dict[str, Any]:
    """The document with the channels of a model's file, where a controller's model says `channels = true`.

    They are the elements of the stimulator's channels, the ones that control grip force, and those that rest
    on an object, of a controller that has `grasping_channels`. Raises InputError for a model whose channels
    were given.
    """
    blocks = document["blocks"]
    for name, table in blocks.items():
        stated = table.get("model")
        if not (_is_file(stated) and stated.get("channels")):
            continue
        where = f"blocks.{name}.model"
        try:
            model = load_patient_model(Path(stated["file"]))
            electrodes = [{"elements": elements, **({"shares": shares} if shares else {})}
                          for elements, shares in map(elements_of, model.electrodes)]
        except InputError as fault:
            raise fault.within(where) from None
        if not model.grasping:
            raise InputError(f"{where}.channels", f"true, and {stated['file']} has no channels of its own",
                             "a model that fesloop identify made from a sweep over all elements",
                             "run sweep_grasp, or leave it out")
        if not model.closing and any(given["kind"] == "grip_force" for given in blocks.values()):
            raise InputError(f"{where}.channels", f"true, and no channel of {stated['file']} closes the hand",
                             "one or more in `closing`", "sweep with more current, or move the arrays")
        own: dict[str, dict[str, Any]] = {"stimulator": {"electrodes": electrodes},
                                          "grip_force": {"closing": list(model.closing)}}
        blocks = {other: {**given, **own.get(given["kind"], {})} for other, given in blocks.items()}
        if "grasping_channels" in hints_of(kinds[table["kind"]]):
            blocks[name] = {**blocks[name], "grasping_channels": list(model.grasping)}
    return {**document, "blocks": blocks}


def _noted(about: dict[str, Any], notes: list[str]) -> dict[str, Any]:
    """The table [experiment] with more notes, if there are any."""
    return {"experiment": {**about, "notes": [*about.get("notes", []), *notes]}} if notes else {}


def _with_model(where: str, table: Mapping[str, Any], document: dict[str, Any], kinds: Kinds,
                notes: list[str], patient_known: bool) -> dict[str, Any]:
    """Replace model files in a block's table by the models; cautions about them are added to `notes`.

    Further models of a block may be of any patient where its `model` may.
    """
    made = dict(table)
    for key, hint in hints_of(kinds[table["kind"]]).items():
        value = table.get(key)
        if hint is LinearModel and _is_file(value):
            made[key] = _model(f"{where}.{key}", value, made, document, notes, patient_known)
        elif isinstance(hint, ReadsFile) and _is_file(value):
            try:
                made[key] = hint.file_tables(Path(value["file"]))
                if patient_known and "patient" in made[key]:
                    _require_patient(f"{where}.{key}", value, made[key], document, notes)
            except InputError as fault:
                raise fault.within(f"{where}.{key}") from None
        elif LinearModel in get_args(hint) and isinstance(value, list):
            stated = table.get("model")
            anyone = {"any_patient": True} if _is_file(stated) and stated.get("any_patient") else {}
            made[key] = [_model(f"{where}.{key}[{i}]", anyone | item, made, document, notes, patient_known)
                         if _is_file(item) else item for i, item in enumerate(value)]
    return made


def _is_file(value: Any) -> TypeGuard[dict[str, Any]]:
    return isinstance(value, dict) and "file" in value


def _model(where: str, value: Mapping[str, Any], table: dict[str, Any],
           document: Mapping[str, Any], notes: list[str], patient_known: bool) -> dict[str, Any]:
    """Plain table of the model in a file; its `current_ma` is added to `table` if that has none."""
    try:
        model = load_patient_model(Path(value["file"]))
        required = _made_for(table, document, model,
                             any_patient=bool(value.get("any_patient")) or not patient_known)
        require_same(value["file"], model, required)
        if not value.get("any_fit"):
            require_usable(value["file"], model)
    except InputError as fault:
        raise fault.within(where) from None
    name, poor = where.removeprefix("blocks."), model.weaknesses()
    if poor:
        much = "little" if model.usable else "too little to control by"
        notes.append(f"{name} explains {much}: {'; '.join(poor)}")
    plant = hand_plant(document["blocks"])
    if plant and model.plant and plant != model.plant:
        notes.append(f"the model {name} was identified on another hand, {model.plant}, and this is {plant}: "
                     f"identify again with --set plant={plant}")
    if missed := model.missed_in_words():
        notes.append(f"the model {name} predicts that its elements leave {missed}: expect errors there")
    day = str(document.get("patient", {}).get("day", ""))
    if "patient" in required and model.day != day:
        notes.append(f"{name} was identified on {_day(model.day)}, and this is {_day(day)}: electrodes, "
                     "skin, strength and thresholds differ between days; identify again if control is poor")
    choice = document.get("patient")
    if patient_known and "patient" not in required and choice:
        own = describe(_without_occasion(choice))
        if model.patient.partition(", day ")[0] != own:
            notes.append(f"{name} is of another person: of {model.patient or 'a plant without one'}, and "
                         f"this is {own} (any_patient = true)")
    table.setdefault("current_ma", list(model.current_ma))
    found: dict[str, Any] = plain(model.model)
    return found


def _require_patient(where: str, value: Mapping[str, Any], of: Mapping[str, str],
                     document: Mapping[str, Any], notes: list[str]) -> None:
    """Raise InputError where a file is `of` another patient than the document's; `any_patient` notes it."""
    own, path = identity(document.get("patient")), value["file"]
    marks = of["patient_fingerprint"], own["patient_fingerprint"]
    if marks[0] == marks[1] if all(marks) else of["patient"] == own["patient"]:
        return
    whose, here = of["patient"] or "a plant without a patient", own["patient"] or "a plant without a patient"
    if value.get("any_patient"):
        notes.append(f"{where.removeprefix('blocks.')} is of another person: of {whose}, and this is {here} "
                     "(any_patient = true)")
        return
    changed = " before its file changed" if whose == here else ""
    raise InputError(f"{path}: patient", f"the recording is of {whose}{changed}",
                     f"{here}, as this experiment has, on any day",
                     "record this one, or say --set any_patient=true")


def _day(day: str) -> str:
    return f"day {day}" if day else "no day in particular"


def _made_for(table: Mapping[str, Any], document: Mapping[str, Any], model: PatientModel, *,
              any_patient: bool) -> dict[str, Any]:
    """Properties of the experiment that a model is made for, as far as they are given."""
    choice, blocks, properties = document.get("patient"), document["blocks"], dict[str, Any]()
    if not any_patient:
        properties["patient"] = describe(_without_occasion(choice)) if choice else ""
        if choice and model.patient_fingerprint:
            properties["patient_fingerprint"] = patient_fingerprint(choice)
    for other in blocks.values():
        if other["kind"] == "stimulator":
            properties["electrodes"] = electrodes_in_words(other, len(model.current_ma))
        if other["kind"] == "electrodes":
            properties["arrays"] = arrays_in_words(other)
        if other["kind"] == "synergies" and "rows" in other:
            properties["outputs"] = tuple(other["rows"])
    if "current_ma" in table:
        properties["current_ma"] = tuple(float(value) for value in table["current_ma"])
    return properties
