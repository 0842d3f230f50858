"""Whether what stands directly before a device is what must stand there.

A device that touches a person names its inputs in a member `guarded`. Each must come straight from a block
that says of itself `guards = True` (the safety limits), and both must step at the same instants: what lies
between them, or a guard that is asked less often than the device is commanded, would let through what the
guard has never seen. A guard stands before one device only. A device may say of its guard what else is wrong
(`faults_behind(guard)`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from fesloop.errors import InputError

if TYPE_CHECKING:
    from fesloop.loop.wiring import Connection


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
