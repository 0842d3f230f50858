"""Order within an instant: topological over zero-latency wires, ties by declaration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fesloop.errors import InputError
from fesloop.loop.clock import Clock
from fesloop.loop.nodes import Connection, Node


@dataclass(frozen=True, slots=True, eq=False)
class Sampling:
    """Sampling of a plant at a clock's ticks, into every wire that samples at that clock.

    `observing`: nothing behind these wires leads to a plant. With or without them every trajectory is the
    same to the last bit, so the plant is not split for them; where others split it at the same ticks, they
    share its outputs.
    """

    plant: Node
    clock: Clock
    connections: tuple[Connection, ...]
    observing: bool


def samplings(connections: Sequence[Connection]) -> list[Sampling]:
    """Samplings, one per plant, clock and `observing`, in the order of declaration."""
    acting = _acting(connections)
    # A plant of fixed steps is split by none, and may show some outputs at less cost than all.
    splits = [(each.source, each.clock) for each in connections
              if each.heard and id(each.target) in acting and each.source.is_plant
              and each.source.plant.grid is None]
    groups: list[tuple[Node, Clock, bool, list[Connection]]] = []
    for connection in connections:
        clock = connection.clock
        if clock is None or not connection.heard:
            continue
        observing = id(connection.target) not in acting and (connection.source, clock) not in splits
        for node, at, only, members in groups:
            if node is connection.source and at == clock and only == observing:
                members.append(connection)
                break
        else:
            groups.append((connection.source, clock, observing, [connection]))
    return [Sampling(node, clock, tuple(members), only) for node, clock, only, members in groups]


def _acting(connections: Sequence[Connection]) -> set[int]:
    """Ids of plants, and of blocks with a path to a plant."""
    acting = {id(c.target) for c in connections if c.target.is_plant}
    before = -1
    while len(acting) > before:
        before = len(acting)
        acting |= {id(c.source) for c in connections if not c.source.is_plant and id(c.target) in acting}
    return acting


def upstream_first(plants: set[str], connections: Sequence[Connection]) -> list[set[str]]:
    """Names of plants that exchange, in stages: no stage has input from a later one; a ring is one stage."""
    exchanges = [(c.source.name, c.target.name) for c in connections
                 if c.heard and c.source.name in plants and c.target.name in plants]
    stages: list[set[str]] = []
    left = set(plants)
    while left:
        first = left - {target for source, target in exchanges if source in left}
        stages += [{name} for name in sorted(first)] or [left]
        left = left - first if first else set()
    return stages


def firing_order(nodes: Sequence[Node], connections: Sequence[Connection]) -> tuple[Sampling | Node, ...]:
    """Samplings and block steps, in the order of execution where several are due at one instant.

    A wire orders its ends if both its least transport time and its source's least execution time are zero.
    A plant is ordered only where an output follows its input at once. Raises InputError for a loop of
    such ends (an algebraic loop), naming the nodes on it.
    """
    items: list[Sampling | Node] = [*samplings(connections), *(n for n in nodes if not n.is_plant)]
    names = [item.plant.name if isinstance(item, Sampling) else item.name for item in items]
    followers: list[list[int]] = [[] for _ in items]
    waiting = [0] * len(items)
    for before, after in _edges(items, connections):
        followers[before].append(after)
        waiting[after] += 1
    order: list[Sampling | Node] = []
    ready = [i for i, count in enumerate(waiting) if count == 0]
    while ready:
        first = min(ready)
        ready.remove(first)
        order.append(items[first])
        for after in followers[first]:
            waiting[after] -= 1
            if waiting[after] == 0:
                ready.append(after)
    if len(order) < len(items):
        stuck = {i for i, count in enumerate(waiting) if count > 0}
        raise _algebraic_loop(_cycle(stuck, followers), names)
    return tuple(order)


def _edges(
    items: Sequence[Sampling | Node], connections: Sequence[Connection]
) -> list[tuple[int, int]]:
    """Pairs (before, after) of item numbers that must run in that order at one instant."""
    numbers: dict[int, int] = {id(item): i for i, item in enumerate(items) if not isinstance(item, Sampling)}
    published = [(i, item) for i, item in enumerate(items) if isinstance(item, Sampling)]
    edges = []
    for connection in connections:
        if connection.wire.least_ns > 0 or connection.source.execution.least_ns > 0:
            continue
        if connection.source.is_plant:
            before = [i for i, sampling in published if connection in sampling.connections]
        else:
            before = [numbers[id(connection.source)]]
        if not connection.target.is_plant:
            after = [numbers[id(connection.target)]]
        elif connection.target.plant.feedthrough:
            after = [i for i, sampling in published if sampling.plant is connection.target]
        else:
            after = []
        edges += [(i, j) for i in before for j in after]
    return edges


def _cycle(stuck: set[int], followers: list[list[int]]) -> list[int]:
    """One cycle among items that all wait for each other."""
    alive = set(stuck)
    while True:
        dead = {i for i in alive if not alive.intersection(followers[i])}
        if not dead:
            break
        alive -= dead
    path = [min(alive)]
    while True:
        after = min(alive.intersection(followers[path[-1]]))
        if after in path:
            return path[path.index(after):]
        path.append(after)


def _algebraic_loop(cycle: list[int], names: list[str]) -> InputError:
    """The fault, with the loop spelt out."""
    ring = " -> ".join([names[i] for i in cycle] + [names[cycle[0]]])
    return InputError(f"wires {ring}", "form an algebraic loop: nothing on it takes any time",
                      "a latency or an execution time above 0 somewhere on the loop",
                      f"give one of these wires latency_ms, or {names[cycle[0]]} an execution time")
