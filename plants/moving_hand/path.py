"""From a script to a smooth path: joint angles and the forearm's pose, twice continuously differentiable.

Columns of a path: the forearm's turn (3, rad, about its flexion, abduction, pronation axes), the hand's
freedoms (d, rad), the forearm's shift (3, m, east, north, up).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, make_interp_spline

from fesloop.hand.anthropometry import HandSize
from fesloop.hand.segments import SegmentTree
from plants.moving_hand.contact_posture import ContactSolver
from plants.moving_hand.script import ArmSway, Phase, length_s

Array = NDArray[np.float64]
Course = Callable[[Array], Array]
"""Rows at local times (m,), s from a piece's beginning."""
ARM = 3
_KEYFRAME_S = 0.2
"""Contacts are solved so often; in between the path is a spline through them."""
_PLAY_PERIOD_S = 3.0
"""Of the touching fingers' play (chosen: slow against 2 Hz, doi 10.3390/s19010208, section 3.1.3)."""
_FADE_S = 1.0


class Piece(NamedTuple):
    """A part of a path, from start to stop, s."""

    start: float
    stop: float
    course: Course


class Span(NamedTuple):
    """When a phase lasts, s: for contacts without approach and release, one span a contact."""

    name: str
    start: float
    stop: float


@dataclass(slots=True)
class MotionPath:
    """A path as quintic pieces between knots that are evenly spaced in time.

    Attributes
    ----------
    knot_s: distance of the knots.
    knots: (knots, 3, columns): values, rates, accelerations.
    spans: when phases with a name last.
    """

    knot_s: float
    knots: Array
    spans: list[Span]


def motion_path(
    phases: Sequence[Phase], tree: SegmentTree, size: HandSize, rest_deg: Mapping[str, float],
    rng: np.random.Generator, knot_s: float, rest_sd_deg: float = 0.0,
) -> MotionPath:
    """The path of a script. Raises InputError for unknown freedoms and contacts out of reach.

    Parameters
    ----------
    tree: the hand that moves, as it is.
    size: of its fingertips.
    rest_deg: the posture at t = 0, by freedom; others are 0.
    rng: where cycles vary and phases of sway and play come from.
    knot_s: distance of the knots.
    rest_sd_deg: sd by which every angle of the posture at t = 0 is missed.
    """
    rest = _posture(tree, rest_deg, np.zeros(len(tree.ranges)))
    if rest_sd_deg:
        rest += math.radians(rest_sd_deg) * rng.standard_normal(rest.size)
    writer = _Writer(tree, size, rest, rng)
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
    return MotionPath(knot_s, knots, writer.spans)


def _fill(columns: Array, times: Array, pieces: Sequence[Piece]) -> None:
    for start, stop, course in pieces:
        first, last = np.searchsorted(times, [start, stop])
        if last > first:
            columns[first:last] = course(times[first:last] - start)


def _posture(tree: SegmentTree, degrees: Mapping[str, float], others: Array) -> Array:
    """Angles (d,), rad: those named, `others` where not."""
    angles = others.copy()
    for name, angle in degrees.items():
        angles[tree.freedom(name)] = math.radians(angle)
    return angles


def _rise(s: Array) -> Array:
    """Minimum-jerk rise from 0 to 1 on [0, 1], still outside, (m, 1)."""
    s = np.clip(s, 0.0, 1.0)[:, np.newaxis]
    return np.asarray(s ** 3 * (10.0 + s * (6.0 * s - 15.0)))


@dataclass(slots=True)
class _Writer:
    """Appends phase after phase; `now` is the posture in which the last one ended."""

    tree: SegmentTree
    size: HandSize
    now: Array
    rng: np.random.Generator
    rest: Array = field(init=False)
    time: float = 0.0
    fingers: list[Piece] = field(default_factory=list)
    arm: list[Piece] = field(default_factory=list)
    spans: list[Span] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.rest = self.now.copy()

    def add(self, phase: Phase) -> None:
        """One more phase."""
        begin = self.time
        if phase.contacts:
            self._touch(phase)
        elif phase.cycles:
            self._repeat(phase)
        else:
            self._go(_posture(self.tree, phase.posture_deg, self.rest if phase.to_rest else self.now),
                     phase.duration_s)
        if phase.name and not phase.contacts:
            self.spans.append(Span(phase.name, begin, self.time))
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
        """Cycles from the posture of now and back to it; together they last as long as declared."""
        far = _posture(self.tree, phase.posture_deg, self.now) - self.now
        shares = np.clip(1.0 + phase.vary * self.rng.standard_normal(phase.cycles), 0.4, 1.6)
        sizes = np.clip(1.0 + phase.vary * self.rng.standard_normal(phase.cycles), 0.4, 1.6)
        durations = phase.length_s * shares / shares.sum()
        if phase.circle:
            first = self.tree.freedom(next(iter(phase.posture_deg)))
            self._append(phase.length_s, _circles(self.now, far, first, phase.length_s, phase.cycles))
            return
        for duration, size in zip(durations, sizes, strict=True):
            stay = phase.stay_s * duration / phase.duration_s
            self._append(duration, _there_and_back(self.now, size * far, duration, stay))

    def _touch(self, phase: Phase) -> None:
        """Take up the contacts, hold them and, with cycles, let go again."""
        solver = ContactSolver(self.tree, self.size, phase.contacts)
        away = self.now
        preferred = _posture(self.tree, phase.posture_deg, away)
        for _ in range(max(1, phase.cycles)):
            course = _held(solver, preferred, phase, self.rng)
            self._go(course(np.zeros(1))[0], phase.approach_s)
            self.spans.append(Span(phase.name, self.time, self.time + phase.duration_s))
            self._append(phase.duration_s, course)
            self.now = course(np.array([phase.duration_s]))[0]
            if phase.cycles:
                self._go(away, phase.approach_s)


def _there_and_back(start: Array, far: Array, duration: float, stay: float) -> Course:
    """From `start` by `far` and back on minimum-jerk paths, standing still for `stay` at either end."""
    going = 0.5 * duration - stay

    def course(t: Array) -> Array:
        share = _rise(t / going) - _rise((t - going - stay) / going)
        return np.asarray(start + share * far)

    return course


def _circles(start: Array, far: Array, first: int, duration: float, cycles: int) -> Course:
    """Around `start` in quadrature, faded in and out over half a cycle."""
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
    """Two sinusoids a column, the second of half the amplitude and 1.6 times as fast, phases random."""
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


def _held(solver: ContactSolver, preferred: Array, phase: Phase, rng: np.random.Generator) -> Course:
    """Postures in which the contacts hold while the preferred posture plays, as a spline of keyframes."""
    count = max(4, 1 + math.ceil(phase.duration_s / _KEYFRAME_S))
    times: Array = np.linspace(0.0, phase.duration_s, count, dtype=np.float64)
    play = np.zeros(preferred.size)
    play[solver.freedoms] = math.radians(phase.play_deg)
    wanted = preferred + _faded(times, phase.duration_s, _FADE_S) * _sines(rng, play, _PLAY_PERIOD_S)(times)
    rows, angles = [], preferred
    for row in wanted:
        angles = solver.solve(row, angles)
        rows.append(angles)
    return CubicSpline(times, np.stack(rows), bc_type="clamped")
