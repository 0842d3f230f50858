"""The form of an experiment file: which tables it has and which keys they take."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NotRequired, Required, Union

from pydantic import Discriminator, TypeAdapter

from fesloop.experiment import registry
from fesloop.experiment.files.guide import Guide
from fesloop.experiment.files.patients import CHOICE
from fesloop.experiment.wanted import Record, Score
from fesloop.forms.schema import Kinds, checked, closed, table
from fesloop.loop.duration import Duration
from fesloop.loop.wire import Wire

Rate = str | int | float
Aliases = dict[str, str | list[str]]


def experiment_table(kinds: Kinds) -> Any:
    """Typed dict of a whole file whose blocks are of these kinds."""
    about = closed("About", {"name": Required[str], "description": NotRequired[str],
                             "duration_s": NotRequired[float], "trials": NotRequired[int],
                             "seed": NotRequired[int], "notes": NotRequired[list[str]]})
    block: Any = _block(kinds)
    wire: Any = _wire(kinds)
    option: Any = option_table()
    return closed("Experiment", {
        "experiment": Required[about],
        "patient": NotRequired[CHOICE],
        "record": NotRequired[table(Record, kinds)],
        "blocks": Required[dict[str, block]],
        "wires": NotRequired[list[wire]],
        "score": NotRequired[table(Score, kinds)],
        "aliases": NotRequired[Aliases],
        "variants": NotRequired[dict[str, dict[str, str | option]]],
        "guide": NotRequired[table(Guide, kinds)],
    })


def option_table() -> Any:
    """Typed dict of an option of a variant: a patch over the file (`fesloop.experiment.files.patches`)."""
    tables = dict.fromkeys(("experiment", "patient", "score"), NotRequired[dict[str, Any]])
    return closed("Option", {
        "description": NotRequired[str],
        "like": NotRequired[str],
        "remove": NotRequired[list[str]],
        **tables,
        "record": NotRequired[table(Record, {})],
        "blocks": NotRequired[dict[str, dict[str, Any]]],
        "wires": NotRequired[list[_wire({})]],  # type: ignore[misc]
        "aliases": NotRequired[Aliases],
    })


def _wire(kinds: Kinds) -> Any:
    return table(Wire, kinds, {"optional": NotRequired[bool]}, {"source": "from", "target": "to"})


def _block(kinds: Kinds) -> Any:
    """A block's table: its kind, its place in time, and the parameters of its kind."""
    if not kinds:
        return dict[str, Any]
    execution = checked(Duration, kinds)
    members = []
    for kind, cls in kinds.items():
        place: dict[str, Any] = {"kind": Required[Literal[kind]]}
        if not hasattr(cls, "advance"):
            place |= {"rate": NotRequired[Rate], "clock": NotRequired[str], "offset_ms": NotRequired[float],
                      "execution": NotRequired[execution]}
        members.append(table(cls, kinds, extra=place))
    if len(members) == 1:
        return members[0]
    return Annotated[Union[tuple(members)], Discriminator("kind")]  # noqa: UP007


def json_schema() -> dict[str, Any]:
    """JSON Schema of experiment files, for every registered kind; loose for those that extend others."""
    kinds = {kind: registry.find(kind) for kind in registry.kinds()}
    whole = TypeAdapter(experiment_table(kinds)).json_schema()
    definitions = whole.pop("$defs", {})
    text = {"type": "string"}
    extending = {"required": ["extends"], "properties": {
        "extends": text, "remove": {"type": "array", "items": text}}}
    return {"title": whole["title"], "type": "object", "$defs": definitions,
            "if": {"required": ["extends"]}, "then": extending, "else": whole}


