"""Sizes that parts leave open, settled from what is wired to them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

from fesloop.errors import InputError
from fesloop.loop.wire import Wire

if TYPE_CHECKING:
    from fesloop.loop.wiring import Node


def resolved(nodes: Sequence[Node], wires: Sequence[Wire]) -> tuple[Node, ...]:
    """Nodes with every open size settled from what is wired to it, sources first."""
    current = {node.name: node for node in nodes}
    wired = {wire.target for wire in wires}
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
                part = _resolve(node, shapes)
                if any(not port.resolved for port in part.inputs):
                    raise InputError(name, "leaves open a size that its wires settle",
                                     "resolve() gives every input a size")
                current[name] = replace(node, part=part)
                progress = any(not p.resolved for p in node.part.inputs + node.part.outputs)
    return tuple(current[node.name] for node in nodes)


def _resolve(node: Node, shapes: dict[str, tuple[int, ...]]) -> Any:
    """The node's part for the sizes that are wired to it; its faults get the node's name for the part's."""
    part: Any = node.part
    try:
        return part.resolve(shapes)
    except InputError as fault:
        place = fault.where.removeprefix(f"{type(part).__name__.lower()}.")
        raise InputError(f"{node.name}.{place}", fault.found, fault.allowed, fault.remedy) from None


def _incoming_shapes(
    node: Node, wires: Sequence[Wire], nodes: Mapping[str, Node]
) -> dict[str, tuple[int, ...]]:
    """Known shapes of what is wired to a node, by input name."""
    shapes: dict[str, tuple[int, ...]] = {}
    for wire in wires:
        target, input_name = wire.target.split(".")
        if target == node.name:
            source, output_name = wire.source.split(".")
            port = next(p for p in nodes[source].part.outputs if p.name == output_name)
            if port.resolved:
                shapes[input_name] = cast(tuple[int, ...], port.shape)
    return shapes
