"""Fit of the error models to the fitted half of two papers' figures, by approximate Bayesian computation.

    python -m fesloop.apps.reproduce.fit_error_model salchow2019 48 3 2019 4
    python -m fesloop.apps.reproduce.fit_error_model kortier2014 40 3 2014 4

(particles, rounds, seed, processes) simulates the fitted half alone, and writes the posterior to
`published/PAPER_posterior.json`. Particles are hyperparameters, as shares of their priors, with the seeds of
a replicate, so that a room or a subject that fits is kept for the prediction. All have uniform priors. Each
round drops the half of the particles with the larger distances, resamples the others, and moves the copies
by a symmetric kernel that accepts whatever is nearer than the tolerance, which is the median distance
(Drovandi and Pettitt 2011, doi 10.1111/j.1541-0420.2010.01410.x, with one move for each copy).
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce import kortier2014, salchow2019
from fesloop.apps.reproduce.cohort import Attempt, Job, run_jobs
from fesloop.apps.reproduce.error_model import PRIORS, theta_at
from fesloop.errors import InputError

Array = NDArray[np.float64]
Statistics = dict[str, float]
_GREATEST_SEED = 2**31 - 1
_JITTER = 0.7
"""Step of a move, in standard deviations of the particles (chosen)."""
_NEW_SEED = 0.5
"""Probability with which a move exchanges the seed of a room (chosen)."""


@dataclass(frozen=True, slots=True)
class Particle:
    """A replicate.

    Attributes
    ----------
    shares: (d,), hyperparameters as shares of their priors. seeds: of the replicate.
    statistics: of the fitted half, logarithms. distance: from the published statistics.
    """

    shares: Array
    seeds: tuple[int, ...]
    statistics: Statistics
    distance: float = np.inf


@dataclass(frozen=True, slots=True)
class Fit:
    """Fitted half of a paper, and how particles are moved.

    Attributes
    ----------
    paper: name. seeds: number of seeds of a replicate.
    jobs: function of particle's theta and seeds, which returns jobs of the fitted half.
    statistics: function of what jobs kept. published: the same of the paper.
    blocks: hyperparameters and positions of rooms' seeds that a move changes together; a block without names
        exchanges one subject's seed.
    rooms, subjects: numbers of the first seeds, which belong to rooms, and of those of subjects after them.
    """

    paper: str
    seeds: int
    jobs: Callable[[dict[str, float], Sequence[int]], list[Job]]
    statistics: Callable[[dict[Any, Any]], Statistics]
    published: Statistics
    blocks: tuple[tuple[tuple[str, ...], tuple[int, ...]], ...]
    rooms: int
    subjects: int


def _salchow_jobs(theta: dict[str, float], seeds: Sequence[int]) -> list[Job]:
    return [job for motion in ("A-F1", "A-F2", "A-F3", "P1", "P3")
            for job in salchow2019.replicate(theta, seeds, motion)]


def _salchow_statistics(kept: dict[Any, Any]) -> Statistics:
    found = {}
    for method in salchow2019.METHODS:
        for motion in ("A-F1", "A-F2", "A-F3"):
            found[f"{motion} {method}"] = kept[motion, 0][method]["rmse"]
        for motion in ("P1", "P3"):
            each = [kept[motion, seat][method]["F1-F2"]["rmse"] for seat in range(4)]
            found |= _mean_and_sd(f"{motion} {method}", each)
    return _logs(found)


def _kortier_jobs(theta: dict[str, float], seeds: Sequence[int]) -> list[Job]:
    return [job for motion in ("flexion", "flat") for job in kortier2014.replicate(theta, seeds, motion, 1)]


def _kortier_statistics(kept: dict[Any, Any]) -> Statistics:
    flexion = kept["flexion", 0]["rms_mm"].mean(axis=0)
    found = dict(zip(kortier2014.AXES, map(float, flexion), strict=True))
    return _logs({**found, "range_deg": kept["flat", 2]["range_deg"], "sd_deg": kept["flat", 2]["sd_deg"]})


def _mean_and_sd(name: str, each: Sequence[float]) -> Statistics:
    return {name: float(np.mean(each)), f"{name}, sd": float(np.std(each, ddof=1))}


def _logs(found: Statistics) -> Statistics:
    return {name: float(np.log(value)) for name, value in found.items()}


def _salchow_published() -> Statistics:
    figures, found = salchow2019.FIGURES, {}
    for method in salchow2019.METHODS:
        for motion in ("A-F1", "A-F2", "A-F3"):
            found[f"{motion} {method}"] = figures[salchow2019.tip_key(motion, method)].value
        for motion in ("P1", "P3"):
            each = figures[salchow2019.distance_key(motion, "F1-F2", method)].each
            found |= _mean_and_sd(f"{motion} {method}", each)
    return _logs(found)


def _kortier_published() -> Statistics:
    figures = kortier2014.FIGURES
    found = {axis: figures[kortier2014.tip_key("flexion", axis)].value for axis in kortier2014.AXES}
    for what in ("range", "sd"):
        found[f"{what}_deg"] = figures[kortier2014.angle_key("flat", what)].value
    return _logs(found)


def _rest(paper: str, *others: str) -> tuple[str, ...]:
    return tuple(name for name in PRIORS[paper] if name not in others)


def fit_of(paper: str) -> Fit:
    """Fit of a paper by name."""
    blocks: tuple[tuple[tuple[str, ...], tuple[int, ...]], ...]
    if paper == "salchow2019":
        lab, room = ("lab_a_m2", "optical_deg", "optical_mm"), ("room_a_m2", "room_m")
        blocks = ((lab, (0,)), (room, (1,)), (_rest(paper, *lab, *room), ()), ((), ()))
        return Fit(paper, salchow2019.SEEDS, _salchow_jobs, _salchow_statistics, _salchow_published(), blocks,
                   rooms=2, subjects=4)
    if paper == "kortier2014":
        optical, room = ("optical_deg", "optical_mm"), ("room_a_m2", "room_m")
        blocks = ((optical, ()), (room, (0,)), (_rest(paper, *optical, *room), ()), ((), ()))
        return Fit(paper, kortier2014.SEEDS, _kortier_jobs, _kortier_statistics, _kortier_published(), blocks,
                   rooms=1, subjects=3)
    raise InputError("paper", repr(paper), ", ".join(PRIORS))


class Simulator:
    """Simulator of the fitted half, which keeps what each run gave, as moves change a part of the runs."""

    def __init__(self, fit: Fit, workers: int) -> None:
        self._fit, self._workers = fit, workers
        self._kept: dict[Hashable, Any] = {}

    def particles(self, points: Sequence[tuple[Array, tuple[int, ...]]]) -> list[Particle]:
        """Simulate points, shares and seeds; one with a run that fails has no statistics."""
        every = [self._jobs(*point) for point in points]
        missing = {known: Attempt((number,), job) for number, (known, job) in enumerate(
            (known, job) for jobs in every for known, job in jobs.items() if known not in self._kept)}
        results = run_jobs(list(missing.values()), self._workers)
        for known, attempt in missing.items():
            self._kept[known] = results[attempt.key]["kept"]
        found = []
        for (shares, seeds), jobs in zip(points, every, strict=True):
            kept = {job.key: self._kept[known] for known, job in jobs.items()}
            possible = all(each is not None for each in kept.values())
            found.append(Particle(shares, seeds, self._fit.statistics(kept) if possible else {}))
        return found

    def _jobs(self, shares: Array, seeds: tuple[int, ...]) -> dict[Hashable, Job]:
        theta = theta_at(self._fit.paper, shares)
        optical = theta["optical_deg"], theta["optical_mm"]
        return {(job.key[0], job.settings, job.seed, optical if job.key[0] in _OPTICAL else ()): job
                for job in self._fit.jobs(theta, seeds)}


_OPTICAL = ("A-F1", "A-F2", "A-F3", "flexion")


def sample(
    paper: str, particles: int, rounds: int, seed: int, workers: int, report: Callable[[str], None]
) -> list[Particle]:
    """Posterior of a paper's error model, the nearest first."""
    fit, rng = fit_of(paper), np.random.default_rng(seed)
    simulator, size = Simulator(fit, workers), len(PRIORS[paper])
    points = [(rng.uniform(size=size), _seeds(rng, fit.seeds)) for _ in range(particles)]
    found = simulator.particles(points)
    scale = _scale(found)
    found = _sorted([_measured(each, fit, scale) for each in found])
    for number in range(rounds):
        half = particles // 2
        tolerance = found[half - 1].distance
        spread = np.std([each.shares for each in found[:half]], axis=0)
        report(f"round {number + 1}: tolerance {tolerance:.3f}, nearest {found[0].distance:.3f}")
        old = [found[int(rng.integers(half))] for _ in range(particles - half)]
        new = [_measured(each, fit, scale)
               for each in simulator.particles([_proposal(each, fit, spread, rng) for each in old])]
        accepted = [each.distance <= tolerance for each in new]
        report(f"{sum(accepted)} of {len(new)} moves accepted")
        moved = [new[i] if accepted[i] else old[i] for i in range(len(new))]
        found = _sorted(found[:half] + moved)
    return found


def _seeds(rng: np.random.Generator, count: int) -> tuple[int, ...]:
    return tuple(int(each) for each in rng.integers(_GREATEST_SEED, size=count))


def _sorted(particles: list[Particle]) -> list[Particle]:
    return sorted(particles, key=lambda each: each.distance)


def _scale(particles: Sequence[Particle]) -> dict[str, float]:
    """Median absolute deviation of each statistic in the prior."""
    rows = [each.statistics for each in particles if each.statistics]
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return {name: float(np.median(np.abs(column - np.median(column)))) for name, column in columns.items()}


def _measured(particle: Particle, fit: Fit, scale: dict[str, float]) -> Particle:
    if not particle.statistics:
        return particle
    gaps = [(particle.statistics[name] - theirs) / scale[name] for name, theirs in fit.published.items()]
    return replace(particle, distance=float(np.sqrt(np.mean(np.square(gaps)))))


def _proposal(
    old: Particle, fit: Fit, spread: Array, rng: np.random.Generator
) -> tuple[Array, tuple[int, ...]]:
    """Move a random block; steps are reflected at the ends of the prior, so that moves are symmetric."""
    names, rooms = fit.blocks[int(rng.integers(len(fit.blocks)))]
    shares, seeds = old.shares.copy(), list(old.seeds)
    chosen = np.array([name in names for name in PRIORS[fit.paper]])
    step = _JITTER * spread * rng.standard_normal(shares.size)
    shares[chosen] = _reflected((shares + step)[chosen])
    for place in rooms:
        if rng.uniform() < _NEW_SEED:
            seeds[place] = int(rng.integers(_GREATEST_SEED))
    if not names:
        place = fit.rooms + int(rng.integers(fit.subjects))
        seeds[place] = int(rng.integers(_GREATEST_SEED))
    return shares, tuple(seeds)


def _reflected(shares: Array) -> Array:
    """Shares folded into [0, 1]."""
    folded = np.mod(shares, 2.0)
    return np.asarray(np.where(folded > 1.0, 2.0 - folded, folded))


def table_of(paper: str, particles: Sequence[Particle], settings: dict[str, int]) -> dict[str, Any]:
    """Table of a posterior for its file."""
    published, near = fit_of(paper).published, particles[:len(particles) // 2]
    gaps = [[each.statistics[name] - theirs for name, theirs in published.items()] for each in near]
    return {"paper": paper, "method": settings, "hyperparameters": list(PRIORS[paper]),
            "model_error": round(float(np.sqrt(np.mean(np.square(gaps)))), 4),
            "particles": [{"shares": [round(float(share), 6) for share in each.shares],
                           "seeds": list(each.seeds), "distance": round(each.distance, 4)}
                          for each in particles]}


def main(paper: str, particles: int, rounds: int, seed: int, workers: int) -> None:
    """Fit a paper's model and write its file."""
    found = sample(paper, particles, rounds, seed, workers,
                   lambda line: print(line, file=sys.stderr, flush=True))
    path = Path(__file__).parent / "published" / f"{paper}_posterior.json"
    table = table_of(paper, found, {"particles": particles, "rounds": rounds, "seed": seed})
    path.write_text(json.dumps(table, indent=1) + "\n")


if __name__ == "__main__":
    main(sys.argv[1], *(int(each) for each in sys.argv[2:6]))
