"""A patch over the tables of an experiment file, and several patches at once.

    remove = ["patient", "blocks.hand.object"]   first of all; with a block go its wires and its signals in
                                                 [record]; last of all go aliases that lead to
                                                 what is not there any more
    blocks.tracker.kind = "vqf"                  tables are merged key by key, here and in all tables below;
                                                 any other value, a list too, takes the place of the old one,
                                                 and so does a table within a block or wire that
                                                 is of another `kind`, or of a `file` in place of a kind
    wires = [{ from = "a.b", to = "c.d" }]       added; merged into a wire between the same ports

Keys are dotted paths as in --set; that of a wire is `wires."a.b->c.d"`.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from fesloop.errors import InputError, did_you_mean
from fesloop.experiment.files.settings import key_parts, key_text

BESIDE = ("guide", "variants")
"""Tables of a file that no variant changes, and a file that extends another may."""
EXTENDING = "said by files that extend others"
"""Key under which a document has what each file said that it is made of, but the first."""
PATCHED = ("experiment", "patient", "record", "blocks", "wires", "score", "aliases")
"""Tables of a file that a patch may change."""
_SIGNALS = ("timed", "leave_out")
"""Lists of [record] that name blocks and signals."""
_MEMBER = ("kind", "file")
"""Keys that say which of several forms a table has."""
_ABSENT = object()
Tables = dict[str, Any]


def keyed(document: Mapping[str, Any]) -> Tables:
    """A copy of a document whose wires stand under their ends and whose lists of signals under the signals,
    so that patches find them wherever they stand. Its form must be that of `is_patchable`."""
    return _named(copy.deepcopy(dict(document)))


def _named(made: Tables) -> Tables:
    """As `keyed`, tables that nobody else has."""
    wires = made.get("wires", [])
    made["wires"] = _by_name(wires, [_ends(wire) for wire in wires])
    for key in _SIGNALS:
        if key in made.get("record", {}):
            made["record"][key] = _by_name(made["record"][key], made["record"][key])
    return made


def plain_lists(document: Mapping[str, Any]) -> Tables:
    """A keyed document as a file has it."""
    made = {**document, "wires": list(document["wires"].values())}
    if "record" in made:
        made["record"] = {key: list(value.values()) if isinstance(value, dict) else value
                          for key, value in made["record"].items()}
    return made


def is_patchable(document: Mapping[str, Any]) -> bool:
    """Whether tables are tables and wires have ends; all else is for the document's check."""
    tables = [document.get(key, {}) for key in PATCHED if key != "wires"]
    wires = document.get("wires", [])
    if not isinstance(wires, list) or not all(isinstance(each, dict) for each in tables + wires):
        return False
    record = document.get("record", {})
    texts = [value for key in _SIGNALS for value in _listed(record.get(key, []))]
    texts += [wire.get(end) for wire in wires for end in ("from", "to")]
    texts += [target for value in document.get("aliases", {}).values()
              for target in (value if isinstance(value, list) else [value])]
    return (all(isinstance(text, str) for text in texts)
            and all(isinstance(block, dict) for block in document.get("blocks", {}).values()))


def _listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [None]


def patched(document: Mapping[str, Any], patch: Mapping[str, Any], where: str) -> Tables:
    """A keyed document with a patch made to it; `where` the patch stands leads every fault.

    Raises InputError for a removal of what is not there.
    """
    made = copy.deepcopy(dict(document))
    place = f"{where}.remove" if where else "remove"
    gone = [path for number, key in enumerate(patch.get("remove", ()))
            for path in _remove(made, key_parts(key), f"{place}[{number}]")]
    for key in PATCHED:
        if key in patch and key != "wires":
            made[key] = merged(made.get(key, {}), patch[key], 0 if key == "blocks" else 1)
    for wire in patch.get("wires", ()):
        made["wires"][_ends(wire)] = merged(made["wires"].get(_ends(wire), {}), wire, 1)
    _drop_aliases(made, [path for path in gone if not _stands(made, path)])
    return _named(plain_lists(made))


def extended(base: Mapping[str, Any], document: Mapping[str, Any]) -> Tables:
    """Tables of a file over those of the one that it extends: a patch that may change [guide] and [variants].

    Raises InputError for tables that are of no form to be laid over each other, or a removal of what is not
    there.
    """
    for each, told in ((base, "what it extends"), (document, "this file")):
        if not is_patchable({key: value for key, value in each.items() if key not in BESIDE}):
            raise InputError(told, "has no such form that one can be laid over the other",
                             "blocks, wires with from and to, and other tables of an experiment file")
    removed = document.get("remove", [])
    if not isinstance(removed, list) or not all(isinstance(key, str) for key in removed):
        raise InputError("remove", f"{removed!r}", "a list of key paths")
    beside = [key for key in removed if key_parts(key)[:1] and key_parts(key)[0] in BESIDE]
    made = plain_lists(patched(keyed({key: base[key] for key in PATCHED if key in base}), {
        **document, "remove": [key for key in removed if key not in beside]}, ""))
    rest = {key: copy.deepcopy(base[key]) for key in base if key not in PATCHED}
    for number, key in enumerate(beside):
        _take_out(rest, key_parts(key), f"remove[{number}]")
    rest |= {key: merged(rest.get(key, {}), value) for key, value in document.items()
             if key not in (*PATCHED, "remove", EXTENDING)}
    own = {key: value for key, value in keyed(document).items() if key in (*PATCHED, *BESIDE)}
    return made | rest | {EXTENDING: [*base.get(EXTENDING, []), own]}


def of_its_own(document: Mapping[str, Any]) -> Tables:
    """A document without the description and [guide] of what it extends, which say nothing of it."""
    made = dict(document)
    if EXTENDING not in document:
        return made
    own = document[EXTENDING][-1]
    if "description" not in own.get("experiment", {}) and "experiment" in made:
        made["experiment"] = {key: value for key, value in made["experiment"].items() if key != "description"}
    if "guide" not in own:
        made.pop("guide", None)
    return made


def overruled(document: Mapping[str, Any], changed: Mapping[str, Any], variant: str,
              options: Sequence[str], asked: bool) -> str:
    """The first key that a file says over those that it extends, and that an option of theirs changes.

    An option that somebody has `asked` for may take the key out.

    Parameters
    ----------
    document, changed: keyed, before and after the option. A file that says of the key what it is to be with
        the option, or with one that the option is like (`options`), is obeyed.
    """
    layers = document.get(EXTENDING, ())
    for number, own in enumerate(layers):
        patches = [_by_ends(each.get("variants", {}).get(variant, {}).get(option, {}))
                   for each in layers[number:] for option in options]
        for path in _leaves({key: own[key] for key in own if key in PATCHED and key != "aliases"}):
            was, now = _at(document, path), _at(changed, path)
            if _same(was, now) or not _same(_at(own, path), was) or (now is _ABSENT and asked):
                continue
            if not any(_says(patch, path) for patch in patches):
                return key_text(path)
    return ""


def _says(patch: Mapping[str, Any], path: tuple[str, ...]) -> bool:
    """Whether a patch gives a key or takes it out."""
    removed = [key_parts(key) for key in patch.get("remove", ())]
    return _at(patch, path) is not _ABSENT or any(list(path[:len(each)]) == each for each in removed)


def _by_ends(patch: Mapping[str, Any]) -> Tables:
    return {**patch, "wires": {_ends(wire): wire for wire in patch.get("wires", ())}}


def _leaves(tables: Mapping[str, Any], path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Paths of all that is no table."""
    for key, value in tables.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, (*path, key))
        else:
            yield (*path, key)


def _at(tables: Any, path: Sequence[str]) -> Any:
    """What stands at a path."""
    for part in path:
        if not isinstance(tables, Mapping) or part not in tables:
            return _ABSENT
        tables = tables[part]
    return tables


def merged(old: Any, new: Any, depth: int = 0) -> Any:
    """What is new over what is old: tables merged, all else in the old one's place.

    `depth`: of the tables; a block is at 1. A table within one that is of another kind, or is made from a
    file where the old one has a kind, takes the old one's place: keys of one kind are none of another.
    """
    if not (isinstance(old, dict) and isinstance(new, Mapping)) or (depth > 1 and _is_another(old, new)):
        return copy.deepcopy(new)
    return {**old, **{key: merged(old.get(key), value, depth + 1) for key, value in new.items()}}


def _is_another(old: Mapping[str, Any], new: Mapping[str, Any]) -> bool:
    """Whether a table is of another kind than the one that it is laid over."""
    told, had = ({key for key in _MEMBER if key in table} for table in (new, old))
    return bool(told) and bool(had) and (told != had or new.get("kind") != old.get("kind"))


def _remove(document: Tables, path: list[str], where: str) -> list[list[str]]:
    """Take out what stands at a path, and what cannot be without it; their paths."""
    _take_out({key: document[key] for key in PATCHED if key in document}, path, where)
    if len(path) == 1:
        del document[path[0]]
    document.setdefault("wires", {})
    return [path, *(_detach(document, path[1]) if path[0] == "blocks" and len(path) == 2 else [])]


def _take_out(tables: Tables, path: Sequence[str], where: str) -> None:
    """Take out what stands at a path; raises InputError if there is nothing."""
    holder: Any = {}
    here: Any = tables
    for depth, part in enumerate(path or [""]):
        if not isinstance(here, dict) or part not in here:
            known = list(here) if isinstance(here, dict) else []
            raise InputError(where, f"there is no {key_text(path[:depth + 1])!r}", ", ".join(known),
                             did_you_mean(part, known))
        holder, here = here, here[part]
    del holder[path[-1]]


def _stands(here: Any, path: Sequence[str]) -> bool:
    for part in path:
        if not isinstance(here, dict) or part not in here:
            return False
        here = here[part]
    return True


def _detach(document: Tables, block: str) -> list[list[str]]:
    """Take a block's signals out of wires and record; the paths of the wires."""
    touching = [ends for ends in document["wires"] if block in blocks_of(ends)]
    for ends in touching:
        del document["wires"][ends]
    for key in _SIGNALS:
        if key in document.get("record", {}):
            document["record"][key] = {name: signal for name, signal in document["record"][key].items()
                                       if signal.partition(".")[0] != block}
    return [["wires", ends] for ends in touching]


def _drop_aliases(document: Tables, gone: Sequence[list[str]]) -> None:
    """Take out aliases, or what of them leads to a path that is gone."""
    left = {}
    for name, targets in document.get("aliases", {}).items():
        listed = targets if isinstance(targets, list) else [targets]
        kept = [each for each in listed
                if not any(key_parts(each)[:len(path)] == path for path in gone)]
        if kept:
            left[name] = kept if isinstance(targets, list) else kept[0]
    if "aliases" in document:
        document["aliases"] = left


def combined(base: Any, one: Any, other: Any, path: tuple[str, ...] = ()) -> Any:
    """The changes of both, each made to the same base, whichever of them is first.

    Raises InputError at the path of what they change in two ways.
    """
    if _same(one, other) or _same(base, other):
        return one
    if _same(base, one):
        return other
    old = {} if base is _ABSENT else base
    if not all(isinstance(each, dict) for each in (old, one, other)):
        raise InputError(key_text(path), "is changed in two ways")
    found = {}
    for key in dict.fromkeys([*one, *other]):
        was, first, second = (each.get(key, _ABSENT) for each in (old, one, other))
        found[key] = combined(was, first, second, (*path, key))
    return {key: value for key, value in found.items() if value is not _ABSENT}


def cut_off(base: Mapping[str, Any], one: Mapping[str, Any], other: Mapping[str, Any]) -> str:
    """The first wire that `one` adds to a block that `other` takes out; "" if there is none."""
    gone = set(base["blocks"]) - set(other["blocks"])
    return next((ends for ends in one["wires"] if ends not in base["wires"] and gone & blocks_of(ends)), "")


def blocks_of(ends: str) -> set[str]:
    """Names of the two blocks of a wire's ends, `a.b->c.d`."""
    return {end.partition(".")[0] for end in ends.split("->")}


def _ends(wire: Mapping[str, str]) -> str:
    return f"{wire['from']}->{wire['to']}"


def _by_name(items: Sequence[Any], names: Sequence[str]) -> dict[str, Any]:
    """Items by their names; the second of a name and later ones are numbered, for the check to find."""
    made: dict[str, Any] = {}
    for name, item in zip(names, items, strict=True):
        again = sum(1 for other in made if other.partition(" ")[0] == name)
        made[f"{name} ({again + 1})" if again else name] = item
    return made


def _same(one: Any, other: Any) -> bool:
    """Whether two values are written alike: 1, 1.0 and true are not."""
    if one is _ABSENT or other is _ABSENT:
        return one is other
    return json.dumps(one, sort_keys=True) == json.dumps(other, sort_keys=True)
