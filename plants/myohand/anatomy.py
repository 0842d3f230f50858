"""Parts of MyoHand that represent the hand's segments, freedoms and muscles, and its segments' frames."""

from __future__ import annotations

from typing import NamedTuple, cast

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.hand.anthropometry import SOFT_TISSUE_MM, Five, HandSize, Three
from fesloop.hand.movements import EXTRINSIC

Array = NDArray[np.float64]
FiveThrees = tuple[Three, Three, Three, Three, Three]


class Bone(NamedTuple):
    """MyoHand's body of a segment, the joint at its near end that flexes it, the sign of flexion about its
    axis, and the joint or site at its far end."""

    body: str
    joint: str
    sign: float
    end: str


def _finger(digit: int, tip: str) -> dict[str, Bone]:
    joints = (f"mcp{digit}_flexion_r", f"pm{digit}_flexion_r", f"md{digit}_flexion_r", tip)
    bodies = (f"{digit}proxph_r", f"midph{digit}_r", f"distph{digit}_r")
    return {f"F{digit}{letter}": Bone(body, near, 1.0, far) for letter, body, near, far in
            zip("pmd", bodies, joints[:-1], joints[1:], strict=True)}


BONES: dict[str, Bone] = {
    "F1m": Bone("firstmc_r", "cmc_flexion_r", -1.0, "mp_flexion_r"),
    "F1p": Bone("proximal_thumb_r", "mp_flexion_r", -1.0, "ip_flexion_r"),
    "F1d": Bone("distal_thumb_r", "ip_flexion_r", -1.0, "THtip_r"),
    **_finger(2, "IFtip_r"), **_finger(3, "MFtip_r"), **_finger(4, "RFtip_r"), **_finger(5, "LFtip_r")}
"""Bones by segment, in the order of the hand's tree after forearm and hand."""
HAND_BODY, WRIST = "lunate_r", "flexion_r"
PALM_BODIES = ("lunate_r", "scaphoid_r", "pisiform_r", "triquetrum_r", "capitate_r", "trapezium_r",
               "trapezoid_r", "hamate_r", "secondmc_r", "thirdmc_r", "fourthmc_r", "fifthmc_r")
"""Bodies of the palm, together one rigid body: MyoHand's carpal bones and metacarpals have no joints."""
JOINTS: dict[str, str] = {
    "wrist_flexion": "flexion_r", "wrist_abduction": "deviation_r",
    "F1_cmc_flexion": "cmc_abduction_r", "F1_cmc_abduction": "cmc_flexion_r",
    "F1_mcp_flexion": "mp_flexion_r", "F1_ip_flexion": "ip_flexion_r",
    **{f"F{i}_{ours}": f"{theirs}{i}_{motion}_r" for i in range(2, 6) for ours, theirs, motion in (
        ("mcp_flexion", "mcp", "flexion"), ("mcp_abduction", "mcp", "abduction"),
        ("pip_flexion", "pm", "flexion"), ("dip_flexion", "md", "flexion"))}}
"""MyoHand's joint that mainly turns each freedom, to either side. `F1_cmc_pronation` has none: it follows
from the two others. The thumb is pronated by 93 deg, so what MyoHand calls abduction bends the thumb out
of the palm, our flexion, and what it calls extension moves it sideways, our abduction to the radial side.
MyoHand's own `pro_sup_r` is the forearm's, which is turned as a whole."""
REPRESENTS: dict[str, tuple[str, ...]] = {
    **{name: (f"{name}_r",) for name in EXTRINSIC}, "THENAR": ("OP_r",),
    "INT2": ("LU_RB2_r", "UI_UB2_r"),
    **{f"INT{i}": (f"RI{i}_r", f"LU_RB{i}_r", f"UI_UB{i}_r") for i in range(3, 6)}}
"""MyoHand's muscles that each muscle of `hand` activates. THENAR: MyoHand has the opponens alone, no short
flexor, abductor or adductor. Interossei and lumbricals: radial interosseous, lumbrical with the radial band,
ulnar interosseous with the ulnar band; the index finger's radial one, RI2_r, is omitted: at some 10 deg of
that MCP joint its path jumps from one side of a wrapping surface to the other and its length by up to 11 mm,
and below that angle it extends the joint that it should flex. The pronators, PT_r and PQ_r, are omitted."""


def activated_by(model: mujoco.MjModel) -> tuple[str, ...]:
    """Muscle of `hand` that activates each of MyoHand's muscles, (36,)."""
    owner = {theirs: name for name, represented in REPRESENTS.items() for theirs in represented}
    return tuple(owner[model.actuator(k).name] for k in range(len(owner)))


class Anatomy(NamedTuple):
    """Frames of MyoHand's segments with all its joints at 0.

    Attributes
    ----------
    wrist: the wrist's centre, (3,), m, in MyoHand's frame. axes: axes of the hand in the columns, (3, 3).
    frames: by segment, hand first, the body, and in its frame the far end (3,), m, and the axes (3, 3).
    size: measures of the hand.
    """

    wrist: Array
    axes: Array
    frames: dict[str, tuple[str, Array, Array]]
    size: HandSize


def load() -> mujoco.MjSpec:
    """Load MyoHand's right hand and arm as shipped; InputError if the package is missing.

    `myo_sim.load_spec("myohand_r")` attaches the same to a torso, but leaves a log file behind.
    """
    try:
        from myo_sim import FRAGMENT_SPEC_BUILDERS
    except ImportError:
        raise InputError("myohand", "the package myo-sim is missing", "the extra `myohand`",
                         "pip install 'fesloop[myohand]'") from None
    return FRAGMENT_SPEC_BUILDERS["myohand_r"]()


def anatomy(model: mujoco.MjModel) -> Anatomy:
    """Find the frames of MyoHand as shipped, in fesloop's convention for right hands.

    y points from a segment's far end to the joint at its near end, z as nearly as possible along that joint's
    axis of flexion; for the hand y points from the middle finger's MCP joint to the wrist's centre, z from
    the little finger's MCP joint to the index finger's.
    """
    at_zero = mujoco.MjData(model)
    mujoco.mj_forward(model, at_zero)

    def place(name: str) -> Array:
        found = (at_zero.site(name).xpos if name.endswith("tip_r") else
                 at_zero.xanchor[model.joint(name).id])
        return np.array(found)

    def frame(body: str, end: Array, axes: Array) -> tuple[str, Array, Array]:
        turned = at_zero.body(body).xmat.reshape(3, 3).T
        return body, turned @ (end - at_zero.body(body).xpos), turned @ axes

    wrist = place(WRIST)
    knuckles = [place(f"mcp{i}_flexion_r") for i in range(2, 6)]
    hand = _axes(wrist - knuckles[1], knuckles[0] - knuckles[3])
    frames = {"hand": frame(HAND_BODY, knuckles[1], hand)}
    lengths = []
    for segment, bone in BONES.items():
        near, far = place(bone.joint), place(bone.end)
        flexion = bone.sign * at_zero.xaxis[model.joint(bone.joint).id]
        frames[segment] = frame(bone.body, far, _axes(near - far, flexion))
        lengths.append(_millimetres(near - far))
    elbow = at_zero.body("radius_r").xpos
    tips = [2e3 * float(model.geom_size[skin(BONES[f"F{i}d"].body, model), 0]) for i in range(1, 6)]
    size = _size(_millimetres(wrist - knuckles[1]), lengths, _millimetres(elbow - wrist), tips)
    return Anatomy(wrist, hand, frames, size)


def _millimetres(way: Array) -> float:
    return round(1e3 * float(np.linalg.norm(way)), 2)


def _size(palm: float, lengths: list[float], forearm: float, thickness: list[float]) -> HandSize:
    """Measures from lengths, mm: palm, 15 segments, forearm, thickness of the tips."""
    rows = [cast(Three, tuple(lengths[i:i + 3])) for i in range(0, 15, 3)]
    middle = palm + sum(rows[2]) + SOFT_TISSUE_MM[2]
    return HandSize(hand_mm=middle, palm_mm=palm, segments_mm=cast(FiveThrees, tuple(rows)),
                    forearm_mm=forearm, tip_thickness_mm=cast(Five, tuple(thickness)))


def skin(body: str, model: mujoco.MjModel) -> int:
    """Capsule (geom) of a body's skin; -1 if it has none."""
    for geom in range(model.ngeom):
        if (model.body(model.geom_bodyid[geom]).name == body and model.geom_contype[geom]
                and model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CAPSULE):
            return geom
    return -1


def _axes(y: Array, z: Array) -> Array:
    """Axes x, y, z in the columns, (3, 3): y as given, z made perpendicular to it."""
    along = y / np.linalg.norm(y)
    across = z - along * (along @ z)
    across /= np.linalg.norm(across)
    return np.column_stack([np.cross(along, across), along, across])
