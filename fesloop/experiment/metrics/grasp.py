"""Metrics of a grasp, what a clinician reads first, from a recording."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.metrics.grasp_effort import charge_c, fitness_ratio, grasps_until_fatigue
from fesloop.experiment.metrics.grasp_forces import contact_s, grip_force, needed_grip_n
from fesloop.experiment.metrics.grasp_posture import (
    aperture,
    rms_known,
    unwanted_motion_deg,
    wrist_extension_deg,
)
from fesloop.experiment.metrics.grasp_score import GraspScore
from fesloop.experiment.metrics.joints import held
from fesloop.experiment.recording.reading import Recording, Signal
from fesloop.experiment.recording.recorded import reached_ns
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import FINGERS
from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
HAND = 1
"""Number of the hand's own segment among the sites."""


class _Trial(NamedTuple):
    """A trial of a recording, and the score that it is read for."""

    recording: Recording
    score: GraspScore
    number: int

    def whole(self, name: str) -> tuple[Array, Array]:
        """Instants (n,), s, and values of a signal."""
        signal = self.recording.signal(name, self.number)
        return signal.times_ns / NS_PER_S, np.asarray(signal.values)

    def between(self, name: str, from_s: float) -> Array:
        """Values from an instant until the end of the while; a row of NaN where the trial ended before."""
        return _between(self.recording.signal(name, self.number), from_s, self.score.until_s)

    def hold(self, name: str) -> Array:
        """Values of the while."""
        return self.between(name, self.score.from_s)

    def closing(self, name: str) -> Array:
        """Values from when the hand starts to close until the end of the while."""
        return self.between(name, self.score.starts_s)


def grasp_metrics(recording: Recording, score: GraspScore) -> dict[str, Any]:
    """What the score's signals allow, in lists of one a trial.

    held: whether. object_moved_mm: how far at most during the while, in the hand where its pose is known.
    held_s: how long from its start the object stayed `within_mm`, to the end of the while at most.
    With forces: grip_force_n, mean of the while by fingertip; time_to_grasp_s, from `starts_s` until thumb
    and fingers touch; grip_margin, mean grip force of the while (`grip_force`) over what is needed
    (`needed_grip_n`), where that is known; grip_force_rmse_n against `wanted_n`.
    With fingertips: aperture_mm at `starts_s` (opening), at contact, as the mean of the while (hold), and
    with `aperture` its RMSE from `starts_s` until contact, or until the while ends where there is none
    (rmse).
    With angles: wrist_extension_deg, mean of the while; with `asked`, unwanted_motion_deg, RMS from
    `starts_s` to the end of the while.
    charge_uc: one phase of all pulses of all channels in the trial. grasps_until_fatigue: how many such
    grasps hold one after the other under unchanged stimulation, if grip force falls as the fitness of the
    muscles that close the hand falls from the first to the last instant of this trial; 0 where this one does
    not hold, NaN where fingertips alone do not explain that it does.

    Of a trial that ended before the while was over, `held` is None and the others are NaN.
    """
    metrics: dict[str, Any] = {}
    for number in range(recording.trials):
        trial = _Trial(recording, score, number)
        for name, value in {**_object(trial), **_forces(trial), **_posture(trial), **_effort(trial)}.items():
            if isinstance(value, dict):
                for part, item in value.items():
                    metrics.setdefault(name, {}).setdefault(part, []).append(item)
            else:
                metrics.setdefault(name, []).append(value)
    return metrics


def _between(signal: Signal, from_s: float, until_s: float) -> Array:
    """Values (n, ...) of a while; one row of NaN where the trial ended before it was over."""
    seconds = signal.times_ns / NS_PER_S
    inside = (seconds >= from_s) & (seconds <= until_s)
    if reached_ns(signal.times_ns) >= round(until_s * NS_PER_S) and inside.any():
        return np.asarray(signal.values[inside])
    return np.full((1, *signal.values.shape[1:]), np.nan)


def _object(trial: _Trial) -> dict[str, Any]:
    """How well the object stays."""
    score = trial.score
    places = _in_hand(trial, trial.hold(score.object))
    ways_mm = 1e3 * np.linalg.norm(places - places[0], axis=1)
    if math.isnan(ways_mm[0]):
        return {"held": None, "object_moved_mm": math.nan, "held_s": math.nan}
    times_s, _ = trial.whole(score.object)
    times_s = times_s[times_s >= score.from_s]
    gone = np.flatnonzero(ways_mm > score.within_mm)
    lasted_s = float(times_s[gone[0]]) - score.from_s if gone.size else score.until_s - score.from_s
    return {"held": not gone.size, "object_moved_mm": float(ways_mm.max()), "held_s": lasted_s}


def _in_hand(trial: _Trial, places: Array) -> Array:
    """Places of the while, (n, 3), m, from the hand's own segment, where its pose is known; else as they are.

    A wrist that gives way takes along what the hand holds.
    """
    score = trial.score
    if score.hand_position is None or score.hand_orientation is None or math.isnan(places[0, 0]):
        return places
    origin, turn = (trial.hold(name)[:, HAND] for name in (score.hand_position, score.hand_orientation))
    seen: Array = quaternion.rotate(quaternion.conjugate(turn), places - origin)
    return seen


def _contact_s(trial: _Trial) -> float:
    """When thumb and fingers touch; NaN where they do not, or forces are not told."""
    score = trial.score
    if score.forces is None:
        return math.nan
    return contact_s(*trial.whole(score.forces), score.starts_s, score.contact_n)


def _needed_n(trial: _Trial) -> float:
    """Least grip force that holds the object; NaN where nobody tells it."""
    if trial.score.needed_n is not None:
        return trial.score.needed_n
    return needed_grip_n(trial.recording.experiment["blocks"].get(trial.score.object.partition(".")[0], {}))


def _margin(trial: _Trial) -> float:
    """Grip force of the while over what is needed; NaN where that is not known."""
    assert trial.score.forces is not None
    return float(grip_force(trial.hold(trial.score.forces)).mean()) / _needed_n(trial)


def _forces(trial: _Trial) -> dict[str, Any]:
    """What the contact forces tell."""
    score = trial.score
    if score.forces is None:
        return {}
    forces = trial.hold(score.forces)
    told: dict[str, Any] = {
        "grip_force_n": dict(zip(FINGERS, forces.mean(axis=0).tolist(), strict=True)),
        "time_to_grasp_s": _contact_s(trial) - score.starts_s}
    if not math.isnan(_needed_n(trial)):
        told["grip_margin"] = _margin(trial)
    if score.wanted_n is not None:
        signal = trial.recording.signal(score.wanted_n, trial.number)
        times_s, every = trial.whole(score.forces)
        inside = (times_s >= score.from_s) & (times_s <= score.until_s)
        wanted = held((signal.times_ns, np.asarray(signal.values)), _ns(times_s[inside]))
        errors = grip_force(every[inside]) - wanted
        told["grip_force_rmse_n"] = math.nan if np.isnan(forces).any() else rms_known(errors)
    return told


def _posture(trial: _Trial) -> dict[str, Any]:
    """What angles and fingertips tell."""
    score = trial.score
    told: dict[str, Any] = {}
    if score.fingertips is not None:
        told["aperture_mm"] = _apertures_mm(trial, score.fingertips)
    if score.angles is not None:
        told["wrist_extension_deg"] = wrist_extension_deg(trial.hold(score.angles))
        if score.asked:
            told["unwanted_motion_deg"] = unwanted_motion_deg(trial.closing(score.angles), score.asked)
    return told


def _apertures_mm(trial: _Trial, name: str) -> dict[str, float]:
    """Aperture at the start, at contact and in the hold, and its error."""
    score, touched_s = trial.score, _contact_s(trial)
    times_s, fingertips = trial.whole(name)
    ways = 1e3 * aperture(fingertips, score.opposed)
    at = [score.starts_s, *(() if math.isnan(touched_s) else (touched_s,))]
    opening, *contact = held((_ns(times_s), ways), _ns(np.array(at)))
    told = {"opening": float(opening), "contact": float(contact[0]) if contact else math.nan,
            "hold": float(1e3 * aperture(trial.hold(name), score.opposed).mean())}
    if score.aperture is not None:
        before = (times_s >= score.starts_s) & (times_s <= min(
            score.until_s, touched_s if contact else score.until_s))
        signal = trial.recording.signal(score.aperture, trial.number)
        wanted = 1e3 * aperture(np.asarray(signal.values), score.opposed)
        told["rmse"] = rms_known(ways[before] - held((signal.times_ns, wanted), _ns(times_s[before])))
    return told


def _effort(trial: _Trial) -> dict[str, Any]:
    """Charge and fatigue."""
    score = trial.score
    told: dict[str, Any] = {}
    if score.pulses is not None:
        node = trial.recording.experiment["blocks"][score.pulses.partition(".")[0]]
        told["charge_uc"] = 1e6 * charge_c(*trial.whole(score.pulses), float(Fraction(node["frequency_hz"])))
    if score.activation is not None and score.fitness is not None:
        _, fitness = trial.whole(score.fitness)
        active = trial.hold(score.activation).mean(axis=0)
        ratio = fitness_ratio(active, fitness[0], fitness[-1]) if len(fitness) else math.nan
        told["grasps_until_fatigue"] = grasps_until_fatigue(_known_margin(trial), ratio)
    return told


def _known_margin(trial: _Trial) -> float:
    """Grip margin by which to tell when grasps fail: 0 where this one did.

    NaN where the object is held by less than is needed: fingertips do not carry it alone then, and what the
    palm and the other phalanges carry is not measured.
    """
    margin, held = _margin(trial), _object(trial)["held"]
    if held is None or (held and margin < 1.0):
        return math.nan
    return margin if held else 0.0


def _ns(seconds: Array) -> NDArray[np.int64]:
    return np.round(seconds * NS_PER_S).astype(np.int64)
