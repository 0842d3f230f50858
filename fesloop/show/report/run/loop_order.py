"""Where the blocks of an experiment stand round its loop: down to the hand on one side, back up on the other.

The way down is the normative one: reference, controller, safety, stimulator, electrodes, muscles, hand; the
way up: sensors, tracker, what is made of its estimates.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

_COMMAND = "stimulation"
"""Port by which stimulation is asked for, passed on and taken."""


@dataclass(frozen=True, slots=True)
class Columns:
    """Names of blocks: `down` in the order in which commands pass them, `up` in that of measurements."""

    down: tuple[str, ...]
    up: tuple[str, ...]


def columns(blocks: Mapping[str, Any], wires: Sequence[Mapping[str, Any]]) -> Columns:
    """Both ways of an experiment, from its tables alone; every block is in one of them.

    Plants, and what lies between the first that asks for stimulation and them, are on the way down; so is
    what nothing is wired to and which leads there at once, such as a reference. All else is on the way up.
    """
    pairs = list(dict.fromkeys((_node(wire["from"]), _node(wire["to"])) for wire in wires))
    plants = {name for name, table in blocks.items() if is_plant(table)}
    askers = [name for name in blocks if _asks(name, wires)]
    passed = _reached(askers, pairs, plants) | plants
    heard = {target for _, target in pairs}
    sources = [name for name in blocks if name not in passed and name not in heard
               and all(target in passed for source, target in pairs if source == name)]
    down = [*sources, *_in_order([name for name in blocks if name in passed], pairs, askers)]
    rest = [name for name in blocks if name not in down]
    starts = [target for source, target in pairs if source in plants and target in rest]
    return Columns(tuple(down), tuple(_in_order(rest, pairs, starts)))


def is_plant(table: Mapping[str, Any]) -> bool:
    """Whether a block's table, every parameter resolved, is that of a plant: it executes nothing."""
    return "execution" not in table


def _node(end: str) -> str:
    return end.partition(".")[0]


def _asks(name: str, wires: Sequence[Mapping[str, Any]]) -> bool:
    """Whether a block's stimulation comes from itself."""
    gives = any(wire["from"] == f"{name}.{_COMMAND}" for wire in wires)
    return gives and not any(wire["to"] == f"{name}.{_COMMAND}" for wire in wires)


def _reached(starts: Sequence[str], pairs: Sequence[tuple[str, str]], plants: Collection[str]) -> set[str]:
    """What commands come to, not beyond the first plant."""
    found, left = set(starts), list(starts)
    while left:
        name = left.pop()
        if name in plants:
            continue
        fresh = {target for source, target in pairs if source == name} - found
        found |= fresh
        left += fresh
    return found


def _in_order(names: Sequence[str], pairs: Sequence[tuple[str, str]], starts: Sequence[str]) -> list[str]:
    """Names by how far they are from the starts, the longest way counting; ties as they were declared."""
    depth: dict[str, int] = {}

    def visit(name: str, far: int, way: tuple[str, ...]) -> None:
        if name in way or depth.get(name, -1) >= far:
            return
        depth[name] = far
        for source, target in pairs:
            if source == name and target in names:
                visit(target, far + 1, (*way, name))

    for name in [*starts, *names]:
        if name in names and name not in depth:
            visit(name, 0, ())
    return sorted(names, key=lambda name: depth[name])
