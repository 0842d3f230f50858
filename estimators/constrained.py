"""`constrained`: orientations without magnetometers, kept from drifting by the joints themselves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from estimators.constrained_filter import SOUND, admit, advance
from estimators.constrained_measurements import N
from estimators.constrained_posture import posture
from estimators.heading import first_orientation
from estimators.joint_constraints import HINGE, Joint, JointTable, joint_table, tree
from estimators.samples import SampleWatch, watch_samples
from estimators.vqf_bank import VqfBank
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock, StampClock
from fesloop.loop.signals import Port, Sample, Value

Array = NDArray[np.float64]
_POSITIVE = ("mounting_sd_deg", "axis_sd_deg", "axis_time_s", "turn_sd_deg", "bias_sd_deg_s",
             "bias_walk_deg_s", "force_sd", "spin_sd_m", "force_time_s", "lever_sd_m", "range_sd_deg",
             "unseen_deg_s", "unsure_deg", "tau_acc_s", "gyr_range_deg_s", "acc_range_g")
_KNOWN, _CALM = 0.5, 1.0
"""Sd of a heading, rad, and acceleration, m/s^2, below which a sample is believed (chosen)."""
_FIRST_TILT = 0.3
"""Sd of the first sample's vertical, rad: 3 m/s^2 of acceleration against gravity (chosen)."""
_SURE_AGAIN = 0.8
"""Share of the limit below which a joint is sure again; in between nothing is reported (chosen)."""


@dataclass(slots=True, eq=False)
class ConstrainedState:
    """Memory of a ConstrainedTracker.

    Attributes
    ----------
    roots: filters of the sensors that are no joint's child.
    watch: what is wrong with the samples.
    settings: of the joint filters, as `constrained_filter` reads them.
    q: (joints, 4), child to parent; NaN until both sensors have given a sample.
    rest: (joints, 13), gyroscope bias, lever arms, mean force, time unseen.
    covariance: (joints, 12, 12), of the error state.
    gyr, acc: (2, n, 3), the sample before and the newest.
    seen: (2, n), LOST, DOUBTED or SOUND, each of these.
    unsure: (joints,), whose angles have been reported as unsure.
    ticks: number of the next tick.
    heading_sd: (joints,), rad, of a hinge that began with its axis too upright to tell it, else 0.
    settled: whether every joint has begun, and none so.
    """

    roots: VqfBank
    watch: SampleWatch
    settings: Array
    q: Array
    rest: Array
    covariance: Array
    gyr: Array
    acc: Array
    seen: NDArray[np.int64]
    unsure: NDArray[np.bool_]
    heading_sd: Array
    ticks: int = 0
    settled: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ConstrainedTracker:
    """Joint angles of a segment tree from gyroscopes and accelerometers, without drift.

    Each joint has a filter (`estimators.constrained_filter`) that integrates the relative rotation and
    holds it by what the two segments share: the acceleration of the joint's centre, its axes, its
    ranges. Neither a magnetometer nor an initial pose is needed. What a sensor's mounting hides (a
    constant turn about a hinge's own axis) no constraint can show; it is in the sd.

    Inputs `gyr` (n, 3) rad/s and `acc` (n, 3) m/s^2, sensor frames equal to segment frames. Outputs
    `orientation` (n, 4), segment to earth, of one common heading in each tree, that of the 6-axis VQF
    filter (doi 10.1016/j.inffus.2022.10.014) of its root; `angles` (a,), rad, those of each joint in
    turn (see Joint); `angle_sd` (a,), rad, their standard deviations.

    A joint is reported as "unsure" when the sd of one of its angles rises above `unsure_deg`, and as
    "sure" when all are well below again. Through a lost sample the joints of that sensor stand still, a
    clipped one still moves them; their sd grows. Before the first sound one they are at zero with the sd
    of no knowledge.

    Attributes
    ----------
    sensors: n; 0 takes it from what is wired to `gyr`.
    joints: from the root outwards; empty: those of `tree`.
    tree: name of a tree (`estimators.joint_constraints.TREES`), read where `joints` is empty.
    mounting_sd_deg, axis_sd_deg: of the sensors on their segments, and of the joints' axes (5 to 10 deg
        each: doi 10.3390/s19010208, section 4). The part of a relative rotation that its joint forbids
        is shared between the two causes accordingly.
    axis_time_s: after what time of motion the error of an axis counts as another one (chosen: a fifth of
        a slow finger movement).
    turn_sd_deg: of the gyroscopes' integral after a second, deg (chosen: soft tissue and scale, above
        any gyroscope's noise).
    bias_sd_deg_s, bias_walk_deg_s: of the gyroscopes' bias at the start, deg/s, and of its change in a
        second (0.6: usual of its kind; the walk is Kortier et al. 2014, doi 10.1186/1743-0003-11-70,
        Table 1).
    force_sd: of the shared acceleration, m/s^2 (chosen: soft tissue; the sensor's own noise is a tenth).
    spin_sd_m: what it grows by for each rad^2/s^2 of rotation, m (chosen: a joint's centre wanders by 3
        cm).
    force_time_s: its correlation time, s (chosen: that of tissue at 10 rad/s).
    lever_sd_m: of the distance from a joint's centre to its sensors at the start, m, each axis.
    range_sd_deg: tolerance of a joint's range (S19 clips hard; 3 is chosen).
    unseen_deg_s: rms rate of a joint while a sample is missing (chosen: a finger in motion).
    unsure_deg: from which sd on a joint's angle is reported.
    tau_acc_s: time constant of the root's inclination, s (VQF's own default).
    gyr_range_deg_s, acc_range_g: from which magnitude on samples count as clipped, as of VqfTracker.
    """

    sensors: int = 0
    joints: tuple[Joint, ...] = ()
    tree: str = "chain5"
    mounting_sd_deg: float = 5.0
    axis_sd_deg: float = 5.0
    axis_time_s: float = 0.2
    turn_sd_deg: float = 0.5
    bias_sd_deg_s: float = 0.6
    bias_walk_deg_s: float = 0.006
    force_sd: float = 0.3
    spin_sd_m: float = 0.03
    force_time_s: float = 0.1
    lever_sd_m: float = 0.1
    range_sd_deg: float = 3.0
    unseen_deg_s: float = 120.0
    unsure_deg: float = 15.0
    tau_acc_s: float = 3.0
    gyr_range_deg_s: float = 2000.0
    acc_range_g: float = 16.0
    table: JointTable | None = field(init=False, repr=False, default=None)

    def __post_init__(self) -> None:
        if self.sensors < 0:
            raise InputError("sensors", f"{self.sensors}", "1 or more, or 0 to take it from the wire")
        for name in _POSITIVE:
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(name, f"{value} is not positive", "a finite number above 0")
        joints = self.joints or tree(self.tree)
        if self.sensors:
            meant = 1 + max(joint.child for joint in joints)
            if not self.joints and meant != self.sensors:
                raise InputError("tree", f"{self.tree!r} has {meant} sensors, {self.sensors} are wired",
                                 "a tree of as many", "name it, or give its `joints`")
            object.__setattr__(self, "table", joint_table(joints, self.sensors))

    @property
    def inputs(self) -> tuple[Port, ...]:
        """gyr and acc."""
        shape = (self.sensors or None, 3)
        return Port("gyr", shape, "rad/s"), Port("acc", shape, "m/s^2")

    @property
    def outputs(self) -> tuple[Port, ...]:
        """orientation, angles and angle_sd."""
        angles = self.table.angles if self.table else None
        return (Port("orientation", (self.sensors or None, 4), "1"), Port("angles", (angles,), "rad"),
                Port("angle_sd", (angles,), "rad", math.pi))

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> ConstrainedTracker:
        """The same tracker for the number of sensors wired to it."""
        return replace(self, sensors=shapes["gyr"][0])

    def init(self, context: Context) -> ConstrainedState:
        """Nothing known of any joint."""
        if not isinstance(context.clock, (RateClock, StampClock)):
            raise InputError(f"{context.name}.rate", "is missing", "the rate of the sensors")
        table = self._joints()
        joints, period = len(table.ends), context.clock.period_s
        return ConstrainedState(
            roots=VqfBank(len(table.roots), period, False, tauAcc=self.tau_acc_s),
            watch=SampleWatch.of(self.sensors, 2), settings=self._settings(period),
            q=np.full((joints, 4), np.nan), rest=np.zeros((joints, 13)),
            covariance=np.zeros((joints, N, N)),
            gyr=np.zeros((2, self.sensors, 3)), acc=np.zeros((2, self.sensors, 3)),
            seen=np.zeros((2, self.sensors), dtype=np.int64), unsure=np.zeros(joints, dtype=np.bool_),
            heading_sd=np.zeros(joints))

    def step(self, state: ConstrainedState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """One sample of every sensor."""
        table = self._joints()
        axis_sd = math.radians(math.hypot(self.axis_sd_deg, self.mounting_sd_deg))
        limits = (math.radians(self.gyr_range_deg_s), 9.81 * self.acc_range_g)
        sound = watch_samples(state.watch, inputs, limits, tick)
        # Ticks that were skipped while the block was busy are made good with this sample.
        for _ in range(tick.index + 1 - state.ticks):
            _take(state, table, inputs, sound)
            if not state.settled and may_begin(
                    state.heading_sd, state.q, table.ends, table.axes, state.acc, state.seen, axis_sd):
                self._begin(state, table)
        state.ticks = tick.index + 1
        orientation, angles, sd, worst = posture(
            state.roots.orientation(), state.q, state.covariance, state.heading_sd, table.roots,
            table.ends, table.kinds, table.axes, table.zero, table.first_angle, table.angles,
            math.radians(self.mounting_sd_deg), math.radians(self.axis_sd_deg))
        self._report(state, table, worst, tick)
        return orientation, angles, sd

    def _begin(self, state: ConstrainedState, table: JointTable) -> None:
        """Joints that begin, or begin anew, with a sample of both sensors that tells more than before.

        A hinge whose axis stands upright has any heading. It moves on from an arbitrary one, whence its
        filter, which is linear, may not find back: it begins anew once the axis leans and all is calm.
        """
        both = (state.seen[1, table.ends] == SOUND).all(axis=1)
        axis_sd = math.radians(math.hypot(self.axis_sd_deg, self.mounting_sd_deg))
        missing = np.isnan(state.q[:, 0])
        for j in np.flatnonzero(both & (missing | (state.heading_sd > 0.0))):
            up = state.acc[1, table.ends[j]]
            q, heading_sd = first_orientation(int(table.kinds[j]), table.axes[j], up, axis_sd)
            leaning = table.kinds[j] != HINGE or heading_sd < _KNOWN
            calm = (np.abs(np.linalg.norm(up, axis=1) - 9.81) < _CALM).all()
            if not missing[j] and not (leaning and calm):
                continue
            state.q[j], state.heading_sd[j] = q, 0.0 if leaning else heading_sd
            state.rest[j] = 0.0
            state.rest[j, 9:12] = up[1]
            vertical = up[1] / np.linalg.norm(up[1])
            turn = _FIRST_TILT ** 2 * np.eye(3) + heading_sd ** 2 * np.outer(vertical, vertical)
            bias = 2.0 * math.radians(self.bias_sd_deg_s) ** 2
            state.covariance[j] = np.diag([0.0] * 3 + [bias] * 3 + [self.lever_sd_m ** 2] * 6)
            state.covariance[j, :3, :3] = turn
        state.settled = not (np.isnan(state.q).any() or state.heading_sd.any())

    def _report(self, state: ConstrainedState, table: JointTable, worst: Array, tick: Tick) -> None:
        limit = math.radians(self.unsure_deg)
        if not changes(worst, limit, state.unsure):
            return
        rises = ~state.unsure & (worst > limit)
        falls = state.unsure & (worst < _SURE_AGAIN * limit)
        for status, changed in (("unsure", rises), ("sure", falls)):
            if changed.any():
                tick.report(status, "joint " + ", ".join(f"{p}-{c}" for p, c in table.ends[changed]))
        state.unsure = (state.unsure | rises) & ~falls

    def _joints(self) -> JointTable:
        if self.table is None:
            raise InputError("sensors", "0", "their number", "wire the tracker, or give it `sensors`")
        return self.table

    def _settings(self, period: float) -> Array:
        axis = math.hypot(self.mounting_sd_deg, self.axis_sd_deg)
        return np.array([period, math.radians(self.turn_sd_deg), math.radians(self.bias_walk_deg_s),
                         self.force_sd, self.spin_sd_m, self.force_time_s, math.radians(axis),
                         self.axis_time_s, math.radians(self.range_sd_deg),
                         math.radians(self.unseen_deg_s)])


def _take(state: ConstrainedState, table: JointTable, inputs: Sequence[Sample], sound: bool) -> None:
    """One period on with the samples that stand at the inputs."""
    codes, roots = state.watch.codes, table.roots
    admit(inputs[0].value, inputs[1].value, codes, state.gyr, state.acc, state.seen)
    gyr, acc = state.gyr[1].take(roots, axis=0), state.acc[1].take(roots, axis=0)
    if sound:
        state.roots.update(gyr, acc, None)
    else:
        state.roots.update_only(state.watch.usable()[roots], gyr, acc, None)
    advance(state.q, state.rest, state.covariance, table.ends, table.kinds, table.axes, table.zero,
            table.ranges, state.gyr, state.acc, state.seen, state.settings)


@numba.njit(cache=True)
def may_begin(
    heading_sd: Any, q: Any, ends: Any, axes: Any, acc: Any, seen: Any, axis_sd: float
) -> bool:
    """Whether a joint has no estimate, or a sample to better it: both sensors calm, its axis leaning."""
    for j in range(q.shape[0]):
        good = heading_sd[j] > 0.0
        for end in range(2):
            up, axis = acc[1, ends[j, end]], axes[j, end]
            size = math.sqrt(up[0] ** 2 + up[1] ** 2 + up[2] ** 2)
            along = abs(up[0] * axis[0] + up[1] * axis[1] + up[2] * axis[2])
            good &= seen[1, ends[j, end]] == SOUND and abs(size - 9.81) < _CALM
            good &= size ** 2 - along ** 2 > (size * axis_sd / _KNOWN) ** 2
        if good or np.isnan(q[j, 0]):
            return True
    return False


@numba.njit(cache=True)
def changes(worst: Any, limit: float, unsure: Any) -> bool:
    """Whether a joint's largest sd (joints,) has crossed what changes its being `unsure`."""
    crossed = False
    for j in range(worst.size):
        crossed |= worst[j] < _SURE_AGAIN * limit if unsure[j] else worst[j] > limit
    return crossed
