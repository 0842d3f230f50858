"""Checks of a wiring before it runs: ends of wires, shapes and units, guards of devices, sizes left open."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from typing import Any, cast

from fesloop.errors import InputError
from fesloop.loop.abilities import (
    ChecksGuard,
    ExplainsInputs,
    Guarded,
    Guards,
    Interlocks,
    NeedsStillness,
    Resolves,
    UsesSensors,
    offers,
)
from fesloop.loop.clock import Clock
from fesloop.loop.duration import Duration
from fesloop.loop.nodes import Connection, Node
from fesloop.loop.signals import Port, Sensors
from fesloop.loop.wire import TRANSPORT, Wire


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
                       + (f" {node.part.for_open_inputs}" if offers(node.part, ExplainsInputs) else ""))
            for node in nodes for port in node.part.inputs
            if not port.optional and f"{node.name}.{port.name}" not in wired]


def link_faults(connections: Sequence[Connection]) -> list[InputError]:
    """Wires that differ from the first wire of their link in transport or in the clock of their source."""
    faults = []
    first: dict[str, Connection] = {}
    for each in connections:
        if each.wire.link is None:
            continue
        other = first.setdefault(each.wire.link, each)
        where, link = f"wire {each.wire.name}", f"link {each.wire.link!r}"
        faults += [InputError(f"{where}: {key}", f"{_brief(found)}, and {_brief(expected)} on wire "
                              f"{other.wire.name} of the same {link}", f"equal {key} on all wires of a link",
                              f"set links.{each.wire.link}.{key}, which all of them follow")
                   for key in TRANSPORT
                   if (found := getattr(each.wire, key)) != (expected := getattr(other.wire, key))]
        clock, reference = each.clock or each.source.clock, other.clock or other.source.clock
        if clock != reference:
            faults.append(InputError(
                f"{where}: link", f"{each.wire.source} is sent at {clock}, {other.wire.source} on the same "
                f"{link} at {reference}", "one clock for all that a packet carries",
                f"give {each.source.name} and {other.source.name} one rate, or the wires different links"))
    return faults


def _brief(value: object) -> str:
    return f"{value.kind} jitter" if isinstance(value, Duration) else f"{value}"


_ONE_OF_A_VECTOR = ("take the number out of the vector in a block of your own, "
                    "whose step returns (float(inputs[0].value[0]),)")


def is_one_number(out: Port, into: Port) -> bool:
    """True if a number is wired to a vector of one, which a block reads it as."""
    return out.shape == () and into.shape == (1,)


def fit_faults(
    wire: Wire, out: Port, into: Port, sender: Clock | None, reader: Clock | None
) -> list[InputError]:
    """Mismatches between the ports `out` and `into`, one line each.

    `sender`: when messages leave; `reader`: when the target steps, None for a plant.
    """
    faults = [
        InputError(f"wire {wire.name}", f"the size of {end!r} is open: {port.shape}",
                   "a size given by the block or by its source")
        for port, end in ((out, wire.source), (into, wire.target)) if not port.resolved]
    if not faults and out.shape != into.shape and not (reader and is_one_number(out, into)):
        faults.append(InputError(f"wire {wire.name}", f"{wire.source!r} has shape {out.shape}",
                                 f"{into.shape}, the shape of {wire.target!r}",
                                 _ONE_OF_A_VECTOR if (out.shape, into.shape) == ((1,), ()) else ""))
    if out.unit != into.unit:
        faults.append(InputError(f"wire {wire.name}", f"{wire.source!r} is in {out.unit!r}",
                                 f"{into.unit!r}, the unit of {wire.target!r}"))
    if into.every and sender is not None and reader is not None and reader.period_s > sender.period_s:
        faults.append(InputError(f"wire {wire.name}",
                                 f"{wire.target!r} is read at {1.0 / reader.period_s:g} Hz, and "
                                 f"{wire.source!r} puts out {1.0 / sender.period_s:g} messages a second of "
                                 "which each counts", "a reader as fast as its source",
                                 f"raise {wire.target.partition('.')[0]}.rate"))
    return faults


_PULSES, _TRAINS = "A,s", "A,s,Hz"
"""Units of currents and widths of pulses, and of trains of them on elements."""


def guard_faults(connections: Sequence[Connection]) -> list[InputError]:
    """Faults of the wires into guarded inputs, one line each."""
    guarded = [connection for connection in connections if _is_guarded(connection)]
    return [fault for connection in guarded for fault in _faults_of(connection)] + _shared(guarded)


def _is_guarded(connection: Connection) -> bool:
    port = connection.wire.target.partition(".")[2]
    part = connection.target.part
    return offers(part, Guarded) and port in part.guarded


def _guards(node: Node) -> bool:
    return offers(node.part, Guards) and node.part.guards


def _interlock(guard: Node) -> str:
    """Input with which a guard waits for trackers; "" where it has none."""
    return guard.part.interlock if offers(guard.part, Interlocks) else ""


def _ends_stillness(node: Node) -> str:
    """Output that ends the stillness which a tracker needs; "" where it needs none."""
    return node.part.needs_stillness if offers(node.part, NeedsStillness) else ""


def _shared(guarded: Sequence[Connection]) -> list[InputError]:
    """Guards before more than one device: they count once what is given twice."""
    first: dict[str, str] = {}
    return [InputError(f"wire {each.wire.name}", f"{each.source.name!r} already guards {before!r}",
                       "a safety block for each device: its limits count what one device gives",
                       f"give {each.target.name!r} a safety block of its own")
            for each in guarded if (before := first.setdefault(each.source.name, each.target.name))
            != each.target.name]


def _faults_of(connection: Connection) -> list[InputError]:
    """Faults of the wire into one guarded input."""
    wire, source, target = connection.wire, connection.source, connection.target
    where = f"wire {wire.name}"
    if not _guards(source):
        return [InputError(where, f"{target.name!r} is a device, and {source.name!r} limits nothing",
                           "a safety block directly before a device",
                           f'wire "{wire.target}" from a block of kind "safety"')]
    faults = []
    if wire.latency_ns or wire.loss or wire.jitter.kind != "zero":
        faults.append(InputError(where, "delays or loses what the safety block puts out",
                                 "no latency, jitter or loss", "give them to the wire into the safety block"))
    if source.execution.kind != "zero":
        faults.append(InputError(f"{source.name}.execution", f"is {source.execution.kind}, before a device",
                                 "none: the device gets what the safety block puts out at once"))
    if source.clock != target.clock:
        faults.append(InputError(where, f"{source.name!r} ticks {source.clock}, {target.name!r} "
                                 f"{target.clock}", "a device that ticks with its safety block",
                                 f"give {target.name!r} the rate of {source.name!r}"))
    if offers(target.part, ChecksGuard):
        faults += [InputError(f"{target.name}.{fault.where}", fault.found, fault.allowed, fault.remedy)
                   for fault in target.part.faults_behind(source.part)]
    return faults


def interlock_faults(nodes: Sequence[Node], connections: Sequence[Connection]) -> list[InputError]:
    """Paths on which pulses could reach a body before a tracker has taken its initial pose."""
    still = [(node, f"{node.name}.{output}") for node in nodes
             if (output := _ends_stillness(node))]
    faults = []
    for guard, connection in _last_guards(connections) if still else ():
        for node, output in still:
            if guard is None:
                faults.append(InputError(
                    f"wire {connection.wire.name}",
                    f"nothing keeps stimulation off while {node.name!r} takes its initial pose",
                    "a safety block on the way to the body",
                    f'add a block of kind "safety", and a wire from "{output}" to its "aligned"'))
            elif not _reaches_interlock(guard, node, connections):
                interlock = _interlock(guard)
                entrance = f'"{guard.name}.{interlock}"' if interlock else "an interlock of the guard's"
                faults.append(InputError(
                    f"blocks.{guard.name}",
                    f"does not know when {node.name!r} has taken its initial pose, which pulses disturb",
                    "no stimulation until each tracker that needs stillness is aligned",
                    f'add a wire from "{output}" to {entrance}'))
    return faults


def _last_guards(connections: Sequence[Connection]) -> list[tuple[Node | None, Connection]]:
    """Last guard on each path of pulses to a body, None where there is none; each guard once."""
    found: dict[str, tuple[Node | None, Connection]] = {}
    for connection in connections:
        if not _reaches_body(connection):
            continue
        guard, seen, ends = None, set(), [connection]
        while ends and guard is None:
            source = ends.pop().source
            if _guards(source):
                guard = source
            elif source.name not in seen:
                seen.add(source.name)
                ends += [each for each in connections if each.target is source
                         and source.part.inputs[each.target_port].unit == _PULSES]
        found.setdefault(guard.name if guard else connection.wire.name, (guard, connection))
    return list(found.values())


def _reaches_body(connection: Connection) -> bool:
    """True if pulses on this wire enter a plant, a device, or a switch of electrodes."""
    part = connection.target.part
    if part.inputs[connection.target_port].unit != _PULSES:
        return False
    return (connection.target.is_plant or _is_guarded(connection)
            or any(port.unit == _TRAINS for port in part.outputs))


def _reaches_interlock(guard: Node, node: Node, connections: Sequence[Connection]) -> bool:
    """True if the output of `node` that ends its stillness reaches the guard's interlock, joined or not."""
    interlock = _interlock(guard)
    ends = [each for each in connections if each.target is guard and interlock
            and each.target.part.inputs[each.target_port].name == interlock]
    seen: set[str] = set()
    while ends:
        end = ends.pop()
        if end.source is node:
            if node.part.outputs[end.source_port].name == _ends_stillness(node):
                return True
        elif end.source.name not in seen and not end.source.is_plant:
            seen.add(end.source.name)
            ends += [each for each in connections if each.target is end.source]
    return False


def resolved(nodes: Sequence[Node], wires: Sequence[Wire]) -> tuple[Node, ...]:
    """Nodes with open sizes resolved from their wires, sources first, and with the sensors wired to them."""
    current = {node.name: node for node in nodes}
    wired = {wire.target for wire in wires}
    known: dict[str, dict[str, Sensors]] = {}
    _pass_on_sensors(current, wires, known)
    progress = True
    while progress:
        progress = False
        for name, node in current.items():
            part: Any = node.part
            open_inputs = {port.name for port in part.inputs
                           if not port.resolved and f"{name}.{port.name}" in wired}
            if not open_inputs or not offers(part, Resolves):
                continue
            shapes = _incoming_shapes(node, wires, current)
            if open_inputs <= shapes.keys():
                _check_dimensions(node, shapes)
                part = _named(node, part.resolve, shapes)
                if any(not port.resolved for port in part.inputs):
                    raise InputError(name, "leaves open a size that its wires decide",
                                     "resolve() gives every input a size")
                current[name] = replace(node, part=part)
                known.pop(name, None)
                _pass_on_sensors(current, wires, known)
                progress = any(not port.resolved for port in node.part.inputs + node.part.outputs)
    return tuple(current[node.name] for node in nodes)


def _pass_on_sensors(
    nodes: dict[str, Node], wires: Sequence[Wire], known: dict[str, dict[str, Sensors]]
) -> None:
    """Give nodes that use them the sensors whose samples are wired to them, as far as known and new."""
    progress = True
    while progress:
        progress = False
        for name, node in nodes.items():
            part: Any = node.part
            if not offers(part, UsesSensors):
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


def _named(node: Node, make: Callable[[Any], Any], given: Any) -> Any:
    """`make(given)` for a node's part; its faults name the node in place of the part."""
    try:
        return make(given)
    except InputError as fault:
        place = fault.where.removeprefix(f"{type(node.part).__name__.lower()}.")
        raise InputError(f"{node.name}.{place}", fault.found, fault.allowed, fault.remedy) from None


def _incoming_shapes(
    node: Node, wires: Sequence[Wire], nodes: Mapping[str, Node]
) -> dict[str, tuple[int, ...]]:
    """Known shapes wired to a node, by input name; a number counts as a vector of one."""
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
