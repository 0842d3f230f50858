"""What is changed of MyoHand as myo-sim 0.2.4 ships it, each change under a name by which to leave it out."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.hand.movements import MUSCLES
from plants.hand.model import DENSITY, END_SOLIMP
from plants.hand.muscles import EXTENSOR_SHARE, FLEXOR_SHARE, MOBL_ARMS_N
from plants.myohand.anatomy import BONES, PALM_BODIES, STANDS_FOR

Array = NDArray[np.float64]
PLACEHOLDER = 1e-4
"""kg m^2 about every axis, of each bone of fingers and palm: the index finger's proximal phalanx has 2e-6."""
LOWEST_DEG, HIGHEST_DEG = -25.0, 10.0
"""Of `deviation_r`, which is positive towards the radius: 25 ulnar and 10 radial, as wrists have more of the
former (`fesloop.hand.skeleton`: 35 and 20, typical). Beyond 25 ulnar the path of EDC3_r jumps by 2 mm."""
ARMATURE = 2e-6
"""kg m^2. Chosen: what 25 g of muscle add where a tendon's arm is 9 mm. Without any the last phalanges, of
1 to 3 g, leave their ranges by 30 deg under full force in steps of 1 ms."""
END_TIME_S = 0.002
"""Back from beyond a range's end within this time, critically damped: chosen, as quick as steps of 1 ms can
be, since MyoHand's muscles are viscous beside its light segments (with the 6 ms of `hand`: 36 deg)."""
FORCE, PASSIVE = 2, 7
"""Where MuJoCo keeps a muscle's peak force and the size of its passive force."""
_SWEPT: tuple[tuple[str, ...], ...] = (("flexion_r",), ("deviation_r",), *(
    (*(f"{letters}{i}_{motion}_r" for i in range(2, 6)), thumb) for letters, motion, thumb in (
        ("mcp", "flexion", "cmc_flexion_r"), ("mcp", "abduction", "cmc_abduction_r"),
        ("pm", "flexion", "mp_flexion_r"), ("md", "flexion", "ip_flexion_r"))))
"""Joints that are moved together to find the lengths of tendons: each tendon crosses one of a row at most."""


def _inertia(spec: mujoco.MjSpec) -> None:
    """Cylinders as thick and long as the skin's capsule, balls where there is none, of the shipped masses."""
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
    """Less: 1e-4 kg m^2 on every joint is again fifty times what turns in a finger."""
    for joint in spec.joints:
        joint.armature = ARMATURE


def _ends(spec: mujoco.MjSpec) -> None:
    """Hard ends of the joints' ranges: full force takes a joint some degrees beyond."""
    for joint in spec.joints:
        joint.solref_limit, joint.solimp_limit = [END_TIME_S, 1.0], END_SOLIMP


def _deviation(spec: mujoco.MjSpec) -> None:
    """The wrist's range of deviation the right way round."""
    spec.joint("deviation_r").range = [math.radians(LOWEST_DEG), math.radians(HIGHEST_DEG)]


def _strength(spec: mujoco.MjSpec) -> None:
    """Peak forces with the shares of `plants.hand.muscles`, and EDC5_r's 39.4 N, where it has 139.4."""
    set_force(spec.actuator("EDC5_r"), MOBL_ARMS_N["EDC5"])
    for name in MUSCLES:
        share = EXTENSOR_SHARE if name[0] in "EA" else FLEXOR_SHARE
        for actuator in STANDS_FOR[name]:
            muscle = spec.actuator(actuator)
            set_force(muscle, share * muscle.gainprm[FORCE])


def set_force(muscle: mujoco.MjsActuator, newtons: float) -> None:
    """Peak force of a muscle: of what it makes actively, and of what passive force is a share of."""
    muscle.gainprm[FORCE] = muscle.biasprm[FORCE] = newtons


def _lengths(spec: mujoco.MjSpec) -> None:
    """Each muscle's range of lengths as its tendon has it over the joints' ranges.

    That is what MyoHand means to store: over it a fibre goes from .75 to 1.05 of its optimal length. What it
    stores fits other joints: FDS4_r and FDP5_r have tendons 50 mm shorter, RI5_r up to 15 mm.
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
"""By name, in the order in which they are applied, those made before the model is compiled."""
JOINTS_PATCH = "passive"
"""The name of the one made after it: springs and dampers of the joints (`plants.myohand.joints`)."""
NAMES = (*PATCHES, JOINTS_PATCH)


def patch(spec: mujoco.MjSpec, as_shipped: tuple[str, ...]) -> None:
    """Make all these changes but those named in `as_shipped`."""
    for name, change in PATCHES.items():
        if name not in as_shipped:
            change(spec)
