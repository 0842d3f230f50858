"""Timing of a block's steps by the wall clock, beside the run: its signals and stamps stay as they are."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from time import perf_counter_ns
from typing import Any

from fesloop.loop.block import Block, Tick
from fesloop.loop.signals import Sample, Value
from fesloop.loop.wiring import Wiring


class TimedBlock:
    """A block that is another one in everything, and notes how long each of its steps took.

    Attributes
    ----------
    durations_ns: of the steps so far, taken out by whoever writes them down.
    """

    def __init__(self, block: Block) -> None:
        self.__wrapped__ = block
        self.durations_ns: list[int] = []

    def __getattr__(self, name: str) -> Any:
        # The other block has been made for its wires: made again, it would no longer be timed.
        if name.startswith("__") or name in ("resolve", "with_sensors"):
            raise AttributeError(name)
        return getattr(self.__wrapped__, name)

    def step(self, state: Any, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """The other block's step."""
        began = perf_counter_ns()
        outputs = self.__wrapped__.step(state, inputs, tick)
        self.durations_ns.append(perf_counter_ns() - began)
        return outputs


def timed(wiring: Wiring, names: Collection[str]) -> tuple[Wiring, dict[str, TimedBlock]]:
    """The same wiring with the named blocks timed, and those blocks by name."""
    if not names:
        return wiring, {}
    blocks = {node.name: TimedBlock(node.block) for node in wiring.nodes if node.name in names}
    nodes = [replace(node, part=blocks.get(node.name, node.part)) for node in wiring.nodes]
    return Wiring(nodes, [connection.wire for connection in wiring.connections], wiring.seed), blocks
