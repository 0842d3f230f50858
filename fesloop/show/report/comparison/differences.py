"""Section of a comparison on the differences between the resolved experiments, one row per key."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from fesloop.show.report.comparison.compared import Compared
from fesloop.show.report.parts import Fold, Notice, Paragraph, Part, Section, Table
from fesloop.show.report.run.words import counted, listed

_LONGEST = 60
"""Letters of a value in the table (chosen)."""
_MOST_ROWS = 80
"""Keys that are shown at once; the others are folded (chosen)."""
MISSING = "–"
Row = tuple[str, list[Any]]


def differences_section(runs: Sequence[Compared]) -> Section:
    """Keys in which the experiments differ; parameters of blocks that are of another kind are folded."""
    experiments = [run.recording.experiment for run in runs]
    rows, of_others = differing(experiments)
    columns = ["key", *(run.name for run in runs)]
    names = {run.recording.name for run in runs}
    parts: list[Part] = []
    if len(names) > 1:
        parts.append(Notice(text=f"These are runs of different experiments, {listed(sorted(names))}: equal "
                            "names may denote different things."))
    if not rows:
        parts.append(Paragraph(text="Their experiments are the same, seed included."))
    else:
        parts.append(Table(columns=columns, rows=_texts(rows[:_MOST_ROWS])))
    if len(rows) > _MOST_ROWS:
        parts.append(Fold(title=counted(len(rows) - _MOST_ROWS, "more key"),
                          parts=[Table(columns=columns, rows=_texts(rows[_MOST_ROWS:]))]))
    if of_others:
        parts.append(Fold(title=f"{counted(len(of_others), 'parameter')} of blocks whose kind differs",
                          parts=[Table(columns=columns, rows=_texts(of_others))]))
    versions = list(_versions(runs))
    if versions:
        parts.append(Fold(title="Versions that differ", parts=[
            Table(columns=["", *(run.name for run in runs)], rows=versions)]))
    return Section(key="differences", title="Differences", parts=parts)


def _texts(rows: Sequence[Row]) -> list[list[str]]:
    return [[key, *(_shown(value) for value in values)] for key, values in rows]


def differing(experiments: Sequence[Mapping[str, Any]]) -> tuple[list[Row], list[Row]]:
    """Every key that is not alike in all, with its value in each, None where it is not there.

    A block or a wire that only some have is one row. Parameters of blocks whose kinds differ come second,
    apart, for they tell of the kinds.
    """
    kinds = [{name: block.get("kind") for name, block in each.get("blocks", {}).items()}
             for each in experiments]
    wires = [{_ends(wire): wire for wire in each.get("wires", ())} for each in experiments]
    rows = [(f"blocks.{name}.kind", [each.get(name) for each in kinds])
            for name in dict.fromkeys(name for each in kinds for name in each)]
    rows += [(f"wire {ends}", ["there" if ends in each else None for each in wires])
             for ends in dict.fromkeys(ends for each in wires for ends in each)]
    changed = {key.split(".")[1] for key, values in rows if key.startswith("blocks.") and not _alike(values)}
    flat = [dict(_flat({**each, "wires": {}})) for each in experiments]
    keys = dict.fromkeys(key for each in flat for key in each)
    every = [(key, [each.get(key) for each in flat]) for key in keys if not key.endswith(".kind")]
    every += _of_wires(wires)
    every = [row for row in every if not _alike(row[1])]
    of_others = [row for row in every if row[0].startswith("blocks.") and row[0].split(".")[1] in changed]
    return [*(row for row in rows if not _alike(row[1])),
            *(row for row in every if row not in of_others)], of_others


def _of_wires(wires: Sequence[Mapping[str, Mapping[str, Any]]]) -> Iterator[Row]:
    """Keys of wires that all have."""
    common = set(wires[0]).intersection(*wires[1:])
    for ends in (each for each in wires[0] if each in common):
        flat = [dict(_flat(each[ends])) for each in wires]
        for key in dict.fromkeys(key for each in flat for key in each):
            yield f"wire {ends}: {key}", [each.get(key) for each in flat]


def _ends(wire: Mapping[str, Any]) -> str:
    return f"{wire.get('from', '?')} → {wire.get('to', '?')}"


def _flat(table: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, Any]]:
    """Keys by their paths."""
    for key, value in table.items():
        place = f"{path}.{key}" if path else str(key)
        if isinstance(value, Mapping):
            yield from _flat(value, place)
        else:
            yield place, value


def _alike(values: Sequence[Any]) -> bool:
    """Return whether all values are equal, NaN included."""
    texts = {json.dumps(value, sort_keys=True, default=str) for value in values}
    return len(texts) == 1


def _shown(value: Any) -> str:
    """A value as it stands in a file, shortened."""
    if value is None:
        return MISSING
    text = value if isinstance(value, str) else json.dumps(value, default=str)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST - 1]}…"


def _versions(runs: Sequence[Compared]) -> Iterator[list[str]]:
    for name in dict.fromkeys(name for run in runs for name in run.recording.versions):
        found = [run.recording.versions.get(name, MISSING) for run in runs]
        if len(set(found)) > 1:
            yield [name, *found]
