"""Joints of a tree of segments, and their constraints on the relative orientation of two segments.

A hinge leaves one rotation free: its axis, fixed in the parent and in the child, has one direction in both.
A saddle leaves two: its axes, one fixed in the parent and one in the child, stay perpendicular. A ball
joint leaves all three. Any joint may be limited to a range.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from estimators.body.body import Body, Pairs
from fesloop.errors import InputError, did_you_mean
from fesloop.hand import quaternion
from fesloop.hand.segments import AXES, SegmentTree

Array = NDArray[np.float64]
Axis = tuple[float, float, float]
Range = tuple[float, float]
JointKind = Literal["hinge", "saddle", "ball"]
KINDS = ("hinge", "saddle", "ball")
HINGE, SADDLE, BALL = range(3)
_ANGLES = ("",), ("parent_axis", "child_axis"), ("flexion", "abduction", "pronation")
"""Names of the angles of each kind, as `Joint` defines them."""
X: Axis = (1.0, 0.0, 0.0)
Y: Axis = (0.0, 1.0, 0.0)
Z: Axis = (0.0, 0.0, 1.0)
_PERPENDICULAR = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Joint:
    """Joint between two segments, each with a sensor whose frame is the segment's.

    Its angles are positive about its axes. A hinge's angle is the rotation about `parent_axis`, zero where
    the child's axes are turned least from the parent's. A saddle's two are those of the rotation about
    `parent_axis` followed by that about `child_axis` (as the child then has it), zero where both frames
    coincide. A ball joint's three are the z-x-y Euler angles flexion, abduction, pronation (doi
    10.3390/s19010208, eq. 20-22).

    Attributes
    ----------
    parent, child: numbers of the segments' sensors.
    kind: "hinge", "saddle" or "ball".
    parent_axis, child_axis: directions, of any length above 0, in the parent's and the child's frame;
        those of a saddle are perpendicular to each other; a ball joint ignores them.
    ranges_deg: (least, most) of each angle, in their order. Empty: unlimited.
    learn_axes: whether a hinge's axes are learnt from motion, in place of given ones.
    """

    parent: int
    child: int
    kind: JointKind
    parent_axis: Axis = Z
    child_axis: Axis = Z
    ranges_deg: tuple[Range, ...] = ()
    learn_axes: bool = False

    def __post_init__(self) -> None:
        if min(self.parent, self.child) < 0 or self.parent == self.child:
            raise InputError("child", f"{self.child} with parent {self.parent}",
                             "two different sensors, 0 or more")
        if self.kind not in KINDS:
            raise InputError("kind", f"{self.kind!r}", ", ".join(KINDS), did_you_mean(self.kind, KINDS))
        for name, axis in (("parent_axis", self.parent_axis), ("child_axis", self.child_axis)):
            if not 0.0 < math.hypot(*axis) < math.inf:
                raise InputError(name, f"{axis} has no direction", "three finite numbers, not all zero")
        if self.kind == "saddle" and abs(float(self.axes[0] @ self.axes[1])) > _PERPENDICULAR:
            raise InputError("child_axis", f"{self.child_axis} with parent_axis {self.parent_axis}",
                             "for a saddle an axis perpendicular to parent_axis")
        if self.ranges_deg and len(self.ranges_deg) != self.angles:
            raise InputError("ranges_deg", f"has {len(self.ranges_deg)} ranges",
                             f"none, or {self.angles} for a {self.kind}")
        if self.learn_axes and (self.kind != "hinge" or not self.parent_axis == self.child_axis == Z):
            raise InputError("learn_axes", f"true for a {self.kind} with axes {self.parent_axis} and "
                             f"{self.child_axis}", "true for a hinge without axes", "remove one of the two")
        for low, high in self.ranges_deg:
            if not -180.0 <= low < high <= 180.0:
                raise InputError("ranges_deg", f"({low}, {high})", "least < most, from -180 to 180 deg")

    @property
    def axes(self) -> Array:
        """Unit axes in the parent's and the child's frame, (2, 3)."""
        pair = np.array([self.parent_axis, self.child_axis], dtype=np.float64)
        return np.asarray(pair / np.linalg.norm(pair, axis=1, keepdims=True))

    @property
    def angles(self) -> int:
        """Number of angles."""
        return KINDS.index(self.kind) + 1


@dataclass(frozen=True, slots=True, eq=False)
class JointTable:
    """Joints as arrays for kernels; parents come before their children. Read-only.

    Attributes
    ----------
    ends: (joints, 2), parent and child.
    kinds: (joints,), HINGE, SADDLE or BALL.
    axes: (joints, 2, 3), in the parent's and the child's frame.
    zero: (joints, 4), child to parent at angle zero.
    ranges: (joints, 3, 2), rad, (least, most) of each angle; infinite where unlimited.
    first_angle: (joints,), index of each joint's first angle among all.
    angles: number of all angles.
    roots: (roots,), sensors that are no joint's child.
    known: (joints,), mask of joints whose axes are known; the others' are learnt.
    names: names of the joints: those of the body, else "parent-child".
    unsensed: names of the body's joints without a sensor on both sides.
    moved: (joints,), segment of the body that each joint moves; None without a body.
    """

    ends: NDArray[np.int64]
    kinds: NDArray[np.int64]
    axes: Array
    zero: Array
    ranges: Array
    first_angle: NDArray[np.int64]
    angles: int
    roots: NDArray[np.int64]
    known: NDArray[np.bool_]
    names: tuple[str, ...]
    unsensed: tuple[str, ...] = ()
    moved: NDArray[np.int64] | None = None

    @property
    def angle_names(self) -> tuple[str, ...]:
        """Names of the angles of joints without a body: the joint's, and which where it has several."""
        return tuple(f"{name}.{part}" if part else name
                     for name, kind in zip(self.names, self.kinds, strict=True) for part in _ANGLES[kind])

    def between(self, sensors: Sequence[str]) -> JointTable:
        """The table with joints named after their sensors, "parent-child"."""
        return replace(self, names=tuple(f"{sensors[parent]}-{sensors[child]}"
                                         for parent, child in self.ends.tolist()))

    def learnt(self, joint: int, axes: Array) -> JointTable:
        """The table with the axes (2, 3) of a hinge that have been learnt."""
        every, zero, known = self.axes.copy(), self.zero.copy(), self.known.copy()
        every[joint], zero[joint], known[joint] = axes, _turn(axes), True
        for array in (every, zero, known):
            array.flags.writeable = False
        return replace(self, axes=every, zero=zero, known=known)


def joints_between(kind: JointKind, pairs: Pairs) -> tuple[Joint, ...]:
    """A joint of one kind between the (parent, child) sensors of each pair; the axes of hinges are learnt."""
    return tuple(Joint(parent=parent, child=child, kind=kind, learn_axes=kind == "hinge")
                 for parent, child in pairs)


def joint_table(joints: tuple[Joint, ...], sensors: int) -> JointTable:
    """Joints of `sensors` sensors as arrays.

    Raises InputError unless they form trees: every sensor is the child of at most one joint, listed after its
    parent's own joint.
    """
    ranges = np.tile([-np.inf, np.inf], (len(joints), 3, 1))
    for row, joint in zip(ranges, joints, strict=True):
        row[:len(joint.ranges_deg)] = np.radians(np.reshape(joint.ranges_deg, (-1, 2)))
    axes = np.array([joint.axes for joint in joints]).reshape(-1, 2, 3)
    zero = np.array([_turn(joint.axes) if joint.kind == "hinge" else (1.0, 0.0, 0.0, 0.0)
                     for joint in joints])
    counts = np.array([joint.angles for joint in joints], dtype=np.int64)
    table = JointTable(
        ends=np.array([(joint.parent, joint.child) for joint in joints], dtype=np.int64).reshape(-1, 2),
        kinds=np.array([KINDS.index(joint.kind) for joint in joints], dtype=np.int64),
        axes=axes, zero=zero.reshape(-1, 4), ranges=ranges, first_angle=np.cumsum(counts) - counts,
        angles=int(counts.sum()), roots=np.array(_roots(joints, sensors), dtype=np.int64),
        known=np.array([not joint.learn_axes for joint in joints], dtype=np.bool_),
        names=tuple(f"{joint.parent}-{joint.child}" for joint in joints))
    for array in (table.ends, table.kinds, table.axes, table.zero, table.ranges, table.first_angle,
                  table.roots, table.known):
        array.flags.writeable = False
    return table


def _roots(joints: tuple[Joint, ...], sensors: int) -> tuple[int, ...]:
    children: set[int] = set()
    for number, joint in enumerate(joints):
        if max(joint.parent, joint.child) >= sensors:
            raise InputError(f"joints[{number}]", f"is between {joint.parent} and {joint.child}",
                             f"two of {sensors} sensors, from 0 to {sensors - 1}")
        if joint.child in children:
            raise InputError(f"joints[{number}].child", f"{joint.child} is another joint's child too",
                             "one joint a child")
        children.add(joint.child)
    placed = set(range(sensors)) - children
    for number, joint in enumerate(joints):
        if joint.parent not in placed:
            raise InputError(f"joints[{number}].parent", f"{joint.parent} is the child of no earlier joint",
                             "joints from the root outwards, without a ring", "list its own joint first")
        placed.add(joint.child)
    return tuple(i for i in range(sensors) if i not in children)


def _turn(axes: Array) -> Array:
    """Least rotation from the child's axis to the parent's, (4,)."""
    parent, child = axes
    if parent @ child < -1.0 + 1e-12:
        across = np.cross(parent, np.eye(3)[np.argmin(np.abs(parent))])
        return quaternion.from_axis_angle(across, math.pi)
    half = np.concatenate([[1.0 + parent @ child], np.cross(child, parent)])
    return quaternion.normalized(half)


CHAIN5 = (Joint(parent=0, child=1, kind="ball"),
          *(Joint(parent=i, child=i + 1, kind="hinge", parent_axis=axis, child_axis=axis)
            for i, axis in enumerate((X, Y, Z), start=1)))
"""A ball joint, then hinges about x, y, z (`fesloop.streams.formats.published`, which gives no lengths)."""


def joints_of(tree: SegmentTree, sensed: Sequence[str]) -> tuple[Joint, ...]:
    """Joints between the sensed segments of a tree, with sensors numbered in the order of `sensed`.

    A segment whose parent is not sensed, or is joined to it rigidly, is a root without a joint. Raises
    InputError for unknown names, and for a tilted ball joint.
    """
    numbers = {name: number for number, name in enumerate(sensed)}
    joints = []
    for name in sensed:
        tree.index(name)
    for segment in tree.segments:
        if segment.name not in numbers or segment.parent not in numbers or segment.joint == "fixed":
            continue
        if segment.joint == "ball" and segment.axes not in ((), AXES):
            raise InputError(f"segment {segment.name!r}: axes", f"{segment.axes}",
                             f"of a ball joint {AXES}")
        first, second = segment.frame[:2].tolist()
        child_axis = first if segment.joint == "hinge" else second
        joints.append(Joint(
            parent=numbers[segment.parent], child=numbers[segment.name], kind=segment.joint,
            parent_axis=tuple(first), child_axis=tuple(child_axis),
            ranges_deg=tuple((math.degrees(low), math.degrees(high)) for low, high in segment.ranges)))
    return tuple(joints)


def body_table(body: Body) -> JointTable:
    """Joints of a body with sensors on both sides, with the angles of the tree's freedoms."""
    tree = body.tree
    names = [tree.names[k] for k in body.sensed]
    table = joint_table(joints_of(tree, names), len(names))
    moved = body.sensed[table.ends[:, 1]]
    first = tree.layout[moved, 2].copy()
    first.flags.writeable = moved.flags.writeable = False
    freedoms = tree.layout[:, 1]
    return replace(
        table, first_angle=first, angles=len(tree.ranges), names=tuple(body.joints[k] for k in moved),
        unsensed=tuple(body.joints[k] for k in np.flatnonzero(~body.seen() & (freedoms > 0))), moved=moved)
