"""`kortier`: the error-state filters of Kortier et al. 2014, one for each finger and one for the hand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from estimators.arrivals import Arrivals
from estimators.body.body import (
    ALIGNED_PORT,
    Body,
    ImplausibleAngles,
    aligned_value,
    body_of,
    of_tree,
    posture_ports,
    random_sd_port,
    stated_by,
    worn_as_stated,
)
from estimators.body.misalignment import misalignment
from estimators.kortier.chain import Filters, Gates, begin_again, new_filters
from estimators.kortier.navigation import HandFilter, HandGates, begin_hands_again, new_hands
from estimators.kortier.samples import Moment, Trust, no_moment
from estimators.kortier.tick import Posture, Settings, Worn, report_unseen, track, worn_by
from estimators.kortier.tilts import Tilts, compare_along_hinges, mounting_scale, new_tilts
from estimators.kortier.tree import CHAIN5, base_of, pose_of
from fesloop.errors import InputError
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import relative_orientations
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.hand.segments import Segment
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock, StampClock
from fesloop.loop.signals import Port, Sample, Sensors, Value

_UNKNOWN = STANDARD_GRAVITY
"""Sd of an acceleration whose sample is missing, m/s^2 (chosen: a hand in motion, upright or not)."""
_SPACING = 0.5
"""Time between comparisons of accelerations, in multiples of `error_time_s` (chosen)."""
_MISLED_SDS = 6.0
"""Estimated bias, in sds of what is stated, that shows that the field misleads (chosen: of a real chain
without magnetometers it is at most 5, on foam; with them, in a field that is not the earth's, 8 to 20)."""
_MISLED_HEADING = math.radians(30.0)
"""Sd of the headings of joints that are no hinges once the field has misled, rad (chosen: a real chain's is
20 to 60 deg off then, hands' 5 to 30)."""
_USUAL = HandSize()
_POSITIVE = ("gyr_sd", "acc_sd", "mag_sd_ut", "bias_walk", "bias_sd_deg_s", "angle_sd_deg",
             "constraint_sd_deg", "mounting_sd_deg", "axis_sd_deg", "fusion_sd_deg",
             "heading_sd_deg", "acc_difference", "mag_difference_ut", "rate_limit", "still_rate",
             "still_acc", "still_sd", "lost_rate_deg_s", "clipped_rate_deg_s", "gap_ms", "gyr_range_deg_s",
             "acc_range_g")


@dataclass(slots=True, eq=False)
class KortierState:
    """State of a KortierTracker.

    Attributes
    ----------
    hands: filters of attitude, velocity and position. filters: filters of the chains.
    moment: samples in the form that the filters use. arrivals: ages and faults of the samples.
    plausible: check for angles that no joint can have.
    tilts: of the axes of hinges; scale: of the variance of mounting and axes, as the tilts show; compared_s:
        time since accelerations were compared for them.
    followed_s: time since the first sample; misled: whether the field has been found to mislead.
    unseen: joints last reported as untracked; None before the first tick.
    """

    hands: HandFilter
    filters: Filters
    moment: Moment
    arrivals: Arrivals
    plausible: ImplausibleAngles
    tilts: Tilts
    scale: float = 1.0
    compared_s: float = 0.0
    followed_s: float = 0.0
    misled: bool = False
    unseen: tuple[str, ...] | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class KortierTracker:
    """Posture, attitude and position of a hand by Kortier et al. 2014 (doi 10.1186/1743-0003-11-70).

    A chain of segments (a finger; forearm and hand) runs from one branching segment to the next, or to a
    tip. Each chain has an error-state filter (`estimators.kortier.chain`) of the relative rotations of its
    segments and of all its gyroscope biases. The filter is corrected by neighbouring accelerometers, by the
    magnetometers of base and tip and by the constraints of the joints. The base, the hand, has a filter of
    attitude, velocity and position (`estimators.kortier.navigation`), which drifts within seconds unless the
    hand is still now and then. Where segments without a sensor divide the tree, the innermost segment of
    each part has such a filter.

    Inputs `gyr` (n, 3) rad/s, `acc` (n, 3) m/s^2 and `mag` (n, 3) T, sensor frames equal to segment frames.
    Their rates may differ: give the tracker the rate of the gyroscopes. Magnetometers other than those of
    bases and tips are not read. Without magnetometers (`magnetometers` false, or `mag` not wired, where
    `sensors` must be given) headings depend on the gyroscopes and the joints alone. Use this where the field
    is not the earth's: gates on magnitudes alone pass much of a disturbed field. A field with which the
    gyroscopes agree only by biases beyond 6 sds is read no more ("field_misleads").

    Outputs `orientation` (n, 4), segment to earth (z up; with magnetometers y to magnetic north, else the
    heading is zero at the start); `angles` (a,), rad, all freedoms of the tree; `angle_sd` (a,), rad;
    `fingertips` (t, 3), m, in the frame of the tree's root (for a hand the WCS), and `fingertip_sd` (t, 3),
    m, from the filters' full covariances, with lengths assumed exact; `position` (3,), m, and `velocity`
    (3,), m/s, of the base since the start; `aligned` (1,), always 1; `angle_random_sd` (a,), rad,
    without mounting and axes, which are constant in a trial. Five sensors without any setting are
    those of chain5 (`fesloop.streams.formats.published`), whose lengths are unknown: the tracker then has no
    fingertip outputs.

    Through lost rates (or frozen ones, or ones held for too long: `estimators.arrivals`) segments turn as the
    rates around the gap tell (`estimators.gaps`), a clipped rate is used as read, both with a larger
    uncertainty. A joint is reported as "untracked" when
    one of its segments has no sensor or its gyroscope has given no sample for `gap_ms` (such as a strip that
    was left off), and as "tracked" when both are back. The angles of an untracked joint are 0, their sd pi.

    Attributes
    ----------
    sensors: number n of sensors; 0 takes it from the wire.
    hand: size of the hand.
    sensed: names of the segments that carry the sensors, in the order of the samples; empty: every segment,
        or all but the tree's root (a hand's forearm).
    segments: segment tree that replaces the hand.
    base: name of the segment whose attitude and position are tracked; empty: "hand" where it has a sensor
        and `segments` is empty, else the first segment of the tree with a sensor.
    magnetometers: whether the tracker has an input `mag`.
    initial_angles_deg: initial posture by names of freedoms, such as `F2_mcp_flexion`; others are 0.
    gyr_sd, acc_sd: sd of a sample, rad/s, m/s^2 (K14, Table 1).
    mag_sd_ut: sd of a sample, with differences of the field within a hand, uT (chosen: Table 1 prints 1e-4).
    bias_walk: random walk of the gyroscopes' biases, rad/s after a second (K14, Table 1, read as a density).
    bias_sd_deg_s, angle_sd_deg: initial sd of the biases, and of joints and the hand's attitude (chosen).
    constraint_sd_deg: sd of the changes of a joint's forbidden angles within error_time_s (chosen; Table 1
        has 1e-5). It is less than the tilt of a joint's axes (5 to 10 deg: doi 10.3390/s19010208, section 5):
        a constant tilt only shifts the angles, by the same amount in each repetition of a posture, and must
        not be modelled as noise that averages out. What varies is its part in the forbidden angles as the
        joint moves. With sd s, correlation time T and `bias_walk` w, errors of the rates show in the
        constraints after sqrt(s sqrt(2 T) / w): 10 s for 1 deg, 24 s for 5 deg. Sensors on soft pads, which
        rotate by several degrees while they move, need more: 5.
    mounting_sd_deg, axis_sd_deg: sds of each sensor's mounting on its segment and of the tilt of joint axes,
        about each axis (5 to 10 about any direction: S19, section 5). They make a forbidden angle constant,
        not zero, and are added to the filters' covariance (`estimators.body.misalignment`), as far as the
        tilts of hinges confirm them (`estimators.kortier.tilts`).
    fusion_sd_deg: sd of each segment's orientation in motion about each axis, which the filters' white noise
        leaves out: soft tissue, scale of the gyroscopes, lever arms (chosen).
    heading_sd_deg: sd of the heading of joints that are no hinges, where magnetometers are used: errors of
        the field pass the gates for as long as they last (chosen).
    error_time_s: correlation time of the errors of constraint_sd_deg, lever_m and motion_sd, s; samples
        within it measure the same error again (chosen); 0: errors are white.
    acc_difference, mag_difference_ut, rate_limit: gates (eq. 27, 28) in m/s^2, uT, rad/s; the paper leaves
        them to the user (chosen).
    lever_m: lever arm by which rotation adds to the accelerometers' variance (chosen: half a phalanx and a
        joint).
    motion_sd: sd of the hand's acceleration where the accelerometer gives the vertical, m/s^2 (chosen).
    still_window: samples of the zero-velocity detector; still_rate, still_acc: rms of rate and acceleration
        below which the hand is still, rad/s, m/s^2; still_sd: sd of its velocity then, m/s (chosen). The
        peak of a straight reach may count as still; with a still_acc of .1 it does not, but needs sensors as
        quiet as the paper's.
    lost_rate_deg_s: rms rate of a segment about each axis while samples are missing (chosen: a finger in
        motion). A joint is unknown once that rate would have turned it by pi.
    clipped_rate_deg_s: sd of a clipped rate (chosen).
    gap_ms: silence of a gyroscope after which its joints are untracked (chosen: ten samples at 100 Hz).
    gyr_range_deg_s, acc_range_g: magnitude above which samples count as clipped, as in VqfTracker.
    """

    sensors: int = 0
    hand: HandSize = _USUAL
    sensed: tuple[str, ...] = ()
    segments: tuple[Segment, ...] = ()
    base: str = ""
    magnetometers: bool = True
    initial_angles_deg: Mapping[str, float] = field(default_factory=dict)
    gyr_sd: float = 5e-4
    acc_sd: float = 4e-2
    mag_sd_ut: float = 1.0
    bias_walk: float = 1e-4
    bias_sd_deg_s: float = 0.6
    angle_sd_deg: float = 10.0
    constraint_sd_deg: float = 1.0
    mounting_sd_deg: float = 5.0
    axis_sd_deg: float = 5.0
    fusion_sd_deg: float = 1.5
    heading_sd_deg: float = 5.0
    error_time_s: float = 0.2
    acc_difference: float = 0.5
    mag_difference_ut: float = 5.0
    rate_limit: float = 3.0
    lever_m: float = 0.03
    motion_sd: float = 0.3
    still_window: int = 25
    still_rate: float = 0.1
    still_acc: float = 0.2
    still_sd: float = 0.01
    lost_rate_deg_s: float = 120.0
    clipped_rate_deg_s: float = 500.0
    gap_ms: float = 100.0
    gyr_range_deg_s: float = 2000.0
    acc_range_g: float = 16.0
    body: Body | None = field(init=False, repr=False, default=None)
    worn: Worn | None = field(init=False, repr=False, default=None)
    settings: Settings = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.sensors < 0:
            raise InputError("sensors", f"{self.sensors}", "1 or more, or 0 to take it from the wire")
        if not 2 <= self.still_window <= 1000:
            raise InputError("still_window", f"{self.still_window}", "2 to 1000 samples")
        for name in _POSITIVE:
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(name, f"{value} is not positive", "a finite number above 0")
        for name in ("error_time_s", "lever_m", "motion_sd"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError(name, f"{value}", "a finite number, zero or more")
        object.__setattr__(self, "settings", self._settings())
        if self.sensors:
            segments = self.segments if self._lengths_known() else CHAIN5
            body = body_of(self.sensors, self.hand, segments, self.sensed)
            base = base_of(body, self.base, "" if self.segments else "hand")
            pose_of(body.tree, self.initial_angles_deg)
            object.__setattr__(self, "body", body)
            wrong = misalignment(body.tree, self.mounting_sd_deg, self.axis_sd_deg, self.fusion_sd_deg)
            object.__setattr__(self, "worn", worn_by(body, base, wrong))

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Ports gyr, acc and, with magnetometers, mag."""
        shape = (self.sensors or None, 3)
        ports = (Port("gyr", shape, "rad/s"), Port("acc", shape, "m/s^2"),
                 Port("mag", shape, "T", optional=True))
        return ports if self.magnetometers else ports[:2]

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Ports orientation to fingertip_sd, position, velocity, aligned and angle_random_sd."""
        ports = posture_ports(self.body, self.sensors)
        return (*ports[:5 if self._lengths_known() else 3], Port("position", (3,), "m"),
                Port("velocity", (3,), "m/s"), ALIGNED_PORT, random_sd_port(self.body))

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> KortierTracker:
        """The tracker for the number of wired sensors."""
        return replace(self, sensors=shapes["gyr"][0])

    def with_sensors(self, sources: Mapping[str, Sensors]) -> KortierTracker:
        """The tracker with its sensors on the segments that their source states (`worn_as_stated`)."""
        return worn_as_stated(self, stated_by(sources))

    def init(self, context: Context) -> KortierState:
        """Create filters in the initial posture, with the hand's attitude unknown."""
        if not isinstance(context.clock, (RateClock, StampClock)):
            raise InputError(f"{context.name}.rate", "is missing", "the rate of the gyroscopes")
        body, worn = self._wearer()
        start = relative_orientations(body.tree, pose_of(body.tree, self.initial_angles_deg))
        filters = new_filters(worn.chains, start[worn.chains.segments], math.radians(self.angle_sd_deg),
                              math.radians(self.bias_sd_deg_s), self.settings.gates.offset_sd)
        limits = (math.radians(self.gyr_range_deg_s), STANDARD_GRAVITY * self.acc_range_g, math.inf)
        return KortierState(
            new_hands(len(worn.held_sensors), self.still_window), filters, no_moment(self.sensors),
            Arrivals(self.sensors, limits, context.clock.period_s, worn.magnetometers, body.sensor_names),
            of_tree(body.tree), new_tilts(worn.chains, worn.wrong))

    def step(self, state: KortierState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Process the samples of a tick."""
        arrivals, motion = state.arrivals, state.hands.motion
        body, worn = self._wearer()
        elapsed = arrivals.note(inputs if inputs[-1].present else inputs[:2], tick)
        if state.misled:
            elapsed = elapsed[0], elapsed[1], 0.0
        angles, tips = np.empty((3, len(body.tree.ranges))), np.empty((2, body.tips.size, 3))
        posture = Posture(np.empty((self.sensors, 4)), angles, tips)
        settings = self.settings._replace(heading=_MISLED_HEADING ** 2) if state.misled else self.settings
        joints = track(
            arrivals.samples, arrivals.codes, elapsed, arrivals.period_s, worn, settings, state.hands,
            state.filters, state.moment, state.scale, posture)
        state.followed_s += elapsed[0]
        read = self.magnetometers and inputs[-1].present and not state.misled
        if self._compare(state, float(elapsed[1])) and read:
            self._doubt_field(state, tick)
        if joints or state.unseen is None:
            seen = state.filters.seen
            state.unseen = report_unseen(state.unseen or (), body, worn.chains, seen, tick)
        state.plausible.note(angles[0], tick)
        fingertips = (tips[0], tips[1]) if self._lengths_known() else ()
        return (posture.orientation, angles[0], angles[1], *fingertips, motion[worn.base, 1].copy(),
                motion[worn.base, 0].copy(), aligned_value(True), angles[2])

    def _compare(self, state: KortierState, elapsed_s: float) -> bool:
        """Compare accelerations for the scale of mounting and axes; return whether it was time."""
        state.compared_s += elapsed_s
        if not (elapsed_s > 0.0 and state.compared_s >= _SPACING * self.error_time_s):
            return False
        _, worn = self._wearer()
        compare_along_hinges(worn.chains, state.filters.seen, state.moment, elapsed_s, state.compared_s,
                             self.settings.trust, self.settings.gates, state.tilts)
        state.scale = mounting_scale(worn.chains, worn.wrong, state.tilts)
        state.compared_s = 0.0
        return True

    def _doubt_field(self, state: KortierState, tick: Tick) -> None:
        """Read magnetometers no more once only biases that no gyroscope has explain what they say.

        A field that turns a joint by more than its gyroscopes do is a bias to the filter. Filters then go on
        from their rotations with the sds of the beginning, and biases begin anew.
        """
        bias_sd = math.radians(self.bias_sd_deg_s)
        sd = math.hypot(bias_sd, self.bias_walk * math.sqrt(state.followed_s))
        greatest = max(float(np.abs(found.bias).max(initial=0.0)) for found in (state.filters, state.hands))
        if greatest < _MISLED_SDS * sd:
            return
        state.misled = True
        _, worn = self._wearer()
        begin_again(worn.chains, state.filters, math.radians(self.angle_sd_deg), bias_sd,
                    self.settings.gates.offset_sd)
        begin_hands_again(state.hands, self.settings.own)
        tick.report("field_misleads", (
            f"magnetometers agree with gyroscopes only with an offset of {math.degrees(greatest):.1f} "
            f"deg/s, over {_MISLED_SDS:g} times bias_sd_deg_s: magnetometers are read no more, and headings "
            "may be wrong by what the field did until now; set magnetometers = false, or bias_sd_deg_s to "
            "the offsets of your gyroscopes"))

    def _wearer(self) -> tuple[Body, Worn]:
        if self.body is None or self.worn is None:
            raise InputError("sensors", "0", "their number", "wire the tracker, or give it `sensors`")
        return self.body, self.worn

    def _lengths_known(self) -> bool:
        """Return whether the segments' lengths are known; those of chain5 are not."""
        return self.sensors != 5 or bool(self.segments or self.sensed) or self.hand != _USUAL

    def _settings(self) -> Settings:
        radians = math.radians
        trust = Trust(self.gyr_sd, self.acc_sd, 1e-6 * self.mag_sd_ut, radians(self.lost_rate_deg_s),
                      radians(self.clipped_rate_deg_s), self.lever_m, self.error_time_s)
        # A forbidden angle has the mounting of two sensors and the tilt of the joint's axes.
        offset_sd = math.hypot(math.sqrt(2.0) * radians(self.mounting_sd_deg), radians(self.axis_sd_deg))
        gates = Gates(self.acc_difference, 1e-6 * self.mag_difference_ut, self.rate_limit,
                      radians(self.constraint_sd_deg), offset_sd, self.error_time_s, self.bias_walk,
                      1e-3 * self.gap_ms, math.pi / trust.lost_sd)
        own = HandGates(self.motion_sd, self.still_rate, self.still_acc, self.still_sd, _UNKNOWN,
                        radians(self.angle_sd_deg), radians(self.bias_sd_deg_s))
        heading = radians(self.heading_sd_deg) ** 2 if self.magnetometers else 0.0
        return Settings(trust, gates, own, heading)
