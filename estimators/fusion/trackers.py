"""Trackers that fuse each inertial sensor separately and chain the orientations to joint angles."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from estimators.arrivals import Arrivals
from estimators.body.body import (
    ALIGNED_PORT,
    ImplausibleAngles,
    Pairs,
    aligned_value,
    flexion_angles,
    heading_offsets,
    initial_flexion,
    no_offsets,
    of_unknown_joints,
    resolve_pairs,
    stated_by,
    stated_pairs,
    turned_angle,
)
from estimators.fusion.front_end import FrontEnd, FrontEndName, front_end_of
from estimators.gaps import Gaps, bridge, lost_samples
from fesloop.errors import InputError
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, RateClock, StampClock, duration_ns
from fesloop.loop.signals import Port, Sample, Sensors, Value

Array = NDArray[np.float64]
T = TypeVar("T")


@dataclass(slots=True, eq=False)
class FusionState:
    """State of a tracker of separate sensors.

    Attributes
    ----------
    bank: the filters.
    arrivals: ages and faults of the samples.
    pairs: (joints, 2), parent and child; (0, 2) for a single sensor.
    heading: (joints, 2), heading offsets that are removed from the children.
    origin: orientations at the alignment, (n, 4).
    plausible: check for angles that no joint can have.
    gaps: rotation through gaps in the samples.
    ticks: number of the next tick.
    aligned: whether `heading` and `origin` are known.
    announced: whether the alignment has been reported.
    """

    bank: FrontEnd
    arrivals: Arrivals
    pairs: NDArray[np.int64]
    heading: Array
    origin: Array
    plausible: ImplausibleAngles
    gaps: Gaps
    ticks: int = 0
    aligned: bool = False
    announced: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class VqfTracker:
    """Joint angles from gyroscopes and accelerometers: 6-axis VQF and an initial pose, no magnetometer.

    Inputs `gyr` (n, 3) rad/s and `acc` (n, 3) m/s^2, sensor frames equal to segment frames (z: flexion).
    Outputs `orientation` (n, 4), segment to earth, each with an independent heading, and `angles`, rad: the
    flexion of each pair (z-x-y Euler), or for a single sensor (1,) the angle of its rotation from its first
    orientation; `aligned` (1,), 0 until the initial pose is over, then 1. VQF: doi
    10.1016/j.inffus.2022.10.014. Its sampling time is the period of this block's clock: give the tracker the
    rate of its sensors.

    Until `align_s` the outputs `angles` are the initial pose, reported as "aligning"; then the relative
    headings are set so that they agree with it. A lost sample (or frozen, or held for too long:
    `estimators.arrivals`) leaves its sensor to the rates around the gap (`estimators.gaps`), a clipped one is
    used as read; each is reported.

    Attributes
    ----------
    sensors: number n of sensors; 0 takes it from the wire.
    pairs: (parent, child) sensors of each joint; empty: the pairs that the source of the samples states, such
        as a recording, else each sensor and the next.
    initial_angles_deg: flexion of each joint in the initial pose, abduction and pronation zero; None where
        it is unknown: the headings then start at zero, and are not corrected.
    align_s: end of the initial pose, s (S19 keeps it for 3 s or more; 0.5 s is chosen for plants that start
        at rest, where only noise has to settle).
    tau_acc_s: time constant of the inclination correction, s (VQF's own default).
    gyr_range_deg_s, acc_range_g: magnitude above which samples count as clipped, deg/s and multiples of
        standard gravity (2000: Kortier et al. 2014, doi 10.1186/1743-0003-11-70; 16: chosen, a usual one).
    """

    sensors: int = 0
    pairs: Pairs = ()
    initial_angles_deg: tuple[float, ...] | None = None
    align_s: float = 0.5
    tau_acc_s: float = 3.0
    gyr_range_deg_s: float = 2000.0
    acc_range_g: float = 16.0
    _stated: Sensors | None = field(init=False, repr=False, compare=False, default=None)

    def __post_init__(self) -> None:
        _check(self.sensors, tau_acc_s=self.tau_acc_s, gyr_range_deg_s=self.gyr_range_deg_s,
               acc_range_g=self.acc_range_g)
        duration_ns(self.align_s, NS_PER_S, "align_s")
        if self.sensors:
            pairs = resolve_pairs(self.pairs, self.sensors)
            initial_flexion(self.initial_angles_deg, len(pairs))

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Ports gyr and acc."""
        shape = (self.sensors or None, 3)
        return Port("gyr", shape, "rad/s"), Port("acc", shape, "m/s^2")

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Ports orientation, angles and aligned."""
        return _outputs(self.sensors, self.pairs, self._stated)

    @property
    def needs_stillness(self) -> str:
        """Name of the output that reports the end of the initial pose; "" where no pose is given."""
        return "aligned" if self.initial_angles_deg is not None else ""

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> VqfTracker:
        """The tracker for the number of wired sensors."""
        return replace(self, sensors=shapes["gyr"][0])

    def with_sensors(self, sources: Mapping[str, Sensors]) -> VqfTracker:
        """The same tracker for the pairs that the sensors' source states; see `stated_pairs`."""
        return _named(self, sources)

    def init(self, context: Context) -> FusionState:
        """Create filters in their initial state, with headings unknown."""
        return _start(self, context, "vqf")

    def step(self, state: FusionState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Process one sample of every sensor."""
        sound = _fuse(state, inputs, tick)
        orientation = state.bank.orientation()
        if not state.aligned:
            flexion = initial_flexion(self.initial_angles_deg, len(state.pairs))
            if flexion is not None and (tick.time_ns < self.align_s * NS_PER_S or not sound):
                if not state.announced:
                    tick.report("aligning", f"initial pose until {self.align_s:g} s")
                    state.announced = True
                return orientation, flexion, aligned_value(False)
            if sound:
                _align(state, orientation, flexion)
                if flexion is None and len(state.pairs):
                    tick.report("no_initial_pose", "headings begin as at the first sample: angles are off by "
                                "what they were then; give initial_angles_deg, and begin in that pose")
        return orientation, _angles(state, orientation, tick), aligned_value(state.aligned)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Vqf9Tracker:
    """Joint angles from gyroscopes, accelerometers and magnetometers: 9-axis VQF, each sensor by itself.

    The baseline "B" of Salchow-Hoemmen et al. 2019 (doi 10.3390/s19010208) with VQF for fusion: no
    initial pose, no constraints. Inputs `gyr` (n, 3) rad/s, `acc` (n, 3) m/s^2, `mag` (n, 3) T; outputs as of
    VqfTracker, but with orientations in the earth frame ENU (y to magnetic north).

    Attributes
    ----------
    sensors: number n of sensors; 0 takes it from the wire.
    pairs: (parent, child) sensors of each joint, as in VqfTracker.
    tau_acc_s, tau_mag_s: time constants of the inclination and heading corrections, s (VQF's own defaults).
    gyr_range_deg_s, acc_range_g: magnitude above which samples count as clipped, as in VqfTracker.
    """

    sensors: int = 0
    pairs: Pairs = ()
    tau_acc_s: float = 3.0
    tau_mag_s: float = 9.0
    gyr_range_deg_s: float = 2000.0
    acc_range_g: float = 16.0
    _stated: Sensors | None = field(init=False, repr=False, compare=False, default=None)

    def __post_init__(self) -> None:
        _check(self.sensors, tau_acc_s=self.tau_acc_s, tau_mag_s=self.tau_mag_s,
               gyr_range_deg_s=self.gyr_range_deg_s, acc_range_g=self.acc_range_g)
        if self.sensors:
            resolve_pairs(self.pairs, self.sensors)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Ports gyr, acc and mag."""
        shape = (self.sensors or None, 3)
        return Port("gyr", shape, "rad/s"), Port("acc", shape, "m/s^2"), Port("mag", shape, "T")

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Ports orientation, angles and aligned."""
        return _outputs(self.sensors, self.pairs, self._stated)

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> Vqf9Tracker:
        """The tracker for the number of wired sensors."""
        return replace(self, sensors=shapes["gyr"][0])

    def with_sensors(self, sources: Mapping[str, Sensors]) -> Vqf9Tracker:
        """The same tracker for the pairs that the sensors' source states; see `stated_pairs`."""
        return _named(self, sources)

    def init(self, context: Context) -> FusionState:
        """Create filters in their initial state."""
        return _start(self, context, "vqf", self.tau_mag_s)

    def step(self, state: FusionState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Process one sample of every sensor."""
        sound = _fuse(state, inputs, tick)
        orientation = state.bank.orientation()
        if sound and not state.aligned:
            _align(state, orientation, None)
        return orientation, _angles(state, orientation, tick), aligned_value(state.aligned)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeelRuppinTracker(Vqf9Tracker):
    """Joint angles from gyroscopes, accelerometers and magnetometers, each sensor by itself: Seel and Ruppin.

    Inclination and heading are corrected apart, so that a disturbed field does not tilt the estimate (doi
    10.1016/j.ifacol.2017.08.1534). The gyroscopes' bias is not estimated. Inputs and outputs as of
    Vqf9Tracker.

    Attributes
    ----------
    sensors: number n of sensors; 0 takes it from the wire.
    pairs: (parent, child) sensors of each joint, as in VqfTracker.
    tau_acc_s, tau_mag_s: halving times of an error of inclination and of heading, s (1 and 3: defaults of
        `qmt.oriEstIMU`).
    gyr_range_deg_s, acc_range_g: magnitude above which samples count as clipped, as in VqfTracker.
    """

    tau_acc_s: float = 1.0
    tau_mag_s: float = 3.0

    def init(self, context: Context) -> FusionState:
        """Create filters in their initial state."""
        return _start(self, context, "seel_ruppin", self.tau_mag_s)


def _check(sensors: int, **positive: float) -> None:
    if sensors < 0:
        raise InputError("sensors", f"{sensors}", "1 or more, or 0 to take it from the wire")
    for name, value in positive.items():
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(name, f"{value} is not positive", "a finite number above 0")


def _outputs(sensors: int, pairs: Pairs, stated: Sensors | None) -> tuple[Port, ...]:
    joints = resolve_pairs(pairs, sensors) if sensors else ()
    names: tuple[str, ...] = ()
    if stated is not None:
        names = tuple(map(stated.pair_name, joints)) or stated.names
    return (Port("orientation", (sensors or None, 4), "1", sensors=stated),
            Port("angles", (max(1, len(joints)) if sensors else None,), "rad", rows=names), ALIGNED_PORT)


def _named(tracker: T, sources: Mapping[str, Sensors]) -> T:
    """Return the tracker with the pairs and names that the source of its samples states."""
    stated, given = stated_by(sources), cast(Any, tracker)
    new = replace(given, pairs=stated_pairs(given.pairs, stated), sensors=given.sensors or len(stated.names))
    object.__setattr__(new, "_stated", stated)
    return cast(T, new)


def _start(
    tracker: VqfTracker | Vqf9Tracker, context: Context, front_end: FrontEndName,
    tau_mag_s: float | None = None
) -> FusionState:
    """State before the first sample; magnetometers are used where `tau_mag_s` is given."""
    clock, sensors = context.clock, tracker.sensors
    if not isinstance(clock, (RateClock, StampClock)):
        raise InputError(f"{context.name}.rate", "is missing", "the rate of the sensors")
    joints = np.array(resolve_pairs(tracker.pairs, sensors), dtype=np.int64).reshape(-1, 2)
    limits = (math.radians(tracker.gyr_range_deg_s), STANDARD_GRAVITY * tracker.acc_range_g, math.inf)
    bank = front_end_of(front_end, sensors, (clock.period_s,) * 3, tau_mag_s is not None, tracker.tau_acc_s,
                        tau_mag_s)
    return FusionState(bank=bank,
                       arrivals=Arrivals(sensors, limits, clock.period_s,
                                         names=tracker._stated.names if tracker._stated else ()),
                       pairs=joints, heading=no_offsets(len(joints)),
                       origin=np.tile([1.0, 0.0, 0.0, 0.0], (sensors, 1)),
                       plausible=of_unknown_joints(_joint_names(tracker._stated, joints)),
                       gaps=Gaps.none(sensors))


def _joint_names(stated: Sensors | None, joints: NDArray[np.int64]) -> tuple[str, ...]:
    """Names of joints from those of their sensors, as the source states them, or from their numbers."""
    if stated is not None:
        return tuple(f"joint {stated.pair_name((int(parent), int(child)))}" for parent, child in joints)
    return tuple(f"joint {parent}-{child}" for parent, child in joints)


def _fuse(state: FusionState, inputs: Sequence[Sample], tick: Tick) -> bool:
    """Update the filters; return whether every sensor had a sample.

    A filter counts time in samples: ticks that were skipped while the block was busy repeat the sample.
    """
    ticks, state.ticks = tick.index + 1 - state.ticks, tick.index + 1
    arrivals = state.arrivals
    elapsed = arrivals.note(inputs, tick)
    gap = bridge(arrivals.samples[0], arrivals.codes[0], ticks * arrivals.period_s, elapsed[0],
                 arrivals.period_s, 0.0, state.gaps)
    gyr = state.gaps.rates
    acc: Any = inputs[1].value
    mag: Any = inputs[2].value if len(inputs) > 2 else None
    for _ in range(ticks):
        if arrivals.sound and not gap:
            state.bank.update(gyr, acc, mag)
        else:
            lost = lost_samples(arrivals.codes, elapsed[0] == 0.0, state.gaps)
            state.bank.update_sound(gyr, acc, mag, lost)
    return arrivals.sound


def _align(state: FusionState, orientation: Array, flexion: Array | None) -> None:
    state.aligned = True
    state.origin = orientation.copy()
    if flexion is not None and len(state.pairs):
        state.heading = heading_offsets(orientation, state.pairs, flexion)


def _angles(state: FusionState, orientation: Array, tick: Tick) -> Array:
    if len(state.pairs):
        angles = np.asarray(flexion_angles(orientation, state.pairs, state.heading))
        state.plausible.note(angles, tick)
        return angles
    return np.asarray(turned_angle(state.origin, orientation))
