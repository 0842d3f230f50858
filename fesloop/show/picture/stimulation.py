"""What was stimulated at given instants: charge of every element, pulses of every channel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.recording.reading import Recording
from fesloop.show.picture.cast import Cast
from fesloop.show.picture.held import first_recorded, values_at

Array = NDArray[np.float64]
Instants = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Stimulation:
    """Of a recording at some instants t; None stands for what was not recorded.

    Attributes
    ----------
    charge: (t, elements), C a phase, of each element's newest pulse.
    shares: (t, channels, elements), of each channel's current that each element has.
    commands: (t, channels, 2), A and s.
    """

    charge: Array | None
    shares: Array | None
    commands: Array | None


def stimulation_at(
    recording: Recording, cast: Cast, trial: int, at_ns: Instants
) -> tuple[Stimulation, list[str]]:
    """What is known of the stimulation, and what is not drawn for want of signals."""
    commands = values_at(recording, cast.stimulation, trial, at_ns) if cast.stimulation else None
    shares = _shares(recording, cast, trial, at_ns, commands)
    charge = None
    if cast.stimulator is not None:
        name = cast.stimulator.name
        recorded = first_recorded(recording, (f"{name}.element_charge", f"{name}.charge"))
        charge = values_at(recording, recorded, trial, at_ns) if recorded else None
        if charge is not None and recorded.endswith(".charge"):
            charge = None if shares is None else np.einsum("tc,tce->te", charge, shares)
    notes = []
    if shares is None:
        notes.append("virtual electrodes are not outlined: neither the multiplexing is recorded nor does the "
                     "stimulator have `shares`")
    if charge is None:
        notes.append("elements have no colour: the stimulator's charges are not recorded")
    return Stimulation(charge, shares, commands), notes


def _shares(
    recording: Recording, cast: Cast, trial: int, at_ns: Instants, commands: Array | None
) -> Array | None:
    """The multiplexing as it was recorded, else the stimulator's own virtual electrodes."""
    if cast.multiplexing in recording.signals:
        return values_at(recording, cast.multiplexing, trial, at_ns)
    if cast.multiplexing or cast.stimulator is None or not hasattr(type(cast.stimulator.part), "shares"):
        return None
    part = cast.stimulator.part
    if hasattr(part, "resolve") and commands is not None:
        part = part.resolve({"stimulation": commands.shape[1:]})
    own: Array = part.shares
    return np.broadcast_to(own, (len(at_ns), *own.shape))
