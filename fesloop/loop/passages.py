"""How values pass through a block: what an input waits for inside it before the outputs follow.

A block with a member `passages(context)` declares it, a `Passage` each, for what the budget cannot see from
outside: a device's latency, a channel's slot, a delay line. An input that no passage names acts on every
output in the step that reads it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from fesloop.loop.block import Context
from fesloop.loop.nodes import Node


@dataclass(frozen=True, slots=True, kw_only=True)
class Passage:
    """The way of some inputs through a block.

    A message comes into force `delay_ns` after `since` and stays so until the next that was read does; it is
    the block's steps from then on whose outputs follow it. With lanes a step serves one of them only.

    Attributes
    ----------
    inputs: names of the ports whose messages wait.
    outputs: names of the ports that follow them in this way; empty: all.
    delay_ns: wait inside the block.
    since: what the delay counts from: the message's arrival, or the step that first reads it.
    delay: what the delay is, in words, for the budget.
    lanes: names of what the block serves in turn, such as channels: the outputs of tick k follow the input
        for lane k mod `slots` alone, and there is no lane for the slots beyond. Empty: no turns.
    slots: turns of a round; at least as many as lanes.
    turn: what the wait for a turn is, in words.
    holds: whether outputs show what a lane was given until its next turn; else in its turn only.
    later: when outputs follow what is read, in words, where that is no fixed time, such as "in the next
        trial"; empty where it is.
    """

    inputs: tuple[str, ...]
    outputs: tuple[str, ...] = ()
    delay_ns: int = 0
    since: Literal["arrival", "read"] = "arrival"
    delay: str = "delay"
    lanes: tuple[str, ...] = ()
    slots: int = 0
    turn: str = "wait for its turn"
    holds: bool = False
    later: str = ""

    def __post_init__(self) -> None:
        if self.slots < len(self.lanes) or (self.lanes and self.since == "read"):
            raise ValueError("a passage with lanes has a slot for each and counts from arrival")


def passage(node: Node, source: str, target: str, context: Context) -> Passage | None:
    """What a block declares of the way from its input `source` to its output `target`; None: at once."""
    declared = getattr(node.part, "passages", None)
    found: Sequence[Passage] = declared(context) if declared is not None else ()
    return next((each for each in found
                 if source in each.inputs and (not each.outputs or target in each.outputs)), None)
