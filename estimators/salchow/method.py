"""What makes a tracker of Salchow-Hoemmen et al. 2019: the parameters of all three, checked, in SI units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from estimators.body.body import Body, body_of
from estimators.calibration.initial_pose import InitialPoseLimits, known_angles
from estimators.fusion.front_end import FrontEndName, require_front_end
from fesloop.errors import InputError
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.loop.signals import Port

_POSITIVE = ("tau_acc_s", "tau_mag_s", "mounting_sd_deg", "heading_sd_deg", "drift_deg_s", "unseen_deg_s",
             "gap_ms", "gyr_range_deg_s", "acc_range_g", "initial_pose_s")


class InitialPose(NamedTuple):
    """Duration, s; angles by freedom, deg; and what is to be believed."""

    duration_s: float
    angles_deg: Mapping[str, float]
    limits: InitialPoseLimits


class Method(NamedTuple):
    """What makes a tracker of this family.

    Attributes
    ----------
    front_end, tau_acc_s, tau_mag_s: as `front_end_of`. every: ticks from one sample to the next of
        accelerometers and magnetometers.
    magnetometer: whether it reads one. pose: the initial pose, None: none is taken.
    constrained: whether joints hold what they allow.
    mounting_sd, heading_sd: rad. drift: rad/s. unseen_rate: rad/s. gap_s: s.
    limits: from which magnitude on samples are clipped, rad/s, m/s^2, T.
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
    """Raise InputError for impossible parameters of a tracker, those that it has."""
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
    """The body that wears a tracker's sensors, where their number is known.

    Raises InputError as `body_of` does, and for an initial pose that the body cannot have.
    """
    if not tracker.sensors:
        return None
    body = body_of(tracker.sensors, tracker.hand, tracker.segments, tracker.sensed)
    known_angles(body.tree, getattr(tracker, "initial_angles_deg", {}))
    return body


def wired(body: Body | None) -> Body:
    """The body; raises InputError where the number of sensors is not known."""
    if body is None:
        raise InputError("sensors", "0", "their number", "wire the tracker, or give it `sensors`")
    return body


def sample_ports(sensors: int, magnetometer: bool) -> tuple[Port, ...]:
    """gyr, acc and, where there is one, mag."""
    shape = (sensors or None, 3)
    ports = (Port("gyr", shape, "rad/s"), Port("acc", shape, "m/s^2"))
    return (*ports, Port("mag", shape, "T")) if magnetometer else ports


def method_of(tracker: Any, *, magnetometer: bool) -> Method:
    """The method that a tracker's parameters make: with an initial pose it also holds the joints."""
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
        unseen_rate=radians(tracker.unseen_deg_s), gap_s=1e-3 * tracker.gap_ms,
        limits=(radians(tracker.gyr_range_deg_s), STANDARD_GRAVITY * tracker.acc_range_g, math.inf))
