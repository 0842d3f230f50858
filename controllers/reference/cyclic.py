"""`cyclic`: periodic movements, as in exercise, identification and tests of a tracker."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

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
from fesloop.loop.signals import Port, Sample, Value

Array = NDArray[np.float64]
Shape = Literal["sine", "open_close"]


@dataclass(frozen=True, slots=True, eq=False)
class Cycles:
    """Periodic movement of m rows between two ends; before and after its cycles a row is at its near end.

    Attributes
    ----------
    mean, amplitude: (m,), rad; the near end is mean - amplitude, the far end mean + amplitude.
    begin_s: (m,), start of the first cycle.
    period_s: period of a cycle.
    cycles: number of cycles; inf: without end.
    way: position from the near end, 0, to the far end, 1, over one cycle (0 to 1); None: sinusoids.
    """

    mean: Array
    amplitude: Array
    begin_s: Array
    period_s: float
    cycles: float
    way: WayPoints | None

    def at(self, times_s: Array) -> Array:
        """Values at (n,) times."""
        elapsed = np.clip((times_s[:, np.newaxis] - self.begin_s) / self.period_s, 0.0, self.cycles)
        share = elapsed - np.floor(elapsed)
        if self.way is None:
            away = 0.5 - 0.5 * np.cos(2.0 * np.pi * share)
        else:
            away = self.way.at(share.ravel()).reshape(share.shape)
        return self.mean + self.amplitude * (2.0 * away - 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Cyclic:
    """Periodic movement of rows of a hand's posture from mean - amplitude to mean + amplitude and back.

    "sine": mean - amplitude cos(2 pi u), u the elapsed cycles. "open_close": minimum-jerk moves (Flash and
    Hogan 1985, doi 10.1523/JNEUROSCI.05-07-01688.1985) at the beginning and in the middle of each cycle, and
    a rest after each. Before its first cycle and after its last a row is at mean - amplitude.

    Attributes
    ----------
    period_s: period of a cycle.
    mean_deg: mean of every row.
    amplitude_deg: amplitude by row, 0 by default. A negative one begins at the greater end.
    rows: elements of `angles`, in this order: synergies (of the block `synergies`), freedoms of the hand, or
        rows of your own with a range in `range_deg`.
    shape: "sine" or "open_close".
    flank_s: duration of a move of "open_close", at most and by default half of `period_s`.
    cycles: number of cycles; 0: without end.
    start_s: start of the first cycle.
    lag_deg: phase lag by row, 0 or more; 360 is a cycle. 0 by default.
    range_deg: range of motion of some rows, in place of the one that follows from their joints.
    preview: number of coming instants in the output `preview`; 0: no such output.
    preview_period_ms: distance between them; the first is one period after now.

    Outputs: `angles` (m,) rad, and `preview` (preview, m) rad.
    """

    period_s: float
    mean_deg: Mapping[str, float]
    amplitude_deg: Mapping[str, float]
    rows: tuple[str, ...] = USUAL_ROWS
    shape: Shape = "sine"
    flank_s: float | None = None
    cycles: int = 0
    start_s: float = 0.0
    lag_deg: Mapping[str, float] = field(default_factory=dict)
    range_deg: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    preview: int = 0
    preview_period_ms: float = 25.0
    course: Cycles = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "range_deg", checked_ranges(self.rows, self.range_deg))
        require_preview(self.preview, self.preview_period_ms)
        for key in ("mean_deg", "amplitude_deg", "lag_deg"):
            given = getattr(self, key)
            for row, value in given.items():
                self._require(key, row, value)
            object.__setattr__(self, key, {row: float(value) for row, value in given.items()})
        missing = [row for row in self.rows if row not in self.mean_deg]
        if missing:
            raise InputError("mean_deg", f"has no angle of {', '.join(missing)}",
                             f"an angle for each of {', '.join(self.rows)}")
        for row in self.rows:
            for sign in (-1.0, 1.0):
                end = self.mean_deg[row] + sign * self.amplitude_deg.get(row, 0.0)
                key = "amplitude_deg" if row in self.amplitude_deg else "mean_deg"
                require_in_range(f"{key}.{row}", row, end, self.range_deg)
        object.__setattr__(self, "course", self._laid_out())

    def _require(self, key: str, row: str, value: float) -> None:
        """Raise InputError for a row that is none, and for a value that is none."""
        if row not in self.rows:
            raise InputError(f"{key}.{row}", "is no row", ", ".join(self.rows), did_you_mean(row, self.rows))
        if not math.isfinite(value) or (key == "lag_deg" and value < 0.0):
            raise InputError(f"{key}.{row}", f"{value:g}",
                             "a finite number" + (", 0 or more" if key == "lag_deg" else ""))

    def _laid_out(self) -> Cycles:
        """The rows in SI."""
        period_ns = duration_ns(self.period_s, NS_PER_S, "period_s")
        if period_ns == 0:
            raise InputError("period_s", f"{self.period_s:g}", "above 0")
        if self.cycles < 0:
            raise InputError("cycles", f"{self.cycles}", "0 or more")
        period, start = period_ns / NS_PER_S, duration_ns(self.start_s, NS_PER_S, "start_s") / NS_PER_S
        flank = 0.5 * period if self.flank_s is None else self.flank_s
        if self.shape == "sine" and self.flank_s is not None:
            raise InputError("flank_s", 'given with shape "sine"', 'shape "open_close"', "leave it out")
        if not 0.0 < flank <= 0.5 * period:
            raise InputError("flank_s", f"{flank:g}", f"above 0, at most {0.5 * period:g}, half of period_s")
        mean, amplitude, lag = (np.radians([told.get(row, 0.0) for row in self.rows])
                                for told in (self.mean_deg, self.amplitude_deg, self.lag_deg))
        return Cycles(mean, amplitude, start + period * lag / (2.0 * np.pi), period,
                      self.cycles or math.inf, _way(flank / period) if self.shape == "open_close" else None)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """None: a source."""
        return ()

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`angles`, and `preview` if there is one."""
        return reference_ports(self.course, self.preview)

    def init(self, context: Context) -> Array:
        """Times of now and of the preview, relative to the tick."""
        return instants_ahead(self.preview, self.preview_period_ms)

    def step(self, state: Array, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Reference of this tick and its preview."""
        return reference_values(self.course, state, tick)


def _way(flank: float) -> WayPoints:
    """Position over a cycle: a move to the far end at its beginning and back in its middle."""
    points = {0.0: 0.0, flank: 1.0, 0.5: 1.0, 0.5 + flank: 0.0}
    return WayPoints(np.array(list(points)), np.array(list(points.values()))[:, np.newaxis])
