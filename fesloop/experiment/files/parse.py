"""Experiments made from experiment files, with every fault of a file reported at once."""

from __future__ import annotations

import copy
import json
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, get_args

from pydantic import TypeAdapter, ValidationError

from fesloop.errors import InputError, InputErrors, did_you_mean
from fesloop.experiment import registry
from fesloop.experiment.files.layout import experiment_table
from fesloop.experiment.files.patients import patient_of, with_models, with_patient
from fesloop.experiment.files.settings import Settings, apply_settings, named_as_set, setting_texts
from fesloop.experiment.files.source import read_experiment
from fesloop.experiment.files.variants import Picked, named_with_options, pick
from fesloop.experiment.record_spec import Record
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.running import Experiment
from fesloop.experiment.score_spec import Score
from fesloop.forms.faults import faults_of, wire_place
from fesloop.forms.schema import Kinds, hints_of, keys_at, make
from fesloop.forms.toml import TomlError, plain_tables
from fesloop.hand.movements import Movement, stated_movement
from fesloop.loop.clock import Clock
from fesloop.loop.duration import Duration
from fesloop.loop.machine import one_blas_thread
from fesloop.loop.nodes import Node
from fesloop.loop.wire import TRANSPORT, Wire

_FORMS = 32
"""Forms that are cached: 1.2 MB each, and cells of a study rarely differ in more sets of kinds."""


def kinds_in(document: Any) -> dict[str, type[Any]]:
    """Classes of all kinds that a document names."""
    named: set[str] = set()
    pending = [document.get("blocks")]
    while pending:
        value = pending.pop()
        if isinstance(value, dict):
            pending += value.values()
            if isinstance(value.get("kind"), str):
                named.add(value["kind"])
        elif isinstance(value, list):
            pending += value
    return {kind: registry.find(kind) for kind in sorted(named.intersection(registry.kinds()))}


def check(document: dict[str, Any], kinds: Kinds, faults: list[InputError]) -> None:
    """Raise InputErrors for everything that is not of the declared form, after the `faults` known before."""
    raise_all(faults + faults_of_form(document, kinds))


def faults_of_form(document: dict[str, Any], kinds: Kinds) -> list[InputError]:
    """Everything that is not of the declared form."""
    unknown = _blocks_of_no_kind(document, kinds)
    faults = [_unknown_kind(name, table) for name, table in unknown]
    hidden = tuple(f"blocks.{name}" for name, _ in unknown)
    faults += [each for each in _faults_of_values(document, kinds) if each.where not in hidden
               and not each.where.startswith(tuple(f"{place}." for place in hidden))]
    return [_with_alias(fault, document) for fault in faults]


def _faults_of_values(document: Any, kinds: Kinds) -> list[InputError]:
    """Unknown and missing keys, and values of another type."""
    table, adapter = _form(tuple(kinds.items()))
    try:
        adapter.validate_json(json.dumps(document))
    except ValidationError as fault:
        return faults_of(fault.errors(include_url=False), document,
                         lambda path: keys_at(table, path, document), tagged=len(kinds) > 1)
    return []


@lru_cache(maxsize=_FORMS)
def _form(kinds: tuple[tuple[str, type[Any]], ...]) -> tuple[Any, TypeAdapter[Any]]:
    """Typed dict of a file whose blocks are of these kinds, and its validator."""
    table = experiment_table(dict(kinds))
    return table, TypeAdapter(table)


def _with_alias(fault: InputError, document: dict[str, Any]) -> InputError:
    """Name, in the fault of a missing key, the alias that sets the key on the command line."""
    aliases = document.get("aliases")
    if fault.found == "is missing" and isinstance(aliases, dict):
        for alias, paths in aliases.items():
            if any(path == fault.where or str(path).startswith(f"{fault.where}.")
                   for path in (paths if isinstance(paths, list) else [paths])):
                return InputError(fault.where, fault.found, fault.allowed, f"give it with --set {alias}=...")
    return fault


def _blocks_of_no_kind(document: dict[str, Any], kinds: Kinds) -> list[tuple[str, Any]]:
    blocks = document.get("blocks")
    tables = blocks.items() if isinstance(blocks, dict) else ()
    known = list(kinds)  # compared, not hashed: the value may be a list
    return [(name, table) for name, table in tables
            if isinstance(table, dict) and table.get("kind") not in known]


def _unknown_kind(name: str, table: dict[str, Any]) -> InputError:
    where = f"blocks.{name}.kind"
    if "kind" not in table:
        return InputError(where, "is missing", ", ".join(registry.kinds()), "add it")
    if not isinstance(table["kind"], str):
        return InputError(where, f"{table['kind']!r} is not text", ", ".join(registry.kinds()))
    try:
        registry.find(table["kind"])
    except InputError as fault:
        return InputError(where, fault.found, fault.allowed, fault.remedy)
    raise AssertionError(f"{name} is of a known kind")


def raise_all(faults: Sequence[InputError]) -> None:
    """Raise all faults as one error, if there are any; one that is the same in several places once."""
    each = list({str(fault): fault for fault in faults}.values())
    if each:
        raise InputErrors(each) if len(each) > 1 else each[0]


def document_of(path: Path) -> dict[str, Any]:
    """Tables of a recorded experiment, with every measured execution time as recorded.

    Raises InputError for a file that is no recording.
    """
    with Recording(path) as recording:
        document = copy.deepcopy(recording.experiment)
        for name, table in document["blocks"].items():
            if table.get("execution", {}).get("kind") == "measured":
                trials = [_durations_ns(recording, name, trial) for trial in range(recording.trials)]
                table["execution"] = {"kind": "recorded", "recorded_ns": trials}
        return document


def _durations_ns(recording: Recording, block: str, trial: int) -> list[int]:
    """Duration of each executed step of a block, ns."""
    signal = next((name for name in recording.signals if name.startswith(f"{block}.")), None)
    if signal is None:
        raise InputError(str(recording.path), f"measured times of {block!r}, which puts nothing out",
                         "a measured block with an output", "run the experiment again instead")
    steps = recording.signal(signal, trial)
    durations: list[int] = (steps.left_ns - steps.times_ns).tolist()
    return durations


_PLACE = ("kind", "rate", "clock", "offset_ms", "execution")


def load(experiment: str | Path, settings: Settings = (), seed: int | None = None) -> Experiment:
    """Load a shipped experiment by its name, one from a file, or that of a recording to repeat it.

    Parameters
    ----------
    experiment: name of a shipped experiment, path of a TOML file, or path of a recording (.h5). Paths in a
        TOML file start from the folder of that file.
    settings: ["KEY=VALUE"] or {KEY: VALUE}, changing what the file says: a variant of the file and which of
        its options it is to be, an alias of the file, or a dotted key path. Paths in them start from the
        current folder.
    seed: takes the place of the file's.

    Raises
    ------
    InputError, InputErrors: every fault of the file, one line each, with file, key, found and allowed.
    """
    return load_picked(experiment, settings, seed)[0]


def load_picked(experiment: str | Path, settings: Settings = (),
                seed: int | None = None) -> tuple[Experiment, Picked]:
    """Load an experiment; also return its file with the options of variants applied."""
    settings = setting_texts(settings)
    name, document = read(experiment)
    picked = pick(document, settings, name)
    every = [*picked.settings, *([f"experiment.seed={seed}"] if seed is not None else [])]
    changed = apply_settings(picked.document, every, picked.name, tuple(picked.options))
    try:
        return from_document(changed, picked.name), picked
    except InputError as fault:
        named = named_with_options(fault, document, picked)
        raise named_as_set(named, f"{picked.name}: ", picked.document, every) from None


def read(experiment: str | Path) -> tuple[str, dict[str, Any]]:
    """Read an experiment: its name for messages, and its tables over those that it extends."""
    if not isinstance(experiment, (str, Path)):
        raise InputError("experiment", f"is of type {type(experiment).__name__}",
                         "a name of a shipped experiment, a path, or, to run it, an Experiment")
    text = str(experiment)
    if text.endswith(".h5"):
        return text, document_of(Path(text))
    return read_experiment(experiment)


@one_blas_thread()
def from_document(document: Mapping[str, Any], name: str = "experiment") -> Experiment:
    """Make the experiment that plain tables describe, such as those of a file or of a recording.

    Variants are at their defaults.
    """
    try:
        tables = pick(plain_tables(document), (), name).document
    except TomlError as fault:
        raise InputError(name, str(fault), "plain tables, as of a TOML file") from None
    try:
        _require_code(tables)
        kinds = kinds_in(tables)
        if "electrodes" in tables:
            return _with_arrays(tables, kinds)
        return _experiment(_filled(_with_movements(tables, kinds), kinds), kinds)
    except InputError as fault:
        raise fault.within(name) from None


def _with_arrays(tables: dict[str, Any], kinds: Kinds) -> Experiment:
    """Make an experiment with a table [electrodes]; faults of what follows from it name that table."""
    from fesloop.experiment.files.arrays import with_arrays  # most experiments do without

    fitted = with_arrays(tables, kinds)
    try:
        filled = _filled(_with_movements(fitted.document, kinds), kinds)
        fitted.require_apart(filled)
        return _experiment(filled, kinds)
    except InputError as fault:
        raise fitted.explained(fault) from None


def _with_movements(tables: dict[str, Any], kinds: Kinds) -> dict[str, Any]:
    """Replace paths of movements' files by the files' tables, which a recording then holds."""
    made = copy.copy(tables)
    blocks = tables.get("blocks")
    places = [("blocks", name) for name, table in (blocks.items() if isinstance(blocks, dict) else ())
              if isinstance(table, dict) and Movement in get_args(_movement_hint(table.get("kind"), kinds))]
    for top, name in [*places, ("score", "search")]:
        holder = made[top].get(name) if isinstance(made.get(top), dict) else None
        given = holder.get("movement") if isinstance(holder, dict) else None
        if isinstance(holder, dict) and isinstance(given, str):
            try:
                stated = stated_movement(given)
            except InputError as fault:
                where = f"{top}.{name}.movement"
                if fault.where == "movement":  # an unknown name
                    raise InputError(where, fault.found, fault.allowed, fault.remedy) from None
                raise fault.within(where) from None
            made[top] = {**made[top], name: {**holder, "movement": stated}}
    return made


def _movement_hint(kind: Any, kinds: Kinds) -> Any:
    return hints_of(kinds[kind]).get("movement") if isinstance(kind, str) and kind in kinds else None


def _require_code(tables: Mapping[str, Any]) -> None:
    """Raise InputError where a class that the tables have the source of is another one here, or missing."""
    code = tables.get("code", {})
    if not isinstance(code, Mapping):
        return  # a fault of form
    for name, table in tables["blocks"].items() if isinstance(tables.get("blocks"), Mapping) else ():
        kind = table.get("kind") if isinstance(table, Mapping) else None
        if not isinstance(kind, str) or kind not in code or registry.source(kind) == code[kind]:
            continue
        where = f"blocks.{name}.kind"
        if ":" in kind:
            raise InputError(where, f"{kind!r} is no kind, but a class that was given as an object",
                             "a class that can be defined from its source",
                             "put @fesloop.block above it, and make the experiment again")
        what = ("is now another class than in this experiment" if registry.source(kind)
                else "is not defined here")
        raise InputError(where, f"{kind!r}, a class of a notebook or a script, {what}", "the class as it was",
                         "make the experiment again with the present one, or run the source that a recording "
                         "has of it, Recording(path).experiment['code']")


def _filled(tables: dict[str, Any], kinds: Kinds) -> dict[str, Any]:
    """Add the parameters of the patient and of model files to the tables; raises InputErrors.

    Tables are validated before a value is used. Missing parameters of blocks are tolerated here, since a
    patient or a model file may supply them.
    """
    faults = faults_of_form(tables, kinds)
    patient, of_patient = patient_of(tables, faults)
    sure = [fault for fault in faults if not _may_be_added(fault)]
    if sure:
        raise_all(of_patient + sure)
    filled = tables
    try:
        filled = tables if patient is None else with_patient(tables, patient, kinds)
    except InputError as fault:
        of_patient.append(fault)
    try:
        filled = with_models(filled, kinds, patient_known=not of_patient)
    except InputErrors as several:
        raise InputErrors([*of_patient, *several.faults]) from None
    raise_all(of_patient + (faults if filled == tables else faults_of_form(filled, kinds)))
    return filled


def _may_be_added(fault: InputError) -> bool:
    """Return whether a fault is a missing parameter of a block, which a patient or model may add."""
    return (fault.found == "is missing" and fault.where.startswith("blocks.") and "[" not in fault.where
            and not fault.where.endswith(".kind"))


def _experiment(document: dict[str, Any], kinds: Kinds) -> Experiment:
    """Make every object, and gather the faults of all."""
    faults: list[InputError] = []

    def made(create: Any, *given: Any) -> Any:
        try:
            return create(*given)
        except InputErrors as several:
            faults.extend(several.faults)
        except InputError as fault:
            faults.append(fault)
        return None

    blocks = document["blocks"]
    nodes: dict[str, Any] = dict.fromkeys(blocks)
    followed = {name: made(_followed, name, blocks) for name in blocks}
    for name in sorted(filter(followed.get, blocks), key=lambda name: len(followed[name])):
        owner_refused = any(nodes[owner] is None for owner in followed[name][1:])
        if not owner_refused:
            nodes[name] = made(_node, name, blocks[name], kinds, nodes)
    listed = document.get("wires", [])
    links = document.get("links", {})
    wires = [made(_wire, wire_place(i, listed), table, kinds, links) for i, table in enumerate(listed)
             if not table.get("optional") or _can_be_wired(table, nodes)]
    record = made(make, Record, document.get("record", {}), kinds, "record")
    score = made(make, Score, document.get("score", {}), kinds, "score")
    raise_all(faults)
    about = dict(document["experiment"])
    if "duration_s" in about:
        about["duration_s"] = float(about["duration_s"])
    return Experiment(nodes=tuple(nodes.values()), wires=tuple(wires), record=record, score=score,
                      patient=document.get("patient"), **about)


def _followed(name: str, blocks: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Chain of clocks: a block, the one whose clock it follows, the one that this one follows, and so on.

    None of a block that ends in a circle; the first block of the file that is in it raises InputError.
    """
    chain = [name]
    owner = blocks[name].get("clock", "")
    while owner in blocks and owner not in chain:
        chain.append(owner)
        owner = blocks[owner].get("clock", "")
    if owner not in chain:
        return chain
    circle = chain[chain.index(owner):]
    if name != next(each for each in blocks if each in circle):
        return []
    ring = " follows ".join((*circle, owner))
    raise InputError(f"blocks.{name}.clock", f"there is no clock to follow: {ring}",
                     "a block with a rate or a clock of its own")


def _node(name: str, table: dict[str, Any], kinds: Kinds, nodes: Mapping[str, Node | None]) -> Node:
    """Make the node of a block or plant; `nodes` are those whose clock it may follow."""
    where = f"blocks.{name}"
    parameters = {key: value for key, value in table.items() if key not in _PLACE}
    part = make(kinds[table["kind"]], parameters, kinds, where)
    place: dict[str, Any] = {key: table[key] for key in ("rate", "offset_ms") if key in table}
    if "clock" in table:
        place["rate"] = _followed_clock(f"{where}.clock", table, nodes)
    if "execution" in table:
        place["execution"] = make(Duration, table["execution"], kinds, f"{where}.execution")
    try:
        return Node(name, part, **place)
    except InputError as fault:
        raise InputError(f"blocks.{fault.where}", fault.found, fault.allowed, fault.remedy) from None


def _followed_clock(where: str, table: dict[str, Any], nodes: Mapping[str, Node | None]) -> Clock | None:
    """Clock of the node whose clock a block follows."""
    if "rate" in table:
        raise InputError(where, "both `clock` and `rate` are given", remedy="remove one")
    sampled = [name for name, node in nodes.items() if node is not None and not node.is_plant]
    node = nodes.get(table["clock"])
    if node is None or node.is_plant:
        raise InputError(where, f"there is no block {table['clock']!r} with a clock", ", ".join(sampled),
                         did_you_mean(table["clock"], sampled))
    return node.clock


def _can_be_wired(table: dict[str, Any], nodes: Mapping[str, Node | None]) -> bool:
    """Return whether to keep an optional wire: its ports exist, or the input requires it."""
    ports = []
    for end, side in ((table["from"], "outputs"), (table["to"], "inputs")):
        name, _, port_name = end.partition(".")
        node = nodes.get(name)
        if node is None:
            return False
        ports.append([port for port in getattr(node.part, side) if port.name == port_name])
    sources, targets = ports
    return bool(targets) and (bool(sources) or not targets[0].optional)


def _wire(where: str, table: dict[str, Any], kinds: Kinds, links: Mapping[str, Any]) -> Wire:
    """Make a wire, with the transport of its link if it names one; `where` leads every fault."""
    link = table.get("link")
    if link is not None:
        if link not in links:
            raise InputError(f"{where}.link", f"there is no link {link!r}",
                             ", ".join(links) or f"a table [links.{link}]",
                             did_you_mean(link, list(links)))
        own = [key for key in TRANSPORT if key in table]
        if own:
            raise InputError(f"{where}.{own[0]}", f"is given beside link = {link!r}",
                             "transport of a wire on a link in the table of the link",
                             f"set links.{link}.{own[0]}, or remove link")
    names = {"from": "source", "to": "target"}
    values = {names.get(key, key): value for key, value in {**links.get(link or "", {}), **table}.items()
              if key != "optional"}
    try:
        return make(Wire, values, kinds, where)  # type: ignore[no-any-return]
    except InputError as fault:
        key = fault.where.removeprefix(f"{where}.").rpartition(": ")[2]
        place = f"links.{link}" if link is not None else where
        known = key.partition(".")[0] in TRANSPORT
        raise InputError(f"{place}.{key}" if known else fault.where, fault.found, fault.allowed,
                         fault.remedy) from None
