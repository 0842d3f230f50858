"""What parts leave open, settled from what is wired to them: sizes, and whose samples they read."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

from fesloop.errors import InputError
from fesloop.loop.signals import Port, Sensors
from fesloop.loop.wire import Wire

if TYPE_CHECKING:
    from fesloop.loop.wiring import Node


def resolved(nodes: Sequence[Node], wires: Sequence[Wire]) -> tuple[Node, ...]:
    """Nodes with every open size settled from what is wired to it, sources first, and told of its sensors."""
    current = {node.name: node for node in nodes}
    wired = {wire.target for wire in wires}
    known: dict[str, dict[str, Sensors]] = {}
    _tell_sensors(current, wires, known)
    progress = True
    while progress:
        progress = False
        for name, node in current.items():
            open_inputs = {port.name for port in node.part.inputs
                           if not port.resolved and f"{name}.{port.name}" in wired}
            if not open_inputs or not hasattr(node.part, "resolve"):
                continue
            shapes = _incoming_shapes(node, wires, current)
            if open_inputs <= shapes.keys():
                _check_dimensions(node, shapes)
                part = _named(node, node.part.resolve, shapes)
                if any(not port.resolved for port in part.inputs):
                    raise InputError(name, "leaves open a size that its wires settle",
                                     "resolve() gives every input a size")
                current[name] = replace(node, part=part)
                known.pop(name, None)
                _tell_sensors(current, wires, known)
                progress = any(not p.resolved for p in node.part.inputs + node.part.outputs)
    return tuple(current[node.name] for node in nodes)


def _tell_sensors(
    nodes: dict[str, Node], wires: Sequence[Wire], known: dict[str, dict[str, Sensors]]
) -> None:
    """Tell nodes that want to know it whose samples are wired to them, as far as that is known and new."""
    progress = True
    while progress:
        progress = False
        for name, node in nodes.items():
            part: Any = node.part
            if not hasattr(part, "with_sensors"):
                continue
            sources = {target: port.sensors for target, port in _incoming_ports(node, wires, nodes)
                       if port.sensors is not None}
            if sources and sources != known.get(name):
                known[name] = sources
                nodes[name] = replace(node, part=_named(node, part.with_sensors, sources))
                progress = True


def _incoming_ports(
    node: Node, wires: Sequence[Wire], nodes: Mapping[str, Node]
) -> Iterator[tuple[str, Port]]:
    """Names of a node's inputs, each with the output that is wired to it."""
    for wire in wires:
        target, input_name = wire.target.split(".")
        if target == node.name:
            source, output_name = wire.source.split(".")
            yield input_name, next(p for p in nodes[source].part.outputs if p.name == output_name)


def _named(node: Node, make: Callable[[Any], Any], what: Any) -> Any:
    """The node's part made for what is wired to it; its faults get the node's name for the part's."""
    try:
        return make(what)
    except InputError as fault:
        place = fault.where.removeprefix(f"{type(node.part).__name__.lower()}.")
        raise InputError(f"{node.name}.{place}", fault.found, fault.allowed, fault.remedy) from None


def _incoming_shapes(
    node: Node, wires: Sequence[Wire], nodes: Mapping[str, Node]
) -> dict[str, tuple[int, ...]]:
    """Known shapes of what is wired to a node, by input name; a number counts as a vector of one."""
    vectors = {port.name for port in node.part.inputs if port.shape == (None,)}
    return {name: cast(tuple[int, ...], port.shape) or ((1,) if name in vectors else ())
            for name, port in _incoming_ports(node, wires, nodes) if port.resolved}


def _check_dimensions(node: Node, shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Raise InputError for what is wired to an open-sized input and is of other dimensions."""
    for port in node.part.inputs:
        shape = shapes.get(port.name)
        if port.resolved or shape is None:
            continue
        if len(shape) != len(port.shape) or any(size not in (None, given)
                                                for size, given in zip(port.shape, shape, strict=True)):
            sizes = ", ".join("any" if size is None else str(size) for size in port.shape)
            raise InputError(f"{node.name}.{port.name}", f"a signal of shape {shape} is wired in",
                             f"shape ({sizes}{',' if len(port.shape) == 1 else ''})")
