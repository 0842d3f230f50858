"""`constrained`: posture of a hand without magnetometers, with the joints' constraints against drift."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from estimators.arrivals import Arrivals, Overrun
from estimators.body.body import (
    ALIGNED_PORT,
    Body,
    aligned_value,
    body_of,
    of_tree,
    of_unknown_joints,
    posture_ports,
    random_sd_port,
    resolve_pairs,
    stated_by,
    stated_pairs,
    worn_as_stated,
)
from estimators.body.joint_constraints import (
    CHAIN5,
    Joint,
    JointTable,
    body_table,
    joint_table,
    joints_between,
)
from estimators.body.misalignment import misalignment
from estimators.calibration.initial_pose import Rest, known_angles, ties_of
from estimators.calibration.pose_evidence import (
    REMEDY,
    PoseEvidence,
    ReleaseWatch,
    against_gravity,
    inclinations,
    taken,
)
from estimators.constrained.agreement import judge, learn_levers_anew
from estimators.constrained.beginning import Hypotheses, Unknown
from estimators.constrained.filter import LOST, SOUND
from estimators.constrained.fingertips import fingertip_posture, moving_joints
from estimators.constrained.lateness import Lateness, advanced, ahead
from estimators.constrained.learning import AxisSearch
from estimators.constrained.posture import mounting_scale, posture
from estimators.constrained.state import LOOK, ConstrainedState, take
from estimators.fusion.front_end import VqfBank
from estimators.gaps import Gaps, bridge
from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import relative_orientations
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.hand.segments import Segment
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, RateClock, StampClock, duration_ns
from fesloop.loop.signals import Port, Sample, Sensors, Value

SURE, UNSURE, UNSEEN = range(3)
_SURE_AGAIN = 0.8
"""Share of the limit below which a joint is certain again: hysteresis of the reports (chosen)."""


@compiled
def status_changed(worst: Any, limit: float, status: Any) -> bool:
    """Whether the status of any joint differs from `status` (joints,).

    `worst` (joints,), rad, is the largest sd of a joint's angles, infinite for an unknown one; `limit` is the
    sd above which it is uncertain.
    """
    changed = False
    for j in range(worst.size):
        changed |= classify(worst[j], limit, status[j]) != status[j]
    return changed


@compiled
def classify(worst: float, limit: float, before: int) -> int:
    """Status of a joint, SURE, UNSURE or UNSEEN, after the status `before`."""
    if worst == math.inf:
        return UNSEEN
    return UNSURE if worst > (_SURE_AGAIN * limit if before == UNSURE else limit) else SURE


@compiled
def by_joint(layout: Any, angles: Any, sd: Any) -> Any:
    """Rotations (segments, 3), rad, and greatest variances (segments,), rad^2, of the joints of a tree."""
    rotations, variance = np.zeros((layout.shape[0], 3)), np.zeros(layout.shape[0])
    for k in range(layout.shape[0]):
        greatest = 0.0
        for i in range(layout[k, 1]):
            rotations[k, i], each = angles[layout[k, 2] + i], sd[layout[k, 2] + i]
            if each > greatest or each != each:
                greatest = each
        variance[k] = greatest * greatest
    return rotations, variance


def report(
    worst: NDArray[np.float64], limit: float, status: NDArray[np.int64], table: JointTable, first: bool,
    tick: Tick
) -> None:
    """Report changes and update `status`; at `first` report the joints without sensors too."""
    now = np.array([classify(sd, limit, before) for sd, before in zip(worst, status, strict=True)],
                   dtype=np.int64)
    changed = now != status
    for event, chosen, more in (
            ("untracked", changed & (now == UNSEEN), table.unsensed if first else ()),
            ("tracked", changed & (status == UNSEEN), ()),
            ("uncertain", changed & (now == UNSURE), ()),
            ("certain", changed & (status == UNSURE) & (now == SURE), ())):
        names = (*more, *(table.names[j] for j in np.flatnonzero(chosen)))
        if names:
            tick.report(event, "joint " + ", ".join(names))
    status[:] = now


def report_misfits(
    before: NDArray[np.bool_], now: NDArray[np.bool_], table: JointTable, tick: Tick
) -> None:
    """Report joints that do not move as their kind does, and those that do again."""
    for event, chosen, remedy in (
            ("misfit", now & ~before, " not as their kind: check kind, axes and mounting, and that no joint "
                                      "lies between the two sensors"),
            ("fits", before & ~now, " as their kind again")):
        if chosen.any():
            names = ", ".join(table.names[j] for j in np.flatnonzero(chosen))
            tick.report(event, f"joint {names}: sensors move{remedy}")


def learn(state: ConstrainedState, first: bool, tick: Tick) -> None:
    """Learn the axes of hinges from the newest samples, and report them; at `first` report that it begins."""
    table = state.table
    if first:
        names = ", ".join(table.names[search.joint] for search in state.searches)
        tick.report("learning_axes", f"joint {names}: untracked until its motion has shown its axes")
    for search in state.searches:
        if state.seen[1].take(search.ends).min() < SOUND:
            continue
        found = search.take(state.gyr[1], state.acc[1])
        name = f"joint {table.names[search.joint]}"
        if isinstance(found, InputError):
            tick.report("axes_not_learnt", f"{name}: {found}")
        elif found is not None:
            state.table = state.table.learnt(search.joint, found.axes)
            state.searches = tuple(each for each in state.searches if each is not search)
            parent, child = ([round(part, 3) + 0.0 for part in axis] for axis in found.axes.tolist())
            tick.report("axes_learnt", f"{name}: parent_axis {parent}, child_axis {child}; give them in "
                        "`joints`, and it is tracked from the first sample")


Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
_USUAL = HandSize()
_USUAL_EVIDENCE = PoseEvidence()
_SPACING = 0.25
"""Time between two measurements of a joint as a share of `force_time_s` (chosen: well below 1)."""
_POSITIVE = ("mounting_sd_deg", "axis_sd_deg", "tissue_sd_deg", "tissue_time_s", "turn_sd_deg",
             "bias_sd_deg_s", "bias_walk_deg_s", "force_sd", "spin_sd_m", "force_time_s", "lever_sd_m",
             "range_sd_deg", "untracked_deg_s", "clipped_rate_deg_s", "uncertain_deg", "pose_sd_deg",
             "tau_acc_s", "gyr_range_deg_s", "acc_range_g")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ConstrainedTracker:
    """Posture of a segment tree from gyroscopes and accelerometers, without drift.

    Each joint has a filter (`estimators.constrained.filter`) that integrates the relative rotation and
    corrects it by the acceleration of the joint's centre, which both segments share, and by its axes and
    ranges. Neither a magnetometer nor an initial pose is needed; where a pose is known (`initial_pose_s`), a
    joint that starts in it has its heading, and axes that disagree are estimated as tilted. No constraint
    shows a constant turn of a sensor about a hinge's own axis; it is part of the sd. Where the first samples
    allow several headings, each has a filter until motion decides (`estimators.constrained.beginning`).

    Inputs `gyr` (n, 3) rad/s and `acc` (n, 3) m/s^2, sensor frames equal to segment frames. Outputs
    `orientation` (n, 4), segment to earth, with the heading of the 6-axis VQF filter (doi
    10.1016/j.inffus.2022.10.014) of the root in each tree of joints; `angles` (a,), rad, all freedoms of
    the tree; `angle_sd` (a,), rad; `fingertips` (t, 3), m, in the frame of the tree's root (for a hand the
    WCS); `fingertip_sd` (t, 3), m; `aligned` (1,), 0 while the initial pose is kept or axes are learnt, and
    once evidence contradicts the pose, else 1; `angle_random_sd` (a,), rad: the part of `angle_sd` that is
    not constant in a trial, as mounting and the joints' axes are. Lengths count as exact.

    A pose that gravity, the joints' ranges or the hand's release contradict
    (`estimators.calibration.pose_evidence`) is reported as "pose_contradicted"; the sds of these joints grow
    by as much.

    With `joints` in place of a body, and for five sensors without any setting (those of chain5,
    `fesloop.streams.formats.published`), no lengths are known: there are no outputs `fingertips` and
    `fingertip_sd`, and `angles` are those of each joint in turn (see Joint). A hinge whose axes are learnt
    (`Joint.learn_axes`, `estimators.constrained.learning`) is untracked until then, which "learning_axes",
    "axes_learnt" and "axes_not_learnt" report.

    A joint is reported as "uncertain" when the sd of one of its angles rises above `uncertain_deg`, and as
    "certain" when all are well below again. Through lost samples (or frozen ones, or ones held for too long:
    `estimators.arrivals`) the joints of that sensor turn on as the rates around the gap tell
    (`estimators.gaps`), a clipped rate is used as read; their sd grows until they are unknown. A joint
    without sensors and an unknown one are reported as "untracked", until "tracked": its angles are zero,
    their sd is pi.

    Attributes
    ----------
    sensors: number n; 0 takes it from the wire.
    hand: size of the hand.
    sensed: names of the sensors' segments, in the order of the samples; empty: every one, or all but the
        tree's root (a hand's forearm).
    segments: another tree in place of the hand.
    joints: joints from the root outwards, in place of a body; or "hinge" or "ball" for one of that kind
        between neighbouring sensors, those that the source of the samples states, else each and the next. A
        hinge's axes are then learnt.
    initial_pose_s: duration of a known pose at the start, s; joints with sound samples within it start in
        that pose; 0: no known pose.
    initial_angles_deg: that pose by names of freedoms, such as `F1_cmc_abduction`; others are 0: straight.
    pose_sd_deg: sd of each joint about it (chosen).
    evidence: tests of that pose against what the sensors show of it.
    mounting_sd_deg, axis_sd_deg: constant errors of each sensor on its segment about each axis, and of the
        joints' axes, sd (5 to 10 deg each: doi 10.3390/s19010208, section 4). The tilts of axes are estimated
        from motion; the part of a relative rotation that its joint forbids is shared between the two causes.
    tissue_sd_deg: sd of the rotation of a sensor on soft tissue in motion (chosen: skin moves by less, foam
        by more).
    tissue_time_s: correlation time of that rotation (chosen: a fifth of a slow finger movement).
    turn_sd_deg: sd of the gyroscopes' integral after a second, deg (chosen: soft tissue and scale, above
        any gyroscope's noise).
    bias_sd_deg_s, bias_walk_deg_s: sd of the gyroscopes' bias at the start, deg/s, and of its change in a
        second (0.6: usual of its kind; the walk is Kortier et al. 2014, doi 10.1186/1743-0003-11-70,
        Table 1).
    force_sd: sd of the shared acceleration, m/s^2 (chosen: soft tissue; the sensor's own noise is a tenth).
    spin_sd_m: increase of that sd for each rad^2/s^2 of rotation, m (chosen: a joint's centre moves by 3 cm).
    force_time_s: correlation time of its error, s (chosen: that of tissue at 10 rad/s).
    lever_sd_m: initial sd of the vector from a joint's centre to its sensors, m, each axis.
    range_sd_deg: tolerance of a joint's range, beyond the mounting's (S19 clips hard; 3 is chosen).
    untracked_deg_s: rms rate of a segment about each axis while a sample is missing (chosen: a finger in
        motion). A joint is unseen once that rate would have turned it by pi.
    clipped_rate_deg_s: sd of the rate in excess of a clipped one (chosen: as in KortierTracker).
    uncertain_deg: sd above which a joint's angle is reported.
    tau_acc_s: time constant of the root's inclination, s (VQF's own default).
    gyr_range_deg_s, acc_range_g: magnitude above which samples count as clipped, as in VqfTracker.
    """

    sensors: int = 0
    hand: HandSize = _USUAL
    sensed: tuple[str, ...] = ()
    segments: tuple[Segment, ...] = ()
    joints: Literal["hinge", "ball"] | tuple[Joint, ...] = ()
    initial_pose_s: float = 0.0
    initial_angles_deg: Mapping[str, float] = field(default_factory=dict)
    pose_sd_deg: float = 3.0
    evidence: PoseEvidence = _USUAL_EVIDENCE
    mounting_sd_deg: float = 5.0
    axis_sd_deg: float = 5.0
    tissue_sd_deg: float = 4.0
    tissue_time_s: float = 0.2
    turn_sd_deg: float = 0.5
    bias_sd_deg_s: float = 0.6
    bias_walk_deg_s: float = 0.006
    force_sd: float = 0.3
    spin_sd_m: float = 0.03
    force_time_s: float = 0.1
    lever_sd_m: float = 0.1
    range_sd_deg: float = 3.0
    untracked_deg_s: float = 120.0
    clipped_rate_deg_s: float = 500.0
    uncertain_deg: float = 15.0
    tau_acc_s: float = 3.0
    gyr_range_deg_s: float = 2000.0
    acc_range_g: float = 16.0
    body: Body | None = field(init=False, repr=False, default=None)
    table: JointTable | None = field(init=False, repr=False, default=None)
    moving: Numbers | None = field(init=False, repr=False, default=None)
    wrong: tuple[Array, Array] | None = field(init=False, repr=False, default=None)
    _stated: Sensors | None = field(init=False, repr=False, compare=False, default=None)

    def __post_init__(self) -> None:
        if self.sensors < 0:
            raise InputError("sensors", f"{self.sensors}", "1 or more, or 0 to take it from the wire")
        for name in _POSITIVE:
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(name, f"{value} is not positive", "a finite number above 0")
        duration_ns(self.initial_pose_s, NS_PER_S, "initial_pose_s")
        if self.initial_angles_deg and not self.initial_pose_s:
            raise InputError("initial_pose_s", "0 beside initial_angles_deg", "how long that pose is kept, s")
        worn = bool(self.sensed or self.segments or self.hand != _USUAL)
        if self.joints and worn:
            raise InputError("joints", "given beside hand, sensed or segments",
                             "joints, or the body that wears the sensors", "remove one")
        if not self.sensors:
            return
        joints = self.joints
        if isinstance(joints, str):
            joints = joints_between(joints, resolve_pairs((), self.sensors))
        if joints or (self.sensors == 5 and not worn):
            if self.initial_pose_s:
                raise InputError("initial_pose_s", f"{self.initial_pose_s:g} beside joints without a body",
                                 "0", "give the body: hand, sensed or segments")
            table = joint_table(joints or CHAIN5, self.sensors)
            pair_sd, axis_sd = self._sds()
            wrong = np.full(len(table.ends), pair_sd ** 2), np.full(len(table.ends), axis_sd ** 2)
            object.__setattr__(self, "table", table)
            object.__setattr__(self, "wrong", wrong)
            return
        body = body_of(self.sensors, self.hand, self.segments, self.sensed)
        known_angles(body.tree, self.initial_angles_deg)
        table = body_table(body)
        whole = misalignment(body.tree, self.mounting_sd_deg, self.axis_sd_deg)
        wrong = whole.pair[table.moved], whole.growing[table.moved]
        for name, value in (("body", body), ("table", table), ("moving", moving_joints(body, table)),
                            ("wrong", wrong)):
            object.__setattr__(self, name, value)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """gyr and acc."""
        shape = (self.sensors or None, 3)
        return Port("gyr", shape, "rad/s"), Port("acc", shape, "m/s^2")

    @property
    def outputs(self) -> tuple[Port, ...]:
        """orientation, angles, angle_sd, with a body fingertips and their sd, aligned, angle_random_sd."""
        ports = posture_ports(self.body, self.sensors)
        if self.table is None or self.body is not None:
            return *ports, ALIGNED_PORT, random_sd_port(self.body)
        shape, names = (self.table.angles,), self.table.angle_names if self._stated else ()
        angles, sd, random_sd = (replace(port, shape=shape, rows=names)
                                 for port in (*ports[1:3], random_sd_port(None)))
        return replace(ports[0], sensors=self._stated), angles, sd, ALIGNED_PORT, random_sd

    @property
    def needs_stillness(self) -> str:
        """`aligned`, which ends the initial pose; "" where no pose is known."""
        return "aligned" if self.initial_pose_s else ""

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> ConstrainedTracker:
        """The tracker for the number of wired sensors."""
        return replace(self, sensors=shapes["gyr"][0])

    def with_sensors(self, sources: Mapping[str, Sensors]) -> ConstrainedTracker:
        """The tracker with its sensors on the segments that their source states (`worn_as_stated`)."""
        stated, joints = stated_by(sources), self.joints
        if isinstance(joints, str):
            pairs = resolve_pairs(stated_pairs((), stated), len(stated.names))
            joints = joints_between(joints, pairs)
        new = worn_as_stated(replace(self, joints=joints), stated)
        object.__setattr__(new, "_stated", stated)
        if new.body is None and new.table is not None:
            object.__setattr__(new, "table", new.table.between(stated.names))
        return new

    def init(self, context: Context) -> ConstrainedState:
        """State before the first sample."""
        if not isinstance(context.clock, (RateClock, StampClock)):
            raise InputError(f"{context.name}.rate", "is missing", "the rate of the sensors")
        table = self._joints()
        period = context.clock.period_s
        limits = (math.radians(self.gyr_range_deg_s), STANDARD_GRAVITY * self.acc_range_g, math.inf)
        watch = None
        if self.body is not None and self.initial_pose_s:
            watch = ReleaseWatch(self.body, known_angles(self.body.tree, self.initial_angles_deg),
                                 self.evidence)
        searches = tuple(AxisSearch.of(int(j), tuple(table.ends[j].tolist()), period)
                         for j in np.flatnonzero(~table.known))
        return ConstrainedState(
            table=table, searches=searches,
            roots=VqfBank(len(table.roots), period, False, tauAcc=self.tau_acc_s),
            arrivals=Arrivals(self.sensors, limits, period, names=self._sensor_names()),
            overrun=Overrun(self.sensors, math.radians(self.clipped_rate_deg_s), self._sensor_names()),
            settings=self._settings(period),
            unknown=self._unknown(), found=Hypotheses.none(len(table.ends)),
            gaps=Gaps.none(self.sensors),
            lateness=Lateness.unknown(self.sensors, len(table.ends), period),
            gyr=np.zeros((2, self.sensors, 3)), acc=np.zeros((2, self.sensors, 3)),
            seen=np.zeros((2, self.sensors), dtype=np.int64),
            status=np.full(len(table.ends), SURE, dtype=np.int64),
            misfit=np.zeros(len(table.ends), dtype=np.bool_), doubted=np.zeros(len(table.ends)),
            pose_acc=np.zeros((self.sensors, 3)), pose_counts=np.zeros(self.sensors), watch=watch,
            pose_samples=round(self.initial_pose_s / period),
            plausible=of_unknown_joints(()) if self.body is None else of_tree(self.body.tree))

    def step(self, state: ConstrainedState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """One sample of every sensor."""
        table, found, (pair_sd, axis_sd) = state.table, state.found, self._sds()
        arrivals, gaps, ends = state.arrivals, state.gaps, table.ends
        first, ticks, state.ticks = state.ticks == 0, tick.index + 1 - state.ticks, tick.index + 1
        captured_s, _, _ = arrivals.note(state.lateness.align(inputs, ticks), tick)
        elapsed_s = ticks * arrivals.period_s
        if state.taken > state.pose_samples and (state.overrun.under_way or not arrivals.faultless):
            state.overrun.note(arrivals.codes, elapsed_s, tick)
        gap = bridge(arrivals.samples[0], arrivals.codes[0], elapsed_s, captured_s, arrivals.period_s,
                     math.radians(self.untracked_deg_s), gaps)
        # Ticks that were skipped while the block was busy are processed with this sample.
        for _ in range(ticks):
            take(state, captured_s == 0.0, gap)
        learning = bool(state.searches)
        if learning:
            learn(state, first, tick)
        if state.taken % round(1.0 / arrivals.period_s) == 0 and (
                told := state.lateness.look(found.q, ends, self._sensor_names())):
            state.seen[:] = LOST  # no acceleration between two samples of before and after
            learn_levers_anew(found.rest, found.covariance, state.unknown.lever_sd)
            for status, detail in told:
                tick.report(status, detail)
        misfit = state.misfit.copy()
        if judge(found.rest[0], found.doubt, math.radians(self.tissue_sd_deg), state.misfit, state.doubted):
            report_misfits(misfit, state.misfit, table, tick)
        q, covariance, doubt = found.q[0], found.covariance[0], state.doubted
        if state.taken % LOOK == 0:
            state.scale = mounting_scale(found.rest[0], covariance, table.kinds, state.unknown.axis_sd ** 2)
        roots = state.roots.orientation()
        if state.lateness.known:
            turns = state.lateness.turns()
            q, roots = ahead(q, ends, turns), advanced(roots, turns[table.roots])
        if gap:
            doubt = np.sqrt(doubt ** 2 + gaps.pending[ends].sum(axis=1))
        if state.contradicted and self.body is not None and state.watch is not None:
            doubt = np.hypot(doubt, state.watch.sizes[self.body.sensed[ends[:, 1]]])
        orientation, angles, sds, relative, worst = posture(
            roots, q, covariance, doubt, table.roots, ends, table.kinds,
            table.axes, table.zero, table.first_angle, table.angles, pair_sd, axis_sd, *self._misalignment(),
            state.scale)
        if first or status_changed(worst, math.radians(self.uncertain_deg), state.status):
            report(worst, math.radians(self.uncertain_deg), state.status, table, first, tick)
        over = state.taken > state.pose_samples or not state.pose_samples
        if self.body is None:
            return orientation, angles, sds[0], aligned_value(over and not learning), sds[1]
        tree = self.body.tree
        state.plausible.note(angles, tick)
        if over and state.watch is not None:
            self._compare(state, self.body, state.watch, angles, sds[0], tick)
        tips, tip_sd = fingertip_posture(
            tree.layout, tree.geometry, self.body.tips, self.moving, relative, q, covariance, doubt,
            table.kinds, table.axes, math.sqrt(state.scale) * pair_sd, math.sqrt(state.scale) * axis_sd)
        aligned = aligned_value(over and not state.contradicted)
        return orientation, angles, sds[0], tips, tip_sd, aligned, sds[1]

    def _compare(self, state: ConstrainedState, body: Body, watch: ReleaseWatch, angles: Array, sd: Array,
                 tick: Tick) -> None:
        """Compare the initial pose with gravity at its end, and the posture since then with the pose."""
        layout = body.tree.layout
        rotations, variance = by_joint(layout, angles, sd)
        if state.aligned_ns is None:
            state.aligned_ns = tick.time_ns
            watch.begin(rotations, tick.time_ns)
            present = state.pose_counts > 0
            rest = Rest(np.zeros_like(state.pose_acc),
                        state.pose_acc / np.maximum(state.pose_counts, 1.0)[:, np.newaxis], None, present)
            pose = known_angles(body.tree, self.initial_angles_deg)
            pose_sd = math.radians(self.pose_sd_deg)
            gravity = inclinations(body, ties_of(body, pose, present), rest,
                                   math.radians(self.mounting_sd_deg), pose_sd)
            wrong = against_gravity(body, gravity, self.evidence)
            if wrong is None:
                tick.report("aligned", taken(body, pose, rest, pose_sd))
                return
            watch.sizes[:] = wrong.sizes
            text = wrong.text
        elif tick.time_ns - state.aligned_ns <= watch.lasts_ns:
            text = watch.note(rotations, variance, variance < math.pi**2, tick.time_ns)
        else:
            return
        if text:
            state.contradicted = True
            tick.report("pose_contradicted", f"{text}; no stimulation: begin again, and {REMEDY}")

    def _sensor_names(self) -> tuple[str, ...]:
        """Names of the sensors' segments, else those that the source states; empty where neither is known."""
        if self.body is not None:
            return self.body.sensor_names
        return self._stated.names if self._stated else ()

    def _joints(self) -> JointTable:
        if self.table is None:
            raise InputError("sensors", "0", "their number", "wire the tracker, or give it `sensors`")
        return self.table

    def _sds(self) -> tuple[float, float]:
        """Sd of the relative mounting of two sensors, and of a joint's axes, rad."""
        return math.radians(self.mounting_sd_deg) * math.sqrt(2.0), math.radians(self.axis_sd_deg)

    def _misalignment(self) -> tuple[Array, Array]:
        """Variances `pair` and `growing` of each joint's misalignment, (joints,), rad^2."""
        if self.wrong is None:
            raise InputError("sensors", "0", "their number", "wire the tracker, or give it `sensors`")
        return self.wrong

    def _unknown(self) -> Unknown:
        pose, table = None, self._joints()
        if self.body is not None and self.initial_pose_s:
            tree = self.body.tree
            relative = relative_orientations(tree, known_angles(tree, self.initial_angles_deg))
            pose = relative[self.body.sensed[table.ends[:, 1]]]
        levers = np.zeros((len(table.ends), 6))
        lever_sd = np.full_like(levers, self.lever_sd_m)
        return Unknown(math.hypot(*self._sds()), math.radians(self.bias_sd_deg_s), levers, lever_sd, pose,
                       math.radians(self.pose_sd_deg))

    def _settings(self, period: float) -> Array:
        pair_sd, _ = self._sds()
        spacing = period * max(1, round(_SPACING * self.force_time_s / period))
        return np.array([period, math.radians(self.turn_sd_deg), math.radians(self.bias_walk_deg_s),
                         self.force_sd, self.spin_sd_m, self.force_time_s, math.radians(self.tissue_sd_deg),
                         self.tissue_time_s, math.hypot(math.radians(self.range_sd_deg), pair_sd),
                         math.radians(self.untracked_deg_s), math.radians(self.bias_sd_deg_s), spacing,
                         math.radians(self.clipped_rate_deg_s)])
