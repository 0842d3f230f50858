"""`salchow_b`, `salchow_m1`, `salchow_m2`: the trackers of Salchow-Hoemmen et al. 2019.

S19 is doi 10.3390/s19010208, section 2.4. B fuses each sensor with its magnetometer and chains the
orientations. M1 adds the initial pose (2.4.2) and the joint constraints (2.4.3), M2 is M1 without any
magnetometer.

Inputs `gyr` (n, 3) rad/s, `acc` (n, 3) m/s^2 and, for B and M1, `mag` (n, 3) T, sensor frames equal to
segment frames. Their rates may differ: give the tracker the rate of the gyroscopes. Outputs `orientation`
(n, 4), segment to earth (z up; with magnetometers y to magnetic north at the first sensor, else its heading
starts at zero); `angles` and `angle_sd` (d,), rad, all freedoms of the tree in its order; `fingertips` and
`fingertip_sd` (t, 3), m, in the frame of the tree's root (for the hand: WCS); `aligned` (1,), for M1 and M2 0
until the initial pose has been taken, and once evidence contradicts it, else 1; `angle_random_sd` (d,), rad,
without what is constant in a trial: mounting, axes, and the pose that was told.

A joint is seen when both its segments have a sensor with valid samples. Other joints are reported as
"untracked", with angle 0 and sd pi, and as "tracked" when they are seen again. Joints between the root and
the first sensor (with 16 sensors the wrist) count as neutral, and the fingertips' sd leaves them out.

The paper has no measure of quality; the sds here are a model. The rotation of each joint has an error from
the mounting of its two sensors and from tilted axes (`estimators.body.misalignment`), and a heading error
about the vertical. The sd of an angle follows from both, that of a fingertip from the joints before it,
assumed independent. Forbidden
angles of a joint are assumed to be exactly zero, and a clipped angle keeps its sd. The model does not include
wrong lengths, soft tissue in motion and a disturbed magnetic field.

A sensor whose rate is lost turns as the rates around the gap tell (`estimators.gaps`, with `untracked_deg_s`
for their spread), and its sd grows; its inclination recovers, and with a magnetometer its heading. A lost
acceleration or field gives no correction. Clipped samples are used; what a clipped rate has missed adds to
the sd. All of these are reported.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

from estimators.body.body import (
    ALIGNED_PORT,
    Body,
    posture_ports,
    random_sd_port,
    stated_by,
    worn_as_stated,
)
from estimators.calibration.initial_pose import InitialPoseLimits
from estimators.calibration.pose_evidence import PoseEvidence
from estimators.fusion.front_end import FrontEndName
from estimators.salchow.fusion import (
    SalchowState,
    method_of,
    require_parameters,
    sample_ports,
    start,
    track,
    wired,
    worn_by,
)
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.segments import Segment
from fesloop.loop.block import Context, Tick
from fesloop.loop.signals import Port, Sample, Sensors, Value

_USUAL = HandSize()
_USUAL_LIMITS = InitialPoseLimits()
_USUAL_EVIDENCE = PoseEvidence()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Tracker:
    """Parameters and members that the three methods share."""

    sensors: int = 0
    hand: HandSize = _USUAL
    sensed: tuple[str, ...] = ()
    segments: tuple[Segment, ...] = ()
    front_end: FrontEndName = "vqf"
    tau_acc_s: float | None = None
    acc_every: int = 1
    mounting_sd_deg: float = 5.0
    axis_sd_deg: float = 5.0
    fusion_sd_deg: float = 2.0
    untracked_deg_s: float = 120.0
    clipped_rate_deg_s: float = 500.0
    gap_ms: float = 100.0
    gyr_range_deg_s: float = 2000.0
    acc_range_g: float = 16.0
    body: Body | None = field(init=False, repr=False, default=None)

    def __post_init__(self) -> None:
        require_parameters(self)
        object.__setattr__(self, "body", worn_by(self))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Ports orientation, angles, angle_sd, fingertips, fingertip_sd, aligned and angle_random_sd."""
        return *posture_ports(self.body, self.sensors), ALIGNED_PORT, random_sd_port(self.body)

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> Self:
        """The tracker for the number of wired sensors."""
        return replace(self, sensors=shapes["gyr"][0])

    def with_sensors(self, sources: Mapping[str, Sensors]) -> Self:
        """The tracker with its sensors on the segments that their source states (`worn_as_stated`)."""
        return worn_as_stated(self, stated_by(sources))

    def step(self, state: SalchowState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Process one sample of every sensor."""
        return track(state, wired(self.body), inputs, tick)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SalchowB(_Tracker):
    """Posture of a hand from 9-axis sensors fused separately: method B of Salchow-Hoemmen et al. 2019.

    Attributes
    ----------
    sensors: number n of sensors; 0 takes it from the wire.
    hand: size of the hand.
    sensed: names of the segments that carry the sensors, in the order of the samples; empty: all segments of
        the tree, or all but its root, depending on the number of sensors.
    segments: segment tree that replaces the hand.
    front_end: "vqf" (doi 10.1016/j.inffus.2022.10.014) or "seel_ruppin" (doi 10.1016/j.ifacol.2017.08.1534,
        the paper's own).
    tau_acc_s, tau_mag_s: time constants of its corrections, s (for "seel_ruppin": halving times of an error);
        None: its authors' values.
    acc_every, mag_every: ticks between samples of the accelerometers, and of the magnetometers.
    mounting_sd_deg, axis_sd_deg: sds of each sensor's mounting on its segment and of the tilt of joint axes,
        about each axis, deg (5 to 10 about any direction: S19, section 5).
    fusion_sd_deg: sd of a fused orientation in motion about each axis, deg (recordings of BROAD: .6 to 5 in
        all; chosen within).
    heading_sd_deg: sd of a magnetometer's heading relative to its neighbour's, deg (chosen; no sensor
        measures it).
    untracked_deg_s: rms rate of a segment whose samples are missing (chosen: a finger in motion).
    clipped_rate_deg_s: sd of the rate in excess of a clipped one (chosen: as in KortierTracker).
    gap_ms: silence of a gyroscope after which its joints are unseen (chosen: ten samples at 100 Hz).
    gyr_range_deg_s, acc_range_g: magnitude above which samples count as clipped, as in VqfTracker.
    """

    tau_mag_s: float | None = None
    mag_every: int = 1
    heading_sd_deg: float = 10.0

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Ports gyr, acc and mag."""
        return sample_ports(self.sensors, magnetometer=True)

    def init(self, context: Context) -> SalchowState:
        """Create filters in their initial state."""
        return start(wired(self.body), method_of(self, magnetometer=True), context)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SalchowM1(_Tracker):
    """Posture of a hand by method M1 of Salchow-Hoemmen et al. 2019: B, an initial pose, joint constraints.

    During the initial pose, reported as "aligning", the outputs are the known pose; "aligned" reports its
    end. A pose in which the hand moved is reported as "initial_pose_failed", with sensors and reasons, one
    that gravity contradicts as "pose_contradicted", with joints and angles. The next pose that is still for
    as long is taken; until then all sds are those of unknown angles. If the posture after the pose
    contradicts it (`estimators.calibration.pose_evidence`), this is reported as "pose_contradicted", too:
    the sds of these joints grow by as much, and `aligned` is 0 for the rest of the trial. Sensors without a
    sample in the pose are left out, and their joints stay unseen.

    Attributes
    ----------
    sensors, hand, sensed, segments, front_end, tau_acc_s, tau_mag_s, acc_every, mag_every: as in SalchowB.
    mounting_sd_deg, axis_sd_deg, fusion_sd_deg, untracked_deg_s, clipped_rate_deg_s, gap_ms, gyr_range_deg_s,
        acc_range_g: as in SalchowB.
    initial_pose_s: duration of the initial pose, s (3 or more: doi 10.3390/s19010208, section 2.4.2).
    initial_angles_deg: the pose by names of freedoms, such as `F1_cmc_abduction`; others are 0: straight.
    pose_sd_deg: sd of each joint's rotation in the pose about any axis, deg (chosen: what a goniometer does).
    pose_limits: limits of the sensors' readings in the pose.
    evidence: tests of the pose against what the sensors show of it.
    heading_sd_deg: as in SalchowB; less, as the pose removes what is constant (chosen).
    """

    tau_mag_s: float | None = None
    mag_every: int = 1
    initial_pose_s: float = 3.0
    initial_angles_deg: Mapping[str, float] = field(default_factory=dict)
    pose_sd_deg: float = 5.0
    pose_limits: InitialPoseLimits = _USUAL_LIMITS
    evidence: PoseEvidence = _USUAL_EVIDENCE
    heading_sd_deg: float = 5.0

    @property
    def needs_stillness(self) -> str:
        """Name of the output that reports the end of the initial pose: `aligned`."""
        return "aligned"

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Ports gyr, acc and mag."""
        return sample_ports(self.sensors, magnetometer=True)

    def init(self, context: Context) -> SalchowState:
        """Create filters in their initial state, before the initial pose."""
        return start(wired(self.body), method_of(self, magnetometer=True), context)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SalchowM2(_Tracker):
    """Posture of a hand by method M2 of Salchow-Hoemmen et al. 2019: M1 without magnetometers.

    It works as SalchowM1. Nothing corrects a heading after the initial pose: it drifts with the residual bias
    of the gyroscopes, and its sd grows; a heading that is lost with samples stays lost.

    Attributes
    ----------
    sensors, hand, sensed, segments, front_end, tau_acc_s, acc_every: as in SalchowB.
    mounting_sd_deg, axis_sd_deg, fusion_sd_deg, untracked_deg_s, clipped_rate_deg_s, gap_ms, gyr_range_deg_s,
        acc_range_g: as in SalchowB.
    initial_pose_s, initial_angles_deg, pose_sd_deg, pose_limits, evidence: as in SalchowM1.
    drift_deg_s: sd of the rate at which neighbours' headings diverge, deg/s (chosen: two biases known to
        within an instability of 10 deg/h, usual for MEMS).
    """

    initial_pose_s: float = 3.0
    initial_angles_deg: Mapping[str, float] = field(default_factory=dict)
    pose_sd_deg: float = 5.0
    pose_limits: InitialPoseLimits = _USUAL_LIMITS
    evidence: PoseEvidence = _USUAL_EVIDENCE
    drift_deg_s: float = 0.004

    @property
    def needs_stillness(self) -> str:
        """Name of the output that reports the end of the initial pose: `aligned`."""
        return "aligned"

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Ports gyr and acc."""
        return sample_ports(self.sensors, magnetometer=False)

    def init(self, context: Context) -> SalchowState:
        """Create filters in their initial state, before the initial pose."""
        return start(wired(self.body), method_of(self, magnetometer=False), context)
