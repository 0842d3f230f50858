"""Whether both ends of a wire fit: shape, unit, and a quick reader where each message counts."""

from __future__ import annotations

from fesloop.errors import InputError
from fesloop.loop.clock import Clock
from fesloop.loop.signals import Port
from fesloop.loop.wire import Wire

_ONE_OF_A_VECTOR = ("take the number out of the vector in a block of your own, "
                    "whose step returns (float(inputs[0].value[0]),)")


def is_one_number(out: Port, into: Port) -> bool:
    """Whether a number reaches a vector of one: a block reads it as that."""
    return out.shape == () and into.shape == (1,)


def fit_faults(
    wire: Wire, out: Port, into: Port, sender: Clock | None, reader: Clock | None
) -> list[InputError]:
    """What does not fit between the ports `out` and `into`, one line each.

    `sender`: when messages leave; `reader`: when the target steps, None for a plant.
    """
    faults = [
        InputError(f"wire {wire.name}", f"the size of {end!r} is not settled: {port.shape}",
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
