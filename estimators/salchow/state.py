"""What a tracker of Salchow-Hoemmen et al. 2019 remembers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.body.body import Body
from estimators.body.implausible import ImplausibleAngles, of_tree
from estimators.calibration.initial_pose import Ties, known_angles, ties_of
from estimators.calibration.still_record import PoseRecord, new_record
from estimators.fusion.front_end import FrontEnd, front_end_of
from estimators.salchow.method import Method
from estimators.samples.arrivals import Arrivals
from fesloop.errors import InputError
from fesloop.hand.kinematics import segment_poses
from fesloop.loop.block import Context
from fesloop.loop.clock import RateClock, StampClock

Array = NDArray[np.float64]
_NO_TURN = np.array([1.0, 0.0])
_TAU_S = {"vqf": (3.0, 9.0), "seel_ruppin": (1.0, 3.0)}
"""Of the corrections of accelerometer and magnetometer where none are given, s."""
_TIME_CONSTANT = {"vqf": 1.0, "seel_ruppin": 1.0 / math.log(2.0)}
"""Of an error that fades, over the former: VQF gives time constants, Seel-Ruppin times of halving."""


@dataclass(slots=True, eq=False)
class SalchowState:
    """Memory of a tracker of this family: n sensors, m segments.

    Attributes
    ----------
    method: what makes the tracker; never changed.
    bank: the filters.
    arrivals: which samples are new, and what is wrong with them.
    period_s: of the ticks. forget: (2,), share of a gap's variances that a sample leaves.
    silent_s: (n,), since the last rate. gaps: (n, 2), variances that gaps have left, rad^2.
    record: of the initial pose, as far as it has come. pose_ticks: how far that is.
    known: (n, 4), segments to the root in the known pose. ties: of all sensors in it.
    headings: (n, 2), cosine and sine of half the heading that each sensor is turned by.
    posed: (n,), which sensors have been aligned.
    aligned_ns: since when; None before.
    failing: whether the pose has been refused; quiet_ns: until when that is not reported again.
    seen, unseen: (m,), joints that are seen; names of those reported not to be, None before the first tick.
    plausible: angles that no joint can have.
    counted: (m,), joints whose uncertainty the fingertips share.
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
    """Filters at their start, headings as they come."""
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
    """Joints (m,) with a sensor somewhere between them and the root: where there is none, none was meant."""
    beyond = np.zeros(len(body.sensors), dtype=np.bool_)
    for k, parent in enumerate(body.tree.layout[:, 0]):
        if parent >= 0:
            beyond[k] = beyond[parent] or body.sensors[parent] >= 0
    return beyond
