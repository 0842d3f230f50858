"""What holds the relaxed hand's joints: stiffness and damping of every freedom."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.hand.anthropometry import FINGERS
from fesloop.hand.segments import SegmentTree
from fesloop.hand.skeleton import RESTING_DEG

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
