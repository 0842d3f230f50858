"""Evidence against an initial pose: gravity while the hand is in it, and the posture after its release.

A tracker takes the pose that it is given for the truth where its sensors do not show it. This module tests
that pose against all that they do show:

- gravity: the inclination of each segment against the next one's. It shows no rotation about the vertical,
  such as flexion of the fingers with the thumb upwards;
- joints: after the release, each joint's rotation against its ranges and against the rotations that it does
  not have;
- relaxation: fingers that were held straight close when they are let go.

A residual's sd follows from the sds of sensors' mounting and of the pose, so that a test has a stated rate of
false alarms. The three tests share this rate, and the joints of each share its part (Bonferroni), because
neighbouring joints have a sensor in common.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import chdtri, ndtri

from estimators.arrivals import LOST
from estimators.body.body import Body
from estimators.calibration.initial_pose import (
    KEEP_STILL,
    InitialPoseLimits,
    Rest,
    Ties,
    add_samples,
    faults,
    known_angles,
    moved,
    new_record,
    rest_of,
    ties_of,
)
from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.kinematics import relative_orientations, segment_poses
from fesloop.hand.quaternion_kernels import (
    conjugate,
    euler_x_of_zxy,
    euler_y_of_zxy,
    euler_z_of_zxy,
    multiply,
)
from fesloop.hand.segments import MOTIONS
from fesloop.hand.skeleton import FINGER_RESTS_DEG
from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Numbers = NDArray[np.int64]

TESTS = 3
"""Number of tests that share the rate of false alarms: gravity, joints, relaxation."""
_SHOWN = 0.5
"""Sine of the angle between an axis and the vertical above which gravity shows a rotation about it
(chosen)."""
_LONG_NS = NS_PER_S // 2
"""Duration of a contradiction of joints before it counts (chosen: fast movement disturbs inclinations)."""
_FINGERS_SD = math.radians(20.0)
"""Sd of a hand's finger closure at rest, summed over MCP, PIP and DIP (chosen: over 120 deg of wrist flexion
its mean changes by 106, Su et al. 2005, doi 10.1016/j.clinbiomech.2005.01.002)."""
_FINGER_SD = math.radians(15.0)
"""Sd of one finger's about the hand's mean (chosen)."""
_MOST_NAMED = 4
REMEDY = "bring it into that pose, or measure and state the one that it reaches (`initial_angles_deg`)"


@dataclass(frozen=True, slots=True, kw_only=True)
class PoseEvidence:
    """Test of the initial pose against all that the sensors show of it.

    Attributes
    ----------
    false_alarm: probability that a pose within its stated sd is reported as contradicted.
    watch_s: duration after the pose for which joints are compared with their ranges, s; 0: not at all.
    relaxed_s: time after the pose by which a paralysed hand, held in the pose by others, has been released
        and rests, without stimulation, s; 0: the hand is not released, or holds the pose itself.
    range_sd_deg: sd of the ends of a joint's range between persons (chosen).
    axis_sd_deg: sd of rotations that a joint is assumed not to have (5 to 10: doi 10.3390/s19010208, section
        4, for tilted axes).
    """

    false_alarm: float = 0.03
    watch_s: float = 10.0
    relaxed_s: float = 0.0
    range_sd_deg: float = 5.0
    axis_sd_deg: float = 7.5

    def __post_init__(self) -> None:
        if not 0.0 < self.false_alarm < 1.0:
            raise InputError("evidence.false_alarm", f"{self.false_alarm}", "above 0 and below 1")
        for name in ("watch_s", "relaxed_s", "range_sd_deg", "axis_sd_deg"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError(f"evidence.{name}", f"{value}", "a finite number, zero or more")


class Contradiction(NamedTuple):
    """Result of a test that a pose does not pass.

    Attributes
    ----------
    text: what contradicts it, with joints and angles.
    sizes: (m,), rad, by how much each segment's joint contradicts it; 0 for none.
    """

    text: str
    sizes: Array


class Gravity(NamedTuple):
    """Inclinations of n tied sensors against those of the known pose.

    Attributes
    ----------
    sensors: (n,), numbers of the sensors.
    angle: (n,), rad, between the measured vertical and that of the pose, given the neighbour's.
    residual: (n, 2), rad, the rotation from one to the other in two directions across the vertical.
    covariance: (2 n, 2 n), rad^2, of the residuals in their order.
    """

    sensors: Numbers
    angle: Array
    residual: Array
    covariance: Array

    def surprise(self) -> tuple[float, Array]:
        """Chi-square of all residuals together (2 n degrees), and of each sensor's (n,) (2 degrees).

        A sensor's is that of its residual given all others, the statistic of greatest power against one wrong
        joint (Baarda 1968, A testing procedure for use in geodetic networks).
        """
        precision = np.linalg.inv(self.covariance)
        whole = self.residual.ravel()
        score = (precision @ whole).reshape(-1, 2, 1)
        own = np.arange(len(score))
        blocks = precision.reshape(len(score), 2, len(score), 2)[own, :, own]
        return float(whole @ score.ravel()), np.sum(score * np.linalg.solve(blocks, score), axis=(1, 2))

    def explained(self, chi_square: float) -> float:
        """Median angle, rad, at which a sensor's residual has this chi-square and all others are 0."""
        blocks = np.diag(np.linalg.inv(self.covariance))
        return math.sqrt(chi_square / float(np.median(blocks)))


def inclinations(body: Body, ties: Ties, rest: Rest, mounting_sd: float, pose_sd: float) -> Gravity:
    """Compare mean specific forces in a pose with the pose.

    Parameters
    ----------
    ties: ties of the known pose among the present sensors.
    rest: mean readings in the pose.
    mounting_sd: sd of each sensor's mounting about any axis, rad.
    pose_sd: sd of each joint's rotation in the pose about any axis, rad.
    """
    sensors = np.flatnonzero(rest.present & (ties.neighbours >= 0))
    above = ties.neighbours[sensors]
    down = quaternion.conjugate(ties.relative[sensors])
    unit = rest.acc / np.maximum(np.linalg.norm(rest.acc, axis=1, keepdims=True), 1e-9)
    expected, found = quaternion.rotate(down, unit[above]), unit[sensors]
    basis = _across(expected)
    across = np.einsum("nij,nj->ni", basis, np.cross(expected, found))
    sine, cosine = np.linalg.norm(across, axis=1), np.sum(expected * found, axis=1)
    angle = np.arctan2(sine, cosine)
    # The opposite of the expected vertical is as far off in any direction.
    direction = across / np.maximum(sine, 1e-9)[:, np.newaxis]
    direction[sine < 1e-9] = 1.0, 0.0
    count, rows = len(sensors), np.arange(len(sensors))
    by_mounting = np.zeros((count, 2, len(rest.present), 3))
    by_mounting[rows, :, sensors] = -basis
    by_mounting[rows, :, above] = basis @ quaternion.to_matrix(down)
    mounting = by_mounting.reshape(2 * count, 3 * len(rest.present))
    joints = [_joints_between(body, int(s), int(p)) for s, p in zip(sensors, above, strict=True)]
    covariance = (mounting_sd**2 * mounting @ mounting.T
                  + pose_sd**2 * np.diag(np.repeat(np.array(joints, dtype=np.float64), 2)))
    return Gravity(sensors, angle, angle[:, np.newaxis] * direction, covariance)


def _across(vectors: Array) -> Array:
    """Two unit vectors (n, 2, 3) at right angles to each of `vectors` (n, 3) and to each other."""
    other = np.where(np.abs(vectors[:, :1]) < 0.7, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    first = np.cross(vectors, other)
    first = first / np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(vectors, first)], axis=1)


def _joints_between(body: Body, sensor: int, above: int) -> int:
    """Number of joints between a sensor's segment and that of a sensor nearer to the root."""
    k, count = int(body.sensed[sensor]), 0
    while k != body.sensed[above]:
        k, count = int(body.tree.layout[k, 0]), count + 1
    return count


def against_gravity(body: Body, gravity: Gravity, evidence: PoseEvidence) -> Contradiction | None:
    """Contradiction between gravity and a pose; None where they agree.

    All residuals together and each sensor's are tested, each with half of the test's rate of false alarms.
    """
    if not gravity.sensors.size:
        return None
    rate = 0.5 * evidence.false_alarm / TESTS
    together, each = gravity.surprise()
    limit = float(chdtri(2, rate / each.size))
    beyond = each > limit
    if not beyond.any() and together <= chdtri(gravity.residual.size, rate):
        return None
    # Where no sensor contradicts the pose alone, all do together, and the worst are named.
    named = np.flatnonzero(beyond) if beyond.any() else np.arange(each.size)
    worst = named[np.argsort(-each[named], kind="stable")]
    sizes = np.zeros(len(body.tree.segments))
    sizes[body.sensed[gravity.sensors[named]]] = gravity.angle[named]
    allowed = math.degrees(gravity.explained(limit))
    angles = _listed((f"{math.degrees(gravity.angle[k]):.0f} deg at {_joint(body, int(gravity.sensors[k]))}"
                      for k in worst), len(named))
    return Contradiction(
        f"the hand was not in the stated pose: gravity shows a difference of {angles}, where up to "
        f"{allowed:.0f} may be errors of mounting and pose", sizes)


def _joint(body: Body, sensor: int) -> str:
    """Joint and sensor, such as "F2_pip (sensor 6, F2m)"."""
    segment = int(body.sensed[sensor])
    return f"{body.joints[segment]} (sensor {sensor}, {body.tree.names[segment]})"


def _listed(parts: Iterable[str], count: int) -> str:
    few = list(parts)[:_MOST_NAMED]
    return ", ".join(few) + (f" and {count - len(few)} more" if count > len(few) else "")


def not_shown(body: Body, angles: Array, rest: Rest) -> tuple[str, ...]:
    """Names of the tracked freedoms that gravity does not show in a pose.

    Parameters
    ----------
    angles: (f,), rad, the pose.
    rest: mean readings in the pose.
    """
    tree = body.tree
    present = np.flatnonzero(rest.present)
    to_root = segment_poses(tree, angles).orientation
    up = quaternion.rotate(to_root[body.sensed[present]], rest.acc[present]).sum(axis=0)
    carrying = np.zeros(len(tree.segments), dtype=np.bool_)
    carrying[body.sensed[present]] = True
    below = _at_or_below(tree.layout, carrying)
    names, relative = [], relative_orientations(tree, angles)
    moved = relative_orientations(tree, angles + 1e-6 * np.eye(len(angles)))
    for k, (parent, freedoms, first) in enumerate(tree.layout.tolist()):
        if not (below[k] and _at_or_above(tree.layout, carrying, parent)):
            continue
        for i in range(first, first + freedoms):
            turn = quaternion.relative(relative[k], moved[i, k])[1:]
            axis = quaternion.rotate(to_root[k], turn)
            if np.linalg.norm(np.cross(axis, up)) < _SHOWN * np.linalg.norm(axis) * np.linalg.norm(up):
                names.append(tree.freedoms[i])
    return tuple(names)


def _at_or_below(layout: Numbers, carrying: Flags) -> Flags:
    found = carrying.copy()
    for k in range(len(layout) - 1, 0, -1):
        found[layout[k, 0]] |= found[k]
    return found


def _at_or_above(layout: Numbers, carrying: Flags, k: int) -> bool:
    while k >= 0 and not carrying[k]:
        k = int(layout[k, 0])
    return k >= 0


def taken(body: Body, angles: Array, rest: Rest, pose_sd: float, left_out: Sequence[str] = ()) -> str:
    """Text on a pose that has been taken: sensors without samples, and angles that gravity does not confirm.

    `angles`, `rest`: as in `not_shown`. `pose_sd`: rad. `left_out`: names of sensors without samples.
    """
    hidden = not_shown(body, angles, rest)
    text = f"without {', '.join(left_out)}: no sample" if left_out else "initial pose taken"
    if hidden:
        text += (f"; gravity does not confirm {_listed(hidden, len(hidden))}, which rest on the stated pose "
                 f"(sd {math.degrees(pose_sd):.3g} deg)")
    return text


def still_readings(
    body: Body, angles_deg: Mapping[str, float], gyr: ArrayLike, acc: ArrayLike,
    mag: ArrayLike | None = None, *, least: int, limits: InitialPoseLimits | None = None,
    mounting_sd_deg: float = 5.0, pose_sd_deg: float = 5.0
) -> tuple[Rest, Ties]:
    """Mean readings in a recorded initial pose, and the ties of its sensors.

    Parameters
    ----------
    angles_deg: angles of the pose, by freedom; others are 0.
    gyr, acc, mag: (t, n, 3), rad/s, m/s^2, any unit of field; a row that is not finite is a lost sample.
    least: least number of samples of the pose.
    mounting_sd_deg, pose_sd_deg: as in `inclinations`.

    Raises InputError for streams of other shapes or of unequal length, for a pose that is too short,
    in motion or contradicts gravity, with the sensors' names, and the errors of `known_angles`.
    """
    limits = limits or InitialPoseLimits()
    kinds = {"gyr": np.asarray(gyr, dtype=np.float64), "acc": np.asarray(acc, dtype=np.float64)}
    if mag is not None:
        kinds["mag"] = np.asarray(mag, dtype=np.float64)
    count = len(kinds["gyr"])
    for name, kind in kinds.items():
        if kind.shape != (count, len(body.sensed), 3):
            raise InputError(f"initial pose: {name}", f"has shape {kind.shape}",
                             f"({count}, {len(body.sensed)}, 3), as many rows as gyr",
                             "cut the streams to one length")
    if count < least:
        raise InputError("initial pose", f"is too short: {count} samples", f"{least} or more",
                         f"{KEEP_STILL} for longer")
    record, fresh = new_record(len(body.sensed)), np.array([True, True, mag is not None])
    rows: Any = [kinds["gyr"], kinds["acc"], kinds.get("mag", kinds["acc"])]
    for k in range(count):
        lost = [~np.isfinite(kind[k]).all(axis=1) for kind in rows]
        codes = np.where(lost, LOST, 0).astype(np.uint8)
        moving = add_samples(rows[0][k], rows[1][k], rows[2][k], codes, fresh, int(2 * k >= count),
                             math.radians(limits.rate_deg_s), record)
        if moving >= 0:
            raise InputError("initial pose", moved(body, moving, rows[0][k, moving]), "no motion", KEEP_STILL)
    rest = rest_of(record, mag is not None)
    ties = ties_of(body, known_angles(body.tree, angles_deg), rest.present)
    found = faults(record, rest, body, limits, count)
    if not found:
        gravity = inclinations(body, ties, rest, math.radians(mounting_sd_deg), math.radians(pose_sd_deg))
        wrong = against_gravity(body, gravity, PoseEvidence())
        found = [wrong.text] if wrong else []
    if found:
        raise InputError("initial pose", "; ".join(found), "a still, known pose", KEEP_STILL)
    return rest, ties


@compiled
def joint_rotations(
    layout: Numbers, geometry: Array, sensors: Numbers, seen: Flags, orientation: Array, headings: Array,
    rotations: Array
) -> None:
    """Fill `rotations` (m, 3), rad: z-x-y Euler angles of each joint, unconstrained; 0 where it is not seen.

    Parameters
    ----------
    layout, geometry: of the tree. sensors: (m,), sensor of each segment. seen: (m,), joints with two sensors.
    orientation: (n, 4), sensor to earth. headings: (n, 2), cosine and sine of half a correction of each.
    """
    for k in range(layout.shape[0]):
        rotations[k] = 0.0
        if not seen[k]:
            continue
        a, b = sensors[layout[k, 0]], sensors[k]
        p, c = orientation[a], orientation[b]
        parent = multiply((headings[a, 0], 0.0, 0.0, headings[a, 1]), (p[0], p[1], p[2], p[3]))
        child = multiply((headings[b, 0], 0.0, 0.0, headings[b, 1]), (c[0], c[1], c[2], c[3]))
        w, x, y, z = multiply(conjugate(parent), child)
        axes = geometry[k]
        q = (w, x * axes[1, 0] + y * axes[1, 1] + z * axes[1, 2],
             x * axes[2, 0] + y * axes[2, 1] + z * axes[2, 2],
             x * axes[0, 0] + y * axes[0, 1] + z * axes[0, 2])
        rotations[k, 0], rotations[k, 1] = euler_z_of_zxy(q), euler_x_of_zxy(q)
        rotations[k, 2] = euler_y_of_zxy(q)


@compiled
def range_excess(
    rotations: Array, variance: Array, seen: Flags, low: Array, high: Array, own_variance: Array
) -> tuple[Array, Array, Array]:
    """Excess of rotations (m, 3) over their ranges, its variance, (m, 3) each, and sums of squares (m + 1,).

    Squares are over their variances; 0 where a joint is not `seen` (m,); the last sum is that of all joints.
    `variance` (m,), rad^2, of a rotation about any axis, and `own_variance` (m, 3) of the ranges `low` to
    `high`, (m, 3) each, rad.
    """
    count = rotations.shape[0]
    excess, spread, surprise = np.empty((count, 3)), np.empty((count, 3)), np.zeros(count + 1)
    for k in range(count):
        # Near its pole two Euler angles are uncertain.
        pole = max(math.cos(rotations[k, 1])**2, 1e-3)
        for i in range(3):
            excess[k, i] = max(low[k, i] - rotations[k, i], 0.0) + max(rotations[k, i] - high[k, i], 0.0)
            spread[k, i] = variance[k] / (1.0 if i == 1 else pole) + own_variance[k, i]
            if seen[k]:
                surprise[k] += excess[k, i]**2 / spread[k, i]
        surprise[count] += surprise[k]
    return excess, spread, surprise


class ReleaseWatch:
    """Comparison of the posture after an initial pose with joints' ranges and with the release of a hand.

    Parameters
    ----------
    body: body with the sensors.
    angles: (f,), rad, the pose.
    evidence: parameters of the tests.
    """

    __slots__ = ("_begun_ns", "_body", "_evidence", "_expected", "_first", "_high", "_limit", "_low",
                 "_relaxed", "_since_ns", "_variance", "sizes")

    def __init__(self, body: Body, angles: Array, evidence: PoseEvidence) -> None:
        tree = body.tree
        count = len(tree.segments)
        self._body, self._evidence = body, evidence
        joints = max(1, int(body.seen().sum()))
        rate = 0.5 * evidence.false_alarm / TESTS
        self._limit = np.full(count + 1, chdtri(3, rate / joints))
        self._limit[-1] = chdtri(3 * joints, rate)
        self._low, self._high = np.zeros((count, 3)), np.zeros((count, 3))
        self._variance = np.full((count, 3), math.radians(evidence.axis_sd_deg)**2)
        for k, (_, freedoms, first) in enumerate(tree.layout.tolist()):
            free = tree.ranges[first:first + freedoms]
            self._low[k, :freedoms], self._high[k, :freedoms] = free.T
            self._variance[k, :freedoms] = math.radians(evidence.range_sd_deg)**2
        turning = self._high - self._low > 2.0 * math.pi - 1e-6
        self._low[turning], self._high[turning] = -np.inf, np.inf
        self._expected = _closures(body, angles)
        if evidence.relaxed_s and not self._expected:
            raise InputError("evidence.relaxed_s", f"{evidence.relaxed_s:g} for a body without fingers F2 to "
                             "F5", "0", "only a hand's relaxation is known")
        self._first = np.zeros(count)
        # The last one is that of all joints together.
        self._since_ns = np.full(count + 1, -1, dtype=np.int64)
        self._begun_ns, self._relaxed = -1, not evidence.relaxed_s
        self.sizes = np.zeros(count)
        """(m,), rad, by how much each segment's joint contradicts the pose; 0 for none."""

    @property
    def lasts_ns(self) -> int:
        """Duration after the pose for which the posture is compared, ns."""
        return round(max(self._evidence.watch_s, self._evidence.relaxed_s) * NS_PER_S)

    def begin(self, rotations: Array, time_ns: int) -> None:
        """Begin with the rotations (m, 3), rad, at the end of the pose."""
        self._begun_ns, self._first = time_ns, rotations[:, 0].copy()
        self._since_ns[:] = -1
        self._relaxed = not self._evidence.relaxed_s

    def note(self, rotations: Array, variance: Array, seen: Flags, time_ns: int) -> str:
        """Test the posture at an instant; return the text of a new contradiction, else "".

        Parameters
        ----------
        rotations: (m, 3), rad, flexion, abduction and pronation of each joint.
        variance: (m,), rad^2, of each joint's rotation about any axis.
        seen: (m,), mask of the joints that are tracked.
        """
        after_ns = time_ns - self._begun_ns
        found = ""
        if after_ns <= self._evidence.watch_s * NS_PER_S:
            found = self._joints(rotations, variance, seen, time_ns)
        if not self._relaxed and after_ns >= self._evidence.relaxed_s * NS_PER_S:
            self._relaxed = True
            found = self._relaxation(rotations, seen) or found
        return found

    def _joints(self, rotations: Array, variance: Array, seen: Flags, time_ns: int) -> str:
        excess, spread, surprise = range_excess(
            rotations, variance, seen, self._low, self._high, self._variance)
        beyond = surprise > self._limit
        if not beyond.any():
            self._since_ns[:] = -1
            return ""
        self._since_ns[beyond & (self._since_ns < 0)] = time_ns
        self._since_ns[~beyond] = -1
        late = beyond & (time_ns - self._since_ns >= _LONG_NS)
        if not (late[:-1] & (self.sizes == 0.0)).any() and not (late[-1] and not self.sizes.any()):
            return ""
        # Where all joints together contradict the pose, each that contributes counts.
        new = (surprise[:-1] > 1.0 if late[-1] else late[:-1]) & (self.sizes == 0.0)
        self.sizes[new] = np.linalg.norm(excess[new], axis=1)
        parts = []
        for k in sorted(np.flatnonzero(new), key=lambda k: -surprise[k])[:_MOST_NAMED]:
            i = int(np.argmax(excess[k]**2 / spread[k]))
            parts.append(f"{self._body.joints[k]} at {math.degrees(rotations[k, i]):.0f} deg of {MOTIONS[i]} "
                         f"({math.degrees(excess[k, i]):.0f} more than the joint has)")
        return ("the hand was not in the stated pose: from it, sensors lead to "
                + _listed(parts, int(new.sum())))

    def _relaxation(self, rotations: Array, seen: Flags) -> str:
        fingers = [finger for finger, (joints, _) in self._expected.items() if seen[joints].all()]
        if not fingers:
            return ""
        rows = [self._expected[finger] for finger in fingers]
        moved = rotations[:, 0] - self._first
        closed = np.array([moved[joints].sum() for joints, _ in rows])
        usual = np.array([expected for _, expected in rows])
        short = usual - closed
        rate = 0.5 * self._evidence.false_alarm / TESTS
        least = -ndtri(rate) * math.hypot(_FINGERS_SD, _FINGER_SD / math.sqrt(len(rows)))
        late = np.full(len(rows), bool(short.mean() > least))
        if not late.any() and len(rows) > 2:
            others = np.array([np.median(np.delete(short, i)) for i in range(len(rows))])
            late = short - others > -ndtri(rate / len(rows)) * _FINGER_SD * math.sqrt(1.0 + 1.0 / len(rows))
        if not late.any():
            return ""
        for i in np.flatnonzero(late):
            joints = rows[i][0]
            self.sizes[joints] = np.maximum(self.sizes[joints], short[i] / len(joints))
        return ("the hand was not in the stated pose: let go, "
                f"{', '.join(fingers[i] for i in np.flatnonzero(late))} closed by "
                f"{math.degrees(closed[late].mean()):.0f} deg (MCP, PIP and DIP together), relaxed fingers "
                f"by about {math.degrees(usual[late].mean()):.0f}")


def _closures(body: Body, angles: Array) -> dict[str, tuple[Numbers, float]]:
    """Joints of each finger, and by how much it closes from a pose to rest, rad."""
    freedoms, tree = body.tree.freedoms, body.tree
    found = {}
    for finger, rests in FINGER_RESTS_DEG.items():
        names = [f"{finger}_{joint}_flexion" for joint in ("mcp", "pip", "dip")]
        if not all(name in freedoms for name in names):
            continue
        rows = [freedoms.index(name) for name in names]
        joints = np.array([int(np.flatnonzero((tree.layout[:, 2] == row) & (tree.layout[:, 1] > 0))[0])
                           for row in rows], dtype=np.int64)
        found[finger] = (joints, math.radians(sum(rests)) - float(angles[rows].sum()))
    return found
