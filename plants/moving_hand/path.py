"""Smooth path of a script: joint angles and the forearm's pose, twice continuously differentiable.

Columns of a path: the forearm's rotation (3, rad, about its flexion, abduction, pronation axes), the hand's
freedoms (d, rad), the forearm's translation (3, m, east, north, up).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, make_interp_spline

from fesloop.errors import InputError
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics_kernels import forward, joint_lines, point_jacobian, turned
from fesloop.hand.segments import SegmentTree
from fesloop.hand.skeleton import contact_point
from plants.moving_hand.script import ArmSway, Contact, Phase, length_s

Array = NDArray[np.float64]
_TOLERANCE_M, _CONVERGED = 5e-4, 1e-5
_LEAST_M = 1e-4
"""Distance below which points count as touching, as the direction between them is undefined."""
_ITERATIONS, _LONGEST_STEP = 300, 0.3
_TANGENTIAL, _CAUTIOUS, _SOON = 0.5, 0.1, 100
"""Gain along the contacts, and that after so many iterations, in which the other did not converge."""
_AT_REFERENCE = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])


class _Pair(NamedTuple):
    """Segments and places of both points of a contact, in the segments' frames, and their distance, m."""

    segments: tuple[int, int]
    places: tuple[Array, Array]
    distance: float


class ContactSolver:
    """Solver for postures of a segment tree in which contacts hold.

    The posture x nearest to the preferred posture w with all gaps g(x) = 0 is the limit of
    x <- x - J^+ g + s (I - J^+ J) (w - x), with the gaps' Jacobian J, and s < 1 for curved gaps; a joint that
    leaves its range is fixed at the range's end.

    Attributes
    ----------
    freedoms: indices of the touching fingers' freedoms; all others keep their preferred angle.
    """

    def __init__(self, tree: SegmentTree, size: HandSize, contacts: Sequence[Contact]) -> None:
        self._tree = tree
        self._pairs = [_pair(tree, size, contact) for contact in contacts]
        fingers = {tree.names[k][:2] for pair in self._pairs for k in pair.segments}
        self.freedoms = np.array([k for k, name in enumerate(tree.freedoms) if name[:2] in fingers])
        self._low, self._high = tree.ranges[self.freedoms].T

    def solve(self, preferred: Array, start: Array) -> Array:
        """Find angles (d,), rad, near `preferred` (d,), starting from `start` (d,).

        Raises InputError if this hand cannot bring the points to that distance.
        """
        angles = preferred.copy()
        target = np.clip(preferred[self.freedoms], self._low, self._high)
        x = np.clip(start[self.freedoms], self._low, self._high)
        free = np.ones(x.size, dtype=np.bool_)
        for iteration in range(_ITERATIONS):
            gain = _TANGENTIAL if iteration < _SOON else _CAUTIOUS
            angles[self.freedoms] = x
            gaps, slopes = self._gaps(angles)
            slopes[:, ~free] = 0.0
            back = np.where(free, target - x, 0.0)
            step = gain * back - np.linalg.lstsq(
                slopes, gaps + gain * (slopes @ back), rcond=1e-9)[0]
            longest = float(np.abs(step).max())
            x = x + step * min(1.0, _LONGEST_STEP / max(longest, 1e-12))
            if longest < _CONVERGED:
                beyond = (x < self._low) | (x > self._high)
                if not beyond.any():
                    break
                free &= ~beyond
                x = np.clip(x, self._low, self._high)
        worst = float(np.abs(gaps).max())
        outside = float(np.maximum(self._low - x, x - self._high).max())
        if worst > _TOLERANCE_M or outside > 0.01:
            raise InputError("contacts", f"are missed by {1e3 * worst:.1f} mm", "contacts within this hand's "
                             "reach", "change posture_deg, distance_mm or the points")
        return angles

    def _gaps(self, angles: Array) -> tuple[Array, Array]:
        """Errors of the distances (for a touch all three coordinates), and their Jacobian."""
        tree = self._tree
        poses, lines = np.empty((len(tree.segments), 7)), np.empty((angles.size, 6))
        forward(tree.layout, tree.geometry, angles, _AT_REFERENCE, poses)
        joint_lines(tree.layout, tree.geometry, angles, poses, lines)
        gaps: list[Array] = []
        rows: list[Array] = []
        for segments, places, distance in self._pairs:
            ends, change = [], []
            for k, place in zip(segments, places, strict=True):
                w, x, y, z = poses[k, :4]
                end = poses[k, 4:] + np.array(turned((w, x, y, z), *place))
                slope = np.empty((6, angles.size))
                point_jacobian(lines, tree.moved[k], end, slope)
                ends.append(end)
                change.append(slope[:3, self.freedoms])
            between = ends[1] - ends[0]
            length = float(np.linalg.norm(between))
            touch = distance < _LEAST_M
            towards = np.eye(3) if touch else between[np.newaxis] / max(length, _LEAST_M)
            gaps.append(between if touch else np.array([length - distance]))
            rows.append(towards @ (change[1] - change[0]))
        return np.concatenate(gaps), np.vstack(rows)


def _pair(tree: SegmentTree, size: HandSize, contact: Contact) -> _Pair:
    (first, a), (second, b) = (text.split(" ") for text in (contact.first, contact.second))
    segments = tree.index(f"{first}d"), tree.index(f"{second}d")
    place, other, distance = contact_point(size, first, a), contact_point(size, second, b), (
        1e-3 * contact.distance_mm)
    if contact.facing:
        # The second point must meet a point straight out from the skin of the first.
        return _Pair(segments, (place * (1.0 + distance / float(np.linalg.norm(place))), other), 0.0)
    return _Pair(segments, (place, other), distance)


Course = Callable[[Array], Array]
"""Rows at local times (m,), s from the start of a piece."""
ARM = 3
_KEYFRAME_S = 0.2
"""Interval between solutions of the contacts; in between the path is a spline."""
_PLAY_PERIOD_S = 3.0
"""Period of the touching fingers' play (chosen: slow against 2 Hz, doi 10.3390/s19010208, section 3.1.3)."""
_FADE_S = 1.0


class Piece(NamedTuple):
    """A part of a path, from start to stop, s."""

    start: float
    stop: float
    course: Course


class Span(NamedTuple):
    """Name, start and end of a phase, s; with contacts one span per contact, without approach and release."""

    name: str
    start: float
    stop: float


@dataclass(slots=True)
class MotionPath:
    """A path of quintic pieces between knots that are evenly spaced in time.

    Attributes
    ----------
    knot_s: interval between knots.
    knots: (knots, 3, columns): values, rates, accelerations.
    spans: spans of the named phases.
    """

    knot_s: float
    knots: Array
    spans: list[Span]


def motion_path(
    phases: Sequence[Phase], tree: SegmentTree, size: HandSize, rest_deg: Mapping[str, float],
    rng: np.random.Generator, knot_s: float, rest_sd_deg: float = 0.0, repeat_sd_deg: float = 0.0,
) -> MotionPath:
    """Make the path of a script; InputError for unknown freedoms and contacts out of reach.

    Parameters
    ----------
    tree: segments of the moving hand.
    size: measures of its fingertips.
    rest_deg: posture at t = 0, by freedom; others are 0.
    rng: source of variation of cycles, and of the phases of sway and play.
    knot_s: interval between knots.
    rest_sd_deg: sd of the error of every angle at t = 0.
    repeat_sd_deg: sd of every angle at each end of a cycle with pauses.
    """
    rest = _posture(tree, rest_deg, np.zeros(len(tree.ranges)))
    if rest_sd_deg:
        rest += math.radians(rest_sd_deg) * rng.standard_normal(rest.size)
    writer = _Writer(tree, size, rest, rng, math.radians(repeat_sd_deg))
    for phase in phases:
        writer.add(phase)
    count = max(6, 1 + math.ceil(length_s(phases) / knot_s))
    times: Array = knot_s * np.arange(count, dtype=np.float64)
    columns = np.zeros((count, 2 * ARM + len(tree.ranges)))
    columns[:, ARM:-ARM] = writer.now
    _fill(columns[:, ARM:-ARM], times, writer.fingers)
    arm = np.zeros((count, 2 * ARM))
    _fill(arm, times, writer.arm)
    columns[:, :ARM], columns[:, -ARM:] = arm[:, :ARM], arm[:, ARM:]
    spline = make_interp_spline(times, columns, k=5)
    knots = np.stack([spline(times), spline(times, 1), spline(times, 2)], axis=1)
    return MotionPath(knot_s, knots, spans_of(phases))


def spans_of(phases: Sequence[Phase]) -> list[Span]:
    """Spans of the named phases of a script, in order."""
    spans, time = [], 0.0
    for phase in phases:
        if not phase.contacts:
            spans.append(Span(phase.name, time, time + phase.length_s))
            time += phase.length_s
            continue
        for _ in range(max(1, phase.cycles)):
            time += phase.approach_s
            spans.append(Span(phase.name, time, time + phase.duration_s))
            time += phase.duration_s + (phase.approach_s if phase.cycles else 0.0)
    return [span for span in spans if span.name]


def _fill(columns: Array, times: Array, pieces: Sequence[Piece]) -> None:
    for start, stop, course in pieces:
        first, last = np.searchsorted(times, [start, stop])
        if last > first:
            columns[first:last] = course(times[first:last] - start)


def _posture(tree: SegmentTree, degrees: Mapping[str, float], others: Array) -> Array:
    """Angles (d,), rad, of the named freedoms, and `others` for the rest."""
    angles = others.copy()
    for name, angle in degrees.items():
        angles[tree.freedom(name)] = math.radians(angle)
    return angles


def _rise(s: Array) -> Array:
    """Minimum-jerk rise from 0 to 1 on [0, 1], constant outside, (m, 1)."""
    s = np.clip(s, 0.0, 1.0)[:, np.newaxis]
    return np.asarray(s ** 3 * (10.0 + s * (6.0 * s - 15.0)))


@dataclass(slots=True)
class _Writer:
    """Builder of a path, phase by phase; `now` is the posture at the end of the last one.

    `scatter` is the sd of every angle at each end of a cycle with pauses, rad.
    """

    tree: SegmentTree
    size: HandSize
    now: Array
    rng: np.random.Generator
    scatter: float = 0.0
    rest: Array = field(init=False)
    time: float = 0.0
    fingers: list[Piece] = field(default_factory=list)
    arm: list[Piece] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.rest = self.now.copy()

    def add(self, phase: Phase) -> None:
        """Append a phase."""
        begin = self.time
        if phase.contacts:
            self._touch(phase)
        elif phase.cycles:
            self._repeat(phase)
        else:
            self._go(_posture(self.tree, phase.posture_deg, self.rest if phase.to_rest else self.now),
                     phase.duration_s)
        if phase.arm is not None:
            self.arm.append(Piece(begin, self.time, _sway(phase.arm, self.time - begin, self.rng)))

    def _append(self, duration: float, course: Course) -> None:
        self.fingers.append(Piece(self.time, self.time + duration, course))
        self.time += duration

    def _go(self, goal: Array, duration: float) -> None:
        start = self.now
        self._append(duration, lambda t: start + _rise(t / duration) * (goal - start))
        self.now = goal

    def _repeat(self, phase: Phase) -> None:
        """Append cycles from the present posture and back, of the declared total duration."""
        far = _posture(self.tree, phase.posture_deg, self.now) - self.now
        shares = np.clip(1.0 + phase.vary * self.rng.standard_normal(phase.cycles), 0.4, 1.6)
        sizes = np.clip(1.0 + phase.vary * self.rng.standard_normal(phase.cycles), 0.4, 1.6)
        durations = phase.length_s * shares / shares.sum()
        if phase.circle:
            first = self.tree.freedom(next(iter(phase.posture_deg)))
            self._append(phase.length_s, _circles(self.now, far, first, phase.length_s, phase.cycles))
            return
        begin = self.now
        for duration, size in zip(durations, sizes, strict=True):
            stay = phase.stay_s * duration / phase.duration_s
            there, back = begin + size * far, begin
            if self.scatter and stay:
                away, home = self.scatter * self.rng.standard_normal((2, begin.size))
                there, back = there + away, back + home
            self._append(duration, _there_and_back(self.now, there, back, duration, stay))
            self.now = back

    def _touch(self, phase: Phase) -> None:
        """Approach the contacts, hold them and, with cycles, release them."""
        solver = ContactSolver(self.tree, self.size, phase.contacts)
        away = self.now
        preferred = _posture(self.tree, phase.posture_deg, away)
        for _ in range(max(1, phase.cycles)):
            course = _in_contact(solver, preferred, phase, self.rng)
            self._go(course(np.zeros(1))[0], phase.approach_s)
            self._append(phase.duration_s, course)
            self.now = course(np.array([phase.duration_s]))[0]
            if phase.cycles:
                self._go(away, phase.approach_s)


def _there_and_back(start: Array, there: Array, back: Array, duration: float, stay: float) -> Course:
    """Minimum-jerk movement from `start` to `there` and to `back`, with a pause of `stay` at either end."""
    going = 0.5 * duration - stay

    def course(t: Array) -> Array:
        away, home = _rise(t / going), _rise((t - going - stay) / going)
        return np.asarray(start + away * (there - start) + home * (back - there))

    return course


def _circles(start: Array, far: Array, first: int, duration: float, cycles: int) -> Course:
    """Circular movement around `start`, in quadrature, faded in and out over half a cycle."""
    fade = 0.5 * duration / cycles

    def course(t: Array) -> Array:
        angle = (2.0 * math.pi * cycles / duration * t)[:, np.newaxis]
        rows = np.sin(angle) * far
        rows[:, first] = np.cos(angle[:, 0]) * far[first]
        return np.asarray(start + _faded(t, duration, fade) * rows)

    return course


def _faded(t: Array, duration: float, fade: float) -> Array:
    fade = min(fade, 0.5 * duration)
    return _rise(t / fade) * _rise((duration - t) / fade)


def _sines(rng: np.random.Generator, amplitudes: Array, period: float) -> Course:
    """Sum of two sinusoids per column with random phases; the second has half the amplitude and 1.6 times
    the frequency."""
    phases = rng.uniform(0.0, 2.0 * math.pi, (2, amplitudes.size))

    def course(t: Array) -> Array:
        angle = (2.0 * math.pi / period * t)[:, np.newaxis]
        waves = np.sin(angle + phases[0]) + 0.5 * np.sin(1.6 * angle + phases[1])
        return np.asarray(amplitudes / 1.5 * waves)

    return course


def _sway(arm: ArmSway, duration: float, rng: np.random.Generator) -> Course:
    moving = _sines(rng, np.concatenate([np.radians(arm.turn_deg), arm.shift_m]), arm.period_s)
    centre = np.array([0.0, 0.0, 0.0, *arm.offset_m])
    return lambda t: _faded(t, duration, _FADE_S) * (centre + moving(t))


def _in_contact(solver: ContactSolver, preferred: Array, phase: Phase, rng: np.random.Generator) -> Course:
    """Spline of postures in which the contacts hold while the preferred posture varies."""
    count = max(4, 1 + math.ceil(phase.duration_s / _KEYFRAME_S))
    times: Array = np.linspace(0.0, phase.duration_s, count, dtype=np.float64)
    play = np.zeros(preferred.size)
    play[solver.freedoms] = math.radians(phase.play_deg)
    varied = preferred + _faded(times, phase.duration_s, _FADE_S) * _sines(rng, play, _PLAY_PERIOD_S)(times)
    rows, angles = [], preferred
    for row in varied:
        angles = solver.solve(row, angles)
        rows.append(angles)
    return CubicSpline(times, np.stack(rows), bc_type="clamped")
