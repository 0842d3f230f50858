"""From a wiring to what is in operation: a link for each wire, a station for each plant and block."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fesloop.loop.nodes import Connection, Node
from fesloop.loop.order import Sampling, upstream_first
from fesloop.loop.plants import ExactStation, GridStation, PlantInputs, PlantRecord, PlantStation
from fesloop.loop.publish import Publisher, Sampler
from fesloop.loop.record import EventRow, Recorder
from fesloop.loop.stations import BlockStation
from fesloop.loop.wire import Link
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


_Ends = Sequence[tuple[Connection, Link]]


@dataclass(frozen=True, slots=True, eq=False)
class Assembly:
    """Everything at t = 0 of a trial.

    Attributes
    ----------
    links: of the wiring's connections, in their order.
    plants, blocks: stations; plants by name, blocks in the order in which they step.
    samplers: of plant outputs, in the wiring's order.
    publishers: by plant that is sampled when somebody looks.
    """

    links: list[Link]
    plants: dict[str, PlantStation]
    samplers: list[Sampler]
    publishers: dict[str, Publisher]
    blocks: list[BlockStation]


def assembled(wiring: Wiring, trial: int, states: Mapping[str, Any], recorder: Recorder | None,
              events: list[EventRow]) -> Assembly:
    """A wiring with the state of each node; the recorder, if any, gets a list of rows for each stream."""
    links = [Link(connection.wire, wiring.seed, trial) for connection in wiring.connections]
    ends = list(zip(wiring.connections, links, strict=True))
    plants = {node.name: _plant_station(node, states[node.name], ends, recorder, events)
              for node in wiring.nodes if node.is_plant}
    samplers = [_sampler(each, plants, ends) for each in wiring.order if isinstance(each, Sampling)]
    published = publishers(wiring, samplers)
    blocks = [_block_station(each, states[each.name], ends, wiring.seed, trial, published, recorder, events)
              for each in wiring.order if isinstance(each, Node)]
    return Assembly(links, plants, samplers, published, blocks)


def _incoming(node: Node, ends: _Ends) -> tuple[tuple[int, Link], ...]:
    return tuple((connection.target_port, link) for connection, link in ends if connection.target is node)


def _plant_station(node: Node, state: Any, ends: _Ends, recorder: Recorder | None,
                   events: list[EventRow]) -> PlantStation:
    plant = node.plant
    input_rows = rows = clock = None
    if recorder is not None:
        input_rows = recorder.inputs.setdefault(node.name, [])
        rows = recorder.plants.setdefault(node.name, [])
        clock = recorder.plant_clock
    inputs = PlantInputs(plant, _incoming(node, ends), input_rows)
    sampled = {connection.source_port for connection, _ in ends
               if connection.source is node and connection.heard}
    record = PlantRecord(node.name, plant, rows, clock, sampled)
    if plant.grid is None:
        return ExactStation(node.name, plant, state, inputs, record)
    return GridStation(node.name, plant, state, inputs, record, plant.grid, events)


def _sampler(sampling: Sampling, plants: Mapping[str, PlantStation], ends: _Ends) -> Sampler:
    members = {id(connection) for connection in sampling.connections}
    outgoing = tuple((connection.source_port, link) for connection, link in ends if id(connection) in members)
    return Sampler(plants[sampling.plant.name], sampling.clock, outgoing, sampling.observing)


def _block_station(node: Node, state: Any, ends: _Ends, seed: int, trial: int,
                   published: Mapping[str, Publisher], recorder: Recorder | None,
                   events: list[EventRow]) -> BlockStation:
    outgoing = tuple((connection.source_port, link) for connection, link in ends if connection.source is node)
    read = {connection.source.name for connection, _ in ends if connection.target is node}
    sampled = {id(publisher): publisher for name, publisher in published.items() if name in read}
    rows = None if recorder is None else recorder.blocks.setdefault(node.name, [])
    return BlockStation(node, state, seed, trial, _incoming(node, ends), outgoing, tuple(sampled.values()),
                        rows, events)
