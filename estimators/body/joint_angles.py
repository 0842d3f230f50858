"""Joint angles from the orientations of neighbouring segments, and the initial pose that aligns them.

Without magnetometers the heading of each sensor is arbitrary. In a known initial pose the heading of each
child relative to its parent is known, and its offset is removed afterwards (initial-pose
alignment, Salchow-Hoemmen et al. 2019, doi 10.3390/s19010208, section 2.4.2).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.quaternion_kernels import conjugate, euler_z_of_zxy, multiply, rotation_angle
from fesloop.hand.segments import SegmentTree
from fesloop.loop.block import Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.signals import Port

Array = NDArray[np.float64]
Pairs = tuple[tuple[int, int], ...]


@compiled
def flexion_angles(orientation: Any, pairs: Any, heading: Any) -> Any:
    """Flexion of each joint, (pairs,), rad: first of the z-x-y Euler angles of child to parent.

    Parameters
    ----------
    orientation: (n, 4), segment to earth.
    pairs: (pairs, 2), parent and child.
    heading: (pairs, 2), cosine and sine of half the child's heading offset.
    """
    angles = np.empty(pairs.shape[0])
    for k in range(pairs.shape[0]):
        p, c = orientation[pairs[k, 0]], orientation[pairs[k, 1]]
        turn = (heading[k, 0], 0.0, 0.0, heading[k, 1])
        child = multiply(turn, (c[0], c[1], c[2], c[3]))
        angles[k] = euler_z_of_zxy(multiply(conjugate((p[0], p[1], p[2], p[3])), child))
    return angles


@compiled
def turned_angle(origin: Any, orientation: Any) -> Any:
    """Angle between two orientations, each (1, 4), as (1,), rad in [0, pi]."""
    a, b = origin[0], orientation[0]
    angles = np.empty(1)
    angles[0] = rotation_angle(multiply(conjugate((a[0], a[1], a[2], a[3])), (b[0], b[1], b[2], b[3])))
    return angles


def heading_offsets(orientation: Array, pairs: NDArray[np.int64], flexion: Array) -> Array:
    """Heading offsets that bring each child to the known pose, for `flexion_angles`: (pairs, 2).

    Parameters
    ----------
    orientation: (n, 4), segment to earth, in the known pose.
    pairs: (pairs, 2), parent and child.
    flexion: (pairs,), rad, flexion in that pose; abduction and pronation are zero.
    """
    wanted = quaternion.multiply(orientation[pairs[:, 0]], quaternion.about_z(flexion))
    error = quaternion.multiply(wanted, quaternion.conjugate(orientation[pairs[:, 1]]))
    turn = quaternion.about_z(quaternion.twist_z(error))
    return np.ascontiguousarray(turn[:, ::3])


def no_offsets(pairs: int) -> Array:
    """Heading offsets of zero, (pairs, 2)."""
    return np.tile([1.0, 0.0], (pairs, 1))


def resolve_pairs(pairs: Pairs, sensors: int) -> Pairs:
    """The pairs, or each sensor with its successor where none are given.

    Raises InputError for a pair without two different sensors.
    """
    for pair in pairs:
        if not all(0 <= end < sensors for end in pair) or pair[0] == pair[1]:
            raise InputError("pairs", f"{list(pair)} is not a pair of the {sensors} sensors",
                             f"two different numbers from 0 to {sensors - 1}")
    return pairs or tuple((i, i + 1) for i in range(sensors - 1))


def initial_flexion(initial_angles_deg: tuple[float, ...] | None, joints: int) -> Array | None:
    """Initial pose in rad, (joints,), or None. Raises InputError for a wrong number of angles."""
    if initial_angles_deg is None:
        return None
    if len(initial_angles_deg) != joints or not joints:
        raise InputError("initial_angles_deg", f"has {len(initial_angles_deg)} angles",
                         f"{joints}, one a joint" if joints else "none: a single sensor has no joint")
    if not all(math.isfinite(angle) and abs(angle) <= 180.0 for angle in initial_angles_deg):
        raise InputError("initial_angles_deg", f"{initial_angles_deg}", "finite angles from -180 to 180 deg")
    flexion = np.radians(initial_angles_deg)
    flexion.flags.writeable = False
    return flexion


ALIGNED_PORT = Port("aligned", (1,), "1")
"""Port that is 0 during the initial pose, 1 afterwards and for trackers without one."""


def aligned_value(aligned: bool) -> NDArray[np.float64]:
    """Value of `aligned`, (1,); read-only."""
    return _ALIGNED if aligned else _ALIGNING


def _constant(value: float) -> NDArray[np.float64]:
    array = np.array([value])
    array.flags.writeable = False
    return array


_ALIGNED, _ALIGNING = _constant(1.0), _constant(0.0)


_BEYOND = math.radians(60.0)
"""Excess over a range above which an angle is implausible (chosen: mounting, tissue and corrected drift cause
less)."""
_LONG_NS = NS_PER_S // 2
"""Duration of such an excess before it is reported (chosen: filters settle sooner after a jump)."""
_REMEDY = "check signs and order of the axes of both sensors, and their mounting"


class ImplausibleAngles:
    """Check of joint angles, which reports once when one begins to be implausible.

    Turns are counted where limits lie a whole turn apart, else an angle is taken next to their middle.

    Parameters
    ----------
    limits: (a, 2), rad, beyond which an angle is implausible; infinite for none.
    names: names of the angles.
    joint: kind of joint, for messages.
    """

    __slots__ = ("_before", "_joint", "_limits", "_names", "_since_ns", "_told")

    def __init__(self, limits: Array, names: Sequence[str], joint: str = "such joint") -> None:
        self._limits = np.ascontiguousarray(limits, dtype=np.float64)
        self._names = tuple(names)
        self._joint = joint
        self._before = np.zeros(len(limits))
        self._since_ns = np.full(len(limits), -1, dtype=np.int64)
        self._told = np.zeros(len(limits), dtype=np.bool_)

    def note(self, angles: Array, tick: Tick) -> None:
        """Check the angles (a,), rad, of a tick."""
        if not _implausible(angles, self._limits, tick.time_ns, self._before, self._since_ns, self._told):
            return
        for k in np.flatnonzero((self._since_ns >= 0) & ~self._told
                                & (tick.time_ns - self._since_ns >= _LONG_NS)):
            self._told[k] = True
            tick.report("implausible_angle", f"{self._names[k]} is at {math.degrees(self._before[k]):.0f} "
                        f"deg, which no {self._joint} can reach: {_REMEDY}")


def of_tree(tree: SegmentTree) -> ImplausibleAngles:
    """Check of all freedoms of a tree by their ranges, except those that may turn round."""
    low, high = tree.ranges.T
    round_about = high - low > 2.0 * math.pi - 1e-6
    limits = np.column_stack([low - _BEYOND, high + _BEYOND])
    limits[round_about] = -math.inf, math.inf
    return ImplausibleAngles(limits, tree.freedoms)


def of_unknown_joints(names: Sequence[str]) -> ImplausibleAngles:
    """Check of joints of unknown range: none of a hand exceeds 180 deg."""
    return ImplausibleAngles(np.tile([-math.pi, math.pi], (len(names), 1)), names, "joint of a hand")


@compiled
def _implausible(angles: Array, limits: Array, now_ns: int, before: Array, since_ns: NDArray[np.int64],
                 told: NDArray[np.bool_]) -> bool:
    """Whether an angle may have to be reported; updates `before` and the starts of excesses."""
    due = False
    for k in range(angles.size):
        if math.isnan(angles[k]):
            continue
        near = before[k]
        if limits[k, 1] - limits[k, 0] < 2.0 * math.pi:
            near = 0.5 * (limits[k, 0] + limits[k, 1])
        angle = near + (angles[k] - near + math.pi) % (2.0 * math.pi) - math.pi
        before[k] = angle
        if limits[k, 0] <= angle <= limits[k, 1]:
            since_ns[k] = -1
            continue
        if since_ns[k] < 0:
            since_ns[k] = now_ns
        due |= not told[k] and now_ns - since_ns[k] >= _LONG_NS
    return due
