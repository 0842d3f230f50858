"""The hand's segments as rigid bodies for MuJoCo: joints, inertia, skin that touches, and sensor sites."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.hand.anthropometry import FINGERS, HandSize
from fesloop.hand.segments import FREEDOMS, MOTIONS, SegmentTree
from fesloop.hand.skeleton import dorsal_points

Array = NDArray[np.float64]
DENSITY = 1100.0
"""kg/m^3, of segments taken as cylinders, the palm as a box."""
RADIUS_RATIOS = {"p": 4.0 / 3.0, "m": 7.0 / 6.0, "d": 1.0}
"""Of a finger's segments over half the thickness of its tip: those of the 8, 7 and 6 mm that give the index
finger's proximal phalanx the published 2e-6 kg m^2."""
THUMB_RADIUS_RATIOS = {"m": 4.0 / 3.0, "p": 7.0 / 6.0, "d": 1.0}
BREADTH_RATIO, THICKNESS_RATIO = 0.45, 0.15
"""Breadth and thickness of the palm over hand length: 85.8 of 190.2 mm (Ibeachu 2011); 28 of 190 mm is
chosen."""
WIDER_RANGES = {"wrist_flexion": (-0.5 * math.pi, 0.5 * math.pi)}
"""Hard ends, rad, beyond those of the typical range: soft tissue stops the relaxed wrist before."""
HYPOTHENAR_RATIO, THENAR_RATIO = 0.075, 1.6
"""Chosen: radius of the ball of the little finger over hand length; skin of the ball of the thumb over its
metacarpal's radius."""
TIPS = tuple(f"{finger}d" for finger in FINGERS)
"""The distal segments."""
TIP_REACH_M = 0.002
"""How far beyond the skin of a distal segment its contacts count as the fingertip's."""
END_SOLREF, END_SOLIMP = [0.006, 1.0], [0.95, 0.999, 0.02, 0.5, 2.0]
"""Of the ends of a joint's range: back from beyond within 6 ms, critically damped, and as hard as keeps a
joint under its muscles' full force within a few degrees (chosen)."""
SKIN_SOLREF, SKIN_SOLIMP = [0.02, 1.0], [0.5, 0.95, 0.006, 0.5, 2.0]
"""Of contacts with skin: soft, and stiffer over the first 6 mm, as the pulp of a fingertip is (chosen: of
those tried the one with which halving a step of 1 ms changes grasps the least)."""
FINGER, FINGER_BASE, THUMB, PALM, OBJECT, TABLE = 1, 2, 4, 8, 16, 32
"""Groups of what can touch."""
TOUCHES = {FINGER: 0, FINGER_BASE: 0, PALM: 0, THUMB: FINGER, OBJECT: FINGER | FINGER_BASE | THUMB | PALM,
           TABLE: OBJECT | FINGER | FINGER_BASE | THUMB | PALM}
"""By group, the groups that it meets. Fingers don't meet each other, nor the palm: ranges keep them apart."""


def radius(size: HandSize, name: str) -> float:
    """Radius of a segment of a digit, m."""
    half = 0.5 * float(size.tips[FINGERS.index(name[:2]), 1])
    return half * (THUMB_RADIUS_RATIOS if name.startswith("F1") else RADIUS_RATIOS)[name[2]]


def add_hand(spec: mujoco.MjSpec, tree: SegmentTree, size: HandSize, forearm: Array) -> None:
    """Add forearm, hand and digits to an empty spec, the wrist's centre at the origin.

    Joints are named as the tree's freedoms, bodies as its segments; the forearm, which does not move, is
    turned by `forearm`, (4,), from its own frame to the global one. A body's frame stands at the joint's
    centre, parallel to the segment's own.
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
    """What is seen of it: it touches nothing."""
    reach = -size.outwards * size.forearm
    body.add_geom(name="forearm", type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[0.03, 0.0, 0.0], mass=0.0,
                  fromto=[0.0, 0.15 * reach, 0.0, 0.0, reach, 0.0], contype=0, conaffinity=0)


def _add_palm(body: mujoco.MjsBody, size: HandSize) -> None:
    """A box from the wrist to the middle finger's MCP joint, as far behind the bones as skin is."""
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
    """A cylinder around the bone, soft tissue beyond it at the tip; its skin a capsule that ends there."""
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
    """Gyroscopes, then accelerometers at the dorsal points, then touch at the fingertips.

    Also sites at the bone ends of the fingertips, named `tip F1d` to `tip F5d`.
    """
    for segment, place in zip(tree.segments, dorsal_points(size), strict=True):
        spec.body(segment.name).add_site(name=f"imu {segment.name}", pos=place + segment.offset)
    for segment in tree.segments:
        if segment.name in TIPS:
            spec.body(segment.name).add_site(name=f"tip {segment.name}", pos=segment.offset)
    sense_sites(spec, tree.names)


def sense_sites(spec: mujoco.MjSpec, segments: tuple[str, ...]) -> None:
    """Gyroscopes, then accelerometers, at sites named `imu F2p`, then touch at those named `touch F2d`."""
    wanted = [(mujoco.mjtSensor.mjSENS_GYRO, f"imu {name}") for name in segments]
    wanted += [(mujoco.mjtSensor.mjSENS_ACCELEROMETER, f"imu {name}") for name in segments]
    wanted += [(mujoco.mjtSensor.mjSENS_TOUCH, f"touch {name}") for name in TIPS]
    for kind, site in wanted:
        spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=site)
