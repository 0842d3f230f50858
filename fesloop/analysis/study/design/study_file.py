"""Reads study files; all faults of a file are reported at once."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NotRequired, Required

from pydantic import TypeAdapter, ValidationError

from fesloop.analysis.study.design.axes import Axis
from fesloop.analysis.study.design.figure_specs import Figure
from fesloop.analysis.study.design.shipped_studies import STUDIES
from fesloop.analysis.study.design.study import About, Preparation, Study, is_name
from fesloop.errors import InputError, InputErrors, did_you_mean
from fesloop.experiment.files.overlay import merged
from fesloop.experiment.files.source import read_tables
from fesloop.experiment.specification import ExperimentSpecification
from fesloop.forms.faults import faults_of
from fesloop.forms.schema import closed, keys_at, make, table
from fesloop.forms.toml import TomlError, plain_tables

_SPAN = {"start": "from", "stop": "to"}


def read_study(study: str | Path, form: str = "") -> Study:
    """Read a study from a file, or a shipped one by its name, in one of its forms ("": the file itself).

    Raises InputError, InputErrors with every fault of the file, one line each.
    """
    name, document, folder = read_tables(study, STUDIES)
    try:
        return study_of(document, form, folder)
    except InputError as fault:
        raise fault.within(name) from None


def study_of(document: Mapping[str, Any], form: str = "", folder: Path | None = None) -> Study:
    """The study of plain tables, in one of its forms; relative paths start from `folder`.

    `study.experiment`, and that of an axis's option, may be an Experiment instead of a name. Raises
    InputError, InputErrors with every fault.
    """
    document, experiments = _named(document)
    try:
        settled, cost = _in_form(plain_tables(document), form)
    except TomlError as fault:
        raise InputError("the study", str(fault), "plain tables, as of a TOML file") from None
    _check(settled)
    # [guide] is for people only, and no part of the document that results are compared with.
    try_next = settled.pop("guide", {}).get("try_next", [])
    faults: list[InputError] = []

    def made(cls: type[Any], values: Mapping[str, Any], where: str) -> Any:
        try:
            return make(cls, values, {}, where)
        except InputError as fault:
            faults.append(fault)

    about = made(About, settled["study"], "study")
    axes = {name: made(Axis, _renamed(values), f"axes.{name}")
            for name, values in settled.get("axes", {}).items()}
    prepare = {key: made(Preparation, values, f"prepare.{key}")
               for key, values in settled.get("prepare", {}).items()}
    figures = tuple(made(Figure, values, f"figures[{i}]")
                    for i, values in enumerate(settled.get("figures", ())))
    if faults:
        raise InputErrors(faults)
    return Study(about=about, axes=axes, prepare=prepare, figures=figures, form=form, cost=cost,
                 folder=folder, experiments=experiments, document=settled, try_next=tuple(try_next))


_DEEPEST = len(("axes", "NAME", "options", "LEVEL", "experiment"))
"""Tables around an experiment, which may hold themselves: `plain_tables` refuses that."""


def _named(document: Any, depth: int = _DEEPEST) -> tuple[Any, dict[str, dict[str, Any]]]:
    """Tables with the names of experiments in place of objects, and the documents of these by name."""
    if isinstance(document, ExperimentSpecification):
        return document.name, {document.name: document.document()}
    if not isinstance(document, Mapping) or not depth:
        return document, {}
    tables, found = {}, dict[str, dict[str, Any]]()
    for key, value in document.items():
        tables[key], inner = _named(value, depth - 1)
        for name, each in inner.items():
            if found.setdefault(name, each) != each:
                raise InputError("study.experiment", f"two experiments have the name {name!r}",
                                 "experiments with names of their own", "give one another name")
    return tables, found


def _in_form(document: Mapping[str, Any], form: str) -> tuple[dict[str, Any], str]:
    """The tables merged with a form's patch, and the form's cost."""
    base = {key: value for key, value in document.items() if key != "forms"}
    forms = document.get("forms", {})
    if not isinstance(forms, dict) or not all(isinstance(patch, dict) for patch in forms.values()):
        raise InputError("forms", "is not a table of tables", "[forms.NAME]")
    for name in forms:
        if not is_name(name):
            raise InputError(f"forms.{name}", "is not a name of a form", "letters, digits, - and _")
    if not form:
        return base, ""
    if form not in forms:
        raise InputError(f"--form {form}", "there is no form of this name", ", ".join(forms) or "none",
                         did_you_mean(form, forms))
    patch = {key: value for key, value in forms[form].items() if key != "cost"}
    known = ["study", "axes", "prepare", "figures"]
    for key in patch:
        if key not in known:
            raise InputError(f"forms.{form}.{key}", "unknown key", ", ".join(["cost", *known]),
                             did_you_mean(key, known))
    cost = forms[form].get("cost", "")
    if not isinstance(cost, str):
        raise InputError(f"forms.{form}.cost", f"{cost!r}", "text")
    return merged(base, patch), cost


def _check(document: Mapping[str, Any]) -> None:
    """Raise InputErrors with everything that does not match the schema."""
    axis: Any = table(Axis, {}, rename=_SPAN)
    preparation: Any = table(Preparation, {})
    figure: Any = table(Figure, {})
    form = closed("Study", {
        "study": Required[table(About, {})], "axes": NotRequired[dict[str, axis]],
        "guide": NotRequired[closed("StudyGuide", {"try_next": Required[list[str]]})],
        "prepare": NotRequired[dict[str, preparation]], "figures": NotRequired[list[figure]]})
    try:
        TypeAdapter(form).validate_json(json.dumps(document))
    except ValidationError as fault:
        raise InputErrors(faults_of(fault.errors(include_url=False), document,
                                    lambda path: keys_at(form, path, document), tagged=False)) from None


def _renamed(axis: Mapping[str, Any]) -> dict[str, Any]:
    """An axis's table with the names of its dataclass."""
    names = {name: own for own, name in _SPAN.items()}
    return {names.get(key, key): value for key, value in axis.items()}
