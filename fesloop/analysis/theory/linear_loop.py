"""Extracts the linear loop of an experiment: the parts that lead from its plant back to its plant.

Parts outside the loop (references, recorders, trackers without a reader) are constant, or have no effect on
deviations from rest, so they are left out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.theory import rest
from fesloop.analysis.theory.loop import LinearLoop, bursts, varies
from fesloop.errors import InputError, RunError
from fesloop.experiment.running import Experiment
from fesloop.loop.block import Context
from fesloop.loop.cautions import is_source, put_out
from fesloop.loop.clock import RateClock
from fesloop.loop.nodes import Connection, Node
from fesloop.models.linear_form import ContinuousForm, LinearBlock, LinearPlant, SampledForm, uncovered


@contextmanager
def within_floats(what: str) -> Iterator[None]:
    """Turn floating-point overflow into a RunError; a context manager and a decorator."""
    try:
        with np.errstate(over="raise"):
            yield
    except FloatingPointError:
        raise RunError(f"{what}: its numbers grow beyond the range of floats") from None


Array = NDArray[np.float64]


@within_floats("the linear loop")
def linear_loop(experiment: Experiment) -> LinearLoop:
    """The linear loop of an experiment near rest, where nothing saturates and no limit acts.

    Raises InputError, in one line that names the part and the reason, for parts that are not linear or that
    the theory does not cover: several plants, plants of fixed steps, stamps in place of rates, random
    execution times, jitter into a plant, jitter kept in order, jitter or losses in bursts on more than one
    wire, and a loop that rests on or beyond a limit of one of its blocks.
    """
    wiring = experiment.wiring
    plant, downstream = _plant_of_the_loop(experiment)
    used, forms = _forms_upstream(plant, downstream, wiring.connections, experiment.seed)
    outputs = sorted({c.source_port for c in used if c.source is plant})
    if len(outputs) != 1:
        names = [plant.part.outputs[port].name for port in outputs]
        raise uncovered(plant.name, f"feeds {' and '.join(names) or 'no output'} back with an effect at rest",
                        "one output")
    plant_form = _plant_form(plant, plant.part.outputs[outputs[0]].name)
    for connection in used:
        if connection.target is plant and not connection.wire.target.endswith(f".{plant_form.input}"):
            raise uncovered(connection.wire.target, "is not linear", f"{plant.name}.{plant_form.input}")
    _require_inverse_curves(plant, plant_form, forms, used)
    _require_covered_wires(used)
    truth = _truth_port(experiment, plant, outputs[0])
    port = plant.part.outputs[truth]
    rows = _plant_form(plant, port.name).c
    named = len(experiment.score.joints) == len(rows)
    truth_names = experiment.score.joints if named else tuple(f"{port.name}[{i}]" for i in range(len(rows)))
    loop = LinearLoop(
        name=experiment.name, plant=plant, plant_form=plant_form, connections=used,
        blocks=tuple((node, forms[node.name]) for node in wiring.nodes if node.name in forms),
        truth=rows, truth_names=truth_names, truth_unit=port.unit,
        reading=RateClock.from_rate(experiment.record.plant_rate), given=_given(experiment, forms, used))
    rest.require_within_limits(loop)
    return loop


def _plant_of_the_loop(experiment: Experiment) -> tuple[Node, set[str]]:
    """The plant whose output returns to it, and the names of all nodes that its output reaches."""
    wiring = experiment.wiring
    reached = {node.name: _reached(node.name, wiring.connections) for node in wiring.nodes if node.is_plant}
    looped = [node for node in wiring.nodes if node.is_plant and node.name in reached[node.name]]
    if len(looped) != 1:
        found = f"plants {', '.join(node.name for node in looped)} are on a loop" if looped else \
            "no plant's output returns to it"
        raise uncovered(experiment.name, found, "one plant")
    plant = looped[0]
    if not isinstance(plant.part, LinearPlant):
        raise uncovered(plant.name, f"{type(plant.part).__name__} is not linear", "a linear plant")
    if plant.plant.grid is not None:
        raise uncovered(plant.name, "advances in fixed steps", "an exact plant")
    return plant, reached[plant.name]


def _reached(start: str, connections: Iterable[Connection]) -> set[str]:
    """Names of all nodes that the output of a node reaches."""
    reached: set[str] = set()
    open_ends = [start]
    while open_ends:
        here = open_ends.pop()
        further = {c.target.name for c in connections if c.source.name == here and c.heard} - reached
        reached |= further
        open_ends += further
    return reached


def _forms_upstream(
    plant: Node, downstream: set[str], connections: Sequence[Connection], seed: int
) -> tuple[tuple[Connection, ...], dict[str, SampledForm]]:
    """Wires that carry the plant's deviations back to it, and the forms of the blocks between them."""
    used: list[Connection] = []
    forms: dict[str, SampledForm] = {}
    open_ends = [plant]
    while open_ends:
        here = open_ends.pop()
        for connection in connections:
            source = connection.source
            if connection.target is not here or source.name not in downstream or not connection.heard:
                continue
            name = here.part.inputs[connection.target_port].name
            if here is not plant and name not in forms[here.name].inputs:
                continue
            used.append(connection)
            if source is not plant and source.name not in forms:
                forms[source.name] = _block_form(source, seed)
                open_ends.append(source)
            if source is not plant:
                _require_output(connection, forms[source.name])
    return tuple(c for c in connections if c in used), forms


def _block_form(node: Node, seed: int) -> SampledForm:
    part: Any = node.part
    if not isinstance(part, LinearBlock):
        raise uncovered(node.name, f"{type(part).__name__} is not linear", "linear blocks")
    if not isinstance(node.clock, RateClock):
        raise uncovered(f"{node.name}.clock", "ticks at given stamps", "a rate")
    if node.execution.kind not in ("zero", "fixed") or node.execution.least_ns > node.clock.shortest_ns:
        raise uncovered(f"{node.name}.execution", f"{node.execution.kind}",
                        "zero, or fixed and no longer than a period")
    return cast(SampledForm, _named(
        node.name, lambda: part.linear_form(Context(node.name, seed, clock=node.clock))))


def _given(
    experiment: Experiment, forms: Mapping[str, SampledForm], used: Sequence[Connection]
) -> dict[tuple[str, str], Array]:
    """Final values of block inputs that no wire of the loop leads to, by (block, port)."""
    wiring, given = experiment.wiring, {}
    for node in (each for each in wiring.nodes if each.name in forms):
        for number, port in enumerate(node.part.inputs):
            into = [c for c in wiring.connections if c.target is node and c.target_port == number]
            if port.name not in forms[node.name].inputs or any(c in used for c in into):
                continue
            if not into:
                given[node.name, port.name] = np.ravel(port.initial_value())
            elif is_source(into[0].source):
                values = put_out(wiring, into[0].source, into[0].source_port, experiment.duration_ns)
                if len(values):
                    given[node.name, port.name] = np.ravel(values[-1])
    return given


def _plant_form(plant: Node, output: str) -> ContinuousForm:
    part: Any = plant.part
    return cast(ContinuousForm, _named(plant.name, lambda: part.linear_form(output)))


def _named(name: str, form: Callable[[], Any]) -> Any:
    """The form; its InputError is prefixed with the node's name."""
    try:
        return form()
    except InputError as fault:
        place = fault.where.rpartition(".")[2]
        raise InputError(f"{name}.{place}", fault.found, fault.allowed, fault.remedy) from None


def _require_output(connection: Connection, form: SampledForm) -> None:
    name = connection.source.part.outputs[connection.source_port].name
    if name != form.output:
        raise uncovered(connection.wire.source, "is not linear", f"{connection.source.name}.{form.output}")


def _require_inverse_curves(
    plant: Node, plant_form: ContinuousForm, forms: dict[str, SampledForm], used: Sequence[Connection]
) -> None:
    """Raise InputError unless blocks turn drives into pulses by the curves of the plant."""
    open_ends = [c.source for c in used if c.target is plant]
    while open_ends:
        node = open_ends.pop()
        form = forms[node.name]
        if form.passes_pulses:
            open_ends += [c.source for c in used if c.target is node]
        elif form.curves != plant_form.curves:
            raise uncovered(f"{node.name}.recruitment", f"is not that of {plant.name}",
                            "the plant's own curves, so that drives come out as they went in")


def _require_covered_wires(connections: Sequence[Connection]) -> None:
    """Raise InputError for the first wire that the theory does not cover."""
    for connection in connections:
        wire, where = connection.wire, f"wire {connection.wire.name}"
        if connection.clock is not None and not isinstance(connection.clock, RateClock):
            raise uncovered(where, "is sampled at given stamps", "a rate")
        if varies(connection):
            if connection.target.is_plant:
                raise uncovered(f"{where}: jitter", "into a plant", "zero or fixed")
            if wire.late == "in-order":
                raise uncovered(f"{where}: late", "in-order under jitter", "keep-newest")
            if bursts(connection):
                raise uncovered(f"{where}: burst_messages", "bursts of losses under jitter", "one of the two")
    packets: dict[str, Connection] = {}
    for connection in connections:
        if connection.wire.link is not None and connection.wire.random:
            other = packets.setdefault(connection.wire.link, connection)
            if other is not connection:
                raise uncovered(f"wire {connection.wire.name}",
                                f"shares losses or jitter with {other.wire.name} (link "
                                f"{connection.wire.link!r})", "one random wire of a link in the loop")
    chained = [c for c in connections if varies(c) or bursts(c)]
    if len(chained) > 1:
        raise uncovered(f"wire {chained[1].wire.name}", f"jitter or bursts, as on {chained[0].wire.name}",
                        "one such wire")


def _truth_port(experiment: Experiment, plant: Node, fed_back: int) -> int:
    """Number of the plant's output that the experiment scores; else of the output that is fed back."""
    name, _, port = (experiment.score.truth or "").partition(".")
    names = [p.name for p in plant.part.outputs]
    return names.index(port) if name == plant.name else fed_back
