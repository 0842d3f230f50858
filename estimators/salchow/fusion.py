"""Common parts of the trackers of Salchow-Hoemmen et al. 2019: fusion, initial pose, posture."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.arrivals import CLIPPED, LOST, Arrivals, Overrun
from estimators.body.body import (
    UNSEEN_SD,
    Body,
    ImplausibleAngles,
    aligned_value,
    body_of,
    chain_up,
    of_tree,
    place_tips,
    spread_tips,
)
from estimators.body.misalignment import Misalignment, add_misalignment, misalignment
from estimators.calibration.initial_pose import (
    KEEP_STILL,
    NO_SAMPLE,
    InitialPoseLimits,
    PoseRecord,
    Ties,
    add_samples,
    faults,
    headings,
    known_angles,
    moved,
    new_record,
    rest_of,
    sensor_name,
    ties_of,
)
from estimators.calibration.pose_evidence import (
    REMEDY,
    PoseEvidence,
    ReleaseWatch,
    against_gravity,
    inclinations,
    joint_rotations,
    taken,
)
from estimators.fusion.front_end import FrontEnd, FrontEndName, front_end_of, require_front_end
from estimators.gaps import Gaps, bridge, lost_samples
from fesloop.compiled import assign, compiled
from fesloop.errors import InputError
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.kinematics_kernels import about, turned
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.hand.quaternion_kernels import (
    Components,
    conjugate,
    euler_x_of_zxy,
    euler_y_of_zxy,
    euler_z_of_zxy,
    multiply,
)
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, RateClock, StampClock
from fesloop.loop.signals import Port, Sample, Value

_POSITIVE = ("tau_acc_s", "tau_mag_s", "mounting_sd_deg", "axis_sd_deg", "fusion_sd_deg",
             "heading_sd_deg", "drift_deg_s", "untracked_deg_s", "clipped_rate_deg_s", "gap_ms",
             "gyr_range_deg_s", "acc_range_g", "initial_pose_s", "pose_sd_deg")


class InitialPose(NamedTuple):
    """Initial pose: duration, s, angles by freedom, deg, their sd, rad, limits and tests of the pose."""

    duration_s: float
    angles_deg: Mapping[str, float]
    sd: float
    limits: InitialPoseLimits
    evidence: PoseEvidence


class Method(NamedTuple):
    """Parameters of a tracker of this family.

    Attributes
    ----------
    front_end, tau_acc_s, tau_mag_s: as in `front_end_of`.
    every: ticks between samples of the accelerometers, and of the magnetometers.
    magnetometer: whether magnetometers are used. pose: the initial pose, or None.
    constrained: whether joint constraints are applied.
    mounting_sd_deg, axis_sd_deg, fusion_sd_deg: deg.
    heading_sd: rad. drift: rad/s. unseen_rate, clipped_rate: rad/s. gap_s: s.
    limits: magnitudes above which samples count as clipped, rad/s, m/s^2, T.
    """

    front_end: FrontEndName
    tau_acc_s: float | None
    tau_mag_s: float | None
    every: tuple[int, int]
    magnetometer: bool
    pose: InitialPose | None
    constrained: bool
    mounting_sd_deg: float
    axis_sd_deg: float
    fusion_sd_deg: float
    heading_sd: float
    drift: float
    unseen_rate: float
    clipped_rate: float
    gap_s: float
    limits: tuple[float, float, float]


def require_parameters(tracker: Any) -> None:
    """Raise InputError for an invalid parameter of a tracker."""
    if tracker.sensors < 0:
        raise InputError("sensors", f"{tracker.sensors}", "1 or more, or 0 to take it from the wire")
    require_front_end(tracker.front_end)
    for name in _POSITIVE:
        value = getattr(tracker, name, None)
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(name, f"{value} is not positive", "a finite number above 0")
    for name in ("acc_every", "mag_every"):
        if getattr(tracker, name, 1) < 1:
            raise InputError(name, f"{getattr(tracker, name)}", "1 or more ticks")


def worn_by(tracker: Any) -> Body | None:
    """Body that carries a tracker's sensors; None while their number is unknown.

    Raises InputError as `body_of` does, and for an initial pose that the body cannot have.
    """
    if not tracker.sensors:
        return None
    body = body_of(tracker.sensors, tracker.hand, tracker.segments, tracker.sensed)
    known_angles(body.tree, getattr(tracker, "initial_angles_deg", {}))
    return body


def wired(body: Body | None) -> Body:
    """Return the body; raise InputError if the number of sensors is unknown."""
    if body is None:
        raise InputError("sensors", "0", "their number", "wire the tracker, or give it `sensors`")
    return body


def sample_ports(sensors: int, magnetometer: bool) -> tuple[Port, ...]:
    """Ports gyr, acc and, with a magnetometer, mag."""
    shape = (sensors or None, 3)
    ports = (Port("gyr", shape, "rad/s"), Port("acc", shape, "m/s^2"))
    return (*ports, Port("mag", shape, "T")) if magnetometer else ports


def method_of(tracker: Any, *, magnetometer: bool) -> Method:
    """Create the method of a tracker from its parameters; with an initial pose it constrains the joints."""
    pose = None
    if hasattr(tracker, "initial_pose_s"):
        pose = InitialPose(tracker.initial_pose_s, tracker.initial_angles_deg,
                           math.radians(tracker.pose_sd_deg), tracker.pose_limits, tracker.evidence)
    radians = math.radians
    return Method(
        front_end=tracker.front_end, tau_acc_s=tracker.tau_acc_s,
        tau_mag_s=tracker.tau_mag_s if magnetometer else None,
        every=(tracker.acc_every, tracker.mag_every if magnetometer else 1), magnetometer=magnetometer,
        pose=pose, constrained=pose is not None, mounting_sd_deg=tracker.mounting_sd_deg,
        axis_sd_deg=tracker.axis_sd_deg, fusion_sd_deg=tracker.fusion_sd_deg,
        heading_sd=radians(tracker.heading_sd_deg) if magnetometer else 0.0,
        drift=0.0 if magnetometer else radians(tracker.drift_deg_s),
        unseen_rate=radians(tracker.untracked_deg_s), clipped_rate=radians(tracker.clipped_rate_deg_s),
        gap_s=1e-3 * tracker.gap_ms,
        limits=(radians(tracker.gyr_range_deg_s), STANDARD_GRAVITY * tracker.acc_range_g, math.inf))


Array = NDArray[np.float64]
_NO_TURN = np.array([1.0, 0.0])
_TAU_S = {"vqf": (3.0, 9.0), "seel_ruppin": (1.0, 3.0)}
"""Default time constants of the corrections by accelerometer and magnetometer, s."""
_TIME_CONSTANT = {"vqf": 1.0, "seel_ruppin": 1.0 / math.log(2.0)}
"""Ratio of an error's time constant to `_TAU_S`: VQF states time constants, Seel-Ruppin halving times."""


@dataclass(slots=True, eq=False)
class SalchowState:
    """State of a tracker of this family: n sensors, m segments.

    Attributes
    ----------
    method: parameters of the tracker; they never change.
    bank: the filters.
    arrivals: ages and faults of the samples.
    period_s: of the ticks. forget: (2,), fraction of a gap's variances that remains after a sample.
    gaps: rotation through gaps in the samples. missed: (n, 2), variances due to bad samples, rad^2.
    record: statistics of the initial pose so far. pose_ticks: number of its ticks so far.
    known: (n, 4), segments to the root in the known pose. ties: relative orientations of all sensors in it.
    headings: (n, 2), cosine and sine of half the heading correction of each sensor.
    posed: (n,), whether each sensor has been aligned.
    aligned_ns: instant of the alignment; None before.
    watch: comparison of the posture after the pose with the pose; None without a pose.
    overrun: what clipped rates have missed since the alignment.
    contradicted: whether evidence contradicts the pose that has been taken.
    failing: whether the pose has been refused; quiet_ns: instant until which that is not reported again.
    seen: (m,), whether each joint is seen.
    unseen: joints last reported as untracked; None before the first tick.
    plausible: check for angles that no joint can have.
    counted: (m,), whether each joint's uncertainty adds to that of the fingertips.
    wrong: misalignment of sensors and joints.
    ticks: number of the next tick.
    """

    method: Method
    bank: FrontEnd
    arrivals: Arrivals
    period_s: float
    forget: Array
    gaps: Gaps
    missed: Array
    record: PoseRecord
    known: Array
    ties: Ties
    headings: Array
    posed: NDArray[np.bool_]
    seen: NDArray[np.bool_]
    counted: NDArray[np.bool_]
    wrong: Misalignment
    plausible: ImplausibleAngles
    overrun: Overrun
    unseen: tuple[str, ...] | None = None
    aligned_ns: int | None = None
    watch: ReleaseWatch | None = None
    contradicted: bool = False
    pose_ticks: int = 0
    failing: bool = False
    quiet_ns: int = -1
    ticks: int = 0


def start(body: Body, method: Method, context: Context) -> SalchowState:
    """Create the initial state of a tracker, without corrections of headings."""
    if not isinstance(context.clock, (RateClock, StampClock)):
        raise InputError(f"{context.name}.rate", "is missing", "the rate of the gyroscopes")
    n, m, period = len(body.sensed), len(body.tree.segments), context.clock.period_s
    angles = known_angles(body.tree, method.pose.angles_deg if method.pose else {})
    usual = _TAU_S[method.front_end]
    tau_mag_s = (method.tau_mag_s or usual[1]) if method.magnetometer else math.inf
    fading = _TIME_CONSTANT[method.front_end] * np.array([method.tau_acc_s or usual[0], tau_mag_s])
    return SalchowState(
        method=method, bank=_new_bank(n, period, method), period_s=period,
        arrivals=Arrivals(n, method.limits, period, names=body.sensor_names),
        forget=np.exp(-2.0 * period / fading), gaps=Gaps.none(n), missed=np.zeros((n, 2)),
        record=new_record(n), known=segment_poses(body.tree, angles).orientation[body.sensed],
        ties=ties_of(body, angles, np.ones(n, dtype=np.bool_)),
        headings=np.tile(_NO_TURN, (n, 1)), posed=np.ones(n, dtype=np.bool_),
        seen=np.zeros(m, dtype=np.bool_), counted=_beyond_a_sensor(body), plausible=of_tree(body.tree),
        wrong=misalignment(body.tree, method.mounting_sd_deg, method.axis_sd_deg, method.fusion_sd_deg),
        watch=_watch_of(body, angles, method), overrun=Overrun(n, method.clipped_rate, body.sensor_names))


def _watch_of(body: Body, angles: Array, method: Method) -> ReleaseWatch | None:
    """Comparison of the posture after the pose with the pose.

    With magnetometers the field contradicts the joints wherever it is disturbed, whatever the pose was.
    """
    if method.pose is None:
        return None
    evidence = method.pose.evidence
    return ReleaseWatch(body, angles, replace(evidence, watch_s=0.0) if method.magnetometer else evidence)


def _new_bank(sensors: int, period_s: float, method: Method) -> FrontEnd:
    periods = (period_s, method.every[0] * period_s, method.every[1] * period_s)
    return front_end_of(method.front_end, sensors, periods, method.magnetometer, method.tau_acc_s,
                        method.tau_mag_s)


def _beyond_a_sensor(body: Body) -> NDArray[np.bool_]:
    """Mask (m,) of joints with a sensor between them and the root; others are not meant to be measured."""
    beyond = np.zeros(len(body.sensors), dtype=np.bool_)
    for k, parent in enumerate(body.tree.layout[:, 0]):
        if parent >= 0:
            beyond[k] = beyond[parent] or body.sensors[parent] >= 0
    return beyond


Flags = NDArray[np.bool_]
Numbers = NDArray[np.int64]
Triple = tuple[float, float, float]
_UNCORRECTED = math.radians(0.5)
"""Drift rate of an uncorrected inclination or heading, rad/s (the bias that VQF assumes before
it has estimated one, doi 10.1016/j.inffus.2022.10.014)."""


@compiled
def widen(
    codes: NDArray[np.uint8], elapsed_s: float, excess_sd: float, forget: Array, gaps: Gaps, missed: Array
) -> None:
    """Advance by a step `missed` (n, 2), variances of inclination and heading due to bad samples, rad^2.

    Parameters
    ----------
    codes: (3, n), LOST and CLIPPED of gyr, acc and mag.
    elapsed_s: duration of the step.
    excess_sd: sd of a rate in excess of a clipped one, rad/s.
    forget: (2,), fraction of the variances that remains after a step with sound samples.
    gaps: of this step.
    """
    for s in range(codes.shape[1]):
        turning = gaps.spread[s] > 0.0 or gaps.pending[s] > 0.0
        for i in range(2):
            if codes[0, s] & CLIPPED:
                # The unknown rate is constant: the sd grows with time, not with its square root.
                missed[s, i] = (math.sqrt(missed[s, i]) + excess_sd * elapsed_s) ** 2
            elif turning:
                missed[s, i] += gaps.spread[s] * elapsed_s
            elif codes[1 + i, s] & LOST:
                missed[s, i] = (math.sqrt(missed[s, i]) + _UNCORRECTED * elapsed_s) ** 2
            else:
                missed[s, i] *= forget[i]
            missed[s, i] = min(missed[s, i], UNSEEN_SD ** 2)


@compiled
def find_seen(
    layout: Numbers, sensors: Numbers, silent: Array, posed: Flags, gap_s: float, seen: Flags
) -> bool:
    """Update `seen` (m,), joints with two sensors that are sound and `posed`; return whether any changed.

    `silent` (n, 2), s, as in Gaps.
    """
    changed = False
    for k in range(sensors.size):
        now = layout[k, 0] >= 0
        if now:
            a, b = sensors[layout[k, 0]], sensors[k]
            now = a >= 0 and b >= 0
            if now:
                now = posed[a] and posed[b] and silent[a, 0] <= gap_s and silent[b, 0] <= gap_s
        changed |= seen[k] != now
        seen[k] = now
    return changed


@compiled(inline="always")
def _unit(q: Array) -> Components:
    return q[0], q[1], q[2], q[3]


@compiled(inline="always")
def _in_segment(axes: Array, v: Triple) -> Triple:
    """Transform a vector from a joint's x, y, z (its axes are listed z, x, y) to its segment's frame."""
    return (v[0] * axes[1, 0] + v[1] * axes[2, 0] + v[2] * axes[0, 0],
            v[0] * axes[1, 1] + v[1] * axes[2, 1] + v[2] * axes[0, 1],
            v[0] * axes[1, 2] + v[1] * axes[2, 2] + v[2] * axes[0, 2])


@compiled(inline="always")
def _cross(a: Triple, b: Triple) -> Triple:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled(inline="always")
def _dot(a: Triple, b: Triple) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled(inline="always")
def in_joint(axes: Array, q: Components) -> Components:
    """Express a rotation of a segment in its joint's own axes."""
    w, x, y, z = q
    return (w, x * axes[1, 0] + y * axes[1, 1] + z * axes[1, 2],
            x * axes[2, 0] + y * axes[2, 1] + z * axes[2, 2],
            x * axes[0, 0] + y * axes[0, 1] + z * axes[0, 2])


@compiled
def joint_turns(axes: Array, q: Components) -> tuple[Triple, Triple, Triple]:
    """Rotation of the child per flexion, abduction and pronation, in its frame, rad/rad.

    `q`: child to parent, in the joint's own axes.
    """
    w, x, y, z = q
    sine, cosine = 2.0 * (w * y - x * z), 1.0 - 2.0 * (x * x + y * y)
    length = math.sqrt(sine * sine + cosine * cosine)
    scale = 1.0 / length if length > 1e-12 else 0.0
    return (_in_segment(axes, turned(conjugate(q), 0.0, 0.0, 1.0)),
            _in_segment(axes, (scale * cosine, 0.0, scale * sine)), (axes[2, 0], axes[2, 1], axes[2, 2]))


@compiled
def joint_angles(q: Components, freedoms: int, first: int, angles: Array) -> None:
    """Fill `angles` (d,) from `first` with the free flexion, abduction, pronation (eq. 20-22)."""
    if freedoms > 0:
        angles[first] = euler_z_of_zxy(q)
    if freedoms > 1:
        angles[first + 1] = euler_x_of_zxy(q)
    if freedoms > 2:
        angles[first + 2] = euler_y_of_zxy(q)


@compiled
def allowed(axes: Array, ranges: Array, freedoms: int, first: int, angles: Array) -> Components:
    """Clip `angles` (d,) from `first`; return the rotation that the joint allows (section 2.4.3).

    Its forbidden angles are zero.
    """
    q = (1.0, 0.0, 0.0, 0.0)
    for i in range(first, first + freedoms):
        angles[i] = min(max(angles[i], ranges[i, 0]), ranges[i, 1])
        q = multiply(q, about(axes[i - first], angles[i]))
    return q


@compiled
def spread_joint(
    turns: tuple[Triple, Triple, Triple], freedoms: int, error: Array, constrained: bool, first: int,
    sd: Array, covariance: Array
) -> None:
    """Fill `sd` (d,) of a joint's angles from `first`, rad, and `covariance` (3, 3) of its rotation, rad^2.

    Parameters
    ----------
    turns: as in `joint_turns`. error: (3, 3), covariance of the measured rotation, in the child's frame.
    constrained: whether forbidden angles are known to be zero.
    """
    rows = (_cross(turns[1], turns[2]), _cross(turns[2], turns[0]), _cross(turns[0], turns[1]))
    volume = _dot(turns[0], rows[0])
    # At the pole flexion and pronation are undefined; their sd there is large, not infinite.
    scale = volume / (volume * volume + 1e-6)
    for a in range(3):
        for b in range(3):
            covariance[a, b] = 0.0 if constrained else error[a, b]
    for i in range(freedoms):
        for j in range(freedoms):
            shared = 0.0
            for a in range(3):
                for b in range(3):
                    shared += scale * scale * rows[i][a] * error[a, b] * rows[j][b]
            if i == j:
                sd[first + i] = min(math.sqrt(shared), UNSEEN_SD)
            if constrained:
                for a in range(3):
                    for b in range(3):
                        covariance[a, b] += turns[i][a] * shared * turns[j][b]


@compiled
def posture(
    layout: Numbers, geometry: Array, ranges: Array, sensors: Numbers, counted: Flags, tips: Numbers,
    fused: Array, headings: Array, seen: Flags, constrained: bool, wrong: Misalignment, tilt: float,
    heading: float, changing: float, missed: Array, orientation: Array, angles: Array, sd: Array,
    fingertips: Array, fingertip_sd: Array, random_sd: Array
) -> None:
    """Fill the output arrays of a tracker.

    Parameters
    ----------
    counted: (m,), whether each joint's uncertainty adds to that of the fingertips.
    fused: (n, 4), sensor to earth. headings: (n, 2), cosine and sine of half the heading correction.
    seen: (m,), whether each joint is seen. constrained: whether joint constraints are applied.
    wrong: misalignment of sensors and joints.
    tilt, heading: further variances of a segment's orientation relative to its parent's, rad^2, about any
        axis and about the vertical; changing: the share of `heading` that is not constant.
    missed: (n, 2), further variances of each sensor's inclination and heading, rad^2.
    orientation: (n, 4), segment to earth; angles, sd, random_sd: (d,), rad, the last without what is
        constant; fingertips, fingertip_sd: (t, 3), m.
    """
    count = layout.shape[0]
    relative, to_root, own = np.empty((count, 4)), np.empty((count, 4)), np.empty(fused.shape)
    places, covariance, error = np.zeros((count, 3)), np.empty((count, 3, 3)), np.empty((3, 3))
    random, scratch = np.empty((3, 3)), np.empty((3, 3))
    for s in range(fused.shape[0]):
        turn = (headings[s, 0], 0.0, 0.0, headings[s, 1])
        own[s, 0], own[s, 1], own[s, 2], own[s, 3] = multiply(turn, _unit(fused[s]))
    for k in range(count):
        parent, freedoms, first = layout[k, 0], layout[k, 1], layout[k, 2]
        axes, child = geometry[k], sensors[k]
        if child >= 0:
            assign(orientation[child], own[child])
        if not seen[k]:
            relative[k] = 0.0
            relative[k, 0] = 1.0
            covariance[k] = 0.0
            for i in range(freedoms):
                angles[first + i], sd[first + i], random_sd[first + i] = 0.0, UNSEEN_SD, UNSEEN_SD
            for a in range(3):
                covariance[k, a, a] = UNSEEN_SD ** 2 if counted[k] else 0.0
            continue
        above = sensors[parent]
        measured = multiply(conjugate(_unit(own[above])), _unit(own[child]))
        q = in_joint(axes, measured)
        joint_angles(q, freedoms, first, angles)
        if constrained:
            measured = allowed(axes, ranges, freedoms, first, angles)
            now = multiply(_unit(orientation[above]), measured)
            for i in range(4):
                orientation[child, i] = now[i]
        for i in range(4):
            relative[k, i] = measured[i]
        upright = turned(conjugate(_unit(own[child])), 0.0, 0.0, 1.0)
        about_vertical = heading + missed[above, 1] + missed[child, 1]
        for i in range(3):
            for j in range(3):
                error[i, j] = about_vertical * upright[i] * upright[j]
                random[i, j] = (about_vertical - heading + changing) * upright[i] * upright[j]
            error[i, i] += tilt + missed[above, 0] + missed[child, 0]
            random[i, i] += tilt + missed[above, 0] + missed[child, 0] + wrong.fused
        add_misalignment(relative[k], wrong.pair[k], wrong.growing[k], error)
        turns = joint_turns(axes, q)
        spread_joint(turns, freedoms, random, False, first, random_sd, scratch)
        spread_joint(turns, freedoms, error, constrained, first, sd, covariance[k])
    chain_up(layout, relative, to_root)
    place_tips(layout, geometry, to_root, tips, places, fingertips)
    spread_tips(layout, geometry, to_root, places, covariance, tips, fingertip_sd)


Outputs = tuple[Array, Array, Array, Array, Array, Array, Array]


def track(state: SalchowState, body: Body, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
    """Process one tick of a tracker."""
    method = state.method
    ticks = tick.index + 1 - state.ticks
    state.ticks = tick.index + 1
    elapsed = state.arrivals.note(inputs, tick)
    fresh = (elapsed[0] > 0.0, elapsed[1] > 0.0, elapsed[2] > 0.0)
    _fuse(state, method, inputs, elapsed, ticks, tick)
    fused = state.bank.orientation()
    if method.pose is not None and state.aligned_ns is None:
        if not _take_pose(state, body, method, method.pose, inputs, fresh, tick):
            _, angles, sd, tips, tip_sd, _, random_sd = _posture(
                state, body, method, state.known, 0.0, tick)
            if state.failing:
                sd[:], random_sd[:] = UNSEEN_SD, UNSEEN_SD
            return fused, angles, sd, tips, tip_sd, aligned_value(False), random_sd
        fused = state.bank.orientation()
    elapsed_s = (tick.time_ns - (state.aligned_ns or 0)) / NS_PER_S
    return _posture(state, body, method, fused, elapsed_s, tick)


def _fuse(
    state: SalchowState, method: Method, inputs: Sequence[Sample], fresh: tuple[float, float, float],
    ticks: int, tick: Tick
) -> None:
    """Update the filters, which count time in samples: ticks skipped while busy repeat the samples.

    `fresh`: as `Arrivals.note` returns it.
    """
    acc: Any = inputs[1].value if fresh[1] > 0.0 else None
    mag: Any = inputs[2].value if fresh[2] > 0.0 else None
    arrivals, gaps, elapsed_s = state.arrivals, state.gaps, ticks * state.period_s
    gap = bridge(arrivals.samples[0], arrivals.codes[0], elapsed_s, fresh[0], state.period_s,
                 method.unseen_rate, gaps)
    widen(arrivals.codes, elapsed_s, method.clipped_rate, state.forget, gaps, state.missed)
    if state.aligned_ns is not None and (state.overrun.under_way or not arrivals.faultless):
        state.overrun.note(arrivals.codes, elapsed_s, tick)
    for _ in range(ticks):
        if arrivals.sound and not gap:
            state.bank.update(gaps.rates, acc, mag)
        else:
            state.bank.update_sound(gaps.rates, acc, mag, lost_samples(arrivals.codes, False, gaps))


def _take_pose(
    state: SalchowState, body: Body, method: Method, pose: InitialPose, inputs: Sequence[Sample],
    fresh: tuple[bool, bool, bool], tick: Tick
) -> bool:
    """Continue the initial pose and align at its end; return whether the tracker is aligned now."""
    if state.pose_ticks == 0 and not state.failing and state.quiet_ns < 0:
        tick.report("aligning", f"{KEEP_STILL} for {pose.duration_s:g} s")
        state.quiet_ns = tick.time_ns
    needed = max(2, math.ceil(pose.duration_s / state.period_s - 1e-9))
    gyr: Any = inputs[0].value
    acc: Any = inputs[1].value
    mag: Any = inputs[-1].value
    half = int(2 * state.pose_ticks >= needed)
    moving = add_samples(gyr, acc, mag, state.arrivals.codes, np.array(fresh), half,
                         math.radians(pose.limits.rate_deg_s), state.record)
    state.pose_ticks += 1
    if moving < 0 and state.pose_ticks < needed:
        return False
    wrong = ""
    if moving >= 0:
        found = [moved(body, moving, gyr[moving])]
    else:
        found, wrong = _align(state, body, method, pose, needed, tick)
    state.record.clear()
    found += [wrong] if wrong else []
    state.pose_ticks, state.failing = 0, bool(found)
    if found and tick.time_ns >= state.quiet_ns:
        then = f"{'; '.join(found)}: {KEEP_STILL} for {pose.duration_s:g} s, the next that is still is taken"
        if wrong:
            tick.report("pose_contradicted", f"{wrong}; no stimulation: {REMEDY}")
        elif found == [NO_SAMPLE]:
            tick.report("waiting", then)
        else:
            tick.report("initial_pose_failed", then)
        state.quiet_ns = tick.time_ns + round(pose.duration_s * NS_PER_S)
    return not found


def _align(
    state: SalchowState, body: Body, method: Method, pose: InitialPose, needed: int, tick: Tick
) -> tuple[list[str], str]:
    """Set biases and headings from a completed pose; return its faults, or what contradicts it, if any."""
    rest = rest_of(state.record, method.magnetometer)
    ties, angles = state.ties, known_angles(body.tree, pose.angles_deg)
    if not rest.present.all():
        ties = ties_of(body, angles, rest.present)
    found = faults(state.record, rest, body, pose.limits, needed)
    if found:
        return found, ""
    mounting_sd = math.radians(method.mounting_sd_deg)
    wrong = against_gravity(body, inclinations(body, ties, rest, mounting_sd, pose.sd), pose.evidence)
    if wrong:
        return [], wrong.text
    state.bank.begin(rest.present, rest.bias, rest.acc, rest.mag, needed)
    turn = 0.5 * headings(ties, state.bank.orientation())
    state.headings[:, 0], state.headings[:, 1] = np.cos(turn), np.sin(turn)
    state.posed, state.aligned_ns = rest.present, tick.time_ns
    state.missed[:] = 0.0
    left_out = [sensor_name(body, int(s)) for s in np.flatnonzero(~rest.present)]
    tick.report("aligned", taken(body, angles, rest, pose.sd, left_out))
    return [], ""


def _heading_sd(method: Method, elapsed_s: float) -> float:
    """Sd of a heading relative to its neighbour's that time after the initial pose, rad."""
    return math.hypot(method.heading_sd, method.drift * elapsed_s, method.pose.sd if method.pose else 0.0)


def _watch(state: SalchowState, body: Body, method: Method, watch: ReleaseWatch, fused: Array,
           elapsed_s: float, tick: Tick) -> None:
    """Compare the posture since the initial pose with the pose; what contradicts it adds to the sds."""
    tree, sensors = body.tree, body.sensors
    rotations = np.empty((len(sensors), 3))
    joint_rotations(tree.layout, tree.geometry, sensors, state.seen, fused, state.headings, rotations)
    if elapsed_s == 0.0:
        watch.begin(rotations, tick.time_ns)
        return
    missed = (state.missed + state.gaps.pending[:, np.newaxis]).sum(axis=1)
    variance = (2.0 * math.radians(method.mounting_sd_deg)**2 + _heading_sd(method, elapsed_s)**2
                + missed[sensors] + missed[sensors[tree.layout[:, 0]]])
    wrong = watch.note(rotations, variance, state.seen, tick.time_ns)
    if wrong:
        state.contradicted = True
        tick.report("pose_contradicted", f"{wrong}; no stimulation: begin again, and {REMEDY}")


def _posture(
    state: SalchowState, body: Body, method: Method, fused: Array, elapsed_s: float, tick: Tick
) -> Outputs:
    tree = body.tree
    changed = find_seen(tree.layout, body.sensors, state.gaps.silent, state.posed, method.gap_s, state.seen)
    if changed or state.unseen is None:
        _report_unseen(state, body, tick)
    if state.watch is not None and state.aligned_ns is not None \
            and tick.time_ns - state.aligned_ns <= state.watch.lasts_ns:
        _watch(state, body, method, state.watch, fused, elapsed_s, tick)
    tilt = UNSEEN_SD if state.failing else 0.0
    heading = min(_heading_sd(method, elapsed_s), UNSEEN_SD)
    changing = min(math.hypot(method.heading_sd, method.drift * elapsed_s), UNSEEN_SD)
    freedoms, tips = len(tree.ranges), len(body.tips)
    arrays = (np.empty((len(fused), 4)), np.empty(freedoms), np.empty(freedoms), np.empty((tips, 3)),
              np.empty((tips, 3)), np.empty(freedoms))
    missed = state.missed + state.gaps.pending[:, np.newaxis]
    if state.watch is not None and state.contradicted:
        missed[:, 0] += state.watch.sizes[body.sensed] ** 2
    posture(tree.layout, tree.geometry, tree.ranges, body.sensors, state.counted, body.tips, fused,
            state.headings, state.seen, method.constrained, state.wrong, tilt ** 2, heading ** 2,
            changing ** 2, missed, *arrays)
    if elapsed_s > 0.0:
        state.plausible.note(arrays[1], tick)
    return *arrays[:5], aligned_value(not state.contradicted), arrays[5]


def _report_unseen(state: SalchowState, body: Body, tick: Tick) -> None:
    before = state.unseen or ()
    now = tuple(joint for joint, seen in zip(body.joints, state.seen, strict=True) if joint and not seen)
    state.unseen = now
    for status, these, others in (("untracked", now, before), ("tracked", before, now)):
        changed = [joint for joint in these if joint not in others]
        if changed:
            tick.report(status, "joint " + ", ".join(changed))
