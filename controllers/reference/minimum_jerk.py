"""`minimum_jerk`: joint angles on minimum-jerk moves between way-points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from controllers.reference.course import (
    WayPoints,
    checked_ranges,
    instants_ahead,
    reference_ports,
    reference_values,
    require_in_range,
    require_preview,
)
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.signals import Port, Sample, Value

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class MinimumJerk:
    """Minimum-jerk moves between way-points.

    Between two way-points each joint follows q0 + (q1 - q0) (10 s^3 - 15 s^4 + 6 s^5), s the elapsed
    fraction (Flash and Hogan 1985, doi 10.1523/JNEUROSCI.05-07-01688.1985), so that it leaves and arrives at
    rest. Before the first and after the last it is constant. Two equal way-points in succession are a hold.

    Attributes
    ----------
    times_s: (points,), strictly increasing, s.
    angles_deg: (points, joints), deg.
    rows: names of the joints, or of synergies, whose range of motion then applies.
    range_deg: range of motion of some rows, in place of the usual one.
    preview: number of coming instants in the output `preview`; 0: no such output.
    preview_period_ms: distance between them; the first is one period after now.

    Outputs: `angles` (joints,) rad, and `preview` (preview, joints) rad.
    """

    times_s: tuple[float, ...]
    angles_deg: tuple[tuple[float, ...], ...]
    rows: tuple[str, ...] = ()
    range_deg: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    preview: int = 0
    preview_period_ms: float = 25.0
    course: WayPoints = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not self.times_s:
            raise InputError("times_s", "no way-point", "one or more")
        if not all(isfinite(t) for t in self.times_s) or any(b <= a for a, b in pairwise(self.times_s)):
            raise InputError("times_s", f"{self.times_s}", "finite, strictly increasing times")
        if len(self.angles_deg) != len(self.times_s):
            raise InputError("angles_deg", f"{len(self.angles_deg)} way-points",
                             f"{len(self.times_s)}, one for each of times_s")
        sizes = {len(row) for row in self.angles_deg}
        if len(sizes) != 1 or 0 in sizes:
            raise InputError("angles_deg", f"way-points of {sorted(sizes)} joints",
                             "equally many, one or more")
        self._require_range()
        require_preview(self.preview, self.preview_period_ms)
        angles = np.radians(np.asarray(self.angles_deg, dtype=np.float64))
        object.__setattr__(self, "course", WayPoints(np.asarray(self.times_s, dtype=np.float64), angles))

    def _require_range(self) -> None:
        """Raise InputError for an angle outside its range, and for a wrong number of rows."""
        if self.rows or self.range_deg:
            object.__setattr__(self, "range_deg", checked_ranges(self.rows, self.range_deg))
        if self.rows and len(self.rows) != self.joints:
            raise InputError("rows", f"{len(self.rows)} names", f"{self.joints}, one for each joint")
        for i, point in enumerate(self.angles_deg):
            for j, angle in enumerate(point):
                require_in_range(f"angles_deg[{i}][{j}]", self.rows[j] if self.rows else "", angle,
                                 self.range_deg)

    @property
    def joints(self) -> int:
        """Number of joints."""
        return len(self.angles_deg[0])

    @property
    def extremes(self) -> Array:
        """Least and greatest angle of each joint, (joints, 2), rad."""
        return np.stack([self.course.values.min(axis=0), self.course.values.max(axis=0)], axis=-1)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """None: a source."""
        return ()

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`angles`, and `preview` if there is one."""
        return reference_ports(self.course, self.preview)

    def angles_at(self, times_s: Array) -> Array:
        """Angles (n, joints), rad, at (n,) times in s."""
        return self.course.at(np.asarray(times_s, dtype=np.float64))

    def init(self, context: Context) -> Array:
        """Times of now and of the preview, relative to the tick."""
        return instants_ahead(self.preview, self.preview_period_ms)

    def step(self, state: Array, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Reference of this tick and its preview."""
        return reference_values(self.course, state, tick)
