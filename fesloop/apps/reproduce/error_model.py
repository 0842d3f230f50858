"""Hierarchical error model of the reproductions of two papers: room, subject, placement, trial.

A virtual paper has hyperparameters theta, the sizes of its error sources, and seeds, those of its rooms and
of its subjects. Everything shared is sampled at its own level: iron by the seed of the room; bones, joint
axes and the length of the hand by that of the subject; the pose that is held, the mounting of the sensors
(half of its variance common to a strip), their sag and the optical frame by that of the placement; noise and
the scatter of postures differ between trials.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.cohort import Attempt, Job, Kept, Key, Progress, run_jobs
from fesloop.experiment import registry
from fesloop.forms.toml import toml_value
from fesloop.hand import quaternion

Array = NDArray[np.float64]
Theta = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Prior:
    """Log-uniform prior of a hyperparameter, from `low` to `high`, and its reason."""

    low: float
    high: float
    reason: str

    def at(self, share: float) -> float:
        """Value below which a share of the prior lies."""
        return float(self.low * (self.high / self.low) ** share)


_S19 = "doi 10.3390/s19010208, section 5"
_COMMON = {
    "length": Prior(0.005, 0.06, f"sd of bones' lengths, log: a few per cent ({_S19})"),
    "joint_mm": Prior(1.0, 8.0, "sd of each digit's first joint on the palm, mm (chosen)"),
    "axis_deg": Prior(2.0, 12.0, f"root mean square tilt of joint axes: 5 to 10 deg ({_S19})"),
    "pose_deg": Prior(1.0, 12.0, "sd of each angle of the initial pose, deg (chosen)"),
    "sag_deg": Prior(0.5, 5.0, "sd of the sag of sensors on skin by 1 g, deg (chosen)"),
    "optical_deg": Prior(0.5, 8.0, "rotation of the optical frame against the inertial one, root mean "
                         "square, deg (chosen; misalignment is the primary contribution in "
                         "doi 10.1186/1743-0003-11-70, Discussion)"),
    "optical_mm": Prior(0.5, 8.0, "displacement of the optical origin, and of each marker, sd along each "
                        "axis, mm (chosen)"),
    "magnet_ut": Prior(0.3, 10.0, "hard iron left in each magnetometer, sd of each axis, uT (chosen)"),
}
PRIORS: dict[str, dict[str, Prior]] = {
    "salchow2019": {
        **_COMMON,
        "mounting_deg": Prior(2.0, 15.0, f"sensor on segment, root mean square: 5 to 10 deg ({_S19})"),
        "thumb": Prior(1.0, 3.0, "factor on axes, joint, pose and mounting of the thumb: its alignment is "
                       f"more challenging ({_S19}; range chosen)"),
        "lab_a_m2": Prior(1e-3, 0.3, "moment of each piece of iron in the laboratory, A m^2 (chosen)"),
        "room_a_m2": Prior(1e-2, 3.0, "the same in the furnished room (chosen)"),
        "room_m": Prior(0.02, 0.5, "distance of its nearest piece from the hand in the initial pose, m "
                        "(chosen)"),
    },
    "kortier2014": {
        **_COMMON,
        "repeat_deg": Prior(0.05, 2.0, "scatter of each angle between repetitions of a posture, sd, deg "
                            "(chosen)"),
        "bias_rad_s": Prior(2e-4, 3e-3, "constant bias of gyroscopes, sd of each axis, rad/s (chosen)"),
        "room_a_m2": Prior(1e-3, 0.3, "moment of each piece of iron in the room, A m^2 (chosen)"),
        "room_m": Prior(0.02, 0.5, "distance of its nearest piece from the hand, m (chosen)"),
    },
}
"""Priors by paper and hyperparameter."""
MOUNTED_DEG = 7.6
"""Root mean square of angles between 5 and 10 deg: sensors before the calibration of doi
10.1186/1743-0003-11-70, which removes it (chosen, of the order of doi 10.3390/s19010208)."""
STATED = {"length": 0.03, "joint_mm": 3.0, "axis_deg": MOUNTED_DEG, "sag_deg": 1.5, "pose_deg": 0.0}
"""Error sizes that doi 10.3390/s19010208, section 5, states: lengths a few per cent, axes 5 to 10 deg;
joints on the palm and sag are chosen."""
UNFITTED: dict[str, tuple[int, ...]] = {"salchow2019": (), "kortier2014": (2, 4, 5, 6, 7)}
"""Positions of the seeds of subjects whose figures are not fitted: they are others in each virtual paper."""
FROZEN: dict[str, str] = {"salchow2019": "0f268e5b", "kortier2014": "d6301428"}
"""Commit of the posterior of each paper, before which nothing of the predicted half was simulated."""
PIECES = 3
"""Pieces of iron in a room (chosen: frame and legs of a table, a computer)."""
_FARTHEST_M = 0.5
_ABOVE_WRIST = np.array([0.0, 0.09, 0.0])
"""The hand in the initial pose, from the wrist, m: the middle of its back, fingers to the north."""


def theta_at(paper: str, shares: Array) -> dict[str, float]:
    """Hyperparameters at shares of their priors, (d,), in the priors' order."""
    return {name: prior.at(float(share))
            for (name, prior), share in zip(PRIORS[paper].items(), shares, strict=True)}


@dataclass(frozen=True, slots=True)
class VirtualPaper:
    """A replicate: its hyperparameters, and the seeds of its rooms and subjects."""

    theta: dict[str, float]
    seeds: tuple[int, ...]


def posterior(paper: str, papers: int) -> list[VirtualPaper]:
    """Virtual papers, (papers,), from the frozen posterior of a paper; more than there are begin again.

    `fesloop.apps.reproduce.fit_error_model` made it, in published/PAPER_posterior.json. It is the half of the
    particles that is nearest to the fitted figures, in a random order; equal particles count as often as they
    occur. Subjects without fitted figures are sampled anew.
    """
    every = _frozen(paper)["particles"]
    particles = every[:len(every) // 2]
    rng = np.random.default_rng(len(particles))
    order = rng.permutation(len(particles))
    found = []
    for number in range(papers):
        chosen = particles[order[number % len(order)]]
        seeds = list(chosen["seeds"])
        for place in UNFITTED[paper]:
            seeds[place] = int(rng.integers(2**31 - 1))
        found.append(VirtualPaper(theta_at(paper, np.array(chosen["shares"])), tuple(seeds)))
    return found


def with_model_error(paper: str, figures: Mapping[str, Array], seed: int = 0) -> dict[str, Array]:
    """Figures of virtual papers, (papers,), each with the error that the model has after its fit.

    Particles do not meet the fitted figures exactly. With the distribution of their logarithmic gaps as that
    of the model's error, approximate Bayesian computation is exact (Wilkinson 2013, doi
    10.1515/sagmb-2013-0010). So each figure of each paper has a lognormal factor whose sd is the root mean
    square gap; without one in the frozen posterior there is no error.
    """
    sd = _frozen(paper).get("model_error", 0.0)
    rng = np.random.default_rng(seed)
    return {key: values * np.exp(sd * rng.standard_normal(values.shape)) for key, values in figures.items()}


def _frozen(paper: str) -> dict[str, Any]:
    text = files(__package__).joinpath("published", f"{paper}_posterior.json").read_text()
    found: dict[str, Any] = json.loads(text)
    return found


def simulated(
    papers: Sequence[VirtualPaper], jobs: Callable[[VirtualPaper], Sequence[Job]], workers: int,
    progress: Progress | None = None
) -> list[dict[Key, Kept]]:
    """Simulate virtual papers: what each kept, by key of its jobs.

    Papers with a run that fails, as where a hand cannot bring two points together, are left out; equal papers
    are simulated once.
    """
    every = [{job.key: job for job in jobs(paper)} for paper in papers]
    unlike = {(job.settings, job.seed, repr(job.score)): job for each in every for job in each.values()}
    attempts = [Attempt((number,), job) for number, job in enumerate(unlike.values())]
    kept = run_jobs(attempts, workers, progress)
    by_run = {run: kept[number,]["kept"] for number, run in enumerate(unlike)}
    found = [{key: by_run[job.settings, job.seed, repr(job.score)] for key, job in each.items()}
             for each in every]
    return [each for each in found if all(value is not None for value in each.values())]


def person_settings(theta: Theta, seed: int, placement: int) -> tuple[str, ...]:
    """Settings that make a left-handed virtual subject of an experiment, with sensors as put on that day.

    The subject is a member of the cohort of able-bodied adults, whose spreads are those of `theta`; `seed`
    and `placement` are those of member and day.
    """
    kind: Any = registry.patient_reader().load("able_bodied")
    spread = replace(kind.cohort, hand_mm=_HAND_MM, width_mm=0.0, length=theta["length"],
                     joint_mm=theta["joint_mm"], axis_deg=theta["axis_deg"])
    day = replace(kind.day, mounting_deg=theta.get("mounting_deg", MOUNTED_DEG), sag_deg=theta["sag_deg"],
                  pose_deg=theta["pose_deg"], ruler_mm=_RULER_MM)
    kind = replace(kind, anthropometry=replace(kind.anthropometry, side="left"), cohort=spread, day=day)
    person = kind.member(cohort=seed, number=0).on_day(placement).table()
    person = _with_thumb(person, theta.get("thumb", 1.0))
    return "patient.file=able_bodied", f"patient.drawn={toml_value(_stated(person))}"


_HAND_MM, _RULER_MM = 9.8, 2.0
"""Sd of the lengths of hands (ANSUR 1988, either sex: 9.7 to 9.9, recalled) and of the ruler's error
(chosen), mm."""
_OF_THUMB = (("anatomy", "axes_deg", 30.0), ("anatomy", "joints_mm", 20.0),
             ("sensors", "mounting_deg", 45.0), ("calibration", "pose_error_deg", 60.0))
"""Tables of a person with deviations of the thumb, and the largest that a person may have."""


def _with_thumb(person: dict[str, Any], factor: float) -> dict[str, Any]:
    """The person's table with deviations of the thumb scaled."""
    for section, key, most in _OF_THUMB:
        table = person.get(section, {}).get(key, {})
        for name in table:
            if name.startswith("F1"):
                scaled = np.clip(factor * np.array(table[name]), -most, most)
                table[name] = scaled.tolist()
    return person


def _stated(value: Any) -> Any:
    """The same tables without keys of no value."""
    if isinstance(value, Mapping):
        return {key: _stated(each) for key, each in value.items() if each is not None}
    return value


def room_settings(moment: float, nearest_m: float | None, seed: int, nodes: Sequence[str]) -> tuple[str, ...]:
    """Settings that put iron into the room of a seed, for the sensors of `nodes`.

    Pieces are dipoles of random direction, beside or below the hand in its initial pose, at distances that
    are log-uniform from 2 to 50 cm; the nearest is at `nearest_m`, if given, and the others are farther.
    """
    rng = np.random.default_rng([seed, 2019])
    shares, towards, direction = rng.uniform(size=PIECES), *rng.standard_normal((2, PIECES, 3))
    low = 0.02 if nearest_m is None else nearest_m
    distances = low * (_FARTHEST_M / low) ** shares
    if nearest_m is not None:
        distances[0] = nearest_m
    towards[:, 2] = -np.abs(towards[:, 2])
    places = _ABOVE_WRIST + distances[:, np.newaxis] * _unit(towards)
    dipoles = [{"position": place.tolist(), "moment": (moment * way).tolist()}
               for place, way in zip(places, _unit(direction), strict=True)]
    table = toml_value(dipoles)
    return tuple(f"blocks.{node}.magnetic_field.dipoles={table}" for node in nodes)


def _unit(rows: Array) -> Array:
    return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True))


@dataclass(frozen=True, slots=True)
class Reference:
    """An optical reference on one placement: frame turned by `turn` (4,), origin and markers displaced.

    `shift` (5, 3) is that of F1 to F5, m.
    """

    turn: Array
    shift: Array

    def of(self, tips: Array) -> Array:
        """Measured positions (n, 5, 3) of fingertips."""
        return np.asarray(quaternion.rotate(self.turn, tips) + self.shift)


def reference(theta: Theta, seed: int) -> Reference:
    """Optical reference of a subject's placement."""
    rng = np.random.default_rng([seed, 1849])
    turn = math.radians(theta["optical_deg"]) / math.sqrt(3.0) * rng.standard_normal(3)
    angle = float(np.linalg.norm(turn))
    origin, markers = rng.standard_normal(3), rng.standard_normal((5, 3))
    return Reference(quaternion.from_axis_angle(turn / angle, angle),
                     1e-3 * theta["optical_mm"] * (origin + markers))
