"""Body model of trackers: segments, their sensors, fingertips."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics_kernels import place, turned
from fesloop.hand.quaternion_kernels import conjugate, euler_z_of_zxy, multiply, rotation_angle
from fesloop.hand.segments import Segment, SegmentTree
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.signals import Port, Sensors

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


Numbers = NDArray[np.int64]
UNSEEN_SD = math.pi
"""Sd of an unknown angle, rad."""
_ROOT = np.array([1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """A segment tree with sensors on some of its segments; arrays are read-only.

    Attributes
    ----------
    tree: tree of all segments.
    sensed: (n,), index of the segment of each sensor.
    sensors: (segments,), number of the sensor on each segment; -1 for none.
    tips: (t,), index of each segment without children, in the tree's order: the fingertips' bones.
    joints: (segments,), name of the joint of each segment with its parent; "" for the root.
    """

    tree: SegmentTree
    sensed: Numbers
    sensors: Numbers
    tips: Numbers
    joints: tuple[str, ...]

    @property
    def sensor_names(self) -> tuple[str, ...]:
        """Name of the segment of each sensor."""
        return tuple(self.tree.names[k] for k in self.sensed)

    def seen(self) -> NDArray[np.bool_]:
        """Mask (segments,) of joints with a sensor on both segments; false for the root."""
        parents = self.tree.layout[:, 0]
        return np.asarray((parents >= 0) & (self.sensors >= 0) & (self.sensors[parents] >= 0))


def body_of(
    sensors: int, hand: HandSize, segments: tuple[Segment, ...], sensed: tuple[str, ...]
) -> Body:
    """Body with `sensors` sensors.

    Parameters
    ----------
    hand: size of the hand, where `segments` is empty.
    segments: another tree in place of the hand's.
    sensed: names of the sensors' segments, in the order of the samples; empty: every segment, or every one
        but the root, depending on the number of sensors.

    Raises InputError for unknown or repeated names, for another number of names than of sensors, and for a
    hand together with another tree.
    """
    if segments and hand != HandSize():
        raise InputError("hand", "is given together with segments", "one of the two", "remove one")
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
    """Names of all segments, or of all but the root."""
    count = len(tree.segments)
    if sensors not in (count, count - 1):
        wired = "1 sensor is wired" if sensors == 1 else f"{sensors} sensors are wired"
        raise InputError("sensed", f"is empty, and {wired}",
                         f"a name for each sensor, of {', '.join(tree.names)}",
                         "name the sensors' segments, give `segments` for a body that is not a hand, or use "
                         "the tracker constrained with joints = \"hinge\" or \"ball\" between its sensors; "
                         "in the experiment replay `--set tracker=constrained --set joints=hinge`")
    return tree.names[count - sensors:]


def posture_ports(body: Body | None, sensors: int) -> tuple[Port, ...]:
    """Output ports of a tracker: orientation, angles, angle_sd, fingertips, fingertip_sd."""
    freedoms = len(body.tree.ranges) if body else None
    tips = len(body.tips) if body else None
    names = body.tree.freedoms if body else ()
    worn = body.sensor_names if body else ()
    ends = tuple(body.tree.names[k] for k in body.tips) if body else ()
    return (Port("orientation", (sensors or None, 4), "1", rows=worn),
            Port("angles", (freedoms,), "rad", rows=names),
            Port("angle_sd", (freedoms,), "rad", UNSEEN_SD, rows=names),
            Port("fingertips", (tips, 3), "m", rows=ends), Port("fingertip_sd", (tips, 3), "m", rows=ends))


def random_sd_port(body: Body | None) -> Port:
    """Output port of the sd of random errors: of what changes in motion, and of nothing constant."""
    return replace(posture_ports(body, 0)[2], name="angle_random_sd")


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
    """Fill `lever` (3, 3), m/rad: derivative of a tip by the error d of a segment's joint, R [d]x r.

    Parameters
    ----------
    q: (4,), segment to root.
    offset: (3,), m, from the joint's centre to the segment's frame, in its axes.
    origin, tip: (3,), m, positions of the segment's frame and of the tip in the root's frame, as the lever
        is.
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
    """Fill the sd (t, 3), m, of each fingertip in the root's frame.

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


T = TypeVar("T")
_CHAIN = 5
"""Number of sensors that trackers take for the chain of the set chain5 by default."""
_CHAIN_NAMES = ("seg1", "seg2", "seg3", "seg4", "seg5")
"""Names of these sensors."""


def stated_by(sources: Mapping[str, Sensors]) -> Sensors:
    """Sensors of all inputs of a tracker; raises InputError where they differ."""
    (name, first), *others = sources.items()
    for other, stated in others:
        if stated != first:
            raise InputError(other, f"comes from {_listed(stated)}, {name} from {_listed(first)}",
                             "the same sensors")
    return first


def _listed(stated: Sensors) -> str:
    pairs = ", ".join(map(stated.pair_name, stated.pairs))
    return ", ".join(stated.names) + (f" ({pairs})" if pairs else "")


def stated_pairs(own: Pairs, stated: Sensors) -> Pairs:
    """Pairs of sensors with a joint: the tracker's own, if they are stated, or all stated ones.

    Raises InputError for a pair that is not stated, and for three or more sensors without stated pairs.
    """
    if not stated.pairs:
        if not own and len(stated.names) > 2:
            raise InputError("pairs", f"which of the sensors {', '.join(stated.names)} are neighbours is not "
                             "stated", "(parent, child) of each joint",
                             "give pairs here, such as [[0, 1], [0, 2]], or in the recording's layout")
        return own
    for pair in own:
        if tuple(pair) not in stated.pairs:
            ends = f" ({stated.pair_name(pair)})" if all(0 <= k < len(stated.names) for k in pair) else ""
            raise InputError("pairs", f"{list(pair)}{ends} is none of the recording's pairs", ", ".join(
                f"{list(each)} ({stated.pair_name(each)})" for each in stated.pairs),
                             "correct the pairs here, or in the recording's layout")
    return own or stated.pairs


def stated_segments(sensed: tuple[str, ...], known: Sequence[str], stated: Sensors) -> tuple[str, ...]:
    """Segments of the sensors: the names of the sensors, where these are segments.

    Raises InputError where the tracker names others.
    """
    if not all(name in known for name in stated.names):
        return sensed
    if sensed and sensed != stated.names:
        raise InputError("sensed", f"names {', '.join(sensed)}", ", ".join(stated.names),
                         "the samples come from sensors of these names: remove sensed, or correct it")
    return stated.names


def require_stated_tree(parents: Mapping[int, set[int]], stated: Sensors, where: str) -> None:
    """Raise InputError where a tracker gives a sensor another parent than the recording states.

    `parents`: parents of each sensor in the tracker; may be empty for sensors without one.
    """
    for child, own in parents.items():
        given = {parent for parent, each in stated.pairs if each == child}
        if given and not own & given:
            has = (" and ".join(stated.names[k] for k in sorted(own)) or "nothing")
            raise InputError(where, f"joins {stated.names[child]} to {has}", "as the recording states it: "
                             + ", ".join(map(stated.pair_name, stated.pairs)),
                             "correct the tracker's tree, or the pairs in the recording's layout")


def parents_in(body: Body) -> dict[int, set[int]]:
    """Parent of each sensor: the one on the nearest sensed segment towards the root."""
    found: dict[int, set[int]] = {}
    layout = body.tree.layout
    for number, segment in enumerate(body.sensed.tolist()):
        parent = int(layout[segment, 0])
        while parent >= 0 and body.sensors[parent] < 0:
            parent = int(layout[parent, 0])
        found[number] = {int(body.sensors[parent])} if parent >= 0 else set()
    return found


def worn_as_stated(tracker: T, stated: Sensors) -> T:
    """Tracker of a body, or of joints alone, with its sensors on the segments of their names.

    Where their names are not segments, the tracker names the segments. Raises InputError where it gives a
    sensor another parent than is stated, and for five sensors that are not those of chain5
    (`fesloop.streams.formats.published`), whose joints it would take for theirs.
    """
    given: Any = tracker
    tree = SegmentTree(given.segments) if given.segments else hand_tree(given.hand)
    joints = getattr(given, "joints", ())
    sensed = given.sensed if joints else stated_segments(given.sensed, tree.names, stated)
    worn = bool(joints or sensed or given.segments or given.hand != HandSize())
    sensors = given.sensors or len(stated.names)
    if not worn and sensors == _CHAIN and not stated.pairs:
        raise InputError("sensed", f"is empty, and which of {', '.join(stated.names)} are neighbours is not "
                         "stated", "a segment each, or pairs in the recording's layout")
    if not worn and sensors == _CHAIN and stated.names != _CHAIN_NAMES:
        raise InputError("sensed", f"is empty, and which joints are between {', '.join(stated.names)} is not "
                         "stated", "a segment each, or segments of your own",
                         "or give the tracker `constrained` joints, such as joints = \"hinge\"")
    told = replace(given, sensed=sensed, sensors=sensors)
    if told.body is not None:
        require_stated_tree(parents_in(told.body), stated, "sensed" if sensed else "segments")
    else:
        parents: dict[int, set[int]] = {}
        for parent, child in told.table.ends.tolist():
            parents.setdefault(child, set()).add(parent)
        require_stated_tree(parents, stated, "joints")
    return cast(T, told)
