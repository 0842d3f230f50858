"""Common parts of references that follow a person's effort."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from controllers.reference.course import Ranges, require_in_range
from fesloop.errors import InputError, did_you_mean
from fesloop.loop.abilities import Surroundings
from fesloop.loop.block import Tick
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample

Array = NDArray[np.float64]
EFFORT_INPUTS = Port("effort"), Port("detection", optional=True)


@dataclass(frozen=True, slots=True)
class Posture:
    """Angles of rows, of which some are where the hand is.

    Attributes
    ----------
    rows: names of all rows. deg: angles of the rows that are given.
    """

    rows: tuple[str, ...]
    deg: Mapping[str, float]

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`measured` (m,), rad, if a row is where the hand is."""
        return (Port("measured", (len(self.rows),), "rad"),) if len(self.deg) < len(self.rows) else ()

    def angles(self, measured: Array | None = None) -> Array:
        """Angles (m,), rad; those that are not given are the measured ones, 0 without any."""
        angles = np.zeros(len(self.rows)) if measured is None else measured.copy()
        for row, angle in self.deg.items():
            angles[self.rows.index(row)] = math.radians(angle)
        return angles


def require_posture(where: str, deg: Mapping[str, float], rows: tuple[str, ...], ranges: Ranges) -> None:
    """Raise InputError for an angle of no row, or outside its range."""
    for row, angle in deg.items():
        if row not in rows:
            raise InputError(f"{where}.{row}", "is no row", ", ".join(rows), did_you_mean(row, rows))
        require_in_range(f"{where}.{row}", row, angle, ranges)


def detected(latch: StatusLatch, tick: Tick, detection: Sample, threshold: float, key: str) -> float:
    """The threshold, or the effort that noise at rest may reach where that is above it; reported then."""
    noise = cast(float, detection.value) if detection.present else 0.0
    latch.put(tick, "threshold_raised", threshold < noise < 1.0,
              f"noise at rest may reach an effort of {noise:.2f}: the threshold {key} is that in place of "
              f"{threshold:g}")
    return max(threshold, noise)


def clocked_readers(surroundings: Surroundings) -> tuple[InputError, ...]:
    """A fault for each reader that follows the reference in no fixed time, such as in the next trial."""
    return tuple(
        InputError(port, f"{reader}, and a person's instants differ in each",
                   "a controller that follows within the trial, such as mpc, pid or tuned_pid",
                   "for a controller that learns from trial to trial, take a reference by the clock, such as "
                   "grasp_phases")
        for port, reader in surroundings.followers.items())
