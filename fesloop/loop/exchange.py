"""Which plants exchange with each other, and what publishes the samples of such a group."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from fesloop.loop.order import upstream_first
from fesloop.loop.publish import Publisher, Sampler
from fesloop.loop.wiring import Wiring


def sampled_in_order(wiring: Wiring) -> frozenset[str]:
    """Names of the plants that are sampled by events in the wiring's order.

    The outputs of a plant with feedthrough depend on what blocks send at the same instant: it, and any plant
    that exchanges with it, waits for them. All others are sampled when somebody looks.
    """
    direct = {node.name for node in wiring.nodes if node.is_plant and node.plant.feedthrough}
    return frozenset(name for name, members in _groups(wiring).items() if members & direct)


def publishers(wiring: Wiring, samplers: Sequence[Sampler]) -> dict[str, Publisher]:
    """By plant that needs no events, its publisher, which is that of all plants that exchange with it."""
    ordered = sampled_in_order(wiring)
    made: dict[int, Publisher] = {}
    found = {}
    for name, members in _groups(wiring).items():
        if name not in ordered:
            own = [_of(together, samplers) for together in upstream_first(members, wiring.connections)]
            found[name] = made.setdefault(id(members), Publisher(own))
    return found


def _groups(wiring: Wiring) -> dict[str, set[str]]:
    """By plant, the names of all that it exchanges with; one set a group."""
    group = {node.name: {node.name} for node in wiring.nodes if node.is_plant}
    for connection in wiring.connections:
        if connection.source.is_plant and connection.target.is_plant and connection.heard:
            joined = group[connection.source.name] | group[connection.target.name]
            for name in joined:
                group[name] = joined
    return group


def _of(plants: Iterable[str], samplers: Sequence[Sampler]) -> list[Sampler]:
    names = set(plants)
    return [sampler for sampler in samplers if sampler.plant.name in names]
