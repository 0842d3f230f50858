"""Steady torque that stimulation evokes in held arms: predicted postures of a person, and predicted people.

Two questions on the recordings of a device that held stimulated arms in 24 postures:

- a person's other 16 postures from 8 (sorted by code, every third): by a person of `ArmPopulation`, by the
  mean of each electrode, and by lines in the angles. Errors are root mean squares over the standard
  deviation of a repeat, mean squares averaged over people; a perfect prediction has .58, as a cell is the
  mean of three;
- a person from the others alone: mean torque over postures of each electrode and joint, against the 90 % band
  of random people, and its log density. Beside it Student's distribution of the other people's values.

A person whom the shipped population does not contain is predicted by it as it is; one whom it contains, by a
population of the others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp
from scipy.stats import norm, t

from fesloop.analysis.people.population import ArmPopulation, Cells, Trials, trials_of
from fesloop.apps.reproduce.comparison import Row
from fesloop.apps.reproduce.people.part import Part
from fesloop.apps.reproduce.result import Sweep
from fesloop.hand.muscle_paths import JOINTS
from fesloop.models.evoked_torque import Postures, Spreads, Weights, features
from fesloop.streams.stimulation import StimulationRecording, open_stimulation

Array = NDArray[np.float64]
SURE = 2.0
"""Standard deviations of a repeat beyond which a sign counts."""
BARS = (0.86, 0.82, 0.95, 0.97)
"""The least errors of a mean, lines and a Gaussian process on five people, by joint."""
STRETCH = 0.80
COVERED = (0.80, 0.97)
FEW = 6
"""Every sixth posture is known in the figure of a person's posterior from few postures."""


@dataclass(frozen=True, slots=True)
class Posture:
    """Errors of predicted postures of one person.

    Attributes
    ----------
    errors: by prediction, (cells, 4), N m.
    scale_nm: (4,), standard deviation of a repeat.
    right, sure: (4,), cells with the right sign, of those with a sure one.
    by_electrode: of each with trials in all postures: codes, measured torque, and the predicted one with the
        standard deviation of their difference.
    """

    errors: dict[str, Array]
    scale_nm: Array
    right: Array
    sure: Array
    by_electrode: dict[str, dict[str, Any]]


@dataclass(frozen=True, slots=True)
class Unseen:
    """Mean torque of a person who was not seen.

    Attributes
    ----------
    inside: (electrodes, 4), whether it is in the 90 % band.
    log_density, others_log_density: (electrodes, 4), of random people, and of Student's distribution of
        the others (NaN where there are fewer than three).
    """

    inside: NDArray[np.bool_]
    log_density: Array
    others_log_density: Array


def recordings(folder: Path) -> list[StimulationRecording]:
    """People with steady trials."""
    found = [open_stimulation(path) for path in sorted(folder.glob("S*.npz")) if "_" not in path.stem]
    return [each for each in found if each.steady is not None]


def populations(people: Sequence[StimulationRecording]) -> dict[str, ArmPopulation]:
    """Population that predicts each person: the shipped one, or that of the others whom it contains."""
    shipped = ArmPopulation.shipped()
    known = {each.person: trials_of(each) for each in people if each.person in shipped.people}
    return {each.person: ArmPopulation.of([seen for name, seen in known.items() if name != each.person])
            if each.person in known else shipped for each in people}


def predicted_postures(recording: StimulationRecording, population: ArmPopulation) -> Posture:
    """Predict every posture but each third of a person from the thirds."""
    assert recording.steady is not None
    names = sorted(set(recording.steady.posture[recording.steady.stimulated].tolist()))
    known = trials_of(recording, names[::3])
    asked = trials_of(recording, [name for i, name in enumerate(names) if i % 3])
    every = trials_of(recording)
    scale = every.scale_nm
    person = population.person(known)
    errors: dict[str, list[Array]] = {"person": [], "mean": [], "lines": []}
    right, sure = np.zeros(len(JOINTS)), np.zeros(len(JOINTS))
    for electrode, cells in asked.cells.items():
        seen, angles = known.cells[electrode], cells.postures.angles
        guess = person.torque(electrode, angles)[0]
        for name, value in (("person", guess), ("mean", _mean(seen)), ("lines", _lines(seen, angles))):
            errors[name].append(value - cells.torque_nm)
        clear = np.abs(cells.torque_nm) > SURE * scale
        sure += clear.sum(axis=0)
        right += (clear & (np.sign(guess) == np.sign(cells.torque_nm))).sum(axis=0)
    shown = {}
    for electrode, cells in every.cells.items():
        mean, sd = person.torque(electrode, cells.postures.angles)
        noise = person.scale_nm / np.sqrt(cells.trials[:, np.newaxis])
        if len(cells.trials) == len(names):
            shown[electrode] = {"codes": names, "theirs_nm": cells.torque_nm, "ours_nm": mean,
                                "sd_nm": np.hypot(sd, noise)}
    return Posture({name: np.concatenate(each) for name, each in errors.items()}, scale, right, sure, shown)


def _mean(seen: Cells) -> Array:
    return np.asarray(np.average(seen.torque_nm, axis=0, weights=seen.trials))


def _lines(seen: Cells, angles: Array) -> Array:
    root = np.sqrt(seen.trials)[:, np.newaxis]
    known = np.column_stack([np.ones(len(seen.trials)), seen.postures.angles])
    found = np.linalg.lstsq(root * known, root * seen.torque_nm, rcond=None)[0]
    return np.asarray(np.column_stack([np.ones(len(angles)), angles]) @ found)


def predicted_person(trials: Trials, population: ArmPopulation, others: Sequence[Trials],
                     scales: Array, rng: np.random.Generator) -> Unseen:
    """Predict the mean torque of each electrode and joint of a person from a population alone."""
    inside, density, plain = [], [], []
    for electrode, cells in trials.cells.items():
        truth = cells.torque_nm.mean(axis=0)
        centre, variance = _moments(cells.postures, scales, population.spreads,
                                    population.newcomer(electrode))
        variance += scales**2 / cells.trials.sum()
        drawn = centre + np.sqrt(variance) * rng.normal(size=centre.shape)
        low, high = np.percentile(drawn, [5.0, 95.0], axis=0)
        inside.append((truth >= low) & (truth <= high))
        density.append(logsumexp(norm.logpdf(truth, centre, np.sqrt(variance)), axis=0) - np.log(len(scales)))
        plain.append(_others_log_density(truth, [each.cells[electrode].torque_nm.mean(axis=0)
                                                 for each in others if electrode in each.cells]))
    return Unseen(np.array(inside), np.array(density), np.array(plain))


def _moments(postures: Postures, scales: Array, spreads: Spreads, weights: Weights) -> tuple[Array, Array]:
    """Mean and variance (people, 4) of the mean torque over postures, at each of the scales (people, 4)."""
    centre, variance = np.empty_like(scales), np.empty_like(scales)
    unit = features(postures, np.ones(len(JOINTS)), spreads).mean(axis=0)
    muscles = postures.arms.shape[1]
    for i, scale in enumerate(scales):
        rows = unit * scale[:, np.newaxis]
        rows[:, :muscles] = unit[:, :muscles] * scale.mean()
        centre[i] = rows @ weights.mean
        variance[i] = np.einsum("jk,kl,jl->j", rows, weights.covariance, rows)
    return centre, variance


def learned(recording: StimulationRecording, population: ArmPopulation, random_people: int) -> dict[str, Any]:
    """Mean torque over all postures, N m, of a person, as it is known after none, few and all of them.

    `theirs_nm` (electrodes, 4) is the measured one, `intervals_nm` by number of postures known (3,
    electrodes, 4): percentiles 5, 50 and 95.
    """
    assert recording.steady is not None
    names = sorted(set(recording.steady.posture[recording.steady.stimulated].tolist()))
    every, rng = trials_of(recording), np.random.default_rng(0)
    known: dict[int, tuple[Spreads, Callable[[str], Weights], Array]] = {
        0: (population.spreads, population.newcomer, population.scales(random_people, rng))}
    for each in (names[::FEW], names):
        person = population.person(trials_of(recording, each))
        known[len(each)] = (person.spreads, person.weights.__getitem__,
                            np.tile(person.scale_nm, (random_people, 1)))
    intervals = {}
    for count, (spreads, weights, scales) in known.items():
        moments = [_moments(cells.postures, scales, spreads, weights(electrode))
                   for electrode, cells in every.cells.items()]
        drawn = [mean + np.sqrt(variance) * rng.normal(size=mean.shape) for mean, variance in moments]
        intervals[count] = np.percentile(drawn, [5.0, 50.0, 95.0], axis=1)
    seen = np.array([cells.torque_nm.mean(axis=0) for cells in every.cells.values()])
    return {"person": recording.person, "joints": JOINTS, "electrodes": list(every.cells),
            "theirs_nm": seen, "intervals_nm": intervals}


def _others_log_density(truth: Array, others: Sequence[Array]) -> Array:
    count = len(others)
    if count < 3:
        return np.full(truth.shape, np.nan)
    spread = np.std(others, axis=0, ddof=1) * np.sqrt(1.0 + 1.0 / count)
    return np.asarray(t.logpdf(truth, count - 1, np.mean(others, axis=0), spread))


@cache
def people_of(folder: Path) -> tuple[list[StimulationRecording], dict[str, ArmPopulation]]:
    """People with steady trials, and the population that predicts each."""
    people = recordings(folder)
    return people, populations(people)


def rows_and_sweeps(folder: Path, random_people: int) -> Part:
    """Rows of both questions, and errors by person."""
    people, by_person = people_of(folder)
    trials = {each.person: trials_of(each) for each in people}
    postures = [predicted_postures(each, by_person[each.person]) for each in people]
    unseen = []
    for seed, (name, seen) in enumerate(trials.items()):
        rng = np.random.default_rng(seed)
        population = by_person[name]
        others = [each for other, each in trials.items() if other != name]
        unseen.append(predicted_person(seen, population, others, population.scales(random_people, rng), rng))
    rows = [*_posture_rows(postures), *_unseen_rows(unseen)]
    kinds = tuple(postures[0].errors)
    sweep = Sweep(title="16 postures from 8: error over the standard deviation of a repeat", unit="1",
                  columns=tuple(f"{joint}, {kind}" for joint in JOINTS for kind in kinds),
                  rows=tuple((name, tuple(
                      float(_ratio([each], kind)[joint]) for joint in range(len(JOINTS)) for kind in kinds))
                      for name, each in zip(trials, postures, strict=True)))
    middle = int(np.argsort([_ratio([each], "person").mean() for each in postures])[len(postures) // 2])
    shown = {"person": list(trials)[middle], "joints": JOINTS, "by_electrode": postures[middle].by_electrode}
    most = max(people, key=lambda each: len(each.steady.muscle) if each.steady else 0)
    return Part(rows, {"postures": sweep}, {
        "postures": shown, "learned": learned(most, by_person[most.person], random_people)})


def _ratio(people: Sequence[Posture], kind: str) -> Array:
    return np.asarray(np.sqrt(np.mean([(each.errors[kind]**2).mean(axis=0) / each.scale_nm**2
                                       for each in people], axis=0)))


def _posture_rows(people: Sequence[Posture]) -> list[Row]:
    ours, plain = _ratio(people, "person"), {kind: _ratio(people, kind) for kind in ("mean", "lines")}
    table = "16 postures from 8: rms error over the sd of a repeat"
    rows = [Row(table, joint, f"{bar:g} or less (here: mean {plain['mean'][j]:.2f}, lines "
                f"{plain['lines'][j]:.2f})", f"{ours[j]:.2f}", bool(ours[j] <= bar))
            for j, (joint, bar) in enumerate(zip(JOINTS, BARS, strict=True))]
    flexion = JOINTS.index("wrist_flexion")
    rows.append(Row(table, "wrist_flexion, stretch", f"{STRETCH:.2f} or less", f"{ours[flexion]:.2f}",
                    bool(ours[flexion] <= STRETCH)))
    right, sure = (np.sum([getattr(each, key) for each in people], axis=0) for key in ("right", "sure"))
    share = right / np.maximum(sure, 1)
    rows += [Row("16 postures from 8: right signs of torques beyond 2 sd", joint,
                 ".98 or more" if j == flexion else "-", f"{share[j]:.2f} of {sure[j]:.0f}",
                 bool(j != flexion or share[j] >= 0.98)) for j, joint in enumerate(JOINTS)]
    return rows


def _unseen_rows(people: Sequence[Unseen]) -> list[Row]:
    inside = np.concatenate([each.inside for each in people])
    density, plain = (np.concatenate([getattr(each, key) for each in people])
                      for key in ("log_density", "others_log_density"))
    both = np.isfinite(plain).all(axis=1)
    table = "a person from the others: mean torque of each electrode and joint"
    covered = float(inside.mean())
    rows = [Row(table, "cells in the 90 % band", f"{COVERED[0]:.2f} to {COVERED[1]:.2f}",
                f"{covered:.2f} of {inside.size}", COVERED[0] <= covered <= COVERED[1])]
    if both.any():
        ours, theirs = float(density[both].mean()), float(plain[both].mean())
        rows.append(Row(table, "mean log density, beside other people's mean", f"{theirs:.2f}", f"{ours:.2f}",
                        ours > theirs, "1"))
    return rows


