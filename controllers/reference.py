"""Reference postures: where the joints should be, now and over the horizon of a predictive controller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite

import numba
import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.signals import Port, Sample, Value


@dataclass(slots=True, eq=False)
class MinimumJerkState:
    """Way-points in SI and the instants of the preview after now."""

    times_s: NDArray[np.float64]
    angles: NDArray[np.float64]
    ahead_s: NDArray[np.float64]
    """(1 + preview,), from 0 on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MinimumJerk:
    """Minimum-jerk moves between way-points (Flash and Hogan 1985, doi 10.1523/JNEUROSCI.05-07-01688.1985).

    Between two way-points each joint follows q0 + (q1 - q0) (10 s^3 - 15 s^4 + 6 s^5), s the elapsed
    fraction, so it leaves and arrives at rest. Before the first and after the last it stands still.
    Two equal way-points in a row make a hold.

    Attributes
    ----------
    times_s: (points,), strictly increasing, s.
    angles_deg: (points, joints), deg.
    preview: number of coming instants that output `preview` shows; 0 leaves that output out.
    preview_period_ms: distance between them, the first one period after now.

    Outputs: `angles` (joints,) rad, and `preview` (preview, joints) rad.
    """

    times_s: tuple[float, ...]
    angles_deg: tuple[tuple[float, ...], ...]
    preview: int = 0
    preview_period_ms: float = 25.0

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
        if not all(isfinite(angle) for row in self.angles_deg for angle in row):
            raise InputError("angles_deg", "an angle that is not finite", "finite angles")
        if self.preview < 0:
            raise InputError("preview", f"{self.preview}", "0 or more instants")
        if duration_ns(self.preview_period_ms, NS_PER_MS, "preview_period_ms") == 0:
            raise InputError("preview_period_ms", f"{self.preview_period_ms}", "above 0")

    @property
    def joints(self) -> int:
        """Number of joints."""
        return len(self.angles_deg[0])

    @property
    def inputs(self) -> tuple[Port, ...]:
        """None: a source."""
        return ()

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`angles`, and `preview` where there is one."""
        now = Port("angles", (self.joints,), "rad", tuple(np.radians(self.angles_deg[0]).tolist()))
        if self.preview == 0:
            return (now,)
        return now, Port("preview", (self.preview, self.joints), "rad", now.initial)

    def angles_at(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Angles at (n,) times in s, (n, joints) rad: also for plots and metrics."""
        return minimum_jerk(np.asarray(self.times_s), np.radians(np.asarray(self.angles_deg)),
                            np.asarray(times_s, dtype=np.float64))

    def init(self, context: Context) -> MinimumJerkState:
        """Way-points in SI."""
        ahead_s = np.arange(1.0 + self.preview) * (self.preview_period_ms / 1e3)
        return MinimumJerkState(np.asarray(self.times_s), np.radians(np.asarray(self.angles_deg)), ahead_s)

    def step(self, state: MinimumJerkState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """The reference now and ahead."""
        angles = minimum_jerk(state.times_s, state.angles, tick.time_ns / NS_PER_S + state.ahead_s)
        return (angles[0],) if self.preview == 0 else (angles[0], angles[1:])


@numba.njit(cache=True)
def minimum_jerk(
    times_s: NDArray[np.float64], angles: NDArray[np.float64], at_s: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Minimum-jerk interpolation of way-points `angles` (points, joints) at `at_s` (n,), (n, joints)."""
    points, joints = angles.shape
    moved = np.empty((at_s.size, joints))
    for i in range(at_s.size):
        leg = 0
        while leg < points - 2 and at_s[i] >= times_s[leg + 1]:
            leg += 1
        last = min(leg + 1, points - 1)
        s = 0.0
        if last > leg:
            s = min(max((at_s[i] - times_s[leg]) / (times_s[last] - times_s[leg]), 0.0), 1.0)
        rise = s * s * s * (10.0 + s * (6.0 * s - 15.0))
        for joint in range(joints):
            moved[i, joint] = angles[leg, joint] + rise * (angles[last, joint] - angles[leg, joint])
    return moved
