"""`moving_hand`: a hand that follows a script exactly, for experiments on trackers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.hand.segments import Segment, SegmentTree
from fesloop.hand.skeleton import dorsal_points, hand_tree
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS, duration_ns
from fesloop.loop.noise import stream_key
from fesloop.loop.signals import Port, Value
from plants.moving_hand.anatomy import Deviation, person
from plants.moving_hand.kernels import observe_rows
from plants.moving_hand.path import MotionPath, motion_path
from plants.moving_hand.script import Phase, length_s
from plants.moving_hand.scripts import MotionScript, script

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
_LEFT_PALM_DOWN = (math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0)
_RIGHT_PALM_DOWN = (0.0, math.sqrt(0.5), 0.0, -math.sqrt(0.5))
"""Forearm to global, palm down, fingers to the north: x up and y north, or x down and y south."""


class Wearer(NamedTuple):
    """The hand of this run.

    Attributes
    ----------
    tree: its segments behind a room, to which the forearm is joined by a ball.
    segments, places: (17,) and (17, 3), of the sites. tips: (5,), segments of the fingertips.
    """

    tree: SegmentTree
    segments: Numbers
    places: Array
    tips: Numbers


@dataclass(slots=True, eq=False)
class MovingHandState:
    """Where the hand is on its path.

    Attributes
    ----------
    wearer: whose hand it is. path: of this trial; neither is ever written to.
    time_ns: now.
    """

    wearer: Wearer
    path: MotionPath
    time_ns: int = 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MovingHand:
    """A hand that moves as a script says, whatever forces that takes: exact at any instant.

    It is one person's: `deviation` draws lengths and joint axes for a run, the same in its every trial;
    what varies in the script is drawn for each trial. Trackers are told `hand`.

    Outputs: `angles`, `rates`, `accelerations` (23,), rad and s, in the order of the hand's freedoms
    (`fesloop.hand.skeleton`; a person's are about their own tilted axes); `fingertips` (5, 3), m, bone ends
    in the wrist coordinate system; and of 17 sites on the back of the segments `site_orientation` (17, 4), to
    the global frame, `site_position` (17, 3), m, global, `site_rate` (17, 3), rad/s, and `site_force`
    (17, 3), m/s^2, angular velocity and specific force in the segments' frames.

    Attributes
    ----------
    hand: the hand as it is measured.
    deviation: how this person differs from it.
    script: name of a script (`plants.moving_hand.scripts`), or empty.
    phases: a script of one's own; afterwards the hand stands still.
    rest_deg: posture at the start of it, by freedom; others are 0.
    rest_sd_deg: sd by which this person misses each angle of it, anew in each trial.
    forearm_orientation: (w, x, y, z), of the wrist coordinate system to the global frame (ENU) without
        sway; empty: palm down, fingers to the north.
    knot_ms: the path is a quintic spline with knots at this distance.
    """

    hand: HandSize = field(default_factory=HandSize)
    deviation: Deviation = field(default_factory=Deviation)
    script: str = ""
    phases: tuple[Phase, ...] = ()
    rest_deg: dict[str, float] = field(default_factory=dict)
    rest_sd_deg: float = 0.0
    forearm_orientation: tuple[float, ...] = ()
    knot_ms: float = 20.0

    def __post_init__(self) -> None:
        if bool(self.script) == bool(self.phases):
            found = f"{len(self.phases)} beside script {self.script!r}" if self.script else "none"
            raise InputError("phases", found, "phases, or the name of a script")
        if self.script and self.rest_deg:
            raise InputError("rest_deg", "given beside a script", "none: the script has its own")
        if not 1.0 <= self.knot_ms <= 1000.0:
            raise InputError("knot_ms", f"{self.knot_ms}", "1 to 1000 ms")
        if not 0.0 <= self.rest_sd_deg <= 30.0:
            raise InputError("rest_sd_deg", f"{self.rest_sd_deg}", "0 to 30 deg")
        q = self.forearm_orientation
        if q and (len(q) != 4 or abs(math.hypot(*q) - 1.0) > 1e-6):
            raise InputError("forearm_orientation", f"{q}", "a quaternion (w, x, y, z) of length 1, or empty")
        tree, told = hand_tree(self.hand), self._told()
        for name in (*told.rest_deg, *(name for phase in told.phases for name in phase.posture_deg)):
            tree.freedom(name)
        if self.length_s > 24 * 3600.0:
            raise InputError("phases", f"last {self.length_s:g} s", "a day at most")

    @property
    def length_s(self) -> float:
        """How long the script lasts, s."""
        return length_s(self._told().phases)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """None: nothing moves it but its script."""
        return ()

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Posture, fingertips, and what the sites go through."""
        return (Port("angles", (23,), "rad"), Port("rates", (23,), "rad/s"),
                Port("accelerations", (23,), "rad/s^2"), Port("fingertips", (5, 3), "m"),
                Port("site_orientation", (17, 4), "1", (1.0, 0.0, 0.0, 0.0)),
                Port("site_position", (17, 3), "m"), Port("site_rate", (17, 3), "rad/s"),
                Port("site_force", (17, 3), "m/s^2", (0.0, 0.0, STANDARD_GRAVITY)))

    @property
    def grid(self) -> None:
        """None: exact at any instant."""
        return

    @property
    def feedthrough(self) -> bool:
        """False: there are no inputs."""
        return False

    def wearer(self, seed: int, name: str) -> Wearer:
        """The person of a run, drawn from its seed and this node's name."""
        nominal = hand_tree(self.hand)
        rng = _drawn_from(stream_key(seed, f"{name}/person", 0))
        own = person(nominal, self.deviation, rng)
        forearm = Segment(name="forearm", parent="room", joint="ball", joint_name="arm")
        tree = SegmentTree((Segment(name="room"), forearm, *own.segments[1:]))
        tips = [tree.index(f"F{i}d") for i in range(1, 6)]
        return Wearer(tree, np.arange(1, 18), dorsal_points(self.hand), np.array(tips))

    def path(self, seed: int, name: str, trial: int = 0) -> MotionPath:
        """The path of a trial. Raises InputError for contacts that this person does not reach."""
        own = SegmentTree((Segment(name="forearm"), *self.wearer(seed, name).tree.segments[2:]))
        rng = _drawn_from(stream_key(seed, f"{name}/path", trial))
        told = self._told()
        return motion_path(told.phases, own, self.hand, told.rest_deg, rng, 1e-3 * self.knot_ms,
                           self.rest_sd_deg)

    def init(self, context: Context) -> MovingHandState:
        """At the beginning of the script."""
        return MovingHandState(self.wearer(context.seed, context.name),
                               self.path(context.seed, context.name, context.trial))

    def next_trial(self, state: MovingHandState, context: Context) -> MovingHandState:
        """The same person at the beginning of another trial."""
        return MovingHandState(state.wearer, self.path(context.seed, context.name, context.trial))

    def advance(self, state: MovingHandState, inputs: Sequence[Value], start_ns: int, stop_ns: int) -> None:
        """To `stop_ns`."""
        state.time_ns = stop_ns

    def read(self, state: MovingHandState, inputs: Sequence[Value]) -> tuple[Value, ...]:
        """All outputs now."""
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

    def _told(self) -> MotionScript:
        if self.script:
            return script(self.script)
        return MotionScript(phases=self.phases, rest_deg=self.rest_deg)

    def _room(self) -> Array:
        usual = _LEFT_PALM_DOWN if self.hand.side == "left" else _RIGHT_PALM_DOWN
        return np.array(self.forearm_orientation or usual)


def _drawn_from(key: int) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(key=key))
