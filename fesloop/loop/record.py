"""Recorder of a loop: plain lists of rows, which a file writer, a test or a live view drains.

A recorder only reads, and costs the loop one `append` a row.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from fesloop.loop.block import Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import Value

BlockRow = tuple[int, int, int, int, int, tuple[Value, ...]]
"""(tick index, time, instant the outputs left, oldest capture, newest capture, outputs); times in ns."""
PlantRow = tuple[list[int], list[int], tuple[Any, ...]]
"""(instants, physical instants of the values, one stack a port); times in ns."""
InputRow = tuple[int, int, int, int, Value]
"""(instant the input acts from, port number, oldest capture, newest capture, value); times in ns."""
EventRow = tuple[int, str, str, str]
"""(time in ns, node or wire, status, detail)."""


class Recorder:
    """Rows in memory, one list a stream.

    Parameters
    ----------
    plant_rate: how often plant outputs are read, for the record alone, Hz; None records no plant.
    """

    def __init__(self, plant_rate: str | int | float | None = "1000") -> None:
        self.plant_clock = (None if plant_rate is None
                            else RateClock.from_rate(plant_rate, where="record.rate"))
        self.blocks: dict[str, list[BlockRow]] = {}
        self.plants: dict[str, list[PlantRow]] = {}
        self.inputs: dict[str, list[InputRow]] = {}
        self.events: list[EventRow] = []

    def drain(self) -> tuple[
        dict[str, list[BlockRow]], dict[str, list[PlantRow]], dict[str, list[InputRow]], list[EventRow]
    ]:
        """Return and remove (blocks, plants, inputs, events) recorded since the last call."""
        taken = (_empty(self.blocks), _empty(self.plants), _empty(self.inputs), list(self.events))
        self.events.clear()
        return taken


def _empty(streams: dict[str, list[Any]]) -> dict[str, list[Any]]:
    """Copies of the streams' rows. The lists themselves, which the loop refers to, are cleared."""
    taken = {name: list(rows) for name, rows in streams.items()}
    for rows in streams.values():
        rows.clear()
    return taken


@dataclass(slots=True)
class StatusLatch:
    """Statuses that are true now, each reported once when it begins; part of a block's state."""

    holding: set[str] = field(default_factory=set)

    def put(self, tick: Tick, status: str, holds: bool, detail: str = "") -> None:
        """Report `status` if it is true and was not before."""
        if holds and status not in self.holding:
            self.holding.add(status)
            tick.report(status, detail)
        elif not holds:
            self.holding.discard(status)
