"""References as functions of time, and the common parts of reference blocks.

A reference block is a frozen dataclass that makes its `course` once; its ports, preview and values come from
the functions here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError, did_you_mean
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.signals import Port, Value
from fesloop.streams.blocks.synergies import GRIP_APERTURE, READY, Synergies

Array = NDArray[np.float64]


class Course(Protocol):
    """Values of m rows at any time."""

    def at(self, times_s: Array) -> Array:
        """Values at (n,) times in s, a new array (n, m), rad."""


@dataclass(frozen=True, slots=True, eq=False)
class WayPoints:
    """Minimum-jerk moves between way-points (Flash and Hogan 1985, doi 10.1523/JNEUROSCI.05-07-01688.1985).

    Attributes
    ----------
    times_s: (points,), strictly increasing.
    values: (points, m), rad. Between two, each row follows v0 + (v1 - v0) (10 s^3 - 15 s^4 + 6 s^5), s the
        elapsed share; before the first and after the last they are constant.
    """

    times_s: Array
    values: Array

    def at(self, times_s: Array) -> Array:
        """Values at (n,) times."""
        return minimum_jerk(self.times_s, self.values, times_s)


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Straight lines between samples, constant before the first and after the last.

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
    """Raise InputError for a preview that is not allowed."""
    if preview < 0:
        raise InputError("preview", f"{preview}", "0 or more instants")
    if duration_ns(preview_period_ms, NS_PER_MS, "preview_period_ms") == 0:
        raise InputError("preview_period_ms", f"{preview_period_ms}", "above 0")


def reference_ports(course: Course, preview: int) -> tuple[Port, ...]:
    """Ports `angles` (m,) and, with a preview, `preview` (preview, m), rad; initially the first values."""
    start = course.at(np.zeros(1))[0]
    now = Port("angles", start.shape, "rad", tuple(start.tolist()))
    if preview == 0:
        return (now,)
    return now, Port("preview", (preview, *start.shape), "rad", now.initial)


def instants_ahead(preview: int, preview_period_ms: float) -> Array:
    """Times (1 + preview,), s: now, which is 0, and the instants of the preview."""
    return np.arange(1.0 + preview) * (preview_period_ms / 1e3)


def reference_values(course: Course, ahead_s: Array, tick: Tick) -> tuple[Value, ...]:
    """Values of the ports of `reference_ports` at a tick."""
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


Ranges = Mapping[str, Sequence[float]]
"""Least and greatest value of some rows, deg."""
USUAL_ROWS = ("wrist_extension", "finger_flexion", "thumb_flexion")
"""Rows of the block `synergies`."""
WHOLE_TURN = (-180.0, 180.0)
"""Range of a row without a name, deg."""
_ROUNDING_DEG = 1e-6
"""Tolerance at the ends of a range, for rounding by conversion to rad and back."""


@cache
def hand_ranges() -> dict[str, tuple[float, float]]:
    """Range of each ready synergy, of the aperture, and of each freedom of the hand, deg."""
    tree = hand_tree(HandSize())
    synergies = Synergies(rows=(*READY, GRIP_APERTURE))
    names = (*synergies.rows, *tree.freedoms)
    limits = np.rad2deg(np.concatenate([synergies.ranges, tree.ranges])).tolist()
    return {name: (low, high) for name, (low, high) in zip(names, limits, strict=True)}


def checked_ranges(rows: Sequence[str], range_deg: Ranges) -> dict[str, tuple[float, float]]:
    """Ranges `range_deg` as floats, for additional rows and in place of the usual ones.

    Raises InputError unless each row has a unique name and a range.
    """
    known = {**hand_ranges(), **range_deg}
    if not rows or len(set(rows)) < len(rows):
        raise InputError("rows", f"{tuple(rows)}", "one or more names, each once")
    for row in rows:
        if row not in known:
            allowed = ", ".join((*READY, GRIP_APERTURE, "or a freedom of the hand"))
            raise InputError("rows", f"{row!r}", allowed,
                             did_you_mean(row, known) or "give range_deg for a row of your own")
    for row, ends in range_deg.items():
        if row not in rows:
            raise InputError(f"range_deg.{row}", "is no row", ", ".join(rows), did_you_mean(row, rows))
        if len(ends) != 2 or not all(map(math.isfinite, ends)) or ends[0] >= ends[1]:
            raise InputError(f"range_deg.{row}", f"{list(ends)}", "least and greatest angle, finite")
    return {row: (float(low), float(high)) for row, (low, high) in range_deg.items()}


def require_in_range(where: str, row: str, value_deg: float, range_deg: Ranges) -> None:
    """Raise InputError, naming `where`, unless a row may have that value."""
    known = {**hand_ranges(), **range_deg}
    low, high = known.get(row, WHOLE_TURN)
    if not math.isfinite(value_deg):
        raise InputError(where, f"{value_deg}", "a finite angle")
    if not low - _ROUNDING_DEG <= value_deg <= high + _ROUNDING_DEG:
        what = f"of {row}" if row else "of a joint"
        raise InputError(where, f"{value_deg:.5g} deg is outside the range of motion {what}",
                         f"{low:.5g} to {high:.5g} deg",
                         "stay within it, or give a range_deg of your own" if row else "")
