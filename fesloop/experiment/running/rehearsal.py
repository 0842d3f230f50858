"""A moment of a loop before the run itself, so that no tick of the run waits for compiled code."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import replace
from typing import Any

from fesloop.experiment.experiment import Experiment
from fesloop.loop.clock import NS_PER_S, waits_for_arrivals
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.wiring import Wiring

_MOMENT_NS = NS_PER_S // 10
_LONGEST_NS = 2 * NS_PER_S
"""Of simulated time, whatever wires take (chosen: a loop that keeps pace needs no longer for it)."""
_LONGEST_WALL_S = 1.0
"""Where the wall clock does not count, no stretch of the rehearsal begins later, however dense ticks are."""


class Rehearsals:
    """Rehearsals of runs in this process.

    They remember of which kinds of parts each loop was: the kernels of those are loaded.
    """

    def __init__(self) -> None:
        self._rehearsed: set[frozenset[type[Any]]] = set()

    def rehearse(self, experiment: Experiment, realtime: bool) -> None:
        """Load the kernels of a run, where that has yet to be done.

        A loop of the same kinds of parts needs it once in a process. Where the wall clock decides what comes
        of the run (in real time, or where steps are measured) it is done each time, for another parameter may
        lead to another kernel; elsewhere such a kernel costs some wall time and changes nothing. There it
        lasts until a message has been all the way round, two simulated seconds at most: blocks may call other
        kernels once they have heard one. Not where a device would notice, unless it has a stand-in. Whatever
        goes wrong here does so again in the run, which tells.
        """
        if without_stand_in(experiment.wiring):
            return
        wiring = with_stand_ins(experiment.wiring)
        parts = frozenset(type(node.part) for node in wiring.nodes)
        measured = any(node.execution.kind == "measured" for node in wiring.nodes)
        wall_counts = bool(realtime or measured or experiment.record.timed)
        if parts in self._rehearsed and not wall_counts:
            return
        self._rehearsed.add(parts)
        until = min(_MOMENT_NS + (_way_round_ns(wiring) if wall_counts else 0), _LONGEST_NS)
        began, done = time.perf_counter(), 0
        with suppress(Exception):
            loop = Loop(wiring, recorder=Recorder(experiment.record.plant_rate))
            while done < until and (wall_counts or time.perf_counter() - began < _LONGEST_WALL_S):
                done = max(1, 4 * done)
                loop.run_until(min(done, until))


def without_stand_in(wiring: Wiring) -> list[str]:
    """Names of the nodes that would notice a rehearsal, which is left out for them."""
    return [node.name for node in wiring.nodes
            if hasattr(node.part, "close") and not hasattr(node.part, "stand_in")]


def _way_round_ns(wiring: Wiring) -> int:
    """No message takes longer through the wires and blocks of the loop, each passed once."""
    wires = [connection.wire for connection in wiring.connections]
    return (sum(wire.latency_ns + (wire.jitter.most_ns or 0) for wire in wires)
            + sum(node.execution.most_ns or 0 for node in wiring.nodes))


def with_stand_ins(wiring: Wiring) -> Wiring:
    """The wiring with a stand-in for each block that has one, and no clock that waits for messages."""
    if not any(hasattr(node.part, "stand_in") or waits_for_arrivals(node.clock) for node in wiring.nodes):
        return wiring
    nodes = [_plain(node) for node in wiring.nodes]
    return Wiring(nodes, [connection.wire for connection in wiring.connections], wiring.seed)


def _plain(node: Node) -> Node:
    """The node with its stand-in, on a clock that ticks by itself."""
    stand_in = getattr(node.part, "stand_in", None)
    if stand_in is not None:
        node = replace(node, part=stand_in())
    given = node.given_clock
    return replace(node, rate=replace(given, arrivals="")) if waits_for_arrivals(given) else node
