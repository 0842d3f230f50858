"""State of a tracker of Salchow-Hoemmen et al. 2019."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.arrivals import Arrivals
from estimators.body.body import Body, ImplausibleAngles, body_of, of_tree
from estimators.calibration.initial_pose import (
    InitialPoseLimits,
    PoseRecord,
    Ties,
    known_angles,
    new_record,
    ties_of,
)
from estimators.fusion.front_end import FrontEnd, FrontEndName, front_end_of, require_front_end
from fesloop.errors import InputError
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.loop.block import Context
from fesloop.loop.clock import RateClock, StampClock
from fesloop.loop.signals import Port

_POSITIVE = ("tau_acc_s", "tau_mag_s", "mounting_sd_deg", "heading_sd_deg", "drift_deg_s", "untracked_deg_s",
             "gap_ms", "gyr_range_deg_s", "acc_range_g", "initial_pose_s")


class InitialPose(NamedTuple):
    """Initial pose: duration, s, angles by freedom, deg, and limits of a plausible pose."""

    duration_s: float
    angles_deg: Mapping[str, float]
    limits: InitialPoseLimits


class Method(NamedTuple):
    """Parameters of a tracker of this family.

    Attributes
    ----------
    front_end, tau_acc_s, tau_mag_s: as in `front_end_of`.
    every: ticks between samples of the accelerometers, and of the magnetometers.
    magnetometer: whether magnetometers are used. pose: the initial pose, or None.
    constrained: whether joint constraints are applied.
    mounting_sd, heading_sd: rad. drift: rad/s. unseen_rate: rad/s. gap_s: s.
    limits: magnitudes above which samples count as clipped, rad/s, m/s^2, T.
    """

    front_end: FrontEndName
    tau_acc_s: float | None
    tau_mag_s: float | None
    every: tuple[int, int]
    magnetometer: bool
    pose: InitialPose | None
    constrained: bool
    mounting_sd: float
    heading_sd: float
    drift: float
    unseen_rate: float
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
        pose = InitialPose(tracker.initial_pose_s, tracker.initial_angles_deg, tracker.pose_limits)
    radians = math.radians
    return Method(
        front_end=tracker.front_end, tau_acc_s=tracker.tau_acc_s,
        tau_mag_s=tracker.tau_mag_s if magnetometer else None,
        every=(tracker.acc_every, tracker.mag_every if magnetometer else 1), magnetometer=magnetometer,
        pose=pose, constrained=pose is not None, mounting_sd=radians(tracker.mounting_sd_deg),
        heading_sd=radians(tracker.heading_sd_deg) if magnetometer else 0.0,
        drift=0.0 if magnetometer else radians(tracker.drift_deg_s),
        unseen_rate=radians(tracker.untracked_deg_s), gap_s=1e-3 * tracker.gap_ms,
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
    silent_s: (n,), time since the last rate. gaps: (n, 2), variances due to gaps, rad^2.
    record: statistics of the initial pose so far. pose_ticks: number of its ticks so far.
    known: (n, 4), segments to the root in the known pose. ties: relative orientations of all sensors in it.
    headings: (n, 2), cosine and sine of half the heading correction of each sensor.
    posed: (n,), whether each sensor has been aligned.
    aligned_ns: instant of the alignment; None before.
    failing: whether the pose has been refused; quiet_ns: instant until which that is not reported again.
    seen: (m,), whether each joint is seen.
    unseen: joints last reported as untracked; None before the first tick.
    plausible: check for angles that no joint can have.
    counted: (m,), whether each joint's uncertainty adds to that of the fingertips.
    ticks: number of the next tick.
    """

    method: Method
    bank: FrontEnd
    arrivals: Arrivals
    period_s: float
    forget: Array
    silent_s: Array
    gaps: Array
    record: PoseRecord
    known: Array
    ties: Ties
    headings: Array
    posed: NDArray[np.bool_]
    seen: NDArray[np.bool_]
    counted: NDArray[np.bool_]
    plausible: ImplausibleAngles
    unseen: tuple[str, ...] | None = None
    aligned_ns: int | None = None
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
        method=method, bank=_new_bank(n, period, method), arrivals=Arrivals(n, method.limits, period),
        period_s=period,
        forget=np.exp(-2.0 * period / fading), silent_s=np.full(n, np.inf), gaps=np.zeros((n, 2)),
        record=new_record(n), known=segment_poses(body.tree, angles).orientation[body.sensed],
        ties=ties_of(body, angles, np.ones(n, dtype=np.bool_)),
        headings=np.tile(_NO_TURN, (n, 1)), posed=np.ones(n, dtype=np.bool_),
        seen=np.zeros(m, dtype=np.bool_), counted=_beyond_a_sensor(body), plausible=of_tree(body.tree))


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
