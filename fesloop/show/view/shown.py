"""Frames of a view, and the protocol of their sources."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fesloop.show.report.parts import Figure3d
from fesloop.show.view.readout import Readout

Array = NDArray[np.float64]
FRAME_S = 1.0 / 30.0
"""Least time between two frames, s."""
_DIGITS = 5
"""Decimals of a pose's numbers (chosen: a hundredth of a millimetre, and of a milliradian)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shown:
    """A frame.

    Attributes
    ----------
    trial, time_s: where in the run it is; a live stream has no trial and time since it was found.
    hands: by name ("truth", "estimate"), poses (17, 7) as those of `fesloop.show.report.parts.Frames`.
    objects: (objects that move, 7).
    note: how far behind it is, or why nothing moves; empty where there is nothing to say.
    readings: numbers beside the hand (`fesloop.show.view.readout.Readout.at`); empty where none are known.
    """

    trial: int
    time_s: float
    hands: Mapping[str, Array]
    objects: Array
    note: str = ""
    readings: Mapping[str, Any] = field(default_factory=dict)

    def as_json(self) -> str:
        """One line; a pose that holds anything that is no number is null."""
        return json.dumps({
            "trial": self.trial, "time_s": round(self.time_s, 4), "note": self.note,
            "hands": {name: _rows(poses) for name, poses in self.hands.items()},
            "objects": _rows(self.objects), "readings": dict(self.readings)},
            separators=(",", ":"), allow_nan=False)


def _rows(poses: Array) -> list[list[float] | None]:
    return [row if all(map(math.isfinite, row)) else None for row in np.round(poses, _DIGITS).tolist()]


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """Request of a viewer: trial, start and speed; at speed 0 one frame is shown.
    """

    trial: int = 0
    at_s: float = 0.0
    speed: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Span:
    """First and last instant of a trial, s."""

    first_s: float
    last_s: float


Play = Callable[[float], Shown | None]
"""Function from seconds since the start to a frame; None if the frame is unchanged."""


class Source(Protocol):
    """Source of frames; several threads may call its methods at once."""

    @property
    def title(self) -> str:
        """Title of the view."""

    @property
    def notices(self) -> Sequence[str]:
        """Sentences on what cannot be shown, and why."""

    @property
    def figure(self) -> Figure3d:
        """Shapes and objects, with enough frames to find about where hands will be."""

    @property
    def spans(self) -> Mapping[int, Span]:
        """Trials that can be chosen, with their lengths; none for a live source."""

    @property
    def shown(self) -> int:
        """Trial that is shown at first; 0 for a live source."""

    @property
    def readout(self) -> Readout:
        """Numbers that frames hold."""

    def play(self, start: Start) -> Play:
        """Begin to show. Raises InputError for a start that does not exist."""

    def close(self) -> None:
        """Release what the source holds open."""
