"""Parts shared by hand plants: ports, MuJoCo state, fixed steps, stability check and forearm drive."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol, cast

import mujoco
import numba
import numpy as np
from llvmlite.binding import load_library_permanently
from numba import types
from numpy.typing import NDArray

from fesloop.compiled import assign, compiled
from fesloop.errors import InputError, RunError
from fesloop.forms.schema import require_not_negative, require_positive
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import FINGERS, PARTS
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.hand.movements import FREEDOMS, MUSCLES, SEGMENTS
from fesloop.hand.segments import AXES, MOTIONS
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.signals import Port, Value
from plants.hand.assist import Hold
from plants.hand.model import PALM, mujoco_library
from plants.hand.scene import GraspObject, Table, give
from plants.hand.tendons import Tendons, pull

Array = NDArray[np.float64]
UNSTABLE_RAD_S = 1000.0
"""Speed of an unstable joint (chosen: above real ones, as snapping fingers reach 140 rad/s: Acharya 2021, doi
10.1098/rsif.2021.0672), and of an object, in m/s."""
BEYOND_RAD = math.radians(60.0)
"""Angle beyond its range of an unstable joint (chosen: sudden full force moves one there by up to 45 deg for
some milliseconds, and a quarter as far with a tenth of the usual step)."""


_POSITION_AND_VELOCITY, _NOTHING = mujoco.mjtStage.mjSTAGE_VEL, mujoco.mjtStage.mjSTAGE_NONE
_VELOCITY_SKIPPED, _NOTHING_SKIPPED = int(_POSITION_AND_VELOCITY), int(_NOTHING)
_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
"""The state from which MuJoCo continues bit for bit."""
FLOOR_M = 100.0
"""Depth of the floor below the wrist, m (chosen: a fall of four and a half seconds, out of every scene).
Without it a falling object would end the run as too fast within minutes."""


class Views(NamedTuple):
    """Arrays of MuJoCo's data, under its names: looking one up in the data costs as much as using it."""

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
    qfrc_applied: Array
    userdata: Array


@dataclass(slots=True, eq=False)
class HandState:
    """State of a hand.

    Attributes
    ----------
    data: MuJoCo's data at `time_ns`, whose user data are the fibres of muscles with tendons that yield
        (`plants.hand.tendons`); copied and pickled whole.
    time_ns: instant of the state.
    evaluated: whether accelerations and sensors are computed for this instant.
    forearm: last commanded orientation of the forearm; None before the first.
    given: whether the object, if any, has been put to where it is to be grasped.
    views: arrays of the data; a copy has its own.
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
    """Compute accelerations and sensors of this instant, under the activation of the step that led here."""
    if state.evaluated:
        return
    # The solver starts from the last step's solution; another start would change the last bit of its result.
    start = state.views.qacc_warmstart.copy()
    mujoco.mj_forward(model, state.data)
    state.views.qacc_warmstart[:] = start
    state.evaluated = True


def step(model: mujoco.MjModel, state: HandState, tendons: Tendons | None = None) -> None:
    """Do one fixed step under the activation in the data: `mj_step` without sensors."""
    if tendons is not None:
        views = state.views
        pull(views.qpos, views.qvel, views.userdata, views.qfrc_applied, *tendons)
    mujoco.mj_forwardSkip(model, state.data, _POSITION_AND_VELOCITY if state.evaluated else _NOTHING, 1)
    mujoco.mj_implicit(model, state.data)
    state.evaluated = False


class Bounds(NamedTuple):
    """Least and greatest angle of each hinge, (h,) each, rad, in a stable simulation."""

    low: Array
    high: Array


@compiled
def find_unstable(angles: Array, speeds: Array, low: Array, high: Array) -> int:
    """Index of the fastest freedom if it is too fast, or of the first hinge outside its bounds; -1 if none.

    `angles` (positions,), hinges first; `speeds` (v,); `low` and `high` (hinges,).
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


load_library_permanently(str(mujoco_library()))  # compiled code calls MuJoCo's C functions
_UNCOMPILED = bool(vars(numba.config)["DISABLE_JIT"])
_void: Any = types.void  # called, it makes the signature of a function
_forward_skip: Any = types.ExternalFunction(
    "mj_forwardSkip", _void(types.intp, types.intp, types.intc, types.intc))
_implicit: Any = types.ExternalFunction("mj_implicit", _void(types.intp, types.intp))


@compiled
def take_steps(
    model: int, data: int, skipping: int, activation: Array, heights: Array, falls: bool, qpos: Array,
    qvel: Array, userdata: Array, qfrc_applied: Array, mocap_pos: Array, waits: Array, low: Array,
    high: Array, table: Array, arms: Array, joints: Numbers, step_s: float,
) -> bool:
    """Do what `step` does with tendons that yield, under `activation` (n, 29), in n steps.

    `model` and `data` are addresses of MuJoCo's structs, and the arrays its own, of these names; `skipping`:
    stage that is computed already; `heights` (n,), m, of the table, empty if there is none; `falls`: whether
    there is an object that the floor stops; `waits`: pose (7,) in which it is held, empty if it is not. False
    as soon as the simulation is unstable.
    """
    for k in range(activation.shape[0]):
        stage = skipping if k == 0 else _NOTHING_SKIPPED
        if heights.size and mocap_pos[0, 2] != heights[k]:
            mocap_pos[0, 2] = heights[k]
            stage = _NOTHING_SKIPPED
        assign(userdata[2 * table.shape[0]:], activation[k])
        pull(qpos, qvel, userdata, qfrc_applied, table, arms, joints, step_s)
        _forward_skip(model, data, stage, 1)
        _implicit(model, data)
        if waits.size:
            qpos[-7:] = waits
            qvel[-6:] = 0.0
        elif falls and qpos[-5] < -FLOOR_M:
            qpos[-5] = -FLOOR_M
            qvel[-6:] = 0.0
        if find_unstable(qpos, qvel, low, high) >= 0:
            return False
    return True


def stable_bounds(model: mujoco.MjModel) -> Bounds:
    """Bounds of a model's hinges in a stable simulation."""
    hinges = model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE
    reach = np.where(model.jnt_limited[hinges] > 0, BEYOND_RAD, np.inf)
    low, high = model.jnt_range[hinges].T
    return Bounds(low - reach, high + reach)


def require_stable(model: mujoco.MjModel, bounds: Bounds, state: HandState) -> None:
    """Raise RunError, naming the joint, if the simulation is unstable."""
    angles, speeds = state.views.qpos, state.views.qvel
    worst = find_unstable(angles, speeds, bounds.low, bounds.high)
    if worst < 0:
        return
    name = model.joint(int(model.dof_jntid[worst])).name
    found = f"moves at {abs(speeds[worst]):.3g} rad/s or m/s"
    if abs(speeds[worst]) < UNSTABLE_RAD_S:
        found = f"is at {math.degrees(angles[worst]):.3g} deg, far beyond its range"
    raise RunError(f"hand became unstable at {state.time_ns / NS_PER_MS:g} ms: {name} {found}; take a "
                   "smaller step_ms, or weaker muscles and springs")


PALM_DOWN = {"left": (math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0),
             "right": (0.0, math.sqrt(0.5), 0.0, -math.sqrt(0.5))}
"""Orientation (w, x, y, z) from forearm to global frame (ENU), by side: palm down, fingers to the north."""
INERTIA, MASS = 0.1, 1.5
"""Inertia of the forearm about each axis, kg m^2, and its mass, kg: chosen so large that the hand hardly
moves it."""
DRIVE_RAD_S = 50.0
"""Natural frequency of the forearm's drive (chosen: critically damped, it arrives within .1 s)."""


def add_forearm_drive(spec: mujoco.MjSpec) -> None:
    """Add hinges z, x, y (intrinsic) of the forearm, `arm_flexion` and so on, with a position drive each.

    Call it after the muscles' actuators are added.
    """
    stiffness, damping = INERTIA * DRIVE_RAD_S**2, 2.0 * INERTIA * DRIVE_RAD_S
    body = spec.body("forearm")
    body.mass, body.inertia, body.explicitinertial = MASS, [INERTIA] * 3, True
    for motion, axis in zip(MOTIONS, AXES, strict=True):
        body.add_joint(name=f"arm_{motion}", type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis)
        drive = spec.add_actuator(name=f"arm_{motion}", target=f"arm_{motion}",
                                  trntype=mujoco.mjtTrn.mjTRN_JOINT)
        drive.gaintype, drive.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
        drive.gainprm[0] = stiffness
        drive.biasprm[:3] = [0.0, -stiffness, -damping]


def drive_angles(start: Array, target: Array, before: Array) -> Array:
    """Angles (3,), rad, of the hinges that turn the forearm from `start` to `target`, (4,), to global.

    Whole turns are chosen so that angles are next to `before`. At 90 deg of the middle hinge the other two
    are not distinct. Raises RunError if `target` has length 0.
    """
    if not np.linalg.norm(target) > 0.0:
        raise RunError(f"hand.forearm: {target} is not an orientation; expected a quaternion (w, x, y, z)")
    turn = quaternion.to_matrix(quaternion.normalized(quaternion.relative(start, target)))
    angles = np.array([math.atan2(-turn[0, 1], turn[1, 1]), math.asin(min(1.0, max(-1.0, turn[2, 1]))),
                       math.atan2(-turn[2, 0], turn[2, 2])])
    return before + np.remainder(angles - before + math.pi, 2.0 * math.pi) - math.pi


Numbers = NDArray[np.int64]
_NOWHERE = np.array([])
OFFER_PERIOD_NS = 100_000_000
"""Interval between tries to put the object into the hand (chosen)."""


class HandParameters(Protocol):
    """Parameters shared by hand plants; see `plants.hand.plant.Hand`."""

    @property
    def strength(self) -> tuple[float, ...]:
        """Factors on the muscles' peak forces."""

    @property
    def step_ms(self) -> float:
        """Step of the solver."""

    @property
    def forearm_orientation(self) -> tuple[float, ...]:
        """Orientation from the forearm to the global frame."""


def require_hand(owner: str, plant: HandParameters) -> None:
    """Raise InputError for invalid values of the shared parameters."""
    require_positive(owner, plant, "strength", "contracture", "step_ms")
    require_not_negative(owner, plant, "stiffness", "damping", "passive_tension")
    if plant.strength and len(plant.strength) != len(MUSCLES):
        raise InputError(f"{owner}.strength", f"{len(plant.strength)} factors", f"{len(MUSCLES)}, or none")
    if not 0.01 <= plant.step_ms <= 10.0:
        raise InputError(f"{owner}.step_ms", f"{plant.step_ms:g}", "0.01 to 10 ms")
    q = plant.forearm_orientation
    if q and not (len(q) == 4 and abs(math.hypot(*q) - 1.0) <= 1e-6):
        raise InputError(f"{owner}.forearm_orientation", f"{q}", "a quaternion of length 1, or empty")


def hand_inputs(forearm: Array | None) -> tuple[Port, ...]:
    """Input ports: activation, and the forearm's orientation, initially `forearm` (4,), if not None."""
    activation = Port("activation", (len(MUSCLES),), "1")
    if forearm is None:
        return (activation,)
    return activation, Port("forearm", (4,), "1", tuple(float(part) for part in forearm), optional=True)


class HandValues(NamedTuple):
    """Values of the output ports, in the order of `hand_outputs`, except those of an object."""

    angles: Array
    rates: Array
    accelerations: Array
    fingertips: Array
    site_orientation: Array
    site_position: Array
    site_rate: Array
    site_force: Array
    contact_force: Array
    velocity: Array


def hand_outputs(start: Array, with_object: bool) -> tuple[Port, ...]:
    """Output ports, from the posture at the start, (23,), rad."""
    ports = (Port("angles", (23,), "rad", tuple(float(angle) for angle in start), rows=FREEDOMS),
             Port("rates", (23,), "rad/s", rows=FREEDOMS),
             Port("accelerations", (23,), "rad/s^2", rows=FREEDOMS),
             Port("fingertips", (5, 3), "m", rows=FINGERS),
             Port("site_orientation", (17, 4), "1", (1.0, 0.0, 0.0, 0.0), rows=SEGMENTS),
             Port("site_position", (17, 3), "m", rows=SEGMENTS),
             Port("site_rate", (17, 3), "rad/s", rows=SEGMENTS),
             Port("site_force", (17, 3), "m/s^2", (0.0, 0.0, STANDARD_GRAVITY), rows=SEGMENTS),
             Port("contact_force", (len(PARTS),), "N", rows=PARTS),
             Port("velocity", (len(MUSCLES),), "1/s", rows=MUSCLES))
    if not with_object:
        return ports
    return (*ports, Port("object_position", (3,), "m"),
            Port("object_orientation", (4,), "1", (1.0, 0.0, 0.0, 0.0)),
            Port("object_force", (len(PARTS),), "N", rows=PARTS))


def sensed(views: Views, fixed: bool, segments: Numbers, sites: Numbers,
           tips: Numbers) -> tuple[Array, Array, Array, Array, Array]:
    """Fingertips and kinematics of the sites, in the order of `HandValues`.

    `fixed`: whether the forearm, body 1, cannot move; `segments`: bodies oriented like the segments;
    `sites`: sites on the segments; `tips`: sites at the five bone ends.
    """
    found: tuple[Array, Array, Array, Array, Array] = gather(
        views.xpos, views.xquat, views.xmat, views.site_xpos, views.sensordata, fixed, segments, sites, tips)
    return found


@compiled
def gather(
    xpos: Array, xquat: Array, xmat: Array, site_xpos: Array, sensordata: Array, fixed: bool,
    segments: Numbers, sites: Numbers, tips: Numbers,
) -> tuple[Array, Array, Array, Array, Array]:
    """Results of `sensed`, from MuJoCo's arrays of these names."""
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
            rate[i, axis] = sensordata[3 * i + axis]
            force[i, axis] = sensordata[3 * (count + i) + axis]
    if fixed:
        # Accelerometers of bodies that cannot move read 0 up to MuJoCo 3.
        for axis in range(3):
            force[0, axis] = STANDARD_GRAVITY * xmat[1, 6 + axis]
    return fingertips, orientation, position, rate, force


def object_pose(views: Views) -> tuple[Array, Array]:
    """Position (3,) and orientation (4,) of the object, MuJoCo's last joint."""
    return views.qpos[-7:-4].copy(), views.qpos[-4:].copy()


OBJECT_PART, NO_PART = -1, -2
"""Parts of geoms that are not the hand's: the object, and all others."""


def parts_of_geoms(model: mujoco.MjModel) -> Numbers:
    """Index in `PARTS` of each geom, (geoms,): those of bones have their names, those of the palm a group."""
    parts = np.full(model.ngeom, NO_PART)
    for geom in range(model.ngeom):
        name = model.geom(geom).name
        if name in PARTS:
            parts[geom] = PARTS.index(name)
        elif model.body(model.geom_bodyid[geom]).name == "object":
            parts[geom] = OBJECT_PART
        elif model.geom_contype[geom] == PALM:
            parts[geom] = PARTS.index("palm")
    return parts


def contact_forces(data: mujoco.MjData, parts: Numbers) -> tuple[Array, Array]:
    """Sums of the normal forces on each of `PARTS`, (16,), N: of all contacts, and of those of the object."""
    every, of_object = np.zeros(len(PARTS)), np.zeros(len(PARTS))
    if data.ncon == 0:
        return every, of_object
    contacts = data.contact
    add_forces(np.asarray(contacts.efc_address), np.asarray(contacts.geom), parts, data.efc_force, every,
               of_object)
    return every, of_object


@compiled
def add_forces(
    rows: NDArray[np.int32], geoms: NDArray[np.int32], parts: Numbers, efc_force: Array, every: Array,
    of_object: Array,
) -> None:
    """Add the normal forces of contacts to those of their `parts` of geoms, and those of the object's.

    `rows` (n,) and `geoms` (n, 2) are MuJoCo's `efc_address` and `geom` of the contacts.
    """
    for row, pair in zip(rows, geoms):  # noqa: B905 - Numba has no `strict`
        if row < 0:
            continue
        force, one, other = efc_force[row], parts[pair[0]], parts[pair[1]]  # the first row is the normal's
        if one >= 0:
            every[one] += force
        if other >= 0:
            every[other] += force
        if min(one, other) == OBJECT_PART and max(one, other) >= 0:
            of_object[max(one, other)] += force


def turn_forearm(state: HandState, start: Array, target: Value) -> None:
    """Command the forearm's drive to an orientation, (4,), if that is new; `start` is the initial one."""
    if target is state.forearm:
        return
    drive = state.views.ctrl[-3:]
    drive[:] = drive_angles(start, cast(Array, target), drive)
    state.forearm = cast(Array, target)


def advance_to(model: mujoco.MjModel, bounds: Bounds, thing: GraspObject | None, table: Table | None,
               hold: Hold | None, state: HandState, stop_ns: int, step_ns: int,
               tendons: Tendons | None = None) -> None:
    """Step until `stop_ns`; RunError if the simulation becomes unstable."""
    while state.time_ns < stop_ns:
        if hold is not None and state.time_ns <= hold.over_ns + step_ns:
            hold.press(state.data, state.time_ns)
        if table is not None:
            _lower(table, state)
        if not state.given and thing is not None:
            _offer(model, thing, state)
        step(model, state, tendons)
        if not state.given:
            _hold_waiting(model, state.views)
        elif thing is not None and state.views.qpos[-5] < -FLOOR_M:
            _rest_on_floor(state.views)
        state.time_ns += step_ns
        require_stable(model, bounds, state)


def advance_steps(model: mujoco.MjModel, bounds: Bounds, thing: GraspObject | None, table: Table | None,
                  hold: Hold | None, tendons: Tendons, state: HandState, activation: Array,
                  times_ns: Sequence[int], step_ns: int) -> bool:
    """Do the steps that end at `times_ns`, n, under `activation` (n, 29), in one call of compiled code.

    False, with the state as before, where something else than muscles and table acts in one of the steps, or
    the simulation becomes unstable.
    """
    last_ns = times_ns[-1] - step_ns
    releasing = (hold is not None and last_ns > hold.until_ns
                 and state.time_ns <= hold.over_ns + step_ns)
    offering = not state.given and thing is not None and _offers(thing, state.time_ns, last_ns, step_ns)
    if releasing or offering or _UNCOMPILED:  # plain Python cannot call MuJoCo's C functions
        return False
    before, views = np.empty(mujoco.mj_stateSize(model, _STATE)), state.views
    mujoco.mj_getState(model, state.data, before, _STATE)
    if hold is not None and last_ns <= hold.until_ns:
        hold.press(state.data, state.time_ns)  # as firmly in all of these steps
    heights = np.array([] if table is None else [_height(table, time - step_ns) for time in times_ns])
    done = take_steps(
        model._address, state.data._address, _VELOCITY_SKIPPED if state.evaluated else _NOTHING_SKIPPED,
        activation, heights, thing is not None, views.qpos, views.qvel, views.userdata, views.qfrc_applied,
        views.mocap_pos, _NOWHERE if state.given else model.qpos0[-7:], bounds.low, bounds.high, *tendons)
    state.evaluated = False
    if done:
        state.time_ns = times_ns[-1]
    else:
        mujoco.mj_setState(model, state.data, before, _STATE)
    return bool(done)


def _offer(model: mujoco.MjModel, thing: GraspObject, state: HandState) -> None:
    """Give the object if it is due and there is room, trying every 100 ms."""
    if _offers(thing, state.time_ns, state.time_ns, round(model.opt.timestep * NS_PER_S)):
        state.given = give(model, thing, state.data)
        state.evaluated = False


def _offers(thing: GraspObject, first_ns: int, last_ns: int, step_ns: int) -> bool:
    """Whether the object is offered in one of the steps that begin at `first_ns` to `last_ns`."""
    given_ns = round(thing.given_at_s * NS_PER_S)
    before_ns = max(first_ns - given_ns - step_ns, -1)
    return (last_ns - given_ns) // OFFER_PERIOD_NS > before_ns // OFFER_PERIOD_NS


def start_state(model: mujoco.MjModel, thing: GraspObject | None, data: mujoco.MjData) -> HandState:
    """State at the start of a run; an object that is given later is where it waits."""
    state = HandState(data, given=thing is None or thing.given_at_s == 0.0)
    if not state.given:
        _hold_waiting(model, state.views)
    return state


def _hold_waiting(model: mujoco.MjModel, views: Views) -> None:
    """Keep the object, MuJoCo's last joint, where it waits: somebody holds it."""
    views.qpos[-7:] = model.qpos0[-7:]
    views.qvel[-6:] = 0.0


def _rest_on_floor(views: Views) -> None:
    """Stop the fallen object, MuJoCo's last joint, on the floor."""
    views.qpos[-5] = -FLOOR_M
    views.qvel[-6:] = 0.0


def _height(table: Table, time_ns: int) -> float:
    """Height of the table's centre at an instant, m."""
    return table.height_m - 0.005 - table.drop(time_ns)


def _lower(table: Table, state: HandState) -> None:
    """Move the table to its height at the start of the step."""
    height = _height(table, state.time_ns)
    if state.views.mocap_pos[0, 2] != height:
        state.views.mocap_pos[0, 2] = height
        state.evaluated = False
