"""The hand's MuJoCo model: bodies, passive moments and muscles put together and compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.hand.anthropometry import FINGERS, HandSize
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.hand.movements import MUSCLES
from fesloop.hand.segments import SegmentTree
from fesloop.hand.skeleton import RESTING_DEG
from plants.hand.bodies import add_hand, add_sensors
from plants.hand.muscles import Muscle

Array = NDArray[np.float64]


class Passive(NamedTuple):
    """Of one freedom: stiffness of the joint alone, N m/rad, damping, N m s/rad."""

    stiffness: float
    damping: float


WRIST_END_DEG, WRIST_BEYOND_DEG = 75.0, 15.0
WRIST_END_MOMENTS = {"flexion": 0.28, "extension": 0.99}
"""The wrist's passive moment, N m, is about 0 over the central 150 deg and .5 and 1.2 at 90 deg of flexion
and extension. This is what relaxed muscles leave of it for springs that are slack over the central range."""


def passive_joints(tree: SegmentTree) -> dict[str, Passive]:
    """By freedom.

    Fingers: MCP joints are .033 to .047 N m/rad stiff, tendons included (PMC7775510), so less without them;
    PIP and DIP are chosen for the proportions in which FDP and FDS flex the joints, tendons included
    (Nimbarte 2008, doi 10.1186/1749-799X-3-8). Damping .003 to .005 at the MCP, PIP and DIP chosen for its
    damping ratio. Thumb and abduction: chosen, in proportion to what moves along. Wrist: chosen, near nothing
    in flexion, where it is free over the central 150 deg; damping chosen.
    """
    rows = {
        "wrist_flexion": Passive(0.02, 0.03), "wrist_abduction": Passive(0.5, 0.03),
        "F1_cmc_flexion": Passive(0.10, 0.008), "F1_cmc_abduction": Passive(0.10, 0.008),
        "F1_cmc_pronation": Passive(0.15, 0.004), "F1_mcp_flexion": Passive(0.05, 0.003),
        "F1_ip_flexion": Passive(0.02, 0.0006)}
    for finger in FINGERS[1:]:
        rows[f"{finger}_mcp_flexion"] = Passive(0.030, 0.004)
        rows[f"{finger}_mcp_abduction"] = Passive(0.08, 0.004)
        rows[f"{finger}_pip_flexion"] = Passive(0.0148, 0.00085)
        rows[f"{finger}_dip_flexion"] = Passive(0.016, 0.00022)
    return {freedom: rows[freedom] for freedom in tree.freedoms}


def resting_posture(tree: SegmentTree, rest_deg: dict[str, float]) -> Array:
    """Angles (d,) at rest, rad; `rest_deg` replaces those of the freedoms that it names.

    Raises InputError for a freedom that is not there.
    """
    angles = np.deg2rad([RESTING_DEG[freedom] for freedom in tree.freedoms])
    for freedom, degrees in rest_deg.items():
        angles[tree.freedom(freedom)] = np.deg2rad(degrees)
    return angles


def require_in_range(where: str, tree: SegmentTree, angles: Array) -> None:
    """Raise InputError, naming the parameter `where`, for an angle (d,) outside its joint's range."""
    rows = zip(tree.freedoms, np.rad2deg(angles), np.rad2deg(tree.ranges), strict=True)
    for name, angle, (low, high) in rows:
        if not low <= angle <= high:
            raise InputError(f"{where}.{name}", f"{angle:g}", f"{low:g} to {high:g} deg")


def require_posture(where: str, tree: SegmentTree, degrees: dict[str, float]) -> None:
    """Raise InputError, naming the parameter `where`, for a freedom that is not there or out of its range."""
    for name in degrees.keys() - set(tree.freedoms):
        raise InputError(f"{where}.{name}", "is no freedom of the hand", ", ".join(tree.freedoms),
                         did_you_mean(name, tree.freedoms))
    require_in_range(where, tree, resting_posture(tree, degrees))


RESTING_LENGTH = 1.06
"""Fibre length over the optimal one where the hand rests (chosen: just onto the passive slope)."""
SHORTEST, LONGEST, FASTEST, ECCENTRIC = 0.0, 2.0, 10.0, 1.4
"""Of Thelen 2003 (doi 10.1115/1.1531112): fibre lengths at which active force is gone, over the optimal one
(his is exp(-(l - 1)^2 / .45): MuJoCo's curve stays within .08 of it from .5 to 1.5); optimal lengths per
second at which force is gone in shortening, and force in fast lengthening over isometric."""
NEARLY_NONE = 1e-12
"""MuJoCo takes no passive force of 0."""
SPLINT_TIME_S = 0.01
"""Time constant with which a splinted joint returns, critically damped (chosen)."""
SPLINT_SOLIMP = [0.999, 0.9999, 0.001, 0.5, 2.0]
"""Of a splint on a digit, so hard that it gives by a degree or two at most under the muscles' full force
(chosen: a finger is so light that MuJoCo's default, which does for the wrist, lets it go)."""
CONTACT_TOLERANCE_M = 1e-5
"""To which the depth of a contact is found (chosen: MuJoCo's 1e-6 costs more and changes the shipped grasp by
.06 deg r.m.s., as halving the step does; skin gives by millimetres)."""
MEMORY = 4 << 20
"""Bytes for constraints and scratch: enough for some hundred contacts, little enough to copy."""


def empty_spec(step_s: float) -> mujoco.MjSpec:
    """Gravity and a solver, nothing in the world yet."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    set_solver(spec, step_s)
    return spec


def set_solver(spec: mujoco.MjSpec, step_s: float) -> None:
    """Gravity, integrator, friction and memory."""
    option = spec.option
    option.timestep = step_s
    option.gravity = [0.0, 0.0, -STANDARD_GRAVITY]
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 10.0  # friction is held ten times as stiffly as the normal force: no creep in a grasp
    # Half of the Jacobian is empty: a finger's contact moves neither the other fingers nor the thumb.
    option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
    option.ccd_tolerance = CONTACT_TOLERANCE_M
    spec.memory = MEMORY


def compiled(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """The model; raises InputError for numbers that MuJoCo has no room for, such as a mass of 1e-20 kg."""
    try:
        return spec.compile()
    except ValueError as fault:
        raise InputError("the hand's model", f"cannot be made: {fault}",
                         "sizes and masses of real things") from None


def build_hand(spec: mujoco.MjSpec, tree: SegmentTree, size: HandSize, forearm: Array, arms: Array) -> None:
    """Add bodies, sensors, the wrist's ends and a tendon for each muscle (`arms` (29, d), m)."""
    add_hand(spec, tree, size, forearm)
    add_sensors(spec, tree, size)
    _add_wrist_ends(spec)
    for name, row in zip(MUSCLES, arms, strict=True):
        tendon = spec.add_tendon(name=name)
        for freedom, arm in zip(tree.freedoms, row, strict=True):
            if arm:
                tendon.wrap_joint(freedom, -arm)  # tension pulls the angle up as the tendon shortens


def _add_wrist_ends(spec: mujoco.MjSpec) -> None:
    """Springs beyond the wrist's free range, as tendons that are slack within it."""
    end, never = math.radians(WRIST_END_DEG), 10.0
    for name, (low, high) in (("wrist flexion end", (-never, end)), ("wrist extension end", (-end, never))):
        tendon = spec.add_tendon(name=name)
        tendon.wrap_joint("wrist_flexion", 1.0)
        tendon.springlength = [low, high]


def add_muscles(spec: mujoco.MjSpec, muscles: tuple[Muscle, ...], strength: Array, tension: float,
                resting_lengths: Array) -> None:
    """An actuator on each muscle's tendon: force-length and force-velocity, activation as its control.

    Passive tension is that of the healthy muscle times `tension`, whatever its strength, (29,);
    `resting_lengths` (29,), m, are the tendons' where the hand rests.
    """
    stretch, knee = RESTING_LENGTH - 1.0, 0.5 * (LONGEST - 1.0)
    for name, muscle, factor, rest in zip(MUSCLES, muscles, strength, resting_lengths, strict=True):
        force, fibre = factor * muscle.force_n, 1e-3 * muscle.fibre_mm
        # MuJoCo's passive force is quadratic in stretch: this gives the stiffness wanted at rest.
        passive = NEARLY_NONE + tension * muscle.passive_n_m * fibre * knee**2 / (force * stretch)
        parameters = [RESTING_LENGTH, RESTING_LENGTH + 1.0, force, 1.0, SHORTEST, LONGEST, FASTEST, passive,
                      ECCENTRIC, 0.0]
        actuator = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_TENDON)
        actuator.dyntype = mujoco.mjtDyn.mjDYN_NONE
        actuator.gaintype, actuator.biastype = mujoco.mjtGain.mjGAIN_MUSCLE, mujoco.mjtBias.mjBIAS_MUSCLE
        actuator.gainprm, actuator.biasprm = parameters, parameters
        actuator.lengthrange = [rest, rest + fibre]
        actuator.ctrlrange, actuator.ctrllimited = [0.0, 1.0], True


def resting_tension(muscles: tuple[Muscle, ...], tension: float) -> Array:
    """Passive tension (29,), N, where the hand rests: half stiffness times stretch."""
    return np.array([0.5e-3 * tension * muscle.passive_n_m * muscle.fibre_mm * (RESTING_LENGTH - 1.0)
                     for muscle in muscles])


def set_passive_joints(model: mujoco.MjModel, tree: SegmentTree, stiffness: Array, damping: Array,
                       rest: Array, moments: Array, ends: float) -> None:
    """Springs and dampers of the freedoms (d,).

    Spring lengths are such that without gravity all moments cancel at `rest`, (d,), rad, under the
    `moments`, (d,), N m, of resting tendons; a freedom without a spring goes where these take it.
    """
    first = model.joint(tree.freedoms[0]).id
    rows = slice(first, first + len(tree.freedoms))
    shift = np.divide(moments, stiffness, out=np.zeros_like(moments), where=stiffness > 0.0)
    model.jnt_stiffness[rows] = stiffness
    model.dof_damping[rows] = damping
    model.qpos_spring[rows] = rest - shift
    for motion, moment in WRIST_END_MOMENTS.items():
        model.tendon_stiffness[model.tendon(f"wrist {motion} end").id] = (
            ends * moment / math.radians(WRIST_BEYOND_DEG))


def add_splint(spec: mujoco.MjSpec, held: dict[str, float]) -> None:
    """Hold freedoms at angles, rad, by constraints."""
    for freedom, angle in held.items():
        lock = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, objtype=mujoco.mjtObj.mjOBJ_JOINT,
                                 name1=freedom)
        lock.data[:5] = [angle, 0.0, 0.0, 0.0, 0.0]
        lock.solref = [SPLINT_TIME_S, 1.0]
        if not freedom.startswith("wrist"):
            lock.solimp = SPLINT_SOLIMP


def add_springs(model: mujoco.MjModel, pulled: dict[str, float], stiffness: float) -> None:
    """Beside their own springs, pull freedoms to angles, deg, with a stiffness, N m/rad."""
    for freedom, angle in pulled.items():
        joint, place = model.joint(freedom).id, model.joint(freedom).qposadr[0]
        own = model.jnt_stiffness[joint]
        moment = own * model.qpos_spring[place] + stiffness * math.radians(angle)
        model.jnt_stiffness[joint] = own + stiffness
        model.qpos_spring[place] = moment / (own + stiffness)


def nominal_passive(tree: SegmentTree, contracture: float) -> tuple[Array, Array]:
    """Stiffness and damping (d,) of the freedoms, N m/rad and N m s/rad; the fingers' MCP joints stiffer."""
    rows = passive_joints(tree)
    stiffness = [row.stiffness * (contracture if name.endswith("mcp_flexion") and name[:2] != "F1" else 1.0)
                 for name, row in rows.items()]
    return np.array(stiffness), np.array([row.damping for row in rows.values()])
