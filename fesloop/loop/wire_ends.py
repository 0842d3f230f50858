"""Ends of wires: those that do not exist, inputs with two wires, and inputs with none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING

from fesloop.errors import InputError
from fesloop.loop.wire import Wire

if TYPE_CHECKING:
    from fesloop.loop.wiring import Node


def end_faults(wire: Wire, nodes: Mapping[str, Node]) -> list[InputError]:
    """Ends of a wire that do not exist."""
    faults = []
    for end, outgoing in ((wire.source, True), (wire.target, False)):
        name, port = end.split(".")
        kind = "output" if outgoing else "input"
        if name not in nodes:
            faults.append(_unknown(wire, f"there is no node {name!r}", name, list(nodes)))
        else:
            part = nodes[name].part
            names = [p.name for p in (part.outputs if outgoing else part.inputs)]
            if port not in names:
                faults.append(_unknown(wire, f"{name!r} has no {kind} port {port!r}", port, names))
    return faults


def _unknown(wire: Wire, found: str, name: str, known: list[str]) -> InputError:
    close = get_close_matches(name, known, 1)
    remedy = f"did you mean {close[0]!r}?" if close else ""
    return InputError(f"wire {wire.name}", found, ", ".join(known) or "none", remedy)


def doubled_inputs(wires: Sequence[Wire]) -> list[InputError]:
    """Inputs with two wires."""
    faults = []
    first: dict[str, Wire] = {}
    for wire in wires:
        if wire.target in first:
            faults.append(InputError(f"wire {wire.name}",
                                     f"{wire.target!r} already has a wire from {first[wire.target].source!r}",
                                     "one wire into a port", "remove one of the two"))
        first.setdefault(wire.target, wire)
    return faults


def open_inputs(nodes: Sequence[Node], wires: Sequence[Wire]) -> list[InputError]:
    """Inputs that need a wire and have none."""
    wired = {wire.target for wire in wires}
    return [InputError(f"{node.name}.{port.name}", "this input has no wire", "one wire",
                       f'add a wire to "{node.name}.{port.name}"'
                       + (f" {other}" if (other := getattr(node.part, "for_open_inputs", "")) else ""))
            for node in nodes for port in node.part.inputs
            if not port.optional and f"{node.name}.{port.name}" not in wired]
