"""A therapist's hands: they bring a relaxed hand into a pose before the start, hold it there, and let go.

The tracker of Salchow-Hoemmen 2019 (doi 10.3390/s19010208, section 2.4.2) begins with such a pose, which a
paralysed hand is brought into by others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.forms.schema import require_not_negative, require_positive
from fesloop.hand.segments import SegmentTree
from fesloop.loop.clock import NS_PER_S
from plants.hand.model import require_posture

Array = NDArray[np.float64]
MOST_N_M = {"wrist": 3.0, "F1_cmc": 1.0, "mcp": 1.0, "ip": 0.4, "pip": 0.6, "dip": 0.3}
"""Greatest moments about a joint, N m, by the joint's name or its end (chosen: firm, and not painful; a
spastic MCP joint of .52 N m/rad, 55 deg from rest, needs .5)."""
YIELDS_RAD = math.radians(10.0)
"""Distance from the pose at which the full moment is applied (chosen: fingers that feel their way)."""
APPROACH = 0.6
"""Share of the time before the start in which the hold grows to its full strength (chosen)."""
STRAIGHT = ("wrist_flexion", "F1_mcp_flexion", "F1_ip_flexion", *(
    f"F{finger}_{joint}" for finger in (2, 3, 4, 5)
    for joint in ("mcp_flexion", "mcp_abduction", "pip_flexion", "dip_flexion")))
"""Freedoms that are 0 in the standard pose: fingers and thumb straight, the wrist in line (section 2.4.2)."""
LEAST_S = 1.0
"""Least time before the start (chosen: faster, moments swing light fingers to and fro)."""
DAMPING_S = 0.05
"""Ratio of damping to stiffness of the hold (chosen: soft hands)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Assistance:
    """A pose that a therapist holds from before the start on, and then releases.

    Attributes
    ----------
    pose_deg: the pose by freedom, where it is not the standard pose with its `STRAIGHT` freedoms at 0; other
        freedoms are left alone.
    error_deg: difference of the pose that is held from this one, by freedom.
    until_s: when the release begins.
    release_s: duration of the release.
    """

    pose_deg: dict[str, float] = field(default_factory=dict)
    error_deg: dict[str, float] = field(default_factory=dict)
    until_s: float = 1.5
    release_s: float = 0.3

    def __post_init__(self) -> None:
        require_not_negative("assist", self, "until_s")
        require_positive("assist", self, "release_s")

    def held_deg(self, tree: SegmentTree) -> dict[str, float]:
        """The pose that is held: with its errors, within the joints' ranges. Raises InputError."""
        require_posture("assist.pose_deg", tree, self.pose_deg)
        low, high = np.rad2deg(tree.ranges).T
        return {name: float(np.clip(angle + self.error_deg.get(name, 0.0), low[tree.freedom(name)],
                                    high[tree.freedom(name)]))
                for name, angle in {**dict.fromkeys(STRAIGHT, 0.0), **self.pose_deg}.items()}


def require_time(owner: str, assistance: Assistance | None, settle_s: float) -> None:
    """Raise InputError if there is too little time to bring the hand into the pose."""
    if assistance is not None and settle_s < LEAST_S:
        raise InputError(f"{owner}.settle_s", f"{settle_s:g} s", f"{LEAST_S:g} s or more with `assist`",
                         "the hand is brought into the pose while it settles")


def most_n_m(freedom: str) -> float:
    """Greatest moment about a freedom, N m."""
    joint = freedom.rpartition("_")[0]
    return MOST_N_M.get(joint) or MOST_N_M[joint.rpartition("_")[2]]


class Hold(NamedTuple):
    """Drives of a model that are a therapist's hands.

    Attributes
    ----------
    first, drives: number of the first drive, and of all of them, among MuJoCo's controls.
    until_ns, release_ns: when the release begins, and its duration.
    """

    first: int
    drives: int
    until_ns: int
    release_ns: int

    def approach(self, data: mujoco.MjData, share: float) -> None:
        """Set the strength of the hold at a share of the time before the start: hands close slowly."""
        data.ctrl[self.first:self.first + self.drives] = min(1.0, share / APPROACH)

    def press(self, data: mujoco.MjData, time_ns: int) -> None:
        """Set the strength of the hold at an instant, from 1 to 0."""
        share = min(1.0, max(0.0, 1.0 - (time_ns - self.until_ns) / self.release_ns))
        data.ctrl[self.first:self.first + self.drives] = share

    @property
    def over_ns(self) -> int:
        """When the hand is released."""
        return self.until_ns + self.release_ns


def add_hold(spec: mujoco.MjSpec, joints: dict[str, str], held_deg: dict[str, float],
             assistance: Assistance) -> Hold:
    """Add drives that pull joints, named by freedom, to angles; call it after the muscles are added.

    The moment of a drive is its control times stiffness (angle - position) - damping speed, which the solver
    takes implicitly in the speed, and is bounded.
    """
    names = [name for name in held_deg if name in joints]
    first = len(spec.actuators)
    for name in names:
        most = most_n_m(name)
        stiffness = most / YIELDS_RAD
        drive = spec.add_actuator(name=f"hold {name}", target=joints[name],
                                  trntype=mujoco.mjtTrn.mjTRN_JOINT)
        drive.gaintype, drive.biastype = mujoco.mjtGain.mjGAIN_AFFINE, mujoco.mjtBias.mjBIAS_NONE
        drive.gainprm[:3] = [stiffness * math.radians(held_deg[name]), -stiffness, -DAMPING_S * stiffness]
        drive.ctrlrange, drive.ctrllimited = [0.0, 1.0], True
        drive.forcerange, drive.forcelimited = [-most, most], True
    return Hold(first, len(names), round(assistance.until_s * NS_PER_S),
                round(assistance.release_s * NS_PER_S))
