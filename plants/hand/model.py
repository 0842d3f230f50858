"""MuJoCo model of the hand: bodies, passive moments and muscles."""

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
from fesloop.hand.segments import FREEDOMS, MOTIONS, SegmentTree
from fesloop.hand.skeleton import RESTING_DEG, dorsal_points
from plants.hand.muscles import Muscle

Array = NDArray[np.float64]
DENSITY = 1100.0
"""Density of segments, kg/m^3; digits are cylinders, the palm is a box."""
RADIUS_RATIOS = {"p": 4.0 / 3.0, "m": 7.0 / 6.0, "d": 1.0}
"""Ratio of radii of a finger's segments to half the thickness of its tip, from 8, 7 and 6 mm, which give the
index finger's proximal phalanx the published 2e-6 kg m^2."""
THUMB_RADIUS_RATIOS = {"m": 4.0 / 3.0, "p": 7.0 / 6.0, "d": 1.0}
BREADTH_RATIO, THICKNESS_RATIO = 0.45, 0.15
"""Ratio of the palm's breadth and thickness to hand length: 85.8 of 190.2 mm (Ibeachu 2011); 28 of 190 mm,
chosen."""
WIDER_RANGES = {"wrist_flexion": (-0.5 * math.pi, 0.5 * math.pi)}
"""Hard ends of joints, rad, beyond the typical range, where soft tissue stops the relaxed wrist before."""
HYPOTHENAR_RATIO, THENAR_RATIO = 0.075, 1.6
"""Chosen: ratio of the radius of the ball of the little finger to hand length, and of the skin of the ball of
the thumb to its metacarpal's radius."""
TIPS = tuple(f"{finger}d" for finger in FINGERS)
"""The distal segments."""
TIP_REACH_M = 0.002
"""Distance beyond the skin of a distal segment within which contacts count as the fingertip's."""
END_SOLREF, END_SOLIMP = [0.006, 1.0], [0.95, 0.999, 0.02, 0.5, 2.0]
"""Solver parameters of the ends of joint ranges: return within 6 ms, critically damped, and hard enough to
keep a joint within a few degrees under the full force of its muscles (chosen)."""
SKIN_SOLREF, SKIN_SOLIMP = [0.02, 1.0], [0.5, 0.95, 0.006, 0.5, 2.0]
"""Solver parameters of contacts with skin: soft, and stiffer over the first 6 mm, like the pulp of a
fingertip (chosen: of those tried, halving a step of 1 ms changes grasps the least with these)."""
FINGER, FINGER_BASE, THUMB, PALM, OBJECT, TABLE = 1, 2, 4, 8, 16, 32
"""Contact groups."""
TOUCHES = {FINGER: 0, FINGER_BASE: 0, PALM: 0, THUMB: FINGER, OBJECT: FINGER | FINGER_BASE | THUMB | PALM,
           TABLE: OBJECT | FINGER | FINGER_BASE | THUMB | PALM}
"""Groups that each group collides with. Fingers do not collide with each other or the palm: joint ranges keep
them apart."""


def radius(size: HandSize, name: str) -> float:
    """Radius of a segment of a digit, m."""
    half = 0.5 * float(size.tips[FINGERS.index(name[:2]), 1])
    return half * (THUMB_RADIUS_RATIOS if name.startswith("F1") else RADIUS_RATIOS)[name[2]]


def add_hand(spec: mujoco.MjSpec, tree: SegmentTree, size: HandSize, forearm: Array) -> None:
    """Add forearm, hand and digits to an empty spec, the wrist's centre at the origin.

    Joints have the names of the tree's freedoms, bodies those of its segments. `forearm`, (4,), is the fixed
    orientation from the forearm to the global frame. A body's frame has its origin at the joint's centre,
    parallel to the segment's own.
    """
    bodies: dict[str, mujoco.MjsBody] = {}
    for segment, geometry in zip(tree.segments, tree.geometry, strict=True):
        if segment.parent is None:
            body = spec.worldbody.add_body(name=segment.name, quat=forearm)
            _add_forearm(body, size)
        else:
            place = np.asarray(tree.segments[tree.index(segment.parent)].offset) + segment.base
            body = bodies[segment.parent].add_body(name=segment.name, pos=place)
            for i, motion in enumerate(MOTIONS[:FREEDOMS[segment.joint]]):
                name = f"{segment.joint_name}_{motion}"
                body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=geometry[i],
                               range=WIDER_RANGES.get(name, segment.ranges[i]), limited=True,
                               solref_limit=END_SOLREF, solimp_limit=END_SOLIMP)
            if segment.name == "hand":
                _add_palm(body, size)
            else:
                _add_phalanx(body, size, segment.name, np.asarray(segment.offset))
        bodies[segment.name] = body


def _add_forearm(body: mujoco.MjsBody, size: HandSize) -> None:
    """Add the visible forearm, which collides with nothing."""
    reach = -size.outwards * size.forearm
    body.add_geom(name="forearm", type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[0.03, 0.0, 0.0], mass=0.0,
                  fromto=[0.0, 0.15 * reach, 0.0, 0.0, reach, 0.0], contype=0, conaffinity=0)


def _add_palm(body: mujoco.MjsBody, size: HandSize) -> None:
    """Add a box from the wrist to the middle finger's MCP joint, up to the dorsal skin."""
    centres, out = size.first_joints, size.outwards
    length = float(centres[2, 0])
    sizes = 1e-3 * size.hand_mm * np.array([THICKNESS_RATIO, 0.0, BREADTH_RATIO]) + [0.0, length, 0.0]
    dorsal = 0.5 * float(size.tips[2, 1])
    centre = out * np.array([dorsal - 0.5 * sizes[0], 0.5 * length,
                             0.5 * float(centres[1, 1] + centres[4, 1])])
    mass = DENSITY * float(np.prod(sizes))
    square = sizes**2
    _set_inertia(body, mass, mass / 12.0 * (square.sum() - square), centre)
    body.add_geom(name="hand", type=mujoco.mjtGeom.mjGEOM_BOX, size=0.5 * sizes, pos=centre, mass=0.0,
                  contype=PALM, conaffinity=TOUCHES[PALM])
    # The ball of the little finger rises out of the palm's ulnar half towards the wrist.
    thick = HYPOTHENAR_RATIO * 1e-3 * size.hand_mm
    palmar, ulnar = dorsal - sizes[0], float(centres[4, 1]) - 0.5 * thick
    ends = out * np.array([palmar, 0.1 * length, 0.5 * ulnar, palmar, 0.55 * length, ulnar])
    body.add_geom(name="hypothenar", type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[thick, 0.0, 0.0], fromto=ends,
                  mass=0.0, contype=PALM, conaffinity=TOUCHES[PALM])


def _add_phalanx(body: mujoco.MjsBody, size: HandSize, name: str, offset: Array) -> None:
    """Add a cylinder around the bone, with soft tissue beyond it at the tip, and a capsule as skin."""
    thick, bone = radius(size, name), float(np.linalg.norm(offset))
    along = offset / bone
    length = bone + (float(size.tips[FINGERS.index(name[:2]), 0]) if name[2] == "d" else 0.0)
    mass = DENSITY * math.pi * thick**2 * length
    across = mass / 12.0 * (3.0 * thick**2 + length**2)
    _set_inertia(body, mass, np.array([across, 0.5 * mass * thick**2, across]), 0.5 * length * along)
    end = (length - thick if name[2] == "d" else bone) * along
    group = THUMB if name.startswith("F1") else FINGER_BASE if name[2] == "p" else FINGER
    ends = np.concatenate([np.zeros(3), end])
    skin = thick * (THENAR_RATIO if name == "F1m" else 1.0)
    body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[skin, 0.0, 0.0], fromto=ends, mass=0.0,
                  solref=SKIN_SOLREF, solimp=SKIN_SOLIMP, contype=group, conaffinity=TOUCHES[group])
    if name[2] == "d":
        body.add_site(name=f"touch {name}", type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=ends,
                      size=[thick + TIP_REACH_M, 0.0, 0.0])


def _set_inertia(body: mujoco.MjsBody, mass: float, inertia: Array, centre: Array) -> None:
    body.mass, body.inertia, body.ipos, body.explicitinertial = mass, inertia, centre, True


def add_sensors(spec: mujoco.MjSpec, tree: SegmentTree, size: HandSize) -> None:
    """Add gyroscopes, then accelerometers, at the dorsal points, then touch sensors at the fingertips.

    Also adds sites at the bone ends of the fingertips, named `tip F1d` to `tip F5d`.
    """
    for segment, place in zip(tree.segments, dorsal_points(size), strict=True):
        spec.body(segment.name).add_site(name=f"imu {segment.name}", pos=place + segment.offset)
    for segment in tree.segments:
        if segment.name in TIPS:
            spec.body(segment.name).add_site(name=f"tip {segment.name}", pos=segment.offset)
    sense_sites(spec, tree.names)


def sense_sites(spec: mujoco.MjSpec, segments: tuple[str, ...]) -> None:
    """Add gyroscopes, then accelerometers, at sites such as `imu F2p`, then touch at such as `touch F2d`."""
    sensors = [(mujoco.mjtSensor.mjSENS_GYRO, f"imu {name}") for name in segments]
    sensors += [(mujoco.mjtSensor.mjSENS_ACCELEROMETER, f"imu {name}") for name in segments]
    sensors += [(mujoco.mjtSensor.mjSENS_TOUCH, f"touch {name}") for name in TIPS]
    for kind, site in sensors:
        spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=site)


class Passive(NamedTuple):
    """Passive moment of one freedom: stiffness of the joint alone, N m/rad, and damping, N m s/rad."""

    stiffness: float
    damping: float


WRIST_END_DEG, WRIST_BEYOND_DEG = 75.0, 15.0
WRIST_END_MOMENTS = {"flexion": 0.28, "extension": 0.99}
"""Moments of springs at the wrist's ends, N m, slack over the central range. The wrist's passive moment is
about 0 over the central 150 deg, and .5 and 1.2 at 90 deg of flexion and extension; relaxed muscles bear the
rest."""


def passive_joints(tree: SegmentTree) -> dict[str, Passive]:
    """Passive moments by freedom.

    Fingers: MCP joints are .033 to .047 N m/rad stiff, tendons included (PMC7775510), so less without them;
    PIP and DIP are chosen for the proportions in which FDP and FDS flex the joints, tendons included
    (Nimbarte 2008, doi 10.1186/1749-799X-3-8). Damping .003 to .005 at the MCP, PIP and DIP chosen for its
    damping ratio. Thumb and abduction: chosen, in proportion to the moved mass. Wrist: chosen, almost none in
    flexion, which is free over the central 150 deg; damping chosen.
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
    """Angles (d,) at rest, rad, with those of `rest_deg` replaced; InputError for an unknown freedom."""
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
    """Raise InputError, naming the parameter `where`, for an unknown freedom or an angle out of range."""
    for name in degrees.keys() - set(tree.freedoms):
        raise InputError(f"{where}.{name}", "is not a freedom of the hand", ", ".join(tree.freedoms),
                         did_you_mean(name, tree.freedoms))
    require_in_range(where, tree, resting_posture(tree, degrees))


RESTING_LENGTH = 1.06
"""Ratio of fibre length to the optimal one in the resting hand (chosen: the start of the passive slope)."""
SHORTEST, LONGEST, FASTEST, ECCENTRIC = 0.0, 2.0, 10.0, 1.4
"""Muscle curves after Thelen 2003 (doi 10.1115/1.1531112): fibre lengths without active force, relative to
the optimal one (his curve is exp(-(l - 1)^2 / .45); MuJoCo's stays within .08 of it from .5 to 1.5);
shortening velocity without force, optimal lengths per second; force in fast lengthening relative to
isometric."""
NEARLY_NONE = 1e-12
"""Least passive force: MuJoCo rejects 0."""
SPLINT_TIME_S = 0.01
"""Time constant with which a splinted joint returns, critically damped (chosen)."""
SPLINT_SOLIMP = [0.999, 0.9999, 0.001, 0.5, 2.0]
"""Solver parameters of a splint on a digit, so hard that it yields by a degree or two at most under the full
force of the muscles (chosen: MuJoCo's default suffices for the wrist, but not for a light finger)."""
CONTACT_TOLERANCE_M = 1e-5
"""Tolerance of the depth of a contact (chosen: MuJoCo's 1e-6 costs more and changes the shipped grasp by
.06 deg r.m.s., as halving the step does; skin yields by millimetres)."""
MEMORY = 4 << 20
"""Bytes for constraints and scratch: enough for some hundred contacts, and quick to copy."""


def empty_spec(step_s: float) -> mujoco.MjSpec:
    """An empty world with gravity and a solver."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    set_solver(spec, step_s)
    return spec


def set_solver(spec: mujoco.MjSpec, step_s: float) -> None:
    """Set gravity, integrator, friction and memory."""
    option = spec.option
    option.timestep = step_s
    option.gravity = [0.0, 0.0, -STANDARD_GRAVITY]
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 10.0  # friction ten times as stiff as the normal force: no creep in a grasp
    # Half of the Jacobian is empty: a finger's contact moves neither the other fingers nor the thumb.
    option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
    option.ccd_tolerance = CONTACT_TOLERANCE_M
    spec.memory = MEMORY


def compiled(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """Compile the model; InputError for numbers beyond MuJoCo's range, such as a mass of 1e-20 kg."""
    try:
        return spec.compile()
    except ValueError as fault:
        raise InputError("the hand's model", f"cannot be compiled: {fault}",
                         "realistic sizes and masses") from None


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
    """Add springs beyond the wrist's free range, as tendons that are slack within it."""
    end, never = math.radians(WRIST_END_DEG), 10.0
    for name, (low, high) in (("wrist flexion end", (-never, end)), ("wrist extension end", (-end, never))):
        tendon = spec.add_tendon(name=name)
        tendon.wrap_joint("wrist_flexion", 1.0)
        tendon.springlength = [low, high]


def add_muscles(spec: mujoco.MjSpec, muscles: tuple[Muscle, ...], strength: Array, tension: float,
                resting_lengths: Array) -> None:
    """Add an actuator to each muscle's tendon: force-length and force-velocity, controlled by activation.

    Passive tension is that of the healthy muscle times `tension`, independent of `strength` (29,);
    `resting_lengths` (29,), m, are those of the tendons in the resting hand.
    """
    stretch, knee = RESTING_LENGTH - 1.0, 0.5 * (LONGEST - 1.0)
    for name, muscle, factor, rest in zip(MUSCLES, muscles, strength, resting_lengths, strict=True):
        force, fibre = factor * muscle.force_n, 1e-3 * muscle.fibre_mm
        # MuJoCo's passive force is quadratic in stretch: this gives the given stiffness at rest.
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
    """Passive tension (29,), N, in the resting hand: half stiffness times stretch."""
    return np.array([0.5e-3 * tension * muscle.passive_n_m * muscle.fibre_mm * (RESTING_LENGTH - 1.0)
                     for muscle in muscles])


def set_passive_joints(model: mujoco.MjModel, tree: SegmentTree, stiffness: Array, damping: Array,
                       rest: Array, moments: Array, ends: float) -> None:
    """Set springs and dampers of the freedoms (d,).

    Spring lengths make all moments cancel without gravity at `rest`, (d,), rad, under the `moments`, (d,),
    N m, of resting tendons; a freedom without a spring follows these.
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
    """Add springs that pull freedoms to angles, deg, with a stiffness, N m/rad."""
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
