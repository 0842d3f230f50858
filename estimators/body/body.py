"""What every tracker knows of the body that wears its sensors: segments, who has a sensor, fingertips."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics_kernels import place, turned
from fesloop.hand.quaternion_kernels import multiply
from fesloop.hand.segments import Segment, SegmentTree
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.signals import Port

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
UNSEEN_SD = math.pi
"""Of an angle of which nothing is known, rad."""
_ROOT = np.array([1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """A segment tree with sensors on some of its segments; arrays are read-only.

    Attributes
    ----------
    tree: of all segments.
    sensed: (n,), index of the segment that each sensor sits on.
    sensors: (segments,), number of the sensor on each segment, -1 where there is none.
    tips: (t,), index of each segment that carries no other, in the tree's order: the fingertips' bones.
    joints: (segments,), name of the joint by which each segment hangs on its parent, "" for the root.
    """

    tree: SegmentTree
    sensed: Numbers
    sensors: Numbers
    tips: Numbers
    joints: tuple[str, ...]

    def seen(self) -> NDArray[np.bool_]:
        """Whether both segments of each segment's joint have a sensor, (segments,); the root's has none."""
        parents = self.tree.layout[:, 0]
        return np.asarray((parents >= 0) & (self.sensors >= 0) & (self.sensors[parents] >= 0))


def body_of(
    sensors: int, hand: HandSize, segments: tuple[Segment, ...], sensed: tuple[str, ...]
) -> Body:
    """The body that wears `sensors` sensors.

    Parameters
    ----------
    hand: its size, where `segments` is empty.
    segments: another tree in place of the hand's.
    sensed: names of the segments that the sensors sit on, in the order of the samples; empty: every segment,
        or every one but the root, as the number of sensors says.

    Raises InputError for unknown or repeated names, for another number of names than of sensors, and for a
    hand beside another tree.
    """
    if segments and hand != HandSize():
        raise InputError("hand", "given beside segments", "one of the two", "leave one out")
    tree = SegmentTree(segments) if segments else hand_tree(hand)
    names = sensed or _usual(tree, sensors)
    if len(names) != sensors:
        raise InputError("sensed", f"names {len(names)} segments, {sensors} sensors are wired",
                         "one name a sensor")
    indices = [tree.index(name) for name in names]
    for name in names:
        if names.count(name) > 1:
            raise InputError("sensed", f"{name!r} given twice", "one sensor a segment")
    of_segment = np.full(len(tree.segments), -1, dtype=np.int64)
    of_segment[indices] = np.arange(sensors)
    parents = set(tree.layout[:, 0].tolist())
    tips = [k for k in range(len(tree.segments)) if k not in parents]
    joints = tuple("" if s.parent is None else s.joint_name or f"{s.parent}-{s.name}" for s in tree.segments)
    body = Body(tree, np.array(indices, dtype=np.int64), of_segment, np.array(tips, dtype=np.int64), joints)
    for array in (body.sensed, body.sensors, body.tips):
        array.flags.writeable = False
    return body


def _usual(tree: SegmentTree, sensors: int) -> tuple[str, ...]:
    """All segments, or all but the root."""
    count = len(tree.segments)
    if sensors not in (count, count - 1):
        wired = "1 sensor is wired" if sensors == 1 else f"{sensors} sensors are wired"
        raise InputError("sensed", f"is empty, and {wired}",
                         f"a name for each sensor, of {', '.join(tree.names)}",
                         "name the segments that the sensors sit on, and give `segments` where it is no hand")
    return tree.names[count - sensors:]


def posture_ports(body: Body | None, sensors: int) -> tuple[Port, ...]:
    """Output ports of a tracker: orientation, angles, angle_sd, fingertips, fingertip_sd."""
    freedoms = len(body.tree.ranges) if body else None
    tips = len(body.tips) if body else None
    names = body.tree.freedoms if body else ()
    worn = tuple(body.tree.names[k] for k in body.sensed) if body else ()
    return (Port("orientation", (sensors or None, 4), "1", rows=worn),
            Port("angles", (freedoms,), "rad", rows=names),
            Port("angle_sd", (freedoms,), "rad", UNSEEN_SD, rows=names), Port("fingertips", (tips, 3), "m"),
            Port("fingertip_sd", (tips, 3), "m"))


@compiled
def chain_up(layout: Numbers, relative: Array, orientations: Array) -> None:
    """Fill `orientations` (n, 4), segment to root, from quaternions (n, 4) to each parent."""
    for k in range(layout.shape[0]):
        parent = layout[k, 0]
        if parent < 0:
            orientations[k] = _ROOT
            continue
        a, b = orientations[parent], relative[k]
        q = multiply((a[0], a[1], a[2], a[3]), (b[0], b[1], b[2], b[3]))
        orientations[k, 0], orientations[k, 1], orientations[k, 2], orientations[k, 3] = q


@compiled
def place_tips(
    layout: Numbers, geometry: Array, orientations: Array, tips: Numbers, positions: Array, fingertips: Array
) -> None:
    """Fill `positions` (n, 3) of all segments in the root's frame, and `fingertips` (t, 3), m.

    `orientations` (n, 4) are to the root's frame; `positions` is scratch whose root must be at zero.
    """
    place(layout, geometry, orientations, positions)
    for i in range(tips.size):
        fingertips[i] = positions[tips[i]]


@compiled
def fill_lever(q: Array, offset: Array, origin: Array, tip: Array, lever: Array) -> None:
    """Fill `lever` (3, 3), m/rad: how a tip moves with the error d of a segment's joint, R [d]x r.

    Parameters
    ----------
    q: (4,), segment to root. offset: (3,), m, the segment's frame from the joint's centre, in its own axes.
    origin, tip: (3,), m, of the segment's frame and of the tip, in the root's frame, as is the lever.
    """
    turn = (q[0], q[1], q[2], q[3])
    x, y, z = turned(turn, offset[0], offset[1], offset[2])
    x, y, z = tip[0] - origin[0] + x, tip[1] - origin[1] + y, tip[2] - origin[2] + z
    for a in range(3):
        u, v, w = turned(turn, 1.0 if a == 0 else 0.0, 1.0 if a == 1 else 0.0, 1.0 if a == 2 else 0.0)
        lever[0, a], lever[1, a], lever[2, a] = v * z - w * y, w * x - u * z, u * y - v * x


@compiled
def spread_tips(
    layout: Numbers, geometry: Array, orientations: Array, positions: Array, covariance: Array, tips: Numbers,
    sd: Array
) -> None:
    """Fill `sd` (t, 3), m, of each fingertip in the root's frame.

    Parameters
    ----------
    orientations, positions: (n, 4) and (n, 3), to the root's frame.
    covariance: (n, 3, 3), rad^2, of the error d of each joint's rotation R (I + [d]x), in the child's
        frame; joints count as independent of each other.
    """
    rows = np.empty((3, 3))
    for i in range(tips.size):
        tip, k = tips[i], tips[i]
        x, y, z = 0.0, 0.0, 0.0
        while layout[k, 0] >= 0:
            fill_lever(orientations[k], geometry[k, 4], positions[k], positions[tip], rows)
            cov = covariance[k]
            x += _quadratic(rows[0], cov)
            y += _quadratic(rows[1], cov)
            z += _quadratic(rows[2], cov)
            k = layout[k, 0]
        sd[i, 0], sd[i, 1], sd[i, 2] = math.sqrt(x), math.sqrt(y), math.sqrt(z)


@compiled
def _quadratic(row: Array, covariance: Array) -> float:
    total = 0.0
    for a in range(3):
        for b in range(3):
            total += row[a] * covariance[a, b] * row[b]
    return total
