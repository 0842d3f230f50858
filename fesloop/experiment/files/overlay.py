"""The overlay of tables: a file over the one that it extends, the option of a variant over its file.

    remove = ["patient", "blocks.hand.object"]   applied first; with a block its wires and its signals in
                                                 [record] are removed too, and in the end aliases that lead to
                                                 what is removed blocks.tracker.kind = "vqf"
                                                 tables are merged key by key, at every depth; any other
                                                 value, a list too, replaces the old one, and so does a
                                                 table within a block or wire that is of another `kind`, or
                                                 has a `file` in place of a kind
    wires = [{ from = "a.b", to = "c.d" }]       added; merged into a wire between the same ports

Keys are dotted paths as in --set; that of a wire is `wires."a.b->c.d"`.
"""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

from fesloop.errors import InputError, did_you_mean

BESIDE = ("guide", "variants")
"""Tables of a file that no variant changes, and a file that extends another may."""
EXTENDING = "said by files that extend others"
"""Key of a document that lists the own tables of each file that it is made of, except the first."""
PATCHED = ("experiment", "patient", "electrodes", "record", "blocks", "links", "wires", "score", "aliases")
"""Tables of a file that a patch may change."""
ABSENT = object()
"""Marks a path at which a document has no value."""
Tables = dict[str, Any]
_SIGNALS = ("timed", "leave_out")
"""Lists of [record] that name blocks and signals."""
_MEMBER = ("kind", "file")
"""Keys that say which of several forms a table has."""
_PART = re.compile(r'"([^"]*)"|([^.\[\]"]+)|\[(\d+)\]')


def key_parts(key: str) -> list[str]:
    """Parts of a dotted path; a part may be quoted, an index may be in brackets."""
    return [quoted or bare or index for quoted, bare, index in _PART.findall(key)]


def key_text(path: Sequence[str]) -> str:
    """Dotted path of these parts."""
    return ".".join(part if part.replace("-", "_").isidentifier() else f'"{part}"' for part in path)


def keyed(document: Mapping[str, Any]) -> Tables:
    """Copy of a document with its wires keyed by their ends and its lists of signals keyed by signal.

    Patches find them by these keys in any order. The document must pass `is_patchable`.
    """
    return _named(copy.deepcopy(dict(document)))


def _named(made: Tables) -> Tables:
    """`keyed` without a copy: changes the tables that are passed."""
    wires = made.get("wires", [])
    made["wires"] = _by_name(wires, [wire_ends(wire) for wire in wires])
    for key in _SIGNALS:
        if key in made.get("record", {}):
            made["record"][key] = _by_name(made["record"][key], made["record"][key])
    return made


def plain_lists(document: Mapping[str, Any]) -> Tables:
    """A keyed document with plain lists again, as in a file."""
    made = {**document, "wires": list(document["wires"].values())}
    if "record" in made:
        made["record"] = {key: list(value.values()) if isinstance(value, dict) else value
                          for key, value in made["record"].items()}
    return made


def is_patchable(document: Mapping[str, Any]) -> bool:
    """Return whether tables are tables and wires have ends; the document's check finds the rest."""
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


def extended(base: Mapping[str, Any], document: Mapping[str, Any]) -> Tables:
    """Lay a file over the one that it extends: a patch that may also change [guide] and [variants].

    Raises InputError for tables of a form that cannot be merged, and for the removal of a key that does not
    exist.
    """
    for tables, where in ((base, "what it extends"), (document, "this file")):
        if not is_patchable({key: value for key, value in tables.items() if key not in BESIDE}):
            raise InputError(where, "cannot be merged with another file",
                             "blocks, wires with from and to, and other tables of an experiment file")
    removed = _removed_keys(document)
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


def merged_without(base: Tables, document: Mapping[str, Any]) -> Tables:
    """Merge a file's tables into those that it extends, without the keys in its list `remove`.

    Raises InputError for the removal of a key that the extended file does not have.
    """
    removed = _removed_keys(document)
    left: Tables = copy.deepcopy(base)
    for number, key in enumerate(removed):
        _take_out(left, key_parts(key), f"remove[{number}]")
    return dict(merged(left, {key: value for key, value in document.items() if key != "remove"}))


def _removed_keys(document: Mapping[str, Any]) -> list[str]:
    removed = document.get("remove", [])
    if not isinstance(removed, list) or not all(isinstance(key, str) for key in removed):
        raise InputError("remove", f"{removed!r}", "a list of key paths")
    return removed


def of_its_own(document: Mapping[str, Any]) -> Tables:
    """Drop the description and [guide] that a document has from the file that it extends."""
    made = dict(document)
    if EXTENDING not in document:
        return made
    own = document[EXTENDING][-1]
    if "description" not in own.get("experiment", {}) and "experiment" in made:
        made["experiment"] = {key: value for key, value in made["experiment"].items() if key != "description"}
    if "guide" not in own:
        made.pop("guide", None)
    return made


def patched(document: Mapping[str, Any], patch: Mapping[str, Any], where: str) -> Tables:
    """Apply a patch to a keyed document; `where`, the place of the patch, leads every fault.

    Raises InputError for the removal of a key that does not exist.
    """
    made = copy.deepcopy(dict(document))
    place = f"{where}.remove" if where else "remove"
    gone = [path for number, key in enumerate(patch.get("remove", ()))
            for path in _remove(made, key_parts(key), f"{place}[{number}]")]
    for key in PATCHED:
        if key in patch and key != "wires":
            made[key] = merged(made.get(key, {}), patch[key], 0 if key in ("blocks", "links") else 1)
    for wire in patch.get("wires", ()):
        made["wires"][wire_ends(wire)] = merged(made["wires"].get(wire_ends(wire), {}), wire, 1)
    _drop_aliases(made, [path for path in gone if not _has(made, path)])
    return _named(plain_lists(made))


def merged(old: Any, new: Any, depth: int = 0) -> Any:
    """Merge new tables into old ones; any other value replaces the old one.

    `depth` is that of the tables; a block is at 1. A deeper table of another kind, or with a file in place of
    a kind, replaces the old one, because keys of one kind are invalid for another.
    """
    if not (isinstance(old, dict) and isinstance(new, Mapping)) or (depth > 1 and _is_another(old, new)):
        return copy.deepcopy(new)
    return {**old, **{key: merged(old.get(key), value, depth + 1) for key, value in new.items()}}


def _is_another(old: Mapping[str, Any], new: Mapping[str, Any]) -> bool:
    """Return whether a table is of another kind than the one that it is merged into."""
    given, had = ({key for key in _MEMBER if key in table} for table in (new, old))
    return bool(given) and bool(had) and (given != had or new.get("kind") != old.get("kind"))


def _remove(document: Tables, path: list[str], where: str) -> list[list[str]]:
    """Remove a key and, with a block, its wires and signals; return the removed paths."""
    _take_out({key: document[key] for key in PATCHED if key in document}, path, where)
    if len(path) == 1:
        del document[path[0]]
    document.setdefault("wires", {})
    return [path, *(_detach(document, path[1]) if path[0] == "blocks" and len(path) == 2 else [])]


def _take_out(tables: Tables, path: Sequence[str], where: str) -> None:
    """Remove the value at a path; raises InputError if there is none."""
    holder: Any = {}
    here: Any = tables
    for depth, part in enumerate(path or [""]):
        if not isinstance(here, dict) or part not in here:
            known = list(here) if isinstance(here, dict) else []
            raise InputError(where, f"there is no {key_text(path[:depth + 1])!r}", ", ".join(known),
                             did_you_mean(part, known))
        holder, here = here, here[part]
    del holder[path[-1]]


def _has(here: Any, path: Sequence[str]) -> bool:
    for part in path:
        if not isinstance(here, dict) or part not in here:
            return False
        here = here[part]
    return True


def _detach(document: Tables, block: str) -> list[list[str]]:
    """Remove a block's wires and its signals in [record]; return the paths of the wires."""
    touching = [ends for ends in document["wires"] if block in blocks_of(ends)]
    for ends in touching:
        del document["wires"][ends]
    for key in _SIGNALS:
        if key in document.get("record", {}):
            document["record"][key] = {name: signal for name, signal in document["record"][key].items()
                                       if signal.partition(".")[0] != block}
    return [["wires", ends] for ends in touching]


def _drop_aliases(document: Tables, gone: Sequence[list[str]]) -> None:
    """Remove aliases, or those of their targets, that lead to a removed path."""
    left = {}
    for name, targets in document.get("aliases", {}).items():
        listed = targets if isinstance(targets, list) else [targets]
        kept = [each for each in listed
                if not any(key_parts(each)[:len(path)] == path for path in gone)]
        if kept:
            left[name] = kept if isinstance(targets, list) else kept[0]
    if "aliases" in document:
        document["aliases"] = left


def blocks_of(ends: str) -> set[str]:
    """Names of the two blocks in a wire's ends, `a.b->c.d`."""
    return {end.partition(".")[0] for end in ends.split("->")}


def wire_ends(wire: Mapping[str, str]) -> str:
    """Key of a wire: `from->to`."""
    return f"{wire['from']}->{wire['to']}"


def _by_name(items: Sequence[Any], names: Sequence[str]) -> dict[str, Any]:
    """Items by name; repeated names are numbered, so that the check of the document finds them."""
    made: dict[str, Any] = {}
    for name, item in zip(names, items, strict=True):
        again = sum(1 for other in made if other.partition(" ")[0] == name)
        made[f"{name} ({again + 1})" if again else name] = item
    return made


def same(one: Any, other: Any) -> bool:
    """Return whether two values are written alike, as 1, 1.0 and true are not."""
    if one is ABSENT or other is ABSENT:
        return one is other
    return json.dumps(one, sort_keys=True) == json.dumps(other, sort_keys=True)
