"""What every hand plant takes and puts out, and how it goes on from step to step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, Protocol, cast

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError, RunError
from fesloop.hand import quaternion
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.hand.movements import MUSCLES
from fesloop.hand.segments import AXES, MOTIONS
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.signals import Port, Value
from plants.checks import require_not_negative, require_positive
from plants.hand.model import OBJECT, SKIN_SOLIMP, SKIN_SOLREF, TABLE, TOUCHES

Array = NDArray[np.float64]
Shape = Literal["cylinder", "block", "ball", "card"]
SIZES: dict[Shape, tuple[str, ...]] = {
    "cylinder": ("diameter", "height"), "block": ("x", "y", "z"), "ball": ("diameter",),
    "card": ("width", "length", "thickness")}
"""What `size_mm` lists of each shape."""
_GEOMS = {"cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER, "block": mujoco.mjtGeom.mjGEOM_BOX,
          "ball": mujoco.mjtGeom.mjGEOM_SPHERE, "card": mujoco.mjtGeom.mjGEOM_BOX}
TORSIONAL_M, ROLLING_M = 0.005, 0.0001
"""Friction against twisting and rolling over that against sliding, m: chosen, a fingertip's patch of contact
is some 5 mm wide; MuJoCo's default for rolling."""
HARD_SOLREF = [0.005, 1.0]
"""Of object and table: back from each other within 5 ms, critically damped (chosen: five steps of 1 ms)."""
_GEOM = mujoco.mjtObj.mjOBJ_GEOM
OVERLAP_M = 0.001
"""Chosen: object, skin and table may be pressed this far into each other at the start."""


def _places(step_m: float, reach_m: float) -> Array:
    """Places on the level around 0, (n, 3), m, the nearest first."""
    side = np.arange(-reach_m, reach_m + 0.5 * step_m, step_m)
    grid = np.stack([*np.meshgrid(side, side, indexing="ij"), np.zeros((side.size, side.size))], axis=-1)
    places = grid.reshape(-1, 3)
    far = np.linalg.norm(places, axis=1)
    near = places[np.argsort(far, kind="stable")]
    return np.asarray(near[np.sort(far) <= reach_m + 1e-9])


_PLACES = _places(0.004, 0.02)
"""Where somebody who gives an object tries to put it (chosen: in steps of 4 mm, up to 2 cm off)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspObject:
    """A rigid object that lies, stands or floats free at the start, and falls where nothing holds it: to a
    table, or to a floor 100 m below the wrist.

    Attributes
    ----------
    shape: of it. size_mm: as `SIZES` lists it: cylinder (diameter, height), along its z; block (x, y, z);
        ball (diameter,); card (width, length, thickness), along its x, y, z.
    mass_kg: spread evenly.
    friction: coefficient against skin and table (skin on plastics .5 to 1; chosen).
    position_m: of its centre from the wrist's, global (ENU).
    orientation: (w, x, y, z), of its axes to the global ones.
    given_at_s: when somebody puts it there; before, it stands `waits_m` away. Where the hand is in the way it
        is put to the nearest place on the level that it fits into, at most 2 cm off, as soon as there is one.
    waits_m: place where it waits, from `position_m` (chosen: in front of the fingers, out of their reach).
    """

    shape: Shape = "cylinder"
    size_mm: tuple[float, ...] = (60.0, 120.0)
    mass_kg: float = 0.2
    friction: float = 0.8
    position_m: tuple[float, float, float] = (0.0, 0.1, -0.06)
    orientation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    given_at_s: float = 0.0
    waits_m: tuple[float, float, float] = (0.0, 0.25, 0.0)

    def __post_init__(self) -> None:
        if self.shape not in SIZES:
            raise InputError("object.shape", f"{self.shape!r}", ", ".join(SIZES))
        if len(self.size_mm) != len(SIZES[self.shape]):
            raise InputError("object.size_mm", f"{self.size_mm}", f"{', '.join(SIZES[self.shape])}, mm")
        require_positive("object", self, "size_mm", "mass_kg")
        require_not_negative("object", self, "friction", "given_at_s")
        for key in ("position_m", "waits_m"):
            if not np.isfinite(getattr(self, key)).all():
                raise InputError(f"object.{key}", f"{getattr(self, key)}", "three finite numbers, m")
        if not abs(math.hypot(*self.orientation) - 1.0) <= 1e-6:
            raise InputError("object.orientation", f"{self.orientation}",
                             "a quaternion (w, x, y, z) of length 1")

    @property
    def start_m(self) -> list[float]:
        """Where it is at the start, m."""
        off = self.waits_m if self.given_at_s > 0.0 else (0.0, 0.0, 0.0)
        return [at + by for at, by in zip(self.position_m, off, strict=True)]

    @property
    def half_sizes(self) -> list[float]:
        """As MuJoCo wants them, m."""
        sizes = [5e-4 * each for each in self.size_mm]
        return sizes + [0.0] * (3 - len(sizes))


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A level table top, 10 mm thick.

    Attributes
    ----------
    height_m: of its surface over the wrist's centre, negative below.
    centre_m: of the top from the wrist's centre, east and north. half_m: half its sides.
    friction: coefficient against skin; against an object that of the object counts.
    lowered_at_s: when it starts to sink; negative: never. lowering_m: how far, lowering_m_s: how fast.
    """

    height_m: float = -0.1
    centre_m: tuple[float, float] = (0.0, 0.1)
    half_m: tuple[float, float] = (0.3, 0.3)
    friction: float = 0.5
    lowered_at_s: float = -1.0
    lowering_m: float = 0.2
    lowering_m_s: float = 0.1

    def __post_init__(self) -> None:
        require_positive("table", self, "half_m", "lowering_m", "lowering_m_s")
        require_not_negative("table", self, "friction")
        if not np.isfinite((self.height_m, *self.centre_m, self.lowered_at_s)).all():
            raise InputError("table", "a place or time that is not finite", "finite numbers")

    def drop(self, time_ns: int) -> float:
        """How far it has sunk, m."""
        since = time_ns / NS_PER_S - self.lowered_at_s
        if self.lowered_at_s < 0.0 or since <= 0.0:
            return 0.0
        return min(self.lowering_m, since * self.lowering_m_s)


def add_object(spec: mujoco.MjSpec, thing: GraspObject) -> None:
    """Add the object, its body and geom named `object`, behind all that is there."""
    body = spec.worldbody.add_body(name="object", pos=thing.start_m, quat=thing.orientation)
    body.add_freejoint(name="object")
    # condim 4: a contact also resists twisting.
    body.add_geom(name="object", type=_GEOMS[thing.shape], size=thing.half_sizes, mass=thing.mass_kg,
                  condim=4, priority=1, friction=[thing.friction, thing.friction * TORSIONAL_M, ROLLING_M],
                  solref=SKIN_SOLREF, solimp=SKIN_SOLIMP, contype=OBJECT, conaffinity=TOUCHES[OBJECT])


def add_table(spec: mujoco.MjSpec, table: Table) -> None:
    """Add the table, moved by `mocap_pos` alone, behind the object, if there is one."""
    body = spec.worldbody.add_body(name="table", mocap=True, pos=[*table.centre_m, table.height_m - 0.005])
    body.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_BOX, size=[*table.half_m, 0.005],
                  friction=[table.friction, TORSIONAL_M * table.friction, ROLLING_M], contype=TABLE,
                  conaffinity=TOUCHES[TABLE])
    thing = spec.geom("object")
    if thing is not None:
        # Between the two there is no skin.
        slide, twist, roll = thing.friction
        spec.add_pair(geomname1="object", geomname2="table", condim=4, solref=HARD_SOLREF,
                      friction=[slide, slide, twist, roll, roll])


def deepest(model: mujoco.MjModel, data: mujoco.MjData, names: Sequence[str]) -> tuple[float, list[str]]:
    """The deepest contact of any of the geoms named: its distance, m, negative inside, and both names."""
    pairs, distances = data.contact.geom, data.contact.dist
    known = [model.geom(name).id for name in names if mujoco.mj_name2id(model, _GEOM, name) >= 0]
    theirs = np.flatnonzero(np.isin(pairs, known).any(axis=1))
    if not theirs.size:
        return math.inf, []
    found = int(theirs[np.argmin(distances[theirs])])
    return float(distances[found]), [model.geom(int(geom)).name for geom in pairs[found]]


def give(model: mujoco.MjModel, thing: GraspObject, data: mujoco.MjData) -> bool:
    """Put the object, MuJoCo's last joint, where it is to be grasped; False where the hand leaves no room."""
    before = data.qpos[-7:].copy(), data.qvel[-6:].copy()
    data.qvel[-6:] = 0.0
    for off in _PLACES:
        data.qpos[-7:] = (*(np.array(thing.position_m) + off), *thing.orientation)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        if deepest(model, data, ("object",))[0] >= -OVERLAP_M:
            return True
    data.qpos[-7:], data.qvel[-6:] = before
    return False


def require_apart(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Raise InputError for an object that is inside the hand or the table, or a table inside the hand."""
    mujoco.mj_forward(model, data)
    distance, names = deepest(model, data, ("object", "table"))
    if distance < -OVERLAP_M:
        thing = "object" if "object" in names else "table"
        other = names[1 - names.index(thing)]
        raise InputError(f"hand.{thing}", f"reaches {-1e3 * distance:.1f} mm into {other} at the start",
                         f"{1e3 * OVERLAP_M:g} mm at most", "move it, or the hand")


UNSTABLE_RAD_S = 1000.0
"""Chosen: above what joints do (snapping fingers, 140 rad/s: Acharya 2021, doi 10.1098/rsif.2021.0672); of an
object also m/s."""
BEYOND_RAD = math.radians(60.0)
"""Chosen: as far beyond its range no joint is. Full force, all at once, flings one there by up to 45 deg for
some milliseconds, and a quarter as far with a tenth of the usual step."""


_POSITION_AND_VELOCITY, _NOTHING = mujoco.mjtStage.mjSTAGE_VEL, mujoco.mjtStage.mjSTAGE_NONE


class Views(NamedTuple):
    """MuJoCo's own memory, as its data name it: to ask the data for an array costs as much as to use it."""

    ctrl: Array
    qpos: Array
    qvel: Array
    qacc: Array
    qacc_warmstart: Array
    mocap_pos: Array
    xpos: Array
    xquat: Array
    xmat: Array
    site_xpos: Array
    sensordata: Array


@dataclass(slots=True, eq=False)
class HandState:
    """Where the hand is.

    Attributes
    ----------
    data: MuJoCo's, of the instant `time_ns`; it copies and pickles with all that it holds.
    time_ns: now.
    evaluated: whether all that follows from position and velocity has been computed for now.
    forearm: the orientation that its drive was last told; None before.
    given: whether the object, if any, is where it is to be grasped.
    views: into the data; made anew for a copy's own.
    """

    data: mujoco.MjData
    time_ns: int = 0
    evaluated: bool = False
    forearm: Array | None = None
    given: bool = True
    views: Views = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.views = Views(*(getattr(self.data, name) for name in Views._fields))

    def __getstate__(self) -> tuple[Any, ...]:
        return self.data, self.time_ns, self.evaluated, self.forearm, self.given

    def __setstate__(self, saved: tuple[Any, ...]) -> None:
        self.data, self.time_ns, self.evaluated, self.forearm, self.given = saved
        self.__post_init__()


def evaluate(model: mujoco.MjModel, state: HandState) -> None:
    """Compute accelerations and sensors of now, under the activation of the step that led here."""
    if state.evaluated:
        return
    # The solver starts from the last step's answer: with another's it would end a last bit elsewhere.
    start = state.views.qacc_warmstart.copy()
    mujoco.mj_forward(model, state.data)
    state.views.qacc_warmstart[:] = start
    state.evaluated = True


def step(model: mujoco.MjModel, state: HandState) -> None:
    """One fixed step under the activation that stands in the data: `mj_step` without sensors."""
    mujoco.mj_forwardSkip(model, state.data, _POSITION_AND_VELOCITY if state.evaluated else _NOTHING, 1)
    mujoco.mj_implicit(model, state.data)
    state.evaluated = False


@compiled
def find_unstable(angles: Array, speeds: Array, low: Array, high: Array) -> int:
    """Number of the fastest freedom if it is too fast, or of the first hinge outside its bounds; -1: none.

    `angles` (positions,) holds the hinges first, `speeds` (v,), `low` and `high` (hinges,).
    """
    fastest, found = UNSTABLE_RAD_S, -1
    for i in range(speeds.size):
        if math.isnan(speeds[i]):
            return i
        if abs(speeds[i]) >= fastest:
            fastest, found = abs(speeds[i]), i
    if found >= 0:
        return found
    for i in range(low.size):
        if not low[i] < angles[i] < high[i]:
            return i
    return -1


def stable_bounds(model: mujoco.MjModel) -> tuple[Array, Array]:
    """Least and greatest angle of each hinge, (h,) each, rad, that a stable simulation stays within."""
    hinges = model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE
    reach = np.where(model.jnt_limited[hinges] > 0, BEYOND_RAD, np.inf)
    low, high = model.jnt_range[hinges].T
    return low - reach, high + reach


def require_stable(model: mujoco.MjModel, bounds: tuple[Array, Array], state: HandState) -> None:
    """Raise RunError, naming the joint, where the hand moves as no hand does; `bounds`: `stable_bounds`."""
    angles, speeds = state.views.qpos, state.views.qvel
    worst = find_unstable(angles, speeds, bounds[0], bounds[1])
    if worst < 0:
        return
    name = model.joint(int(model.dof_jntid[worst])).name
    told = f"moves at {abs(speeds[worst]):.3g} rad/s or m/s"
    if abs(speeds[worst]) < UNSTABLE_RAD_S:
        told = f"is at {math.degrees(angles[worst]):.3g} deg, far beyond its range"
    raise RunError(f"hand became unstable at {state.time_ns / NS_PER_MS:g} ms: {name} {told}; take a smaller "
                   "step_ms, or weaker muscles and springs")


PALM_DOWN = {"left": (math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0),
             "right": (0.0, math.sqrt(0.5), 0.0, -math.sqrt(0.5))}
"""By side, (w, x, y, z) of the forearm to the global frame (ENU), palm down, fingers to the north."""
INERTIA, MASS = 0.1, 1.5
"""kg m^2 about each axis, and kg: chosen so heavy that what the hand does hardly moves it."""
QUICKNESS_RAD_S = 50.0
"""Chosen: the drive is critically damped and there within .1 s."""


def add_forearm_drive(spec: mujoco.MjSpec) -> None:
    """Hinges z, x, y (intrinsic) named `arm_flexion` and on, and a position drive on each.

    Call it before bodies hang on the forearm's joints and after the muscles' actuators.
    """
    stiffness, damping = INERTIA * QUICKNESS_RAD_S**2, 2.0 * INERTIA * QUICKNESS_RAD_S
    body = spec.body("forearm")
    body.mass, body.inertia, body.explicitinertial = MASS, [INERTIA] * 3, True
    for motion, axis in zip(MOTIONS, AXES, strict=True):
        body.add_joint(name=f"arm_{motion}", type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis)
        drive = spec.add_actuator(name=f"arm_{motion}", target=f"arm_{motion}",
                                  trntype=mujoco.mjtTrn.mjTRN_JOINT)
        drive.gaintype, drive.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
        drive.gainprm[0] = stiffness
        drive.biasprm[:3] = [0.0, -stiffness, -damping]


def drive_angles(start: Array, wanted: Array, before: Array) -> Array:
    """Angles (3,), rad, of the hinges that turn the forearm from `start` to `wanted`, (4,), to global.

    Of the whole turns that an angle leaves open, those next to the angles `before`. The middle hinge reaches
    90 deg to either side: there the other two are not apart. Raises RunError where `wanted` has length 0.
    """
    if not np.linalg.norm(wanted) > 0.0:
        raise RunError(f"hand.forearm: {wanted} is no orientation; a quaternion (w, x, y, z) is expected")
    turn = quaternion.to_matrix(quaternion.normalized(quaternion.relative(start, wanted)))
    angles = np.array([math.atan2(-turn[0, 1], turn[1, 1]), math.asin(min(1.0, max(-1.0, turn[2, 1]))),
                       math.atan2(-turn[2, 0], turn[2, 2])])
    return before + np.remainder(angles - before + math.pi, 2.0 * math.pi) - math.pi


Numbers = NDArray[np.int64]
OFFERED_NS = 100_000_000
"""How often somebody tries to put an object into the hand (chosen)."""
FLOOR_M = 100.0
"""How far below the wrist an object that nothing holds stops, m (chosen: four and a half seconds of fall, far
out of every scene). Without a floor it would go by kilometres, and end the run as too fast within minutes."""


class HandParameters(Protocol):
    """Parameters that hand plants share, as `plants.hand.plant.Hand` says."""

    @property
    def strength(self) -> tuple[float, ...]:
        """Factors on the muscles' peak forces."""

    @property
    def step_ms(self) -> float:
        """Of the solver."""

    @property
    def forearm_orientation(self) -> tuple[float, ...]:
        """Of the forearm to the global frame."""


def require_hand(owner: str, plant: HandParameters) -> None:
    """Raise InputError for numbers that no hand plant takes."""
    require_positive(owner, plant, "strength", "contracture", "step_ms")
    require_not_negative(owner, plant, "stiffness", "damping", "passive_tension")
    if plant.strength and len(plant.strength) != len(MUSCLES):
        raise InputError(f"{owner}.strength", f"{len(plant.strength)} of them", f"{len(MUSCLES)}, or none")
    if not 0.01 <= plant.step_ms <= 10.0:
        raise InputError(f"{owner}.step_ms", f"{plant.step_ms:g}", "0.01 to 10 ms")
    q = plant.forearm_orientation
    if q and not (len(q) == 4 and abs(math.hypot(*q) - 1.0) <= 1e-6):
        raise InputError(f"{owner}.forearm_orientation", f"{q}", "a quaternion of length 1, or empty")


def hand_inputs(forearm: Array | None) -> tuple[Port, ...]:
    """Activation of the muscles, and where the forearm should be: (4,) at the start; None if it stays."""
    activation = Port("activation", (len(MUSCLES),), "1")
    if forearm is None:
        return (activation,)
    return activation, Port("forearm", (4,), "1", tuple(float(part) for part in forearm), optional=True)


def hand_outputs(start: Array, with_object: bool) -> tuple[Port, ...]:
    """Posture, (23,), rad, at the start, fingertips, what sites feel, forces, fibres, the object's pose."""
    ports = (Port("angles", (23,), "rad", tuple(float(angle) for angle in start)),
             Port("rates", (23,), "rad/s"), Port("accelerations", (23,), "rad/s^2"),
             Port("fingertips", (5, 3), "m"),
             Port("site_orientation", (17, 4), "1", (1.0, 0.0, 0.0, 0.0)),
             Port("site_position", (17, 3), "m"), Port("site_rate", (17, 3), "rad/s"),
             Port("site_force", (17, 3), "m/s^2", (0.0, 0.0, STANDARD_GRAVITY)),
             Port("contact_force", (5,), "N"), Port("velocity", (len(MUSCLES),), "1/s"))
    if not with_object:
        return ports
    return (*ports, Port("object_position", (3,), "m"),
            Port("object_orientation", (4,), "1", (1.0, 0.0, 0.0, 0.0)))


def sensed(views: Views, fixed: bool, segments: Numbers, sites: Numbers,
           tips: Numbers) -> tuple[Array, ...]:
    """Fingertips, what the sites go through, and contact forces, as `hand_outputs` lists them.

    `fixed`: whether the forearm, body 1, cannot move; `segments`: bodies that stand as the segments do;
    `sites`: on the segments; `tips`: the five bone ends.
    """
    found: tuple[Array, ...] = gather(
        views.xpos, views.xquat, views.xmat, views.site_xpos, views.sensordata, fixed, segments, sites, tips)
    return found


@compiled
def gather(
    xpos: Array, xquat: Array, xmat: Array, site_xpos: Array, felt: Array, fixed: bool, segments: Numbers,
    sites: Numbers, tips: Numbers,
) -> tuple[Array, Array, Array, Array, Array, Array]:
    """What `sensed` gives, from MuJoCo's arrays of these names; `felt` is its `sensordata`."""
    count = sites.size
    fingertips = np.empty((tips.size, 3))
    for i in range(tips.size):
        for axis in range(3):
            total = 0.0
            for k in range(3):
                total += (site_xpos[tips[i], k] - xpos[1, k]) * xmat[1, 3 * k + axis]
            fingertips[i, axis] = total
    orientation, position = np.empty((count, 4)), np.empty((count, 3))
    rate, force = np.empty((count, 3)), np.empty((count, 3))
    for i in range(count):
        for part in range(4):
            orientation[i, part] = xquat[segments[i], part]
        for axis in range(3):
            position[i, axis] = site_xpos[sites[i], axis]
            rate[i, axis] = felt[3 * i + axis]
            force[i, axis] = felt[3 * (count + i) + axis]
    if fixed:
        # Accelerometers of bodies that cannot move read 0 up to MuJoCo 3.
        for axis in range(3):
            force[0, axis] = STANDARD_GRAVITY * xmat[1, 6 + axis]
    return fingertips, orientation, position, rate, force, felt[6 * count:6 * count + 5].copy()


def object_pose(views: Views) -> tuple[Array, Array]:
    """Position (3,) and orientation (4,) of the object, which is MuJoCo's last joint."""
    return views.qpos[-7:-4].copy(), views.qpos[-4:].copy()


def turn_forearm(state: HandState, start: Array, wanted: Value) -> None:
    """Have the drive go from an orientation at the start to another, (4,), unless it was told before."""
    if wanted is state.forearm:
        return
    drive = state.views.ctrl[-3:]
    drive[:] = drive_angles(start, cast(Array, wanted), drive)
    state.forearm = cast(Array, wanted)


def go_on(model: mujoco.MjModel, bounds: tuple[Array, Array], thing: GraspObject | None, table: Table | None,
          state: HandState, stop_ns: int, step_ns: int) -> None:
    """Steps until `stop_ns`; raises RunError where the hand leaves the `bounds` of a stable simulation."""
    while state.time_ns < stop_ns:
        if table is not None:
            _lower(table, state)
        if not state.given and thing is not None:
            _offer(model, thing, state)
        step(model, state)
        if thing is not None and state.views.qpos[-5] < -FLOOR_M:
            _rest_on_floor(state.views)
        state.time_ns += step_ns
        require_stable(model, bounds, state)


def _offer(model: mujoco.MjModel, thing: GraspObject, state: HandState) -> None:
    """Give the object, if it is time to and there is room; every 100 ms is tried."""
    since_ns = state.time_ns - round(thing.given_at_s * NS_PER_S)
    if since_ns >= 0 and since_ns % OFFERED_NS < model.opt.timestep * NS_PER_S:
        state.given = give(model, thing, state.data)
        state.evaluated = False


def _rest_on_floor(views: Views) -> None:
    """Stop the object, MuJoCo's last joint, where it has fallen out of the scene."""
    views.qpos[-5] = -FLOOR_M
    views.qvel[-6:] = 0.0


def _lower(table: Table, state: HandState) -> None:
    """Put the table where it is at the start of the step."""
    height = table.height_m - 0.005 - table.drop(state.time_ns)
    if state.views.mocap_pos[0, 2] != height:
        state.views.mocap_pos[0, 2] = height
        state.evaluated = False
