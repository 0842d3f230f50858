"""Which signals of a recording are stimulation, and what each element was given."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.metrics.joints import held
from fesloop.show.report.run.known import Known

Array = NDArray[np.float64]
_PORT = "stimulation"


def final_stimulation(known: Known) -> str:
    """The recorded stimulation that comes nearest to the patient; empty where none is recorded.

    What commands the stimulator, else what no other block passes on.
    """
    if known.cast is not None and known.cast.stimulator is not None and known.cast.stimulation:
        return known.cast.stimulation
    every = sorted(name for name in known.signals if name.endswith(f".{_PORT}"))
    wires = known.recording.experiment.get("wires", [])
    passed_on = {wire["from"] for wire in wires
                 if wire["to"].endswith(f".{_PORT}") and wire["to"] in every}
    return next((name for name in every if name not in passed_on), "")


def element_charge(known: Known, trial: int) -> tuple[Array, Array | None] | None:
    """Charge (elements,), C, of one phase of all pulses in a trial; and (channels, elements) shares of it.

    The shares are of what each channel gave, None where that is not known. None where charges are not
    recorded, or how channels lie on elements is not, or how often they give pulses.
    """
    if known.cast is None or known.cast.stimulator is None:
        return None
    name = known.cast.stimulator.name
    if f"{name}.charge" in known.signals:
        pulses, by_channel = _pulses_a_row(known, f"{name}.charge", trial), _by_channel(known, trial)
        if pulses is not None and by_channel is not None:
            return pulses * by_channel.sum(axis=0), pulses * by_channel
    if f"{name}.element_charge" in known.signals:
        pulses = _pulses_a_row(known, f"{name}.element_charge", trial)
        total = _sum(known, f"{name}.element_charge", trial)
        return None if pulses is None or total is None else (pulses * total, None)
    return None


def _pulses_a_row(known: Known, name: str, trial: int) -> float | None:
    """Pulses of a channel that a row of the stimulator's charges counts for; None where that is not known.

    Less than one: the charge of a pulse stands in the rows of every slot until the channel's next pulse.
    """
    assert known.cast is not None
    assert known.cast.stimulator is not None
    part = known.cast.stimulator.part
    if not hasattr(part, "frequency_hz"):
        return None
    first = next(known.recording.tables([name], trial)[0].pieces(), None)
    if first is None or len(first.times_ns) < 2:
        return None
    return float(Fraction(part.frequency_hz)) * 1e-9 * float(first.times_ns[1] - first.times_ns[0])


def _by_channel(known: Known, trial: int) -> Array | None:
    """(channels, elements), C, summed over rows: the channels' charges, shared out as was switched."""
    cast = known.cast
    assert cast is not None
    assert cast.stimulator is not None
    charge = f"{cast.stimulator.name}.charge"
    if cast.multiplexing:
        recorded = cast.multiplexing in known.signals
        return _switched(known, charge, cast.multiplexing, trial) if recorded else None
    total = _sum(known, charge, trial)
    part = cast.stimulator.part
    if total is None or not hasattr(type(part), "shares"):
        return None
    if hasattr(part, "resolve"):
        part = part.resolve({_PORT: (len(total), 2)})
    shares: Array = part.shares
    return total[:, np.newaxis] * shares


def _switched(known: Known, charge: str, multiplexing: str, trial: int) -> Array | None:
    switched = known.recording.column(multiplexing, trial)
    total: Array | None = None
    for table in known.recording.tables([charge], trial):
        for piece in table.pieces():
            given = np.flatnonzero(piece.values[0].any(axis=1))
            shares = np.nan_to_num(held(switched, piece.times_ns[given]))
            sums = np.einsum("tc,tce->ce", piece.values[0][given], shares)
            total = sums if total is None else total + sums
    return total


def _sum(known: Known, name: str, trial: int) -> Array | None:
    """Of all rows of a trial; None where there are none."""
    total: Array | None = None
    for table in known.recording.tables([name], trial):
        for piece in table.pieces():
            sums = piece.values[0].sum(axis=0)
            total = sums if total is None else total + sums
    return total
