"""`moving_hand`: a hand that follows a script exactly, for experiments on trackers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.hand.anthropometry import FINGERS, HandSize
from fesloop.hand.kinematics_kernels import forward, turned
from fesloop.hand.motion import STANDARD_GRAVITY, motions, sense
from fesloop.hand.movements import FREEDOMS, SEGMENTS
from fesloop.hand.quaternion_kernels import conjugate, multiply
from fesloop.hand.segments import Segment, SegmentTree
from fesloop.hand.skeleton import dorsal_points, hand_tree
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS, duration_ns
from fesloop.loop.noise import stream_key
from fesloop.loop.signals import Port, Value
from plants.moving_hand.path import MotionPath, Span, motion_path, spans_of
from plants.moving_hand.recorded import RecordedAngles, recorded_path
from plants.moving_hand.script import Phase, length_s
from plants.moving_hand.scripts import MotionScript, script

Array = NDArray[np.float64]


Numbers = NDArray[np.int64]
_AT_REFERENCE = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])


@compiled
def follow(knots: Array, knot_ns: int, time_ns: int, columns: Array) -> None:
    """Fill `columns` (3, c) with value, rate, acceleration of quintic pieces at an instant.

    `knots` (k, 3, c) are the same at the knots, in s. After the last one the path is constant.
    """
    last = knots.shape[0] - 1
    k = min(time_ns // knot_ns, last)
    if k == last:
        columns[0] = knots[last, 0]
        columns[1:] = 0.0
        return
    h = 1e-9 * knot_ns
    u = (time_ns - k * knot_ns) / knot_ns
    for c in range(knots.shape[2]):
        q0, v0, a0 = knots[k, 0, c], h * knots[k, 1, c], h * h * knots[k, 2, c]
        gap = knots[k + 1, 0, c] - q0 - v0 - 0.5 * a0
        slope = h * knots[k + 1, 1, c] - v0 - a0
        bend = h * h * knots[k + 1, 2, c] - a0
        c3 = 10.0 * gap - 4.0 * slope + 0.5 * bend
        c4 = -15.0 * gap + 7.0 * slope - bend
        c5 = 6.0 * gap - 3.0 * slope + 0.5 * bend
        columns[0, c] = q0 + u * (v0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5))))
        columns[1, c] = (v0 + u * (a0 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h
        columns[2, c] = (a0 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / (h * h)


@compiled
def observe_rows(
    layout: Numbers, geometry: Array, knots: Array, knot_ns: int, room: Array, segments: Numbers,
    places: Array, tips: Numbers, times_ns: Numbers, postures: Array, fingertips: Array, orientations: Array,
    positions: Array, samples: Array,
) -> None:
    """Fill the outputs at each of `times_ns` (t,).

    Parameters
    ----------
    layout, geometry: tree whose segments 0 and 1 are room and forearm, joined by a ball.
    room: (4,), orientation of the room's frame, in which the forearm's rotation is 0, to the global one.
    segments, places: (m,) and (m, 3), segments and places of the sites. tips: (f,), segments of the
        fingertips.
    postures: (t, 3, d), angles, rates, accelerations of the hand's freedoms.
    fingertips: (t, f, 3), m, in the forearm's frame.
    orientations, positions: (t, m, 4) and (t, m, 3), m, poses of the sites to and in the global frame.
    samples: (t, 2, m, 3), angular velocity and specific force in the segments' frames.
    """
    count, wide = layout.shape[0], knots.shape[2]
    columns, poses = np.empty((3, wide)), np.empty((count, 7))
    chain, work, root = np.empty((count, 3, 3)), np.empty((3, 3)), np.zeros((3, 3))
    to_global = (room[0], room[1], room[2], room[3])
    for t in range(times_ns.size):
        follow(knots, knot_ns, times_ns[t], columns)
        moving = columns[:, :wide - 3]
        root[2, 0], root[2, 1], root[2, 2] = turned(
            conjugate(to_global), columns[2, wide - 3], columns[2, wide - 2],
            columns[2, wide - 1] + STANDARD_GRAVITY)
        motions(layout, geometry, moving[0], moving[1], moving[2], root, chain)
        sense(chain, segments, places, work, samples[t])
        forward(layout, geometry, moving[0], _AT_REFERENCE, poses)
        postures[t] = moving[:, 3:]
        _place_sites(poses, to_global, columns[0, wide - 3:], segments, places, orientations[t], positions[t])
        wrist = poses[1]
        back = conjugate((wrist[0], wrist[1], wrist[2], wrist[3]))
        for i in range(tips.size):
            tip = poses[tips[i]]
            fingertips[t, i, 0], fingertips[t, i, 1], fingertips[t, i, 2] = turned(
                back, tip[4] - wrist[4], tip[5] - wrist[5], tip[6] - wrist[6])


@compiled
def _place_sites(
    poses: Array, to_global: tuple[float, float, float, float], shift: Array, segments: Numbers,
    places: Array, orientations: Array, positions: Array
) -> None:
    for i in range(segments.size):
        pose, place = poses[segments[i]], places[i]
        q = (pose[0], pose[1], pose[2], pose[3])
        whole = multiply(to_global, q)
        size = 1.0 / math.sqrt(whole[0] ** 2 + whole[1] ** 2 + whole[2] ** 2 + whole[3] ** 2)
        for j in range(4):
            orientations[i, j] = size * whole[j]
        x, y, z = turned(q, place[0], place[1], place[2])
        x, y, z = turned(to_global, pose[4] + x, pose[5] + y, pose[6] + z)
        positions[i, 0], positions[i, 1], positions[i, 2] = x + shift[0], y + shift[1], z + shift[2]


_LEFT_PALM_DOWN = (math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0)
_RIGHT_PALM_DOWN = (0.0, math.sqrt(0.5), 0.0, -math.sqrt(0.5))
"""Orientation from forearm to global frame, palm down, fingers to the north: x up and y north, or x down and
y south."""


class Wearer(NamedTuple):
    """The hand of a run.

    Attributes
    ----------
    tree: its segments after a room, to which the forearm is joined by a ball.
    segments, places: (17,) and (17, 3), segments and places of the sites. tips: (5,), segments of the
        fingertips.
    """

    tree: SegmentTree
    segments: Numbers
    places: Array
    tips: Numbers


@lru_cache(maxsize=4)
def _path(plant: MovingHand, key: int) -> MotionPath:
    """Path by a random key; kept, as a rehearsal and the run need the same."""
    if plant.recorded is not None:
        tree, generator = hand_tree(plant.hand), _generator(key)
        rest = np.zeros(len(tree.freedoms))
        for name, angle in plant.posture_at_start().items():
            rest[tree.freedom(name)] = math.radians(angle)
        rest += math.radians(plant.rest_sd_deg) * generator.standard_normal(rest.size)
        return recorded_path(plant.recorded, tree, rest, 1e-3 * plant.knot_ms)
    return motion_path(plant.chosen_script().phases, hand_tree(plant.hand), plant.hand,
                       plant.posture_at_start(), _generator(key), 1e-3 * plant.knot_ms, plant.rest_sd_deg,
                       plant.repeat_sd_deg)


@dataclass(slots=True, eq=False)
class MovingHandState:
    """State of the moving hand.

    Attributes
    ----------
    wearer: the hand. path: path of this trial. Neither is written to.
    time_ns: instant of the state.
    """

    wearer: Wearer
    path: MotionPath
    time_ns: int = 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MovingHand:
    """A hand that moves exactly along a script, whatever the forces; exact at any instant.

    The hand is one person's, the same in every trial; variation in the script is random by trial.

    Outputs: `angles`, `rates`, `accelerations` (23,), rad and s, in the order of the hand's freedoms
    (`fesloop.hand.skeleton`; a person's are about their own tilted axes); `fingertips` (5, 3), m, bone ends
    in the wrist coordinate system; and of 17 sites on the back of the segments `site_orientation` (17, 4), to
    the global frame, `site_position` (17, 3), m, global, `site_rate` (17, 3), rad/s, and `site_force`
    (17, 3), m/s^2, angular velocity and specific force in the segments' frames.

    Attributes
    ----------
    hand: the hand itself, with its own lengths and joint axes.
    script: name of a script (`plants.moving_hand.scripts`), or empty.
    phases: a script of one's own; after it the hand does not move.
    recorded: joint angles of a file, in place of a script.
    rest_deg: posture at its start, by freedom; others are 0.
    pose_error_deg: error of the posture at the start, by freedom, the same in every trial.
    rest_sd_deg: sd of the error of each angle at the start, random by trial.
    repeat_sd_deg: sd of each angle of a posture whenever a cycle returns to it, after a pause.
    forearm_orientation: (w, x, y, z), from the wrist coordinate system to the global frame (ENU) without
        sway; empty: palm down, fingers to the north.
    knot_ms: interval between knots of the path, a quintic spline.
    """

    hand: HandSize = field(default_factory=HandSize)
    script: str = ""
    phases: tuple[Phase, ...] = ()
    recorded: RecordedAngles | None = None
    rest_deg: dict[str, float] = field(default_factory=dict)
    pose_error_deg: dict[str, float] = field(default_factory=dict)
    rest_sd_deg: float = 0.0
    repeat_sd_deg: float = 0.0
    forearm_orientation: tuple[float, ...] = ()
    knot_ms: float = 20.0

    def __post_init__(self) -> None:
        if bool(self.script) + bool(self.phases) + (self.recorded is not None) != 1:
            stated = [name for name in ("script", "phases", "recorded") if getattr(self, name)]
            raise InputError("phases", " and ".join(stated) + " are given" if stated else "none",
                             "phases, the name of a script, or recorded angles")
        if self.recorded is not None and self.repeat_sd_deg:
            raise InputError("repeat_sd_deg", "is given with recorded angles", "none: they do not repeat")
        if self.script and self.rest_deg:
            raise InputError("rest_deg", "is given with a script", "none: the script has its own")
        if not 1.0 <= self.knot_ms <= 1000.0:
            raise InputError("knot_ms", f"{self.knot_ms}", "1 to 1000 ms")
        for name in ("rest_sd_deg", "repeat_sd_deg"):
            if not 0.0 <= getattr(self, name) <= 30.0:
                raise InputError(name, f"{getattr(self, name)}", "0 to 30 deg")
        for name, error in self.pose_error_deg.items():
            if not abs(error) <= 60.0:
                raise InputError(f"pose_error_deg.{name}", f"{error}", "-60 to 60 deg")
        q = self.forearm_orientation
        if q and (len(q) != 4 or abs(math.hypot(*q) - 1.0) > 1e-6):
            raise InputError("forearm_orientation", f"{q}", "a quaternion (w, x, y, z) of length 1, or empty")
        tree, chosen = hand_tree(self.hand), self.chosen_script()
        for name in (*self.pose_error_deg, *chosen.rest_deg,
                     *(name for phase in chosen.phases for name in phase.posture_deg)):
            tree.freedom(name)
        if self.length_s > 24 * 3600.0:
            raise InputError("phases", f"last {self.length_s:g} s", "a day at most")

    @property
    def length_s(self) -> float:
        """Duration of the script, or of the recorded movement, s."""
        if self.recorded is not None:
            return self.recorded.length_s
        return length_s(self.chosen_script().phases)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """None: only the script moves the hand."""
        return ()

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Posture, fingertips, and kinematics of the sites."""
        return (Port("angles", (23,), "rad", rows=FREEDOMS), Port("rates", (23,), "rad/s", rows=FREEDOMS),
                Port("accelerations", (23,), "rad/s^2", rows=FREEDOMS),
                Port("fingertips", (5, 3), "m", rows=FINGERS),
                Port("site_orientation", (17, 4), "1", (1.0, 0.0, 0.0, 0.0), rows=SEGMENTS),
                Port("site_position", (17, 3), "m", rows=SEGMENTS),
                Port("site_rate", (17, 3), "rad/s", rows=SEGMENTS),
                Port("site_force", (17, 3), "m/s^2", (0.0, 0.0, STANDARD_GRAVITY), rows=SEGMENTS))

    @property
    def grid(self) -> None:
        """None: exact at any instant."""
        return

    @property
    def feedthrough(self) -> bool:
        """False: there are no inputs."""
        return False

    @property
    def wearer(self) -> Wearer:
        """The hand, as segments after a room."""
        forearm = Segment(name="forearm", parent="room", joint="ball", joint_name="arm")
        tree = SegmentTree((Segment(name="room"), forearm, *hand_tree(self.hand).segments[1:]))
        tips = [tree.index(f"F{i}d") for i in range(1, 6)]
        return Wearer(tree, np.arange(1, 18), dorsal_points(self.hand), np.array(tips))

    def path(self, seed: int, name: str, trial: int = 0) -> MotionPath:
        """Path of a trial; InputError for contacts out of this person's reach."""
        return _path(self, stream_key(seed, f"{name}/path", trial))

    @property
    def spans(self) -> list[Span]:
        """Named phases of the script."""
        return spans_of(self.chosen_script().phases)

    def posture_at_start(self) -> dict[str, float]:
        """Posture of the script at its start with the error of the pose, deg, by freedom; others are 0."""
        rest = self.chosen_script().rest_deg
        return {each: rest.get(each, 0.0) + self.pose_error_deg.get(each, 0.0)
                for each in {**rest, **self.pose_error_deg}}

    def init(self, context: Context) -> MovingHandState:
        """State at the start of the script."""
        return MovingHandState(self.wearer, self.path(context.seed, context.name, context.trial))

    def next_trial(self, state: MovingHandState, context: Context) -> MovingHandState:
        """State of the same person at the start of another trial."""
        return MovingHandState(state.wearer, self.path(context.seed, context.name, context.trial))

    def advance(self, state: MovingHandState, inputs: Sequence[Value], start_ns: int, stop_ns: int) -> None:
        """Set the instant."""
        state.time_ns = stop_ns

    def read(self, state: MovingHandState, inputs: Sequence[Value]) -> tuple[Value, ...]:
        """All outputs at this instant."""
        return tuple(rows[0] for rows in self.observe(state, inputs, state.time_ns, (state.time_ns,)))

    def observe(
        self, state: MovingHandState, inputs: Sequence[Value], start_ns: int, times_ns: Sequence[int]
    ) -> tuple[Array, ...]:
        """All outputs at `times_ns`."""
        count, wearer = len(times_ns), state.wearer
        postures, fingertips = np.empty((count, 3, 23)), np.empty((count, 5, 3))
        orientations, positions = np.empty((count, 17, 4)), np.empty((count, 17, 3))
        samples = np.empty((count, 2, 17, 3))
        observe_rows(
            wearer.tree.layout, wearer.tree.geometry, state.path.knots,
            duration_ns(self.knot_ms, NS_PER_MS, "knot_ms"), self._room(), wearer.segments, wearer.places,
            wearer.tips, np.array(times_ns, dtype=np.int64), postures, fingertips, orientations, positions,
            samples)
        return (postures[:, 0], postures[:, 1], postures[:, 2], fingertips, orientations, positions,
                samples[:, 0], samples[:, 1])

    def chosen_script(self) -> MotionScript:
        """Phases, and the posture at their start without error."""
        if self.script:
            return script(self.script)
        return MotionScript(phases=self.phases, rest_deg=self.rest_deg)

    def _room(self) -> Array:
        usual = _LEFT_PALM_DOWN if self.hand.side == "left" else _RIGHT_PALM_DOWN
        return np.array(self.forearm_orientation or usual)


def _generator(key: int) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(key=key))
