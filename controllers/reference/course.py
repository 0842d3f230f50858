"""References as functions of time, and what every block that gives one out has in common.

A reference block is a frozen dataclass that makes its `course` once and says the rest with the functions
here: ports, preview, values of a tick.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.loop.block import Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.signals import Port, Value

Array = NDArray[np.float64]


class Course(Protocol):
    """Where m rows should be at any time."""

    def at(self, times_s: Array) -> Array:
        """Values at (n,) times in s, a fresh array (n, m), rad."""


@dataclass(frozen=True, slots=True, eq=False)
class WayPoints:
    """Minimum-jerk moves between way-points (Flash and Hogan 1985, doi 10.1523/JNEUROSCI.05-07-01688.1985).

    Attributes
    ----------
    times_s: (points,), strictly increasing.
    values: (points, m), rad. Between two, each row follows v0 + (v1 - v0) (10 s^3 - 15 s^4 + 6 s^5), s the
        elapsed share; before the first and after the last it stands still.
    """

    times_s: Array
    values: Array

    def at(self, times_s: Array) -> Array:
        """Values at (n,) times."""
        return minimum_jerk(self.times_s, self.values, times_s)


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Straight lines between samples; before the first and after the last it stands still.

    Attributes
    ----------
    times_s: (samples,), strictly increasing.
    values: (samples, m), rad.
    """

    times_s: Array
    values: Array

    def at(self, times_s: Array) -> Array:
        """Values at (n,) times."""
        return np.stack([np.interp(times_s, self.times_s, row) for row in self.values.T], axis=-1)


def require_preview(preview: int, preview_period_ms: float) -> None:
    """Raise InputError for a preview that cannot be."""
    if preview < 0:
        raise InputError("preview", f"{preview}", "0 or more instants")
    if duration_ns(preview_period_ms, NS_PER_MS, "preview_period_ms") == 0:
        raise InputError("preview_period_ms", f"{preview_period_ms}", "above 0")


def reference_ports(course: Course, preview: int) -> tuple[Port, ...]:
    """`angles` (m,) and, where there is one, `preview` (preview, m); rad. Safe outputs: where it begins."""
    start = course.at(np.zeros(1))[0]
    now = Port("angles", start.shape, "rad", tuple(start.tolist()))
    if preview == 0:
        return (now,)
    return now, Port("preview", (preview, *start.shape), "rad", now.initial)


def instants_ahead(preview: int, preview_period_ms: float) -> Array:
    """(1 + preview,), s: now, which is 0, and the instants of the preview."""
    return np.arange(1.0 + preview) * (preview_period_ms / 1e3)


def reference_values(course: Course, ahead_s: Array, tick: Tick) -> tuple[Value, ...]:
    """What the ports of `reference_ports` say at a tick."""
    angles = course.at(tick.time_ns / NS_PER_S + ahead_s)
    return (angles[0],) if ahead_s.size == 1 else (angles[0], angles[1:])


@compiled
def minimum_jerk(times_s: Array, values: Array, at_s: Array) -> Array:
    """Minimum-jerk interpolation of way-points `values` (points, m) at `at_s` (n,), (n, m)."""
    points, rows = values.shape
    moved = np.empty((at_s.size, rows))
    for i in range(at_s.size):
        last = min(int(np.searchsorted(times_s, at_s[i], side="right")), points - 1)
        leg = max(last - 1, 0)
        s = 0.0
        if last > leg:
            s = min(max((at_s[i] - times_s[leg]) / (times_s[last] - times_s[leg]), 0.0), 1.0)
        rise = s * s * s * (10.0 + s * (6.0 * s - 15.0))
        for row in range(rows):
            moved[i, row] = values[leg, row] + rise * (values[last, row] - values[leg, row])
    return moved

