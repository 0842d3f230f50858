"""What every hand plant takes and puts out, and how it goes on from step to step."""

from __future__ import annotations

import math
from typing import Protocol, cast

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError, RunError
from fesloop.hand import quaternion
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.hand.movements import MUSCLES
from fesloop.hand.segments import AXES, MOTIONS
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.signals import Port, Value
from plants.checks import require_not_negative, require_positive
from plants.hand.objects import GraspObject, Table, give
from plants.hand.state import HandState, Views, require_stable, step

Array = NDArray[np.float64]
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
