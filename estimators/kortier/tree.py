"""Chains of segments with sensors in a body's tree, for a Kortier tracker."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.body.body import Body
from fesloop.errors import InputError, did_you_mean
from fesloop.hand.segments import Segment, SegmentTree

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

CHAIN5 = (
    Segment(name="seg1"), Segment(name="seg2", parent="seg1", joint="ball", joint_name="seg1-seg2"),
    *(Segment(name=f"seg{i + 1}", parent=f"seg{i}", joint="hinge", joint_name=f"seg{i}-seg{i + 1}",
              axes=(axis,))
      for i, axis in enumerate(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), start=2)))
"""Segments of chain5: a ball joint, then hinges about x, y, z
(`fesloop.streams.formats.published`, which gives no lengths)."""


class Chains(NamedTuple):
    """Chains of segments, each with a filter; a chain of n joints has n + 1 segments. Read-only.

    Arrays over joints, and over places (the segments of each chain, one more than its joints; a base is
    listed in each of its chains), run chain by chain, from base to tip. A part is a set of segments that are
    connected by joints with sensors on both sides.

    Attributes
    ----------
    first: (chains + 1,), first joint of each chain, then the number of joints.
    first_entry: (chains + 1,), first entry of each chain's covariance, then the number of entries.
    sensors: (places,), numbers of sensors. segments: (joints,), index in the tree of each joint's child.
    freedoms: (joints,), 0 to 3. first_angle: (joints,), index of the joint's first angle in the tree.
    axes: (joints, 3, 3), of flexion, abduction and pronation, in the child's frame.
    joint_of, chain_of: (segments,), joint between a segment and its parent, and its chain; -1 for none.
    part_of: (segments,), part of each segment with a sensor, -1 for the others.
    held: (parts,), the segment of each part whose attitude, velocity and position are tracked.
    """

    first: Numbers
    first_entry: Numbers
    sensors: Numbers
    segments: Numbers
    freedoms: Numbers
    first_angle: Numbers
    axes: Array
    joint_of: Numbers
    chain_of: Numbers
    part_of: Numbers
    held: Numbers


def base_of(body: Body, name: str, usual: str) -> int:
    """Index of the segment `name`, else of `usual`, else of the tree's first segment with a sensor.

    Raises InputError if no segment called `name` has a sensor.
    """
    sensed = [body.tree.names[k] for k in sorted(body.sensed)]
    if name and name not in sensed:
        raise InputError("base", f"{name!r}", ", ".join(sensed), did_you_mean(name, sensed))
    return body.tree.index(name or (usual if usual in sensed else sensed[0]))


def pose_of(tree: SegmentTree, angles_deg: Mapping[str, float]) -> Array:
    """Angles (freedoms,), rad, of a posture given by names of freedoms; the others are 0."""
    angles = np.zeros(len(tree.ranges))
    for name, angle in angles_deg.items():
        where = f"initial_angles_deg.{name}"
        if name not in tree.freedoms:
            raise InputError(where, "is no freedom", ", ".join(tree.freedoms),
                             did_you_mean(name, tree.freedoms))
        if not -180.0 <= angle <= 180.0:
            raise InputError(where, f"{angle}", "-180 to 180 deg")
        angles[tree.freedom(name)] = math.radians(angle)
    return angles


def chains_of(body: Body, base: int) -> Chains:
    """Find the chains of a body: from `base` or a branching segment to the next of these, or to a tip.

    Parameters
    ----------
    base: index of a segment with a sensor, tracked in its part; in other parts the innermost is.
    """
    layout, seen = body.tree.layout, body.seen()
    children = [[int(c) for c in np.flatnonzero((layout[:, 0] == k) & seen)] for k in range(len(layout))]
    parts = np.full(len(layout), -1, dtype=np.int64)
    tracked: list[int] = []
    runs: list[list[int]] = []
    for k in range(len(layout)):
        if body.sensors[k] < 0:
            continue
        if seen[k]:
            parts[k] = parts[layout[k, 0]]
        else:
            parts[k] = len(tracked)
            tracked.append(k)
        if not seen[k] or k == base or len(children[k]) > 1:
            runs += [_run(k, child, children, base) for child in children[k]]
    tracked[parts[base]] = base
    return _table(body, runs, parts, tracked)


def _run(start: int, child: int, children: list[list[int]], base: int) -> list[int]:
    run = [start, child]
    while run[-1] != base and len(children[run[-1]]) == 1:
        run += children[run[-1]]
    return run


def _table(body: Body, runs: list[list[int]], parts: Numbers, tracked: list[int]) -> Chains:
    tree = body.tree
    joints = np.array([len(run) - 1 for run in runs], dtype=np.int64)
    moved = np.array([k for run in runs for k in run[1:]], dtype=np.int64)
    joint_of, chain_of = np.full((2, len(tree.segments)), -1, dtype=np.int64)
    joint_of[moved] = np.arange(moved.size)
    chain_of[moved] = np.repeat(np.arange(len(runs)), joints)
    chains = Chains(
        first=_starts(joints), first_entry=_starts((6 * joints + 3) ** 2),
        sensors=np.array([body.sensors[k] for run in runs for k in run], dtype=np.int64), segments=moved,
        freedoms=np.ascontiguousarray(tree.layout[moved, 1]),
        first_angle=np.ascontiguousarray(tree.layout[moved, 2]),
        axes=np.ascontiguousarray(tree.geometry[moved, :3]), joint_of=joint_of, chain_of=chain_of,
        part_of=parts, held=np.array(tracked, dtype=np.int64))
    for array in chains:
        array.flags.writeable = False
    return chains


def _starts(sizes: Numbers) -> Numbers:
    return np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(sizes)])
