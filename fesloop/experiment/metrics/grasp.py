"""Metrics of a grasp, from a recording."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.metrics.grasp_outcome import (
    FREEDOMS,
    LASTING_S,
    OBJECT_KEYS,
    OUTCOMES,
    TABLE_KEYS,
    Found,
    GraspScore,
    ObjectCourse,
    contact_s,
    find_outcome,
    needed_grip_n,
)
from fesloop.experiment.metrics.joints import held
from fesloop.experiment.metrics.missing import note, put
from fesloop.experiment.metrics.stimulation import given_signal
from fesloop.experiment.recording.reading import Recording, Signal, reached_ns
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import FINGERS
from fesloop.hand.grip import by_digit, grip_force, places_of
from fesloop.hand.movements import MUSCLES
from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]
CLOSING = tuple(name for name in MUSCLES if name.startswith(("FDS", "FDP", "FPL", "THENAR", "INT")))
"""Muscles that close the hand on an object: flexors of fingers and thumb."""
_COLUMNS = [MUSCLES.index(name) for name in CLOSING]


def charge_c(times_s: Array, pulses: Array, frequency_hz: float) -> float:
    """Charge of one phase, C, summed over the pulses of all channels.

    `pulses` (n, channels, 2), A and s, or (n, channels), C a phase, each valid until the next row, the
    last as long as the one before it; a device gives `frequency_hz` pulses a second of the valid row.
    """
    charges = pulses[..., 0] * pulses[..., 1] if pulses.ndim == 3 else pulses
    if times_s.size < 2:
        return math.nan
    lasting_s = np.diff(times_s, append=2.0 * times_s[-1] - times_s[-2])
    return float(frequency_hz * (charges.sum(axis=1) @ lasting_s))


def fitness_ratio(activation: Array, before: Array, after: Array) -> float:
    """Ratio of the fitness `after` to that `before` (29,), of the muscles that close the hand.

    Each counts by its activation (29,), the mean of a hold. NaN where none is active.
    """
    share = activation[_COLUMNS]
    total = float(share @ before[_COLUMNS])
    return float(share @ after[_COLUMNS]) / total if total > 0.0 else math.nan


def grasps_until_fatigue(margin: float, ratio: float) -> float:
    """Number of grasps that hold, one after the other, under unchanged stimulation.

    Grip force over the force needed is `margin` in the first, and `ratio` times that of the one before in
    each that follows; a grasp holds while it is 1 or more: 1 + floor(ln margin / -ln ratio). 0 where the
    first does not hold, inf where fitness does not fall, NaN where an argument is.
    """
    if math.isnan(margin) or math.isnan(ratio):
        return math.nan
    if margin < 1.0:
        return 0.0
    if ratio >= 1.0:
        return math.inf
    return 1.0 + math.floor(math.log(margin) / -math.log(ratio)) if ratio > 0.0 else 1.0


_WRIST = FREEDOMS.index("wrist_flexion")


def aperture(fingertips: Array, opposed: Sequence[str]) -> Array:
    """Mean distance (n,), m, of the thumb's tip from those of the `opposed` fingers; `fingertips` (n, 5, 3).

    Values (n,) are apertures already.
    """
    if fingertips.ndim == 1:
        return fingertips
    fingers = [FINGERS.index(name) for name in opposed]
    distances = np.linalg.norm(fingertips[:, fingers] - fingertips[:, :1], axis=2)
    return np.asarray(distances.mean(axis=1))


def rms_known(errors: Array) -> float:
    """Root mean square of the finite values; NaN if there are none."""
    known = errors[np.isfinite(errors)]
    return float(np.sqrt(np.mean(known**2))) if known.size else float("nan")


def wrist_extension_deg(angles: Array) -> float:
    """Mean extension of the wrist over (n, 23), rad, in deg."""
    return float(-np.degrees(angles[:, _WRIST].mean()))


def unwanted_motion_deg(angles: Array, intended: Sequence[str]) -> float:
    """RMS over time and freedoms, deg, of how far those that are not `intended` are from the first row.

    `angles` (n, 23), rad. NaN where every freedom is intended.
    """
    others = [column for column, name in enumerate(FREEDOMS) if not name.startswith(tuple(intended))]
    return float(np.degrees(np.sqrt(np.mean((angles[:, others] - angles[0, others]) ** 2)))) if others \
        else float("nan")


HAND = 1
"""Number of the hand's own segment among the sites."""


class _Trial(NamedTuple):
    """A trial of a recording, its score, and the outcome of the object."""

    recording: Recording
    score: GraspScore
    number: int
    found: Found = Found("incomplete", math.nan, math.nan)

    def whole(self, name: str) -> tuple[Array, Array]:
        """Instants (n,), s, and values of a signal."""
        signal = self.recording.signal(name, self.number)
        return signal.times_ns / NS_PER_S, np.asarray(signal.values)

    def between(self, name: str, from_s: float) -> Array:
        """Values from an instant until the end of the hold; a row of NaN where the trial ended before."""
        return _between(self.recording.signal(name, self.number), from_s, self.score.until_s)

    def hold(self, name: str) -> Array:
        """Values of the hold."""
        return self.between(name, self.score.from_s)

    def closing(self, name: str) -> Array:
        """Values from when the hand starts to close until the end of the hold."""
        return self.between(name, self.score.starts_s)


def grasp_metrics(recording: Recording, score: GraspScore) -> dict[str, Any]:
    """Metrics of a grasp that the score's signals allow, in lists of one value per trial.

    object_outcome: outcome of the object, a word of `fesloop.experiment.metrics.grasp_outcome.OUTCOMES`.
    held: whether that is "held". object_moved_mm: how far at most it moved in the hand during the hold, as
    long as it was in it (in the room where the hand's pose is not known). held_s: how long from the start of
    the hold it stayed `within_mm` in the hand, to the end of the hold at most.
    With forces: grip_force_n, mean of the hold by digit and of the palm; time_to_grasp_s, from `starts_s`
    until the hand grips (0 where it did before): until two of thumb, fingers and palm press; of fingertips
    alone, until thumb and fingers do. Where they do not before the hold, and the object is held, until one
    side presses, or else until anything does: the object rests on it, or it is opposed by a part of the hand
    that has no sensor;
    grip_margin, mean grip force of the hold (`grip_force`) over `needed_grip_n`, where that
    is known; grip_force_rmse_n against `target_n`; with `touching`, unwanted_contact_s, for how long until
    the end of the hold a part of the hand presses that should not: any before `starts_s`, then others.
    With fingertips: aperture_mm at `starts_s` (opening), when the hand grips (contact), as the mean of the
    hold (hold), and with `aperture` its RMSE from `starts_s` until the hand grips, or until the hold ends
    where it does not (rmse); where `aperture` is fingertips, fingertip_placement_mm is the RMS distance of
    the thumb's and the opposed tips from them, in the same time.
    With angles: wrist_extension_deg, mean of the hold; with `intended`, unwanted_motion_deg, RMS from
    `starts_s` to the end of the hold.
    charge_uc: charge of one phase, summed over all channels' pulses in the trial: the given pulses where the
    recording has the `charge` of the stimulator that `pulses` command, else the commanded pulses.
    grasps_until_fatigue: how many such grasps hold one after the other under unchanged stimulation, if grip
    force falls as the fitness of the muscles that close the hand falls from the first to the last instant of
    this trial; 0 where this one does not hold, infinite where fitness does not fall.

    A number that is not known is NaN (`held`: None), and `missing` has the reason in words under its name;
    None for a trial with a known number.
    """
    metrics: dict[str, Any] = {}
    for number in range(recording.trials):
        trial = _Trial(recording, score, number)
        for path, value, why in _of_trial(trial._replace(found=_found(trial))):
            put(metrics, path, value)
            note(metrics, path, number, recording.trials, why)
    return metrics


def _of_trial(trial: _Trial) -> Iterator[tuple[tuple[str, ...], Any, str | None]]:
    """Path and value of every metric of a trial, and the reason if it is missing."""
    for name, value in {**_object(trial), **_forces(trial), **_posture(trial), **_effort(trial)}.items():
        for path, item in (((name, part), each) for part, each in value.items()) \
                if isinstance(value, dict) else [((name,), value)]:
            known = item is not None and (isinstance(item, str) or math.isfinite(item))
            yield path, item, None if known else _why(trial, path)


def _why(trial: _Trial, path: tuple[str, ...]) -> str:
    """Reason why a metric of a trial is missing."""
    score, name = trial.score, ".".join(path)
    touch = (f"no two sides of the hand pressed together by more than {score.contact_n:g} N for "
             f"{LASTING_S:g} s" if score.forces else "contact forces are not scored")
    ended = f"the trial ended before {score.until_s:g} s, when the hold is over"
    if score.forces and trial.found.word == "incomplete":
        touch = f"{ended}: until then {touch}"
    whenever = {
        "time_to_grasp_s": touch, "aperture_mm.contact": touch,
        "aperture_mm.opening": f"no fingertips are recorded at {score.starts_s:g} s",
        "aperture_mm.rmse": ended if trial.found.word == "incomplete" else
        f"no aperture was given as a reference from {score.starts_s:g} s on",
        "fingertip_placement_mm": ended if trial.found.word == "incomplete" else
        f"no fingertips were given as a reference from {score.starts_s:g} s on",
        "charge_uc": "fewer than two samples of the pulses are recorded",
    }
    if name in whenever:
        return whenever[name]
    if trial.found.word == "incomplete":
        return ended
    if name == "grasps_until_fatigue":
        return _why_no_count(trial)
    whole = {
        "object_moved_mm": f"the object was not in the hand during the hold: {OUTCOMES[trial.found.word]}",
        "unwanted_motion_deg": "the movement asks for every freedom",
        "grip_force_rmse_n": "no grip force was given as a reference during the hold",
    }
    return whole.get(name, "what it is computed from was not recorded to the end of the hold")


def _why_no_count(trial: _Trial) -> str:
    """Reason why the number of grasps until fatigue is missing."""
    margin = _margin(trial)
    if math.isnan(margin):
        return "the least grip force is not known: set needed_n"
    if margin < 1.0:
        return ("what is measured presses by less than holds the object: it rests on the hand, or others "
                "carry it")
    _, fitness = trial.whole(str(trial.score.fitness))
    active = trial.hold(str(trial.score.activation)).mean(axis=0)
    if len(fitness) and math.isfinite(fitness_ratio(active, fitness[0], fitness[-1])):
        return "no end: fitness does not fall"
    return "no muscle that closes the hand is active during the hold"


def _between(signal: Signal, from_s: float, until_s: float) -> Array:
    """Values (n, ...) of an interval; one row of NaN if the trial ended before it."""
    seconds = signal.times_ns / NS_PER_S
    inside = (seconds >= from_s) & (seconds <= until_s)
    if reached_ns(signal.times_ns) >= round(until_s * NS_PER_S) and inside.any():
        return np.asarray(signal.values[inside])
    return np.full((1, *signal.values.shape[1:]), np.nan)


def _object(trial: _Trial) -> dict[str, Any]:
    """Metrics of the outcome of the object."""
    found = trial.found
    if found.word == "incomplete":
        return {"object_outcome": found.word, "held": None, "object_moved_mm": math.nan, "held_s": math.nan}
    return {"object_outcome": found.word, "held": found.word == "held",
            "object_moved_mm": 1e3 * found.moved_m, "held_s": found.held_s}


def _found(trial: _Trial) -> Found:
    """Outcome of the object; `incomplete` if the trial ended before the hold."""
    score = trial.score
    if np.isnan(trial.hold(score.object)).any():
        return Found("incomplete", math.nan, math.nan)
    return find_outcome(_course(trial), score.from_s, score.until_s, 1e-3 * score.within_mm)


def _course(trial: _Trial) -> ObjectCourse:
    """Motion of the object in a trial, that of the hand where it is known, and the tables of the hand's node.

    A wrist that gives way moves a held object along.
    """
    score = trial.score
    times_s, places = trial.whole(score.object)
    node_name = score.object.partition(".")[0]
    node = trial.recording.experiment["blocks"].get(node_name, {})
    thing, table = _known(node.get("object"), OBJECT_KEYS), _known(node.get("table"), TABLE_KEYS)

    def at_rows(name: str) -> Array:
        signal = trial.recording.signal(name, trial.number)
        return held((signal.times_ns, np.asarray(signal.values)), _ns(times_s))

    hand, in_hand = np.zeros_like(places), places
    if score.hand_position is not None and score.hand_orientation is not None:
        hand, turn = (at_rows(name)[:, HAND] for name in (score.hand_position, score.hand_orientation))
        in_hand = quaternion.rotate(quaternion.conjugate(turn), places - hand)
    turned = np.tile(thing["orientation"] if thing else (1.0, 0.0, 0.0, 0.0), (times_s.size, 1))
    if f"{node_name}.object_orientation" in trial.recording.signals:
        turned = at_rows(f"{node_name}.object_orientation")
    pressed = None if score.forces is None else np.any(at_rows(score.forces) > score.contact_n, axis=1)
    return ObjectCourse(times_s=times_s, places=places, hand=hand, in_hand=in_hand, turned=turned,
                        pressed=None if pressed is None else np.asarray(pressed), thing=thing, table=table)


def _known(table: Any, keys: frozenset[str]) -> dict[str, Any] | None:
    """A node's table if it has the keys of the hand's; the plant of another package may have others."""
    return table if isinstance(table, dict) and keys <= set(table) else None


def _contact_s(trial: _Trial) -> float:
    """Instant at which the hand grips; NaN if it does not, or forces are not recorded."""
    score = trial.score
    if score.forces is None:
        return math.nan
    times_s, forces = trial.whole(score.forces)
    both_s = contact_s(times_s, forces, score.starts_s, score.contact_n)
    if trial.found.word != "held" or both_s <= score.from_s:
        return both_s
    # What is held without its table is pressed by something when the hold begins, however lightly.
    found_s = (contact_s(times_s, forces, score.starts_s, limit_n, one_side=True)
               for limit_n in (score.contact_n, 0.0))
    return next((each_s for each_s in found_s if each_s <= score.from_s), both_s)


def _needed_n(trial: _Trial) -> float:
    """Least grip force that holds the object; NaN if it is unknown."""
    if trial.score.needed_n is not None:
        return trial.score.needed_n
    return needed_grip_n(trial.recording.experiment["blocks"].get(trial.score.object.partition(".")[0], {}))


def _margin(trial: _Trial) -> float:
    """Ratio of the grip force of the hold to the least one; NaN if that is unknown."""
    assert trial.score.forces is not None
    forces = trial.hold(trial.score.forces)
    return float(grip_force(forces, places_of(forces)).mean()) / _needed_n(trial)


def _forces(trial: _Trial) -> dict[str, Any]:
    """Metrics of contact forces."""
    score = trial.score
    if score.forces is None:
        return {}
    forces = trial.hold(score.forces)
    metrics: dict[str, Any] = {
        "grip_force_n": {digit: float(force)
                         for digit, force in by_digit(forces.mean(axis=0), places_of(forces)).items()},
        "time_to_grasp_s": _contact_s(trial) - score.starts_s}
    if not math.isnan(_needed_n(trial)):
        metrics["grip_margin"] = _margin(trial)
    if score.touching:
        metrics["unwanted_contact_s"] = _unwanted_contact_s(trial, score.forces)
    if score.target_n is not None:
        signal = trial.recording.signal(score.target_n, trial.number)
        times_s, every = trial.whole(score.forces)
        inside = (times_s >= score.from_s) & (times_s <= score.until_s)
        target = held((signal.times_ns, np.asarray(signal.values)), _ns(times_s[inside]))
        errors = grip_force(every[inside], places_of(every)) - target
        metrics["grip_force_rmse_n"] = math.nan if np.isnan(forces).any() else rms_known(errors)
    return metrics


def _unwanted_contact_s(trial: _Trial, name: str) -> float:
    """How long until the end of the hold a part of the hand presses on the object that should not."""
    score = trial.score
    forces = trial.between(name, 0.0)
    if np.isnan(forces).any():
        return math.nan
    wanted = np.array([place.startswith(score.touching) for place in places_of(forces)])
    times_s, _ = trial.whole(name)
    times_s = times_s[times_s <= score.until_s]
    pressing = forces > score.contact_n
    unwanted = np.where(times_s < score.starts_s, pressing.any(axis=1), pressing[:, ~wanted].any(axis=1))
    return float(np.diff(times_s, append=times_s[-1]) @ unwanted)


def _posture(trial: _Trial) -> dict[str, Any]:
    """Metrics of angles and fingertips."""
    score = trial.score
    metrics: dict[str, Any] = {}
    if score.fingertips is not None:
        metrics |= _apertures_mm(trial, score.fingertips)
    if score.angles is not None:
        metrics["wrist_extension_deg"] = wrist_extension_deg(trial.hold(score.angles))
        if score.intended:
            metrics["unwanted_motion_deg"] = unwanted_motion_deg(trial.closing(score.angles), score.intended)
    return metrics


def _apertures_mm(trial: _Trial, name: str) -> dict[str, Any]:
    """Aperture at the start, at contact and in the hold, its error, and that of the tips."""
    score, touched_s = trial.score, _contact_s(trial)
    times_s, fingertips = trial.whole(name)
    ways = 1e3 * aperture(fingertips, score.opposed)
    at = [score.starts_s, *(() if math.isnan(touched_s) else (touched_s,))]
    opening, *contact = held((_ns(times_s), ways), _ns(np.array(at)))
    # The end of the last row is rounded up by 1 ns: that instant itself has no row.
    begun = reached_ns(_ns(times_s)) > round(score.starts_s * NS_PER_S) + 1
    metrics = {"opening": float(opening) if begun else math.nan,
               "contact": float(contact[0]) if contact else math.nan,
               "hold": float(1e3 * aperture(trial.hold(name), score.opposed).mean())}
    if score.aperture is not None:
        before = (times_s >= score.starts_s) & (times_s <= min(
            score.until_s, touched_s if contact else score.until_s))
        signal = trial.recording.signal(score.aperture, trial.number)
        target = held((signal.times_ns, np.asarray(signal.values)), _ns(times_s[before]))
        whole = bool(contact) or not math.isnan(metrics["hold"])
        errors = ways[before] - 1e3 * aperture(target, score.opposed)
        metrics["rmse"] = rms_known(errors) if whole else math.nan
        if target.ndim == 3:
            tips = [0, *(FINGERS.index(finger) for finger in score.opposed)]
            apart = 1e3 * np.linalg.norm(fingertips[before][:, tips] - target[:, tips], axis=2)
            return {"aperture_mm": metrics, "fingertip_placement_mm": rms_known(apart) if whole else math.nan}
    return {"aperture_mm": metrics}


def _effort(trial: _Trial) -> dict[str, Any]:
    """Metrics of charge and fatigue."""
    score = trial.score
    metrics: dict[str, Any] = {}
    if score.pulses is not None:
        node = trial.recording.experiment["blocks"][score.pulses.partition(".")[0]]
        given = given_signal(trial.recording, score.pulses)
        if given is not None:
            node = trial.recording.experiment["blocks"][given.partition(".")[0]]
        metrics["charge_uc"] = 1e6 * charge_c(*trial.whole(given or score.pulses),
                                              float(Fraction(node["frequency_hz"])))
    if score.activation is not None and score.fitness is not None:
        _, fitness = trial.whole(score.fitness)
        active = trial.hold(score.activation).mean(axis=0)
        ratio = fitness_ratio(active, fitness[0], fitness[-1]) if len(fitness) else math.nan
        failed = trial.found.word not in ("held", "incomplete")
        metrics["grasps_until_fatigue"] = 0.0 if failed else grasps_until_fatigue(_known_margin(trial), ratio)
    return metrics


def _known_margin(trial: _Trial) -> float:
    """Grip margin that predicts the failure of grasps.

    NaN where the object is held by less grip force than is needed: then it rests on the hand in part, or
    parts carry it whose load is not measured.
    """
    margin = _margin(trial)
    return math.nan if trial.found.word == "incomplete" or margin < 1.0 else margin


def _ns(seconds: Array) -> NDArray[np.int64]:
    return np.round(seconds * NS_PER_S).astype(np.int64)
