"""Stimulation that was commanded, passed by a safety block and given by the device, from a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

_PORT = "stimulation"


class Rows(Protocol):
    """The parts of a recording that stimulation is read from."""

    @property
    def signals(self) -> Sequence[str]:
        """Names of the recorded signals."""

    @property
    def experiment(self) -> Mapping[str, Any]:
        """The document of the experiment."""

    def tables(self, names: Sequence[str], trial: int = 0) -> Sequence[Any]:
        """Signals of a trial, read in pieces."""


@dataclass(frozen=True, slots=True)
class Stimulated:
    """Stimulation of a trial: charge per phase, C, the mean of all channels and rows.

    Attributes
    ----------
    commanded: into the safety block; 0 if it is not recorded.
    passed: out of it.
    given: by the device, if it records its charge; else as `passed`.
    """

    commanded: float
    passed: float
    given: float


def commanded_signal(recording: Rows, safety: str) -> str:
    """Signal wired into a safety block as stimulation; "" if there is none."""
    return next((str(wire["from"]) for wire in recording.experiment.get("wires", ())
                 if wire["to"] == f"{safety}.{_PORT}"), "")


def given_signal(recording: Rows, commanded: str) -> str | None:
    """Recorded `charge` of the device that a signal of pulses commands; None if there is none."""
    for wire in recording.experiment.get("wires", ()):
        charge = f"{wire['to'].partition('.')[0]}.charge"
        if wire["from"] == commanded and wire["to"].endswith(f".{_PORT}") and charge in recording.signals:
            return charge
    return None


def stimulated(recording: Rows, safety: str, trial: int, from_ns: int = 0) -> Stimulated | None:
    """Stimulation through a safety block in a trial from an instant on; None without rows."""
    passed = f"{safety}.{_PORT}"
    if passed not in recording.signals:
        return None
    source = commanded_signal(recording, safety)
    commanded = _mean(recording, source, trial, from_ns) if source in recording.signals else 0.0
    let_through = _mean(recording, passed, trial, from_ns)
    given = _mean(recording, given_signal(recording, passed) or passed, trial, from_ns)
    if commanded is None or let_through is None or given is None:
        return None
    return Stimulated(commanded, let_through, given)


def _mean(recording: Rows, name: str, trial: int, from_ns: int) -> float | None:
    """Charge per phase, C: the mean of the rows from an instant on; None if there are none."""
    total, count = 0.0, 0
    for piece in recording.tables([name], trial)[0].pieces():
        rows = piece.values[0][piece.times_ns >= from_ns]
        charges = rows[..., 0] * rows[..., 1] if rows.ndim == 3 else rows
        total += float(np.nansum(charges))
        count += charges.size
    return total / count if count else None
