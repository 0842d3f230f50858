"""MuJoCo model of the hand: bodies, passive moments and muscles."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.hand.anthropometry import FINGERS, FINGERTIPS, HandSize
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.hand.movements import MUSCLES
from fesloop.hand.segments import FREEDOMS, MOTIONS, SegmentTree
from fesloop.hand.skeleton import RESTING_DEG, dorsal_points

Array = NDArray[np.float64]


class Muscle(NamedTuple):
    """A muscle's force and fibre: peak isometric force, N, optimal fibre length, mm, and passive stiffness
    of the whole muscle, N/m, where the hand rests."""

    force_n: float
    fibre_mm: float
    passive_n_m: float


FLEXOR_SHARE, EXTENSOR_SHARE = 0.3, 0.5
"""Fraction of the peak forces of the MoBL-ARMS model (Saul 2015, doi 10.1080/10255842.2014.916698), as in
MyoHand (myo-sim 0.2.4), chosen so that the wrist's largest moments are as measured: flexion 5.2 to 18.7,
extension 3.4 to 9.4, radial deviation 7.9 to 15.3, ulnar 5.9 to 11.9 N m (Delp 1996, doi
10.1016/0021-9290(96)00029-2). Unscaled they give a flexion of 42 and an extension of 15."""
MOBL_ARMS_N = {
    "ECRL": 337.3, "ECRB": 252.2, "EDC2": 48.8, "EDC3": 94.4, "EDC4": 109.2, "EDC5": 39.4, "EDM": 72.4,
    "ECU": 192.9, "EIP": 47.3, "EPL": 88.3, "EPB": 46.0, "APL": 116.7, "FCR": 407.9, "PL": 101.0,
    "FCU": 479.8, "FDS2": 162.5, "FDS3": 258.8, "FDS4": 171.2, "FDS5": 75.3, "FDP2": 197.3, "FDP3": 212.4,
    "FDP4": 172.9, "FDP5": 236.8, "FPL": 201.0, "INT2": 183.6, "INT3": 257.2, "INT4": 250.8, "INT5": 155.7,
    "THENAR": 330.0}
"""Peak forces before scaling. EDC5: 39.4, where MyoHand has 139.4. INT: both interossei and the
lumbrical of MyoHand together. THENAR: chosen, its opponens of 180 and as much again for the rest."""
FIBRES_MM = {
    "ECRL": 81.0, "ECRB": 58.5, "EDC2": 70.0, "EDC3": 72.4, "EDC4": 62.6, "EDC5": 65.0, "EDM": 67.5,
    "ECU": 62.2, "EIP": 58.9, "EPL": 54.0, "EPB": 67.9, "APL": 71.3, "FCR": 62.8, "PL": 63.8, "FCU": 50.9,
    "FDS2": 72.0, "FDS3": 70.0, "FDS4": 73.0, "FDS5": 70.0, "FDP2": 66.0, "FDP3": 66.0, "FDP4": 68.0,
    "FDP5": 62.0, "FPL": 55.1, "INT2": 40.0, "INT3": 40.0, "INT4": 40.0, "INT5": 40.0, "THENAR": 45.0}
"""FDP and FDS: resting lengths of Brand 1981. Other extrinsic muscles: Holzbaur 2005
(doi 10.1007/s10439-005-3320-7), recalled. Intrinsic ones are chosen (MyoHand: 33 to 54)."""
PASSIVE_N_M = {"FDP": 20.0, "FDS": 20.0, "EDC": 40.0, "EIP": 10.0, "EDM": 20.0, "FPL": 30.0, "EPL": 20.0,
               "INT": 20.0, "THE": 20.0}
"""Passive stiffness by the first three letters of a name; all others 10. Chosen: with the joints' own
stiffness the MCP joint is as stiff as measured, tendons included, and the fingers follow the wrist
(tenodesis)."""

WRIST_MM = {
    "ECRL": (-10.2, -23.6), "ECRB": (-13.7, -14.2), "EDC2": (-17.3, -2.3), "EDC3": (-17.8, 2.2),
    "EDC4": (-17.3, 9.1), "EDC5": (-11.1, 9.9), "EDM": (-9.5, 14.5), "ECU": (-5.7, 27.8),
    "EIP": (-12.8, 2.8), "EPL": (-7.5, -22.7), "EPB": (-1.0, -34.2), "APL": (7.0, -26.8),
    "FCR": (17.7, -4.0), "PL": (21.7, -7.2), "FCU": (18.4, 15.0), "FDS2": (14.8, -9.6),
    "FDS3": (14.8, -7.3), "FDS4": (14.8, -1.3), "FDS5": (14.8, 0.4), "FDP2": (13.1, -9.6),
    "FDP3": (13.1, -5.3), "FDP4": (13.1, -2.7), "FDP5": (13.1, -0.9), "FPL": (15.1, -20.8)}
"""Flexion and ulnar deviation. Flexion of FCR, PL, FDS, FDP, FPL, APL, ECRB, ECRL, ECU, EPL: published wrist
moment arms at 0 deg. The others, and all of deviation: MyoHand (myo-sim 0.2.4) at its neutral posture, but
for FCU's deviation, which is chosen: MyoHand's 10.6 leaves the largest ulnar moment below the measured."""
FINGER_MM = {
    "FDP2": (10.1, 9.8, 6.5), "FDP3": (11.6, 10.7, 7.0), "FDP4": (10.4, 10.4, 6.8), "FDP5": (8.9, 8.5, 6.0),
    "FDS2": (12.1, 8.3, 0.0), "FDS3": (14.0, 8.7, 0.0), "FDS4": (13.0, 8.5, 0.0), "FDS5": (9.8, 7.4, 0.0),
    "EDC2": (-8.6, -2.9, -0.8), "EDC3": (-9.4, -3.2, -0.9), "EDC4": (-7.9, -2.7, -0.7),
    "EDC5": (-5.9, -2.0, -0.5), "EIP": (-9.2, -3.1, -0.9), "EDM": (-5.7, -1.9, -0.5),
    "INT2": (6.6, -2.6, -1.6), "INT3": (6.6, -2.6, -1.6), "INT4": (6.6, -2.6, -1.6),
    "INT5": (6.6, -2.6, -1.6)}
"""Flexion of MCP, PIP, DIP. FDP, FDS: Ketchum 1978. EDC2 and INT at the MCP: An 1983
(doi 10.1016/0021-9290(83)90053-X) as usually quoted; other extensors at the MCP: MyoHand. Extensors at PIP
and DIP in the proportions in which EDC extends the joints (Nimbarte 2008, doi 10.1186/1749-799X-3-8). INT at
PIP and DIP chosen, for all fingers alike. No tendon abducts: interossei cancel out, others are small."""
THUMB_MM = {
    "FPL": (11.0, 0.0, 0.0, 7.1, 8.8), "EPL": (-6.7, -9.0, 0.0, -9.0, -5.2),
    "EPB": (-12.5, 0.8, 0.0, -9.1, 0.0),
    "APL": (-7.0, 10.0, 0.0, 0.0, 0.0), "THENAR": (10.0, 8.0, 4.0, 6.0, -1.0)}
"""Flexion and palmar abduction in the resting thumb's own plane, and pronation, at the CMC joint; flexion of
MCP and IP. Directions: Smutz 1998 (doi 10.1016/S0021-9290(98)00043-8): FPL a flexor alone, EPL extensor and
adductor, EPB extensor and mild abductor, APL extensor and abductor, the thenar group flexor and abductor.
Magnitudes of EPL, EPB and of FPL at MCP and IP: MyoHand; others chosen."""


ADULT_MM = 190.0
"""Length of the hand to which all numbers here apply (chosen: the default). Another hand is built to scale s:
lengths grow as s, forces as its square, moments, stiffness and damping as its cube."""


def passive_n_m(name: str) -> float:
    """Passive stiffness of a whole muscle, N/m, in the resting adult hand."""
    return PASSIVE_N_M.get(name[:3], 10.0)


def muscles(scale: float = 1.0) -> tuple[Muscle, ...]:
    """Force and fibre of every muscle, in the order of `MUSCLES`, of a hand built to scale."""
    rows = []
    for name in MUSCLES:
        share = EXTENSOR_SHARE if name[0] in "EA" else FLEXOR_SHARE
        rows.append(Muscle(scale**2 * share * MOBL_ARMS_N[name], scale * FIBRES_MM[name],
                           scale * passive_n_m(name)))
    return tuple(rows)


def moment_arms(tree: SegmentTree, thumb_pronation: float, scale: float = 1.0) -> Array:
    """Moment arms (29, d) of all muscles about the hand's freedoms, m; positive: tension increases the angle.

    `thumb_pronation`, rad, is that of the resting thumb, in whose plane the arms at its CMC joint are given.
    """
    arms = np.zeros((len(MUSCLES), len(tree.freedoms)))
    # Axes of the pronated thumb in the frame before pronation: its z flexes, its -x abducts.
    sine, cosine = np.sin(thumb_pronation), np.cos(thumb_pronation)
    for i, name in enumerate(MUSCLES):
        placed = dict(zip(("wrist_flexion", "wrist_abduction"), WRIST_MM.get(name, ()), strict=False))
        if name in FINGER_MM:
            finger = {"EIP": "F2", "EDM": "F5"}.get(name, f"F{name[-1]}")
            joints = (f"{finger}_{joint}_flexion" for joint in ("mcp", "pip", "dip"))
            placed.update(zip(joints, FINGER_MM[name], strict=True))
        if name in THUMB_MM:
            flexion, abduction, pronation, mcp, ip = THUMB_MM[name]
            placed.update({
                "F1_cmc_flexion": cosine * flexion + sine * abduction,
                "F1_cmc_abduction": sine * flexion - cosine * abduction,
                "F1_cmc_pronation": pronation, "F1_mcp_flexion": mcp, "F1_ip_flexion": ip})
        for freedom, millimetres in placed.items():
            arms[i, tree.freedom(freedom)] = 1e-3 * scale * millimetres
    return arms


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


def _set_inertia(body: mujoco.MjsBody, mass: float, inertia: Array, centre: Array) -> None:
    body.mass, body.inertia, body.ipos, body.explicitinertial = mass, inertia, centre, True


def add_sensors(spec: mujoco.MjSpec, tree: SegmentTree, size: HandSize) -> None:
    """Add gyroscopes, then accelerometers, at the dorsal points.

    Also adds sites at the bone ends of the fingertips, named `tip F1d` to `tip F5d`.
    """
    for segment, place in zip(tree.segments, dorsal_points(size), strict=True):
        spec.body(segment.name).add_site(name=f"imu {segment.name}", pos=place + segment.offset)
    for segment in tree.segments:
        if segment.name in FINGERTIPS:
            spec.body(segment.name).add_site(name=f"tip {segment.name}", pos=segment.offset)
    sense_sites(spec, tree.names)


def sense_sites(spec: mujoco.MjSpec, segments: tuple[str, ...]) -> None:
    """Add gyroscopes, then accelerometers, at sites such as `imu F2p`."""
    sensors = [(mujoco.mjtSensor.mjSENS_GYRO, f"imu {name}") for name in segments]
    sensors += [(mujoco.mjtSensor.mjSENS_ACCELEROMETER, f"imu {name}") for name in segments]
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
CONTACT_TOLERANCE_M = 1e-7
"""Tolerance of the depth of a contact (chosen: with MuJoCo's own, 1e-6, halving the step changes a grasp by
up to 1.5 deg, with this one by .6, and as much with a tenth of it)."""
MEMORY = 4 << 20
"""Bytes for constraints and scratch: enough for some hundred contacts, and quick to copy."""


def mujoco_library() -> Path:
    """File of MuJoCo's library, which is loaded already."""
    folder = Path(mujoco.__file__).parent
    found = [path for pattern in ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll")
             for path in folder.glob(pattern)]
    if not found:
        raise ImportError(f"{folder}: MuJoCo's library is missing; expected libmujoco.so.*, "
                          "libmujoco.*.dylib or mujoco.dll; install mujoco from its wheel")
    return found[0]


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
    option.impratio = 10.0  # friction ten times as stiff as the normal force: less creep; see `GraspObject`
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
