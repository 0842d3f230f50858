"""`proportional_posture`: a reference between two postures, as far as a person's effort."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from controllers.reference.course import (
    USUAL_ROWS,
    WayPoints,
    checked_ranges,
    instants_ahead,
    reference_ports,
    require_preview,
)
from controllers.reference.intended import EFFORT_INPUTS, Posture, clocked_readers, detected, require_posture
from fesloop.errors import InputError
from fesloop.loop.abilities import Surroundings
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, duration_ns
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample, Value, is_finite

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class ProportionalState:
    """State of the reference.

    Attributes
    ----------
    ahead_s: times of now and of the preview relative to the tick.
    rest, active: (m,), the two postures, rad.
    share: way from the first to the second, from 0 to 1.
    begun: whether the effort has exceeded the dead band.
    last_ns: instant of the newest tick; -1 before the first.
    """

    ahead_s: Array
    rest: Array
    active: Array
    share: float = 0.0
    begun: bool = False
    last_ns: int = -1
    latch: StatusLatch = field(default_factory=StatusLatch)


@dataclass(frozen=True, slots=True, kw_only=True)
class ProportionalPosture:
    """Rows of a hand's posture between two postures, as far as a person's effort.

        share = clip((effort - dead_band) / (full - dead_band), 0, 1),  angles = rest + share (active - rest)

    The share changes by at most 1 in `travel_s`, so that angles are continuous and never leave the range
    between the two postures. Where `detection` is above the dead band, it takes its place (status
    `threshold_raised`), and `full` is at least as far above it.

    Rows that `rest_deg` does not name rest where the hand is: they equal the last value of `measured` until
    the effort first exceeds the dead band. Controllers that follow a reference from trial to trial are
    refused, as by `triggered_phases`.

    Attributes
    ----------
    active_deg: angles at full effort, by row; other rows do not move.
    rest_deg: angles without effort, by row.
    rows: elements of `angles`, as those of `grasp_phases`.
    dead_band: effort up to which nothing moves. full: effort of the second posture, above it.
    travel_s: least time from one posture to the other.
    range_deg: range of motion of some rows, in place of the one that follows from their joints.
    preview: number of coming instants in the output `preview`, for an effort that stays as it is; 0: no such
        output.
    preview_period_ms: distance between them; the first is one period after now.

    Inputs: `effort`, from 0 to 1; optional `detection`, the effort that noise at rest may reach; if
    `rest_deg` leaves out a row: `measured` (m,) rad. Outputs: `angles` (m,) rad; `phase`, 1 while the effort
    exceeds the dead band, else 0; `preview` (preview, m) rad.
    """

    active_deg: Mapping[str, float]
    rest_deg: Mapping[str, float] = field(default_factory=dict)
    rows: tuple[str, ...] = USUAL_ROWS
    dead_band: float = 0.1
    full: float = 0.8
    travel_s: float = 1.0
    range_deg: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    preview: int = 0
    preview_period_ms: float = 25.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "range_deg", checked_ranges(self.rows, self.range_deg))
        for key in ("rest_deg", "active_deg"):
            deg = {row: float(angle) for row, angle in getattr(self, key).items()}
            require_posture(key, deg, self.rows, self.range_deg)
            object.__setattr__(self, key, deg)
        if not self.active_deg:
            raise InputError("active_deg", "names no row", ", ".join(self.rows),
                             "give the angles at full effort")
        if not 0.0 < self.dead_band < 1.0:
            raise InputError("dead_band", f"{self.dead_band:g}", "above 0, below 1")
        if not self.dead_band < self.full <= 1.0:
            raise InputError("full", f"{self.full:g}", f"above dead_band, {self.dead_band:g}, at most 1")
        if duration_ns(self.travel_s, NS_PER_S, "travel_s") == 0:
            raise InputError("travel_s", f"{self.travel_s:g}", "above 0")
        require_preview(self.preview, self.preview_period_ms)

    @property
    def posture(self) -> Posture:
        """The posture without effort."""
        return Posture(self.rows, self.rest_deg)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`effort`, `detection`, and `measured` if a row rests where the hand is."""
        return (*EFFORT_INPUTS, *self.posture.inputs)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`angles`, `phase`, and `preview` if there is one."""
        rest = self.posture.angles()
        angles, *ahead = reference_ports(WayPoints(np.zeros(1), rest[np.newaxis]), self.preview)
        return replace(angles, rows=self.rows), Port("phase"), *ahead

    def faults(self, context: Context, surroundings: Surroundings) -> tuple[InputError, ...]:
        """Readers that learn by the clock."""
        return clocked_readers(surroundings)

    def init(self, context: Context) -> ProportionalState:
        """State before any effort."""
        rest = self.posture.angles()
        ahead_s = instants_ahead(self.preview, self.preview_period_ms)
        return ProportionalState(ahead_s, rest, self._active(rest))

    def step(self, state: ProportionalState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Reference of this tick, whether the person moves it, and the preview."""
        effort, detection, *measured = inputs
        state.latch.put(tick, "no_effort", not effort.present, "no effort has arrived: the hand is to rest")
        made = cast(float, effort.value) if effort.present else 0.0
        least = detected(state.latch, tick, detection, self.dead_band, "dead_band")
        full = max(self.full, least + self.full - self.dead_band)
        wanted = min(max((made - least) / (full - least), 0.0), 1.0)
        state.begun |= wanted > 0.0
        if measured and not state.begun and measured[0].present and is_finite(measured[0].value):
            state.rest = self.posture.angles(cast(Array, measured[0].value))
            state.active = self._active(state.rest)
        passed_s = (tick.time_ns - state.last_ns) / NS_PER_S if state.last_ns >= 0 else 0.0
        state.last_ns = tick.time_ns
        reach = (state.ahead_s + passed_s) / self.travel_s
        shares = state.share + np.clip(wanted - state.share, -reach, reach)
        state.share = float(shares[0])
        angles = state.rest + shares[:, np.newaxis] * (state.active - state.rest)
        return angles[0], float(wanted > 0.0), *([angles[1:]] if self.preview else [])

    def _active(self, rest: Array) -> Array:
        """Posture at full effort, (m,), rad, of one without."""
        active = rest.copy()
        for row, angle in self.active_deg.items():
            active[self.rows.index(row)] = math.radians(angle)
        return active
