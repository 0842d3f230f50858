"""`grasp_phases`: a grasp as a sequence of named phases."""

from __future__ import annotations

import math
from bisect import bisect_right
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
    require_in_range,
    require_preview,
)
from fesloop.errors import InputError, did_you_mean
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, duration_ns
from fesloop.loop.signals import Port, Sample, Value, is_finite

Array = NDArray[np.float64]
_MOST_REPEATS = 10_000


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspPhase:
    """A phase: a move of some rows to given angles, and a rest there until its end.

    Attributes
    ----------
    name: such as rest, open, approach, close, hold, release; names may repeat.
    duration_s: duration of the phase with its move.
    move_s: duration of the move; by default the whole phase.
    deg: angles at the end of the move, by row; other rows do not move.
    back: whether the rows that `deg` does not name move back to where the first phase had them.
    """

    name: str
    duration_s: float
    move_s: float | None = None
    deg: Mapping[str, float] = field(default_factory=dict)
    back: bool = False

    def __post_init__(self) -> None:
        if not self.name:
            raise InputError("name", "is empty", "a name such as open, close or hold")
        if duration_ns(self.duration_s, NS_PER_S, "duration_s") == 0:
            raise InputError("duration_s", f"{self.duration_s:g}", "above 0")
        if self.move_s is not None and not 0 < self.move_ns <= self.duration_ns:
            raise InputError("move_s", f"{self.move_s:g}", f"above 0, at most {self.duration_s:g}, the phase",
                             "leave it out for a move that takes the whole phase")
        object.__setattr__(self, "deg", {row: float(angle) for row, angle in self.deg.items()})

    @property
    def duration_ns(self) -> int:
        """Length of the phase, ns."""
        return duration_ns(self.duration_s, NS_PER_S, "duration_s")

    @property
    def move_ns(self) -> int:
        """Length of its move, ns."""
        return self.duration_ns if self.move_s is None else duration_ns(self.move_s, NS_PER_S, "move_s")


@dataclass(slots=True, eq=False)
class PhasesState:
    """Times of now and of the preview relative to the tick, s, and the way-points of all moves."""

    ahead_s: Array
    course: WayPoints


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspPhases:
    """Rows of a hand's posture through named phases, on minimum-jerk paths.

    The reference has the first phase's angles from t = 0. Every later phase begins with a move of the rows
    that it names (Flash and Hogan 1985, doi 10.1523/JNEUROSCI.05-07-01688.1985), then rests. After the last
    phase the reference is constant and the phase number stays. A repeat begins with the move back to the
    first phase's angles, in that phase.

    Rows that the first phase does not name start where the hand is: they equal the last value of `measured`
    (0 before one has arrived) until the first phase ends for the first time, and keep that value from then
    on, so that no resting angle has to be known beforehand.

    Attributes
    ----------
    phases: phases in order from t = 0.
    rows: elements of `angles`, in this order: synergies (of the block `synergies`), freedoms of the hand, or
        rows of your own with a range in `range_deg`.
    repeats: number of passes through all phases.
    range_deg: range of motion of some rows, in place of the one that follows from their joints.
    preview: number of coming instants in the output `preview`; 0: no such output.
    preview_period_ms: distance between them; the first is one period after now.

    Input, if the first phase leaves out a row: `measured` (m,) rad. Outputs: `angles` (m,) rad; `phase`,
    number of the phase in `phases`, from 0; `preview` (preview, m) rad.
    """

    phases: tuple[GraspPhase, ...]
    rows: tuple[str, ...] = USUAL_ROWS
    repeats: int = 1
    range_deg: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    preview: int = 0
    preview_period_ms: float = 25.0
    starts_ns: tuple[int, ...] = field(init=False, repr=False, compare=False)
    """Starts of all phases of all repeats, ns."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "range_deg", checked_ranges(self.rows, self.range_deg))
        if not self.phases:
            raise InputError("phases", "there is none", "one or more")
        if not 1 <= self.repeats <= _MOST_REPEATS:
            raise InputError("repeats", f"{self.repeats}", f"1 to {_MOST_REPEATS}")
        for i, phase in enumerate(self.phases):
            for row, angle in phase.deg.items():
                if row not in self.rows:
                    raise InputError(f"phases[{i}].deg.{row}", "is no row", ", ".join(self.rows),
                                     did_you_mean(row, self.rows))
                require_in_range(f"phases[{i}].deg.{row}", row, angle, self.range_deg)
        require_preview(self.preview, self.preview_period_ms)
        ends = np.cumsum([phase.duration_ns for phase in self.phases * self.repeats])
        object.__setattr__(self, "starts_ns", (0, *ends[:-1].tolist()))

    @property
    def follows(self) -> NDArray[np.bool_]:
        """Mask (m,) of the rows that start where the hand is."""
        return np.array([row not in self.phases[0].deg for row in self.rows])

    def course(self, start: Array) -> WayPoints:
        """Way-points of all moves from a start (m,), rad, of the rows that the first phase does not name."""
        first = np.array([math.radians(self.phases[0].deg[row]) if row in self.phases[0].deg else value
                          for row, value in zip(self.rows, start.tolist(), strict=True)])
        times, values, target = [0], [first], first
        for now, phase in zip(self.starts_ns, self.phases * self.repeats, strict=True):
            before = target
            target = first.copy() if phase.back or phase is self.phases[0] else before.copy()
            for row, angle in phase.deg.items():
                target[self.rows.index(row)] = math.radians(angle)
            if not np.array_equal(target, before):
                if times[-1] < now:
                    times.append(now)
                    values.append(before)
                times.append(now + phase.move_ns)
                values.append(target)
        return WayPoints(np.array(times) / NS_PER_S, np.array(values))

    @property
    def duration_s(self) -> float:
        """Duration of all phases of all repeats, s."""
        return self.repeats * sum(phase.duration_ns for phase in self.phases) / NS_PER_S

    @property
    def ends_s(self) -> tuple[float, ...]:
        """End of each phase, s, at which its angles are reached: for laws with chosen instants."""
        return (*(start / NS_PER_S for start in self.starts_ns[1:]), self.duration_s)

    def phase_at(self, time_ns: int) -> int:
        """Number of the phase at an instant, from 0."""
        return (bisect_right(self.starts_ns, time_ns) - 1) % len(self.phases)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`measured` if a row starts where the hand is, else none: a source."""
        return (Port("measured", (len(self.rows),), "rad"),) if self.follows.any() else ()

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`angles`, `phase`, and `preview` if there is one."""
        angles, *ahead = reference_ports(self.course(np.zeros(len(self.rows))), self.preview)
        return replace(angles, rows=self.rows), Port("phase"), *ahead

    def init(self, context: Context) -> PhasesState:
        """State before any measurement."""
        return PhasesState(instants_ahead(self.preview, self.preview_period_ms),
                           self.course(np.zeros(len(self.rows))))

    def step(self, state: PhasesState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Reference of this tick, the phase, and the preview."""
        first = len(self.starts_ns) == 1 or tick.time_ns < self.starts_ns[1]
        if inputs and first and inputs[0].arrived_ns >= 0 and is_finite(inputs[0].value):
            state.course = self.course(cast(Array, inputs[0].value))
        angles, *ahead = reference_values(state.course, state.ahead_s, tick)
        return angles, float(self.phase_at(tick.time_ns)), *ahead
