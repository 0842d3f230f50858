"""`triggered_phases`: phases of a grasp that a person's bursts of effort begin."""

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
    reference_values,
    require_preview,
)
from controllers.reference.intended import (
    EFFORT_INPUTS,
    Posture,
    clocked_readers,
    detected,
    require_posture,
)
from fesloop.errors import InputError
from fesloop.loop.abilities import Surroundings
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample, Value, is_finite

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class TriggeredPhase:
    """A phase: a move of some rows to given angles, and a rest there until the next trigger.

    Attributes
    ----------
    name: such as rest, open, close, release; names may repeat.
    move_s: duration of the move, in which no trigger counts.
    deg: angles at the end of the move, by row; other rows do not move.
    back: whether the rows that `deg` does not name move back to where the first phase had them.
    """

    name: str
    move_s: float = 1.0
    deg: Mapping[str, float] = field(default_factory=dict)
    back: bool = False

    def __post_init__(self) -> None:
        if not self.name:
            raise InputError("name", "is empty", "a name such as open, close or hold")
        if self.move_ns == 0:
            raise InputError("move_s", f"{self.move_s:g}", "above 0")
        object.__setattr__(self, "deg", {row: float(angle) for row, angle in self.deg.items()})

    @property
    def move_ns(self) -> int:
        """Length of the move, ns."""
        return duration_ns(self.move_s, NS_PER_S, "move_s")


@dataclass(slots=True, eq=False)
class TriggeredState:
    """State of the reference.

    Attributes
    ----------
    ahead_s: times of now and of the preview relative to the tick.
    start: (m,), angles of the first phase, rad.
    target: (m,), angles at the end of the present phase's move.
    course: the present move. phase: number of the present phase.
    above_ns: begin of the burst under way; -1 for none.
    armed: whether the effort was below `off` since the last trigger.
    locked_ns: instant until which no trigger counts.
    """

    ahead_s: Array
    start: Array
    target: Array
    course: WayPoints
    phase: int = 0
    above_ns: int = -1
    armed: bool = False
    locked_ns: int = 0
    latch: StatusLatch = field(default_factory=StatusLatch)


@dataclass(frozen=True, slots=True, kw_only=True)
class TriggeredPhases:
    """Rows of a hand's posture through phases, each begun by a burst of a person's effort.

    The reference has the first phase's angles until the first trigger. A trigger is an effort that reached
    `on`, and has not fallen to `off` since, for `hold_ms`; it begins the next phase at that tick, on a
    minimum-jerk path (Flash and Hogan 1985, doi 10.1523/JNEUROSCI.05-07-01688.1985). After the last phase
    the second follows again. No trigger counts during a move, within `refractory_s` after the one before,
    and before the effort has been at `off` or below since that one. Where `detection` is above `on`, both
    thresholds are raised in proportion (status `threshold_raised`).

    Rows that the first phase does not name start where the hand is: they equal the last value of `measured`
    until the first trigger. Controllers that follow a reference from trial to trial are refused: a person's
    instants differ in each.

    Attributes
    ----------
    phases: phases in order, two or more; the first needs no trigger and has no move.
    rows: elements of `angles`, as those of `grasp_phases`.
    on: effort that begins a burst. off: effort that ends it, below `on`.
    hold_ms: duration of a burst at its trigger.
    refractory_s: least time between two triggers.
    range_deg: range of motion of some rows, in place of the one that follows from their joints.
    preview: number of coming instants in the output `preview`, which knows no trigger to come;
        0: no such output.
    preview_period_ms: distance between them; the first is one period after now.

    Inputs: `effort`, from 0 to 1; optional `detection`, the effort that noise at rest may reach; if the first
    phase leaves out a row: `measured` (m,) rad. Outputs: `angles` (m,) rad; `phase`, number of the phase in
    `phases`, from 0; `preview` (preview, m) rad.
    """

    phases: tuple[TriggeredPhase, ...]
    rows: tuple[str, ...] = USUAL_ROWS
    on: float = 0.3
    off: float = 0.15
    hold_ms: float = 150.0
    refractory_s: float = 1.0
    range_deg: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    preview: int = 0
    preview_period_ms: float = 25.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "range_deg", checked_ranges(self.rows, self.range_deg))
        if len(self.phases) < 2:
            raise InputError("phases", f"{len(self.phases)}", "two or more: rest, and what triggers begin")
        for number, phase in enumerate(self.phases):
            require_posture(f"phases[{number}].deg", phase.deg, self.rows, self.range_deg)
        if not 0.0 < self.on < 1.0:
            raise InputError("on", f"{self.on:g}", "above 0, below 1")
        if not 0.0 <= self.off < self.on:
            raise InputError("off", f"{self.off:g}", f"0 or more, below on, {self.on:g}")
        duration_ns(self.hold_ms, NS_PER_MS, "hold_ms")
        duration_ns(self.refractory_s, NS_PER_S, "refractory_s")
        require_preview(self.preview, self.preview_period_ms)

    @property
    def posture(self) -> Posture:
        """The first phase's angles."""
        return Posture(self.rows, self.phases[0].deg)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`effort`, `detection`, and `measured` if a row starts where the hand is."""
        return (*EFFORT_INPUTS, *self.posture.inputs)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`angles`, `phase`, and `preview` if there is one."""
        angles, *ahead = reference_ports(_rest(self.posture.angles()), self.preview)
        return replace(angles, rows=self.rows), Port("phase"), *ahead

    def faults(self, context: Context, surroundings: Surroundings) -> tuple[InputError, ...]:
        """Readers that learn by the clock."""
        return clocked_readers(surroundings)

    def init(self, context: Context) -> TriggeredState:
        """State before any effort."""
        start = self.posture.angles()
        ahead_s = instants_ahead(self.preview, self.preview_period_ms)
        return TriggeredState(ahead_s, start, start, _rest(start))

    def step(self, state: TriggeredState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Reference of this tick, the phase, and the preview."""
        effort, detection, *measured = inputs
        if measured and state.phase == 0 and state.locked_ns == 0 and measured[0].present \
                and is_finite(measured[0].value):
            state.start = state.target = self.posture.angles(cast(Array, measured[0].value))
            state.course = _rest(state.start)
        state.latch.put(tick, "no_effort", not effort.present, "no effort has arrived: nothing is triggered")
        if effort.present and self._triggered(state, cast(float, effort.value), detection, tick):
            self._begin(state, tick.time_ns)
        angles, *ahead = reference_values(state.course, state.ahead_s, tick)
        return angles, float(state.phase), *ahead

    def _triggered(self, state: TriggeredState, effort: float, detection: Sample, tick: Tick) -> bool:
        """Follow the burst; True at its trigger."""
        on = detected(state.latch, tick, detection, self.on, "on")
        if effort <= self.off * on / self.on:
            state.above_ns, state.armed = -1, True
        elif effort >= on and state.above_ns < 0:
            state.above_ns = tick.time_ns
        held = 0 <= state.above_ns <= tick.time_ns - duration_ns(self.hold_ms, NS_PER_MS, "hold_ms")
        return held and state.armed and tick.time_ns >= state.locked_ns

    def _begin(self, state: TriggeredState, now_ns: int) -> None:
        """Begin the next phase."""
        state.phase = state.phase + 1 if state.phase + 1 < len(self.phases) else 1
        phase, before = self.phases[state.phase], state.target
        state.target = state.start.copy() if phase.back else before.copy()
        for row, angle in phase.deg.items():
            state.target[self.rows.index(row)] = math.radians(angle)
        state.course = WayPoints(np.array([now_ns, now_ns + phase.move_ns]) / NS_PER_S,
                                 np.stack([before, state.target]))
        wait_ns = max(duration_ns(self.refractory_s, NS_PER_S, "refractory_s"), phase.move_ns)
        state.armed, state.locked_ns = False, now_ns + wait_ns


def _rest(angles: Array) -> WayPoints:
    """A course that stays at (m,) angles."""
    return WayPoints(np.zeros(1), angles[np.newaxis])
