"""The table [electrodes]: electrode arrays of an experiment, and what follows from them for its blocks."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import TypeAdapter, ValidationError

from fesloop.errors import InputError, InputErrors
from fesloop.forms.faults import faults_of
from fesloop.forms.schema import Kinds, keys_at, make, table
from fesloop.forms.toml import TomlError, tables_of
from fesloop.given_files import read_whole
from fesloop.models.electrode_arrays import USUAL_RADIUS_MM, ElectrodeArrays, FitsArrays

_FORM = table(ElectrodeArrays, {})
_REPLACED = ("electrodes",)
"""Keys of a block that name elements of the arrays that the experiment was written for."""
_A_FILE = "a TOML file of arrays"


class Fitted(NamedTuple):
    """A document whose blocks fit its arrays, and where the user stated what they follow from.

    Attributes
    ----------
    document: without the table [electrodes].
    origins: place of the stated value by place in the document.
    where, arrays: place of the arrays for messages, and the arrays.
    """

    document: dict[str, Any]
    origins: Mapping[str, str]
    where: str
    arrays: ElectrodeArrays

    def require_apart(self, filled: Mapping[str, Any]) -> None:
        """Raise InputError for pads that overlap on the forearm of a document with its patient."""
        radius_mm = next((block["radius_mm"] for block in filled["blocks"].values()
                          if "arrays" in block and "radius_mm" in block), USUAL_RADIUS_MM)
        try:
            self.arrays.require_apart(radius_mm)
        except InputError as fault:
            raise fault.within(self.where) from None

    def explained(self, fault: InputError) -> InputError:
        """The fault, or all of several, at the place that the user wrote."""
        if isinstance(fault, InputErrors):
            return InputErrors([self.explained(each) for each in fault.faults])
        for place, origin in self.origins.items():
            if fault.where == place or fault.where.startswith((f"{place}.", f"{place}[", f"{place}:")):
                return InputError(origin + fault.where[len(place):], fault.found, fault.allowed, fault.remedy)
        return fault


def with_arrays(document: Mapping[str, Any], kinds: Kinds) -> Fitted:
    """Give the blocks of a document what follows from its table [electrodes].

    Raises InputError, InputErrors for a table or file of another form, for an experiment without a block
    `electrodes`, and for what a block states that follows from the arrays.
    """
    where, arrays = _arrays(document["electrodes"])
    rest = {key: value for key, value in document.items() if key != "electrodes"}
    blocks = dict(document["blocks"]) if isinstance(document.get("blocks"), dict) else {}
    added: dict[str, dict[str, Any]] = {}
    if _chosen_by_model(blocks):
        arrays = replace(arrays, channels=())
        blocks = {name: {key: value for key, value in own.items() if key not in _REPLACED}
                  if isinstance(own, dict) else own for name, own in blocks.items()}
    for name, own in blocks.items():
        cls = kinds.get(own.get("kind", "")) if isinstance(own, dict) else None
        if cls is not None and issubclass(cls, FitsArrays):
            try:
                added[name] = cls.for_arrays(arrays, own, _wired(document, name))
            except InputError as fault:
                raise fault.within(where) from None
    if not any("arrays" in each for each in added.values()):
        raise InputError("electrodes.array", "would change nothing: no block has electrode arrays",
                         "an experiment with a block of kind electrodes", "remove it")
    faults, origins = [], {}
    for name, more in added.items():
        for path, value in _leaves(more):
            place = ".".join(("blocks", name, *path))
            origins[place] = f"{where}: {'channels' if path == _REPLACED else 'arrays'}"
            if _at(blocks[name], path) is not None and path != _REPLACED:
                follows = "" if isinstance(value, list) else f"; the arrays give {value:.6g}"
                faults.append(InputError(place, "is given beside electrodes.array", "one of both",
                                         f"remove one{follows}"))
        blocks[name] = _merged(blocks[name], more)
    if faults:
        raise InputErrors(faults)
    return Fitted(rest | {"blocks": blocks}, origins, where, arrays)


def _arrays(choice: Any) -> tuple[str, ElectrodeArrays]:
    """Place of the arrays for messages, and the arrays. Raises InputError, InputErrors."""
    stated = choice.get("array") if isinstance(choice, dict) and set(choice) == {"array"} else None
    if not isinstance(stated, (str, dict)):
        raise InputError("electrodes", f"{choice!r}", 'array = "FILE.toml", or a table [electrodes.array]')
    where, tables = "electrodes.array", stated if isinstance(stated, dict) else {}
    if isinstance(stated, str):
        where = stated
        content = read_whole(Path(stated), _A_FILE)
        try:
            tables = tables_of(content.decode("utf-8-sig"))
        except (UnicodeDecodeError, TomlError) as fault:
            raise InputError(where, f"is not TOML: {fault}", _A_FILE, "mend the line") from None
    try:
        TypeAdapter(_FORM).validate_json(json.dumps(tables))
    except ValidationError as fault:
        faults = faults_of(fault.errors(include_url=False), tables,
                           lambda path: keys_at(_FORM, path, tables), tagged=False)
        raise InputErrors(faults).within(where) from None
    try:
        return where, make(ElectrodeArrays, tables, {}, where)
    except InputError as fault:
        place = fault.where.removeprefix(f"{where}.").removeprefix(f"{where}: ")
        raise InputError(f"{where}: {place}", fault.found, fault.allowed, fault.remedy) from None


def _chosen_by_model(blocks: Mapping[str, Any]) -> bool:
    """Return whether the channels' elements are those of a controller's model file (`channels = true`)."""
    models = [own.get("model") for own in blocks.values() if isinstance(own, dict)]
    return any(isinstance(model, dict) and model.get("channels") for model in models)


def _wired(document: Mapping[str, Any], name: str) -> set[str]:
    """Inputs of a block that have a wire."""
    ends = [str(wire.get("to", "")).partition(".") for wire in document.get("wires", ())
            if isinstance(wire, dict)]
    return {port for block, _, port in ends if block == name}


def _leaves(tables: Mapping[str, Any], path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    for key, value in tables.items():
        if isinstance(value, dict):
            yield from _leaves(value, (*path, key))
        else:
            yield (*path, key), value


def _at(tables: Any, path: tuple[str, ...]) -> Any:
    for key in path:
        tables = tables.get(key) if isinstance(tables, dict) else None
    return tables


def _merged(own: Mapping[str, Any], more: Mapping[str, Any]) -> dict[str, Any]:
    made = copy.deepcopy(dict(own))
    for key, value in more.items():
        below = isinstance(value, dict) and isinstance(made.get(key), dict)
        made[key] = _merged(made[key], value) if below else value
    return made
