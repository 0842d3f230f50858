"""The form of experiment files: their tables, and the keys of each table."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal, NotRequired, Required, Union

from pydantic import Discriminator, TypeAdapter

from fesloop.errors import InputError
from fesloop.experiment import registry
from fesloop.experiment.files.patients import CHOICE
from fesloop.experiment.record_spec import Record
from fesloop.experiment.score_spec import Score
from fesloop.forms.schema import Kinds, checked, closed, make, table
from fesloop.loop.block import is_plant
from fesloop.loop.duration import Duration
from fesloop.loop.wire import Wire
from fesloop.models.electrode_arrays import ElectrodeArrays

Job = Literal["closed_loop", "array_search", "hardware", "trackers"]
Need = Literal["extra lsl", "extra myohand", "extra search", "extra stimulator", "a recording", "a run",
               "an error process", "a live stream", "real time", "a C compiler"]
RUN = "RUN.h5"
"""Placeholder for the recording of the run in commands to try next."""
PLAYED = "RECORDING"
"""Placeholder for the recording that the run played."""
_OF_PLAYED = ("layout", "sensor_set", "pairs", "twin", "trial", "command", "posture", "signal")
"""Settings, aliases or last parts of keys, that reading the played recording may need."""
_FITS_ERROR = "fesloop fit-error "
_PATIENT = ("patient", "cohort", "member", "day", "error_scale", "electrodes.array", "plant", "follow",
            "any_patient")
"""Settings that choose the patient, by which arrays it is stimulated, and what its model predicts."""
_RUNS = re.compile(r"fesloop (?P<verb>run|check) (?P<name>[^ ]+)(?: .*)?")


@dataclass(frozen=True, slots=True, kw_only=True)
class Guide:
    """The table [guide] of an experiment file.

    Attributes
    ----------
    job: what it is for.
    takes_s: about how long `fesloop run` takes with the default settings, s of wall time of one free core,
        code compiled; `fesloop bench shipped` measures it.
    needs: requirements: extras of fesloop, input, a way to run.
    needs_with: additional requirements of a setting, such as {"plant=myohand" = "extra myohand"}.
    try_next: commands that continue from its run; `RUN.h5` in them means the recording of the run, and
        `RECORDING` the recording that it played.
    try_next_with: commands that take the place of these with a setting, as in {"plant=myohand" = [...]}.
    """

    job: Job
    takes_s: float
    needs: tuple[Need, ...] = ()
    needs_with: dict[str, Need] = field(default_factory=dict)
    try_next: tuple[str, ...] = ()
    try_next_with: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.takes_s > 0.0:
            raise InputError("takes_s", f"{self.takes_s:g}", "seconds above 0")

    def next_commands(self, recording: str, settings: Sequence[str] = (), scored: bool = True,
                      experiment: str = "", options: Sequence[str] = ()) -> list[str]:
        """Commands to try next, ready to be typed, with the recording of the run.

        A command on the run's own `experiment` gets the run's `settings`, "KEY=VALUE" each, that it does not
        change, and its `options`, such as "--seed"; it is left out where it would repeat the run. One on
        another experiment gets those settings that choose the patient. A command that plays the run's own
        source gets that file, its layout and its pairs; it is left out where no setting names the file, and,
        if it fits an error, where the run did not score its tracker. Whether the settings fit together is
        not checked.
        """
        played = next((value.strip().strip("'\"") for key, _, value in map(_parts, settings)
                       if key.split(".")[-1] == "recording"), "")
        # A name that begins with a dash would be an option.
        recording = f"./{recording}" if recording.startswith("-") else recording
        plain = {"".join(each.strip() for each in _parts(setting)) for setting in settings}
        suggested = next((these for setting, these in self.try_next_with.items() if setting in plain),
                         self.try_next)
        commands = []
        for command in suggested:
            plays, runs = PLAYED in command, _RUNS.fullmatch(command)
            if plays and (not played or (command.startswith(_FITS_ERROR) and not scored)):
                continue
            words = [word.replace(RUN, recording) if RUN in word else word.replace(PLAYED, played)
                     for word in shlex.split(command)]
            given = [words[k + 1] for k, word in enumerate(words) if word == "--set"]
            keys = {_parts(setting)[0] for setting in given}
            others = [setting for setting in settings if _parts(setting)[0] not in keys]
            if runs and runs["name"] == Path(experiment).stem:
                if runs["verb"] == "run" and set(words[3:]) <= {"--set", *settings, *options}:
                    continue
                words[2:3] = [experiment, *_sets(others), *(options if runs["verb"] == "run" else ())]
            elif plays:
                words += _sets(each for each in others if _parts(each)[0].split(".")[-1] in _OF_PLAYED)
            elif runs:
                words += _sets(each for each in others if _chooses_patient(_parts(each)[0]))
            commands.append(shlex.join(words))
        return commands


def _sets(settings: Iterable[str]) -> list[str]:
    """Words of the command line that give these settings."""
    return [word for setting in settings for word in ("--set", setting)]


def _chooses_patient(key: str) -> bool:
    return key in _PATIENT or key.startswith("patient.")


def _parts(setting: str) -> tuple[str, str, str]:
    """Key, "=" and value of a setting."""
    key, equals, value = setting.partition("=")
    return key.strip(), equals, value


def guide_of(document: Mapping[str, Any]) -> Guide | None:
    """The table [guide] of a valid document; None if there is none."""
    if "guide" not in document:
        return None
    guide: Guide = make(Guide, document["guide"], {}, "guide")
    return guide


Rate = str | int | float
Aliases = dict[str, str | list[str]]


def experiment_table(kinds: Kinds) -> Any:
    """Typed dict of a whole file whose blocks are of these kinds."""
    about = closed("About", {"name": Required[str], "description": NotRequired[str],
                             "duration_s": NotRequired[float], "trials": NotRequired[int],
                             "seed": NotRequired[int], "notes": NotRequired[list[str]]})
    block: Any = _block(kinds)
    wire: Any = _wire(kinds)
    link: Any = _link(kinds)
    option: Any = option_table()
    return closed("Experiment", {
        "experiment": Required[about],
        "patient": NotRequired[CHOICE],
        "electrodes": NotRequired[_electrodes()],
        "record": NotRequired[table(Record, kinds)],
        "blocks": Required[dict[str, block]],
        "links": NotRequired[dict[str, link]],
        "wires": NotRequired[list[wire]],
        "score": NotRequired[table(Score, kinds)],
        "aliases": NotRequired[Aliases],
        "variants": NotRequired[dict[str, dict[str, str | option]]],
        "guide": NotRequired[table(Guide, kinds)],
        "code": NotRequired[dict[str, str]],
    })


def option_table() -> Any:
    """Typed dict of an option of a variant: a patch over the file (`fesloop.experiment.files.overlay`)."""
    tables = dict.fromkeys(("experiment", "patient", "electrodes", "score"), NotRequired[dict[str, Any]])
    return closed("Option", {
        "description": NotRequired[str],
        "like": NotRequired[str],
        "remove": NotRequired[list[str]],
        **tables,
        "record": NotRequired[table(Record, {})],
        "blocks": NotRequired[dict[str, dict[str, Any]]],
        "links": NotRequired[dict[str, _link({})]],  # type: ignore[misc]
        "wires": NotRequired[list[_wire({})]],  # type: ignore[misc]
        "aliases": NotRequired[Aliases],
    })


def _electrodes() -> Any:
    """The table [electrodes]: a file of arrays, or its tables."""
    return closed("ElectrodesChoice", {"array": Required[str | table(ElectrodeArrays, {})]})


def _wire(kinds: Kinds) -> Any:
    return table(Wire, kinds, {"optional": NotRequired[bool]}, {"source": "from", "target": "to"})


def _link(kinds: Kinds) -> Any:
    """Typed dict of a link: what all wires that name it have in common."""
    return closed("Link", {"latency_ms": NotRequired[float], "jitter": NotRequired[checked(Duration, kinds)],
                           "loss": NotRequired[float], "burst_messages": NotRequired[float],
                           "late": NotRequired[Literal["keep-newest", "in-order"]]})


def _block(kinds: Kinds) -> Any:
    """A block's table: its kind, its place in time, and the parameters of its kind."""
    if not kinds:
        return dict[str, Any]
    execution = checked(Duration, kinds)
    members = []
    for kind, cls in kinds.items():
        place: dict[str, Any] = {"kind": Required[Literal[kind]]}
        if not is_plant(cls):
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
