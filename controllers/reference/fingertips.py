"""`fingertip_path`: fingertips on paths between points, as joint angles or synergies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from controllers.reference.course import (
    Samples,
    WayPoints,
    checked_ranges,
    instants_ahead,
    reference_ports,
    reference_values,
    require_in_range,
    require_preview,
)
from fesloop.errors import InputError, did_you_mean
from fesloop.hand.anthropometry import FINGERS, HandSize, Three
from fesloop.hand.inverse_kinematics import InverseKinematics, of_hand
from fesloop.hand.skeleton import RESTING_DEG
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.signals import Port, Sample, Value
from fesloop.streams.blocks.synergies import GRIP_APERTURE, Synergies

Array = NDArray[np.float64]
_SAMPLE_S = 0.005
"""Distance between computed postures; straight lines between them stay within .03 mm of the path in a move of
60 deg in .3 s (chosen)."""
_LONGEST_S = 600.0
_FASTEST_DEG_S = 2000.0
"""Rate above which the posture jumps (range of the gyroscopes that Kortier 2014 chose for hands, doi
10.1186/1743-0003-11-70)."""
_OFF_PATH_MM = 0.1
"""Distance from their path above which fingertips are reported."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FingertipPoint:
    """Positions of some fingertips at an instant.

    Attributes
    ----------
    at_s: time in the trial.
    mm: position by finger, in the wrist coordinate system.
    by_mm: displacement by finger from its last point. Other fingers do not move.
    """

    at_s: float
    mm: Mapping[str, Three] = field(default_factory=dict)
    by_mm: Mapping[str, Three] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not 0.0 <= self.at_s <= _LONGEST_S:
            raise InputError("at_s", f"{self.at_s:g}", f"0 to {_LONGEST_S:g}")
        for key in ("mm", "by_mm"):
            told = getattr(self, key)
            for finger, place in told.items():
                if finger not in FINGERS:
                    raise InputError(f"{key}.{finger}", "is no finger", ", ".join(FINGERS),
                                     did_you_mean(finger, FINGERS))
                if len(place) != 3 or not all(map(math.isfinite, place)):
                    raise InputError(f"{key}.{finger}", f"{list(place)}", "three finite numbers")
            exact = {finger: tuple(map(float, place)) for finger, place in told.items()}
            object.__setattr__(self, key, exact)
        for finger in self.mm.keys() & self.by_mm.keys():
            raise InputError(f"by_mm.{finger}", "is given together with mm", "one of the two")


@dataclass(frozen=True, slots=True, kw_only=True)
class FingertipPath:
    """Fingertips on minimum-jerk paths between points, converted to postures within ranges of motion.

    Between two points each fingertip moves straight, from rest to rest (Flash and Hogan 1985, doi
    10.1523/JNEUROSCI.05-07-01688.1985). Postures are found by `fesloop.hand.inverse_kinematics`: DIP follows
    PIP, and of several postures the one nearest to the preferred posture is used. Before the first point and
    after the last the hand is at rest.

    Attributes
    ----------
    points: points of the path, in the order of their times. Fingers that the first does not name are where
        the preferred posture has them; fingers that no point names do not move.
    posture_deg: preferred posture, by freedom; others as at rest (`fesloop.hand.skeleton`). Freedoms that do
        not move stay there.
    rows: elements of `angles`, in this order: synergies (of the block `synergies`) or freedoms of the hand.
        Empty: all its freedoms.
    moving: freedoms that may move; empty: those of the fingers that points name.
    hand: hand of the subject, in whose wrist coordinate system (`fesloop.hand.skeleton`) positions are.
    contact: point of a fingertip (`fesloop.hand.skeleton.CONTACTS`); the bone's end is "tip".
    tolerance_mm: greatest distance of a fingertip from its path where that leaves its reach.
    preview: number of coming instants in the output `preview`; 0: no such output.
    preview_period_ms: distance between them; the first is one period after now.

    Outputs: `angles` (m,) rad; `fingertips` (fingers, 3) m, the paths of the fingers that points name, from
    F1 on; `preview` (preview, m) rad.
    """

    points: tuple[FingertipPoint, ...]
    posture_deg: Mapping[str, float] = field(default_factory=dict)
    rows: tuple[str, ...] = ()
    moving: tuple[str, ...] = ()
    hand: HandSize = field(default_factory=HandSize)
    contact: str = "tip"
    tolerance_mm: float = 1.0
    preview: int = 0
    preview_period_ms: float = 25.0
    course: Samples = field(init=False, repr=False, compare=False)
    paths: WayPoints = field(init=False, repr=False, compare=False)
    """Paths of the fingertips, (points, 3 fingers), m."""
    off_path_mm: dict[str, float] = field(init=False, repr=False, compare=False)
    """Greatest distance of each fingertip from its path, by finger."""

    def __post_init__(self) -> None:
        require_preview(self.preview, self.preview_period_ms)
        exact = {name: float(angle) for name, angle in self.posture_deg.items()}
        object.__setattr__(self, "posture_deg", exact)
        if self.rows:
            checked_ranges(self.rows, {})
        if GRIP_APERTURE in self.rows:
            raise InputError("rows", f"{GRIP_APERTURE!r} is no sum of angles", "sums and freedoms",
                             "points already set where fingertips are; remove it")
        if not (math.isfinite(self.tolerance_mm) and self.tolerance_mm >= 0.0):
            raise InputError("tolerance_mm", f"{self.tolerance_mm:g}", "0 or more")
        times = [point.at_s for point in self.points]
        if not times or any(b <= a for a, b in pairwise(times)):
            raise InputError("points", f"at_s {times}", "one or more points, each later than the one before")
        if not self.fingers:
            raise InputError("points", "no finger is named", "mm or by_mm of one finger or more")
        solver = of_hand(self.hand, self.fingers, self._preferred(), moving=self.moving, contact=self.contact)
        object.__setattr__(self, "paths", self._paths(solver))
        course, off_path = self._course(solver)
        object.__setattr__(self, "course", course)
        object.__setattr__(self, "off_path_mm", dict(zip(self.fingers, off_path.tolist(), strict=True)))

    @property
    def fingers(self) -> tuple[str, ...]:
        """Fingers that points name, from F1 on."""
        return tuple(finger for finger in FINGERS
                     if any(finger in point.mm or finger in point.by_mm for point in self.points))

    def _preferred(self) -> Array:
        """Preferred posture, (23,), rad; raises InputError for unknown freedoms and angles out of range."""
        for key, names in (("posture_deg", self.posture_deg), ("moving", self.moving)):
            for name in names:
                if name not in RESTING_DEG:
                    raise InputError(key, f"{name!r} is no freedom of the hand", ", ".join(RESTING_DEG),
                                     did_you_mean(name, RESTING_DEG))
        for name, angle in self.posture_deg.items():
            require_in_range(f"posture_deg.{name}", name, angle, {})
        return np.radians([self.posture_deg.get(name, angle) for name, angle in RESTING_DEG.items()])

    def _paths(self, solver: InverseKinematics) -> WayPoints:
        """Way-points of all fingertips."""
        tips = solver.tips(solver.posture(solver.preferred))
        rows = []
        for point in self.points:
            tips = tips.copy()
            for i, finger in enumerate(self.fingers):
                if finger in point.mm:
                    tips[i] = np.multiply(1e-3, point.mm[finger])
                tips[i] += np.multiply(1e-3, point.by_mm.get(finger, (0.0, 0.0, 0.0)))
            rows.append(tips.ravel())
        return WayPoints(np.array([point.at_s for point in self.points]), np.array(rows))

    def _course(self, solver: InverseKinematics) -> tuple[Samples, Array]:
        """Rows over time, and the distance of each fingertip from its path, mm."""
        first, last = self.paths.times_s[[0, -1]]
        grid = np.linspace(first, last, math.ceil((last - first) / _SAMPLE_S) + 1)
        times = np.unique(np.concatenate([grid, self.paths.times_s]))
        found = solver.along(self.paths.at(times).reshape(times.size, -1, 3))
        self._require_reach(times, 1e3 * found.distances, 1e3 * solver.tips(found.angles))
        self._require_no_jump(times, found.angles)
        freedoms = {name: {name: 1.0} for name in RESTING_DEG}
        weights = Synergies(rows=self.rows or tuple(freedoms), weights=freedoms).matrix
        return Samples(times, found.angles @ weights.T), 1e3 * found.distances.max(axis=0)

    def _require_reach(self, times: Array, distances_mm: Array, reached_mm: Array) -> None:
        """Raise InputError where a fingertip is too far from its path."""
        k, finger = np.unravel_index(np.argmax(distances_mm), distances_mm.shape)
        distance = distances_mm[k, finger]
        if distance > self.tolerance_mm:
            place = ", ".join(f"{each:.1f}" for each in reached_mm[k, finger])
            point = int(np.searchsorted(self.paths.times_s, times[k]))
            raise InputError(
                f"points[{point}]", f"{self.fingers[finger]} stays {distance:.1f} mm off its path at "
                f"{times[k]:.4g} s, the nearest that the ranges of motion allow is ({place}) mm",
                f"at most {self.tolerance_mm:g} mm (tolerance_mm)",
                "move the point, let more freedoms move (moving), or state a greater tolerance_mm")

    def _require_no_jump(self, times: Array, angles: Array) -> None:
        """Raise InputError where a joint is faster than `_FASTEST_DEG_S`."""
        if times.size == 1:
            return
        speeds = np.degrees(np.abs(np.diff(angles, axis=0))) / np.diff(times)[:, np.newaxis]
        k, freedom = np.unravel_index(np.argmax(speeds), speeds.shape)
        fastest = speeds[k, freedom]
        if fastest > _FASTEST_DEG_S:
            point = int(np.searchsorted(self.paths.times_s, times[k + 1]))
            raise InputError(
                f"points[{point}]", f"{tuple(RESTING_DEG)[freedom]} turns by {fastest:.0f} deg/s at "
                f"{times[k]:.4g} s", f"at most {_FASTEST_DEG_S:g} deg/s",
                "give the move more time, or another path")

    @property
    def inputs(self) -> tuple[Port, ...]:
        """None: a source."""
        return ()

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`angles`, `fingertips`, and `preview` if there is one."""
        angles, *ahead = reference_ports(self.course, self.preview)
        places = tuple(self.paths.values[0].tolist())
        return angles, Port("fingertips", (len(self.fingers), 3), "m", places), *ahead

    def cautions(self, context: Context) -> tuple[tuple[str, str], ...]:
        """Warnings (status, detail) about fingertips that leave their paths."""
        return tuple(("path_unreachable", f"{finger} is up to {most:.2f} mm off its path, out of its reach")
                     for finger, most in self.off_path_mm.items() if most > _OFF_PATH_MM)

    def init(self, context: Context) -> Array:
        """Times of now and of the preview, relative to the tick."""
        return instants_ahead(self.preview, self.preview_period_ms)

    def step(self, state: Array, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Reference of this tick, positions of the fingertips, and the preview."""
        angles, *ahead = reference_values(self.course, state, tick)
        return angles, self.paths.at(np.array([tick.time_ns / NS_PER_S])).reshape(-1, 3), *ahead
