"""Whether what stands directly before a device is what must stand there.

A device that touches a person names its inputs in a member `guarded`. Each must come straight from a block
that says of itself `guards = True` (the safety limits), and both must step at the same instants: what lies
between them, or a guard that is asked less often than the device is commanded, would let through what the
guard has never seen. A guard stands before one device only. A device may say of its guard what else is wrong
(`faults_behind(guard)`).

A tracker that begins with an initial pose is right only if the wearer keeps still in it. While it waits for
that, nothing may be stimulated: a part that `needs_stillness` names the output that is 0 until the pose has
been taken, and wherever pulses reach a body a guard lies on the way, with a wire from each such output into
the input that it names in `interlock`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from fesloop.errors import InputError

if TYPE_CHECKING:
    from fesloop.loop.wiring import Connection, Node

_PULSES, _TRAINS = "A,s", "A,s,Hz"
"""Units of currents and widths of pulses, and of trains of them on elements."""


def guard_faults(connections: Sequence[Connection]) -> list[InputError]:
    """What is wrong with the ways into guarded inputs, one line each."""
    guarded = [connection for connection in connections if _is_guarded(connection)]
    return [fault for connection in guarded for fault in _faults_of(connection)] + _shared(guarded)


def _is_guarded(connection: Connection) -> bool:
    port = connection.wire.target.partition(".")[2]
    return port in getattr(connection.target.part, "guarded", ())


def _shared(guarded: Sequence[Connection]) -> list[InputError]:
    """Guards before more than one device: they count what they let through once, and it is given twice."""
    first: dict[str, str] = {}
    return [InputError(f"wire {each.wire.name}", f"{each.source.name!r} stands before {before!r} already",
                       "a safety block for each device: its limits count what one device gives",
                       f"give {each.target.name!r} a safety block of its own")
            for each in guarded if (before := first.setdefault(each.source.name, each.target.name))
            != each.target.name]


def _faults_of(connection: Connection) -> list[InputError]:
    """What is wrong with the way into one guarded input."""
    wire, source, target = connection.wire, connection.source, connection.target
    where = f"wire {wire.name}"
    if not getattr(source.part, "guards", False):
        return [InputError(where, f"{target.name!r} is a device, and {source.name!r} limits nothing",
                           "a safety block directly before a device",
                           f'wire "{wire.target}" from a block of kind "safety"')]
    faults = []
    if wire.latency_ns or wire.loss or wire.jitter.kind != "zero":
        faults.append(InputError(where, "something lies between the safety block and the device",
                                 "no latency, jitter or loss", "give them to the wire into the safety block"))
    if source.execution.kind != "zero":
        faults.append(InputError(f"{source.name}.execution", f"is {source.execution.kind}, before a device",
                                 "none: the device gets what the safety block puts out at once"))
    if source.clock != target.clock:
        faults.append(InputError(where, f"{source.name!r} ticks {source.clock}, {target.name!r} "
                                 f"{target.clock}", "a device that ticks with its safety block",
                                 f"give {target.name!r} the rate of {source.name!r}"))
    tell = getattr(target.part, "faults_behind", None)
    if tell is not None:
        faults += [InputError(f"{target.name}.{fault.where}", fault.found, fault.allowed, fault.remedy)
                   for fault in tell(source.part)]
    return faults


def interlock_faults(nodes: Sequence[Node], connections: Sequence[Connection]) -> list[InputError]:
    """Ways on which pulses could reach a body before a tracker has taken its initial pose."""
    still = [(node, f"{node.name}.{output}") for node in nodes
             if (output := getattr(node.part, "needs_stillness", ""))]
    faults = []
    for guard, connection in _last_guards(connections) if still else ():
        for node, output in still:
            if guard is None:
                faults.append(InputError(
                    f"wire {connection.wire.name}",
                    f"nothing keeps stimulation off while {node.name!r} takes its initial pose",
                    "a safety block on the way to the body",
                    f'add a block of kind "safety", and a wire from "{output}" to its "aligned"'))
            elif not _hears(guard, node, connections):
                interlock = getattr(guard.part, "interlock", "")
                entrance = f'"{guard.name}.{interlock}"' if interlock else "an interlock of the guard's"
                faults.append(InputError(
                    f"blocks.{guard.name}",
                    f"does not know when {node.name!r} has taken its initial pose, which pulses disturb",
                    "no stimulation until each tracker that needs stillness is aligned",
                    f'add a wire from "{output}" to {entrance}'))
    return faults


def _last_guards(connections: Sequence[Connection]) -> list[tuple[Node | None, Connection]]:
    """For each way of pulses to a body the last guard on it, None where there is none; each guard once."""
    found: dict[str, tuple[Node | None, Connection]] = {}
    for connection in connections:
        if not _reaches_body(connection):
            continue
        guard, seen, ends = None, set(), [connection]
        while ends and guard is None:
            source = ends.pop().source
            if getattr(source.part, "guards", False):
                guard = source
            elif source.name not in seen:
                seen.add(source.name)
                ends += [each for each in connections if each.target is source
                         and source.part.inputs[each.target_port].unit == _PULSES]
        found.setdefault(guard.name if guard else connection.wire.name, (guard, connection))
    return list(found.values())


def _reaches_body(connection: Connection) -> bool:
    """Whether pulses on this wire enter a plant, a device, or what switches them onto electrodes."""
    part = connection.target.part
    if part.inputs[connection.target_port].unit != _PULSES:
        return False
    return (connection.target.is_plant or _is_guarded(connection)
            or any(port.unit == _TRAINS for port in part.outputs))


def _hears(guard: Node, node: Node, connections: Sequence[Connection]) -> bool:
    """Whether the output of `node` that ends its stillness reaches the guard's interlock, joined or not."""
    interlock = getattr(guard.part, "interlock", "")
    ends = [each for each in connections if each.target is guard and interlock
            and each.target.part.inputs[each.target_port].name == interlock]
    seen: set[str] = set()
    while ends:
        end = ends.pop()
        if end.source is node:
            if node.part.outputs[end.source_port].name == getattr(node.part, "needs_stillness", ""):
                return True
        elif end.source.name not in seen and not end.source.is_plant:
            seen.add(end.source.name)
            ends += [each for each in connections if each.target is end.source]
    return False
