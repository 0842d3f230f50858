"""Named changes of MyoHand as shipped with myo-sim 0.2.4; each can be omitted."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.hand.movements import MUSCLES
from plants.hand.model import DENSITY, END_SOLIMP, EXTENSOR_SHARE, FLEXOR_SHARE, MOBL_ARMS_N
from plants.myohand.anatomy import BONES, PALM_BODIES, REPRESENTS

Array = NDArray[np.float64]
PLACEHOLDER = 1e-4
"""Shipped inertia of each bone of fingers and palm about every axis, kg m^2; the index finger's proximal
phalanx has 2e-6."""
LOWEST_DEG, HIGHEST_DEG = -25.0, 10.0
"""Range of `deviation_r`, positive towards the radius: 25 ulnar and 10 radial, as wrists have more ulnar
range (`fesloop.hand.skeleton`: 35 and 20, typical). Beyond 25 ulnar the path of EDC3_r jumps by 2 mm."""
ARMATURE = 2e-6
"""Armature of joints, kg m^2 (chosen: that of 25 g of muscle at a tendon's arm of 9 mm). Without it the last
phalanges, of 1 to 3 g, leave their ranges by 30 deg under full force in steps of 1 ms."""
END_TIME_S = 0.002
"""Time to return from beyond a range's end, critically damped (chosen: as short as steps of 1 ms allow, since
MyoHand's muscles are viscous relative to its light segments; with the 6 ms of `hand`: 36 deg)."""
FORCE, PASSIVE = 2, 7
"""Indices of a muscle's peak force and passive force among MuJoCo's parameters."""
_SWEPT: tuple[tuple[str, ...], ...] = (("flexion_r",), ("deviation_r",), *(
    (*(f"{letters}{i}_{motion}_r" for i in range(2, 6)), thumb) for letters, motion, thumb in (
        ("mcp", "flexion", "cmc_flexion_r"), ("mcp", "abduction", "cmc_abduction_r"),
        ("pm", "flexion", "mp_flexion_r"), ("md", "flexion", "ip_flexion_r"))))
"""Joints moved together to find the lengths of tendons; each tendon crosses at most one of a row."""


def _inertia(spec: mujoco.MjSpec) -> None:
    """Set inertias of cylinders of the skin capsule's size, or else of balls, of the shipped masses."""
    for name in (*PALM_BODIES, *(bone.body for bone in BONES.values())):
        body = spec.body(name)
        if not np.allclose(body.fullinertia[:3], PLACEHOLDER):
            continue
        body.fullinertia = np.full(6, np.nan)  # so that MuJoCo takes `inertia`
        capsules = [geom for geom in body.geoms
                    if geom.contype and geom.type == mujoco.mjtGeom.mjGEOM_CAPSULE]
        if capsules:
            thick, length = capsules[0].size[0], 2.0 * capsules[0].size[1]
            across = body.mass / 12.0 * (3.0 * thick**2 + length**2)
            body.inertia = [across, across, 0.5 * body.mass * thick**2]
            body.ipos, body.iquat = capsules[0].pos, capsules[0].quat
        else:
            ball = (0.75 * body.mass / (math.pi * DENSITY)) ** (1.0 / 3.0)
            body.inertia = [0.4 * body.mass * ball**2] * 3


def _armature(spec: mujoco.MjSpec) -> None:
    """Reduce the armature: 1e-4 kg m^2 on every joint is fifty times the inertia of a finger's segment."""
    for joint in spec.joints:
        joint.armature = ARMATURE


def _ends(spec: mujoco.MjSpec) -> None:
    """Set hard ends of the joints' ranges, which full force exceeds by some degrees."""
    for joint in spec.joints:
        joint.solref_limit, joint.solimp_limit = [END_TIME_S, 1.0], END_SOLIMP


def _deviation(spec: mujoco.MjSpec) -> None:
    """Exchange the wrist's ranges of radial and ulnar deviation."""
    spec.joint("deviation_r").range = [math.radians(LOWEST_DEG), math.radians(HIGHEST_DEG)]


def _strength(spec: mujoco.MjSpec) -> None:
    """Scale peak forces by the fractions of `plants.hand.model`; EDC5_r has 39.4 N, shipped as 139.4."""
    set_force(spec.actuator("EDC5_r"), MOBL_ARMS_N["EDC5"])
    for name in MUSCLES:
        share = EXTENSOR_SHARE if name[0] in "EA" else FLEXOR_SHARE
        for actuator in REPRESENTS[name]:
            muscle = spec.actuator(actuator)
            set_force(muscle, share * muscle.gainprm[FORCE])


def set_force(muscle: mujoco.MjsActuator, newtons: float) -> None:
    """Set the peak force of a muscle, to which active and passive force are relative."""
    muscle.gainprm[FORCE] = muscle.biasprm[FORCE] = newtons


def _lengths(spec: mujoco.MjSpec) -> None:
    """Set each muscle's range of lengths to that of its tendon over the joints' ranges.

    MyoHand defines it so: over this range a fibre goes from .75 to 1.05 of its optimal length. The stored
    ranges fit other joints: FDS4_r and FDP5_r have tendons 50 mm shorter, RI5_r up to 15 mm.
    """
    model = spec.compile()
    posture, low_high = mujoco.MjData(model), []
    ranges = np.stack([model.jnt_range[:, 0], model.jnt_range.mean(axis=1), model.jnt_range[:, 1]], axis=1)
    rows = [[model.joint(name).id for name in names] for names in _SWEPT]
    for places in itertools.product(range(3), repeat=len(rows)):
        for joints, place in zip(rows, places, strict=True):
            posture.qpos[joints] = ranges[joints, place]
        mujoco.mj_kinematics(model, posture)
        mujoco.mj_comPos(model, posture)
        mujoco.mj_tendon(model, posture)
        low_high.append(posture.ten_length.copy())
    lengths = np.array(low_high)
    for actuator in spec.actuators:
        tendon = model.tendon(actuator.target).id
        actuator.lengthrange = [lengths[:, tendon].min(), lengths[:, tendon].max()]


PATCHES: dict[str, Callable[[mujoco.MjSpec], None]] = {
    "inertia": _inertia, "armature": _armature, "ends": _ends, "deviation": _deviation, "strength": _strength,
    "lengths": _lengths}
"""Changes before the model is compiled, by name, in the order of application."""
JOINTS_PATCH = "passive"
"""Name of the change after compilation: springs and dampers of the joints (`plants.myohand.joints`)."""
NAMES = (*PATCHES, JOINTS_PATCH)


def patch(spec: mujoco.MjSpec, as_shipped: tuple[str, ...]) -> None:
    """Apply all changes except those named in `as_shipped`."""
    for name, change in PATCHES.items():
        if name not in as_shipped:
            change(spec)
