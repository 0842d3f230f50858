"""MyoHand's model with the forearm, skin, segment frames, sensors and solver of `hand`."""

from __future__ import annotations

from functools import cache

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.hand.anthropometry import FINGERTIPS
from fesloop.hand.movements import MUSCLES
from fesloop.hand.skeleton import dorsal_points
from plants.hand.model import (
    FIBRES_MM,
    FINGER,
    FINGER_BASE,
    NEARLY_NONE,
    PALM,
    SKIN_SOLIMP,
    SKIN_SOLREF,
    THUMB,
    TOUCHES,
    sense_sites,
    set_solver,
)
from plants.myohand.anatomy import (
    BONES,
    HAND_BODY,
    PALM_BODIES,
    REPRESENTS,
    Anatomy,
    anatomy,
    load,
)
from plants.myohand.patches import FORCE, PASSIVE, set_force

Array = NDArray[np.float64]
ROOT, FIRST = "myoarm_r_root", "clavicle_r"
"""Root body of MyoHand, and its only child."""


def to_quaternion(axes: Array) -> Array:
    """Quaternion (4,) of a rotation matrix (3, 3)."""
    q = np.zeros(4)
    mujoco.mju_mat2Quat(q, np.ascontiguousarray(axes).ravel())
    return q


@cache
def loaded() -> tuple[mujoco.MjSpec, mujoco.MjModel, Anatomy]:
    """Stripped MyoHand, to be copied before changes, and model and anatomy of the shipped one.

    Raises InputError if it is missing.
    """
    spec = load()
    shipped = spec.compile()
    strip(spec)
    return spec, shipped, anatomy(shipped)


def strip(spec: mujoco.MjSpec) -> None:
    """Remove all but bones without meshes, the skin's capsules, and the represented muscles."""
    kept = {name for names in REPRESENTS.values() for name in names}
    for actuator in list(spec.actuators):
        if actuator.name not in kept:
            spec.delete(spec.tendon(actuator.target))
            spec.delete(actuator)
    bodies = {bone.body for bone in BONES.values()} | set(PALM_BODIES)
    on_path = {wrap.target.name for tendon in spec.tendons for wrap in tendon.path}
    for geom in list(spec.geoms):
        skin = (geom.type == mujoco.mjtGeom.mjGEOM_CAPSULE and geom.contype and geom.parent.name in bodies)
        if not skin and geom.name not in on_path:
            spec.delete(geom)
        else:
            geom.material = ""
    for thing in (*spec.meshes, *spec.materials, *spec.textures, *spec.cameras, *spec.excludes):
        spec.delete(thing)


def weld_arm(spec: mujoco.MjSpec, shipped: mujoco.MjModel, found: Anatomy, forearm: Array,
             step_s: float) -> None:
    """Weld MyoHand's arm to a body `forearm` of orientation `forearm`, (4,), with the wrist at the origin.

    The arm has no mass, as the forearm is fixed or driven.
    """
    set_solver(spec, step_s)
    at_zero = mujoco.MjData(shipped)
    mujoco.mj_forward(shipped, at_zero)
    spec.delete(spec.joint("pro_sup_r"))
    root, first = spec.body(ROOT), spec.body(FIRST)
    place = at_zero.body(FIRST)
    first.pos = found.axes.T @ (place.xpos - found.wrist)
    first.quat = to_quaternion(found.axes.T @ place.xmat.reshape(3, 3))
    root.name, root.pos, root.quat = "forearm", np.zeros(3), forearm
    body = first
    while body.name != HAND_BODY:
        body.mass, body.inertia, body.fullinertia = 0.0, np.zeros(3), np.full(6, np.nan)
        body = body.bodies[0]


def add_segments(spec: mujoco.MjSpec, found: Anatomy) -> None:
    """Add massless bodies in the segments' frames, with their names, and sensors on the back of each."""
    names = ("forearm", *found.frames)
    for name, (bone, end, axes) in found.frames.items():
        spec.body(bone).add_body(name=name, pos=end, quat=to_quaternion(axes))
    for name, place in zip(names, dorsal_points(found.size), strict=True):
        spec.body(name).add_site(name=f"imu {name}", pos=place)
    for name in FINGERTIPS:
        spec.body(name).add_site(name=f"tip {name}")
    sense_sites(spec, names)


def set_skin(spec: mujoco.MjSpec) -> None:
    """Give the remaining skin the contact parameters of `hand`, and the names of segments."""
    owner = {bone.body: name for name, bone in BONES.items()}
    for geom in spec.geoms:
        if not geom.contype:
            continue
        body = geom.parent.name
        segment = owner.get(body)
        group = (PALM if segment is None else THUMB if segment.startswith("F1")
                 else FINGER_BASE if segment[2] == "p" else FINGER)
        geom.name = segment or body
        geom.contype, geom.conaffinity, geom.margin = group, TOUCHES[group], 0.0
        geom.solref, geom.solimp = SKIN_SOLREF, SKIN_SOLIMP


def set_muscles(spec: mujoco.MjSpec, strength: Array, tension: float) -> None:
    """Remove MyoHand's activation lag, and set factors (29,) on peak force, and one on passive tension.

    Passive tension is that of the healthy muscle times `tension`, independent of its strength.
    """
    for name, factor in zip(MUSCLES, strength, strict=True):
        for actuator in REPRESENTS[name]:
            muscle = spec.actuator(actuator)
            muscle.dyntype = mujoco.mjtDyn.mjDYN_NONE
            passive = NEARLY_NONE + muscle.gainprm[PASSIVE] * tension / factor
            muscle.gainprm[PASSIVE] = muscle.biasprm[PASSIVE] = passive
            set_force(muscle, factor * muscle.gainprm[FORCE])


def fibres_of(activated: tuple[str, ...]) -> Array:
    """Matrix (29, 36), 1/m, from tendon velocities of MyoHand to fibre velocities, optimal lengths per s."""
    share = np.array([[1.0 * (owner == name) for owner in activated] for name in MUSCLES])
    lengths = 1e-3 * np.array([FIBRES_MM[name] for name in MUSCLES])
    return np.asarray(share / (share.sum(axis=1) * lengths)[:, np.newaxis])
