"""The table [record] of an experiment: what is recorded, and how often."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from fesloop.errors import InputError
from fesloop.loop.clock import parse_rate
from fesloop.loop.nodes import Node
from fesloop.loop.signals import Port


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """Settings of the recording, which has a row for each tick of a block by itself.

    Attributes
    ----------
    plant_rate: rate at which plant outputs are recorded, Hz; it changes no trajectory.
    timed: blocks whose steps are timed by the wall clock; it changes no result.
    leave_out: outputs, and inputs of plants, as "node.port", that are not recorded, to save space.
    """

    plant_rate: str | int | float = "1000"
    timed: tuple[str, ...] = ()
    leave_out: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        parse_rate(self.plant_rate, "plant_rate")
        for name in {name for name in self.timed if self.timed.count(name) > 1}:
            raise InputError("timed", f"{name!r} is listed twice", "each block once", "remove one")

    def faults(self, nodes: Sequence[Node]) -> list[InputError]:
        """Faults: blocks and signals that do not exist."""
        blocks = [node.name for node in nodes if not node.is_plant]
        signals = {name for node in nodes for name, _ in outputs_of(node)}
        signals |= {f"{node.name}.{port.name}" for node in nodes if node.is_plant
                    for port in node.part.inputs}
        known = {"timed": (self.timed, "block", blocks), "leave_out": (self.leave_out, "signal", signals)}
        return [InputError(f"record.{key}", f"there is no {what} {name!r}", ", ".join(sorted(names)))
                for key, (given, what, names) in known.items() for name in given if name not in names]


def outputs_of(node: Node) -> Iterator[tuple[str, Port]]:
    """Output ports of a node, each after the name of its signal."""
    return ((f"{node.name}.{port.name}", port) for port in node.part.outputs)
