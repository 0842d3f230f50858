"""How much stimulated muscle differs from trial to trial, from repeats of steady trials by the same pulses.

A muscle's torque at its strongest joint is that of its posture times 1 + e, plus what does not grow with
torque (readings, friction, effort). e has parts that are new in each trial or slow, of all muscles or of one.
Their variances have the greatest restricted likelihood: that of all contrasts between repeats, which no mean
of a posture enters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve, cholesky, helmert
from scipy.optimize import minimize

from fesloop.errors import InputError
from fesloop.hand.muscle_paths import JOINTS
from fesloop.models.arm_responses import FRICTION_NM
from fesloop.models.dry_friction import play
from fesloop.streams.stimulation import StimulationRecording

Array = NDArray[np.float64]
LEAST_MEAN = 0.5
"""Least mean torque of a muscle that counts, over the standard deviation of a repeat (chosen)."""
_LOG_SD, _LOG_SHARE, _PRIOR = -1.5, -0.3, 2.0
"""Centres of the normal priors of the logarithms: of sds of e, and of that of the rest over the scatter of
repeats; and the sd of either prior (chosen)."""


class Scatter(NamedTuple):
    """Standard deviations of e: new in each trial and slow, of all muscles together and of each besides."""

    trial: float
    muscle_trial: float
    drift: float
    muscle_drift: float


class Repeats(NamedTuple):
    """Contrasts between a person's repeats.

    Attributes
    ----------
    values: (n,), N m. weights: (n, trials), what they are of the trials' torques.
    torque: (trials,), usual torque of muscle, pulses and posture, N m: linear in the angles.
    muscle, visit: (trials,). time_s: (trials,).
    rest: (joints, trials), scatter of all repeats at the trial's joint, 0 at other joints, N m.
    """

    values: Array
    weights: Array
    torque: Array
    muscle: NDArray[np.int64]
    visit: NDArray[np.int64]
    time_s: Array
    rest: Array

    def covariances(self, drift_s: float) -> Array:
        """Covariance of the contrasts by unit of each variance, (4 + joints, n, n): of e, then the rest."""
        alike = np.equal.outer(self.muscle, self.muscle)
        slow = np.exp(-np.abs(np.subtract.outer(self.time_s, self.time_s)) / drift_s)
        shapes = (np.equal.outer(self.visit, self.visit), np.eye(len(alike)), slow, slow * alike)
        of_torque = [np.outer(self.torque, self.torque) * shape for shape in shapes]
        return np.array([self.weights @ each @ self.weights.T
                         for each in (*of_torque, *(np.diag(row**2) for row in self.rest))])


def repeats_of(recording: StimulationRecording) -> Repeats:
    """Contrasts of a recording's muscles with a clear torque. Raises InputError without repeated trials."""
    steady = recording.steady
    groups = [] if steady is None else steady.repeats()
    if steady is None or not any(len(rows) > 1 for rows in groups):
        raise InputError(recording.source, "has no repeated steady trials",
                         "each posture more than once by the same pulses")
    evoked, stimulus = steady.evoked_nm, steady.stimulus
    free = sum(len(rows) - 1 for rows in groups)
    sd = np.sqrt(sum(((evoked[rows] - evoked[rows].mean(axis=0)) ** 2).sum(axis=0)
                     for rows in groups) / free)
    joint, torque = np.full(len(steady), -1), np.zeros(len(steady))
    for number in np.unique(steady.muscle[steady.stimulated]):
        here = steady.muscle == number
        means = np.array([evoked[rows].mean(axis=0) for rows in groups if here[rows[0]]])
        size = np.sqrt((means**2).mean(axis=0))
        strongest = int(np.argmax(np.divide(size, sd, out=np.zeros_like(sd), where=sd > 0.0)))
        if sd[strongest] > 0.0 and abs(means[:, strongest].mean()) >= LEAST_MEAN * sd[strongest]:
            joint[here] = strongest
            for each in np.unique(stimulus[here]):
                rows = np.flatnonzero(stimulus == each)
                torque[rows] = _lines(steady.reference_rad[rows], evoked[rows, strongest])
    weights = []
    for rows in groups:
        if len(rows) > 1 and joint[rows[0]] >= 0:
            weights.append(np.zeros((len(rows) - 1, len(steady))))
            weights[-1][:, rows] = helmert(len(rows))
    used = joint >= 0
    if not weights:
        raise InputError(recording.source, "has no muscle of a clear torque",
                         f"{LEAST_MEAN:g} of the repeats' scatter or more")
    matrix = np.concatenate(weights)[:, used]
    own = evoked[used, joint[used]]
    rest = np.array([sd[j] * (joint[used] == j) for j in np.unique(joint[used])])
    return Repeats(matrix @ own, matrix, torque[used], steady.muscle[used], steady.visit[used],
                   steady.time_s[used], rest)


def _lines(angles: Array, values: Array) -> Array:
    """Values (n,) or (n, j) of least squares that are linear in the angles (n, joints)."""
    rows = np.column_stack([np.ones(len(angles)), angles])
    return np.asarray(rows @ np.linalg.lstsq(rows, values, rcond=None)[0])


def scatter_of(people: Sequence[Repeats], drift_s: float) -> Scatter:
    """Scatter that people share, at a correlation time of the slow parts; the rest is each joint's own."""
    known = [each.covariances(drift_s) for each in people]
    counts = [len(each) - len(Scatter._fields) for each in known]
    starts = len(Scatter._fields) + np.concatenate([[0], np.cumsum(counts)])
    centres = np.full(starts[-1], _LOG_SHARE)
    centres[:len(Scatter._fields)] = _LOG_SD

    def cost(logs: Array) -> tuple[float, Array]:
        left = (logs - centres) / _PRIOR
        total, slope = 0.5 * float(left @ left), left / _PRIOR
        for person, parts, start, count in zip(people, known, starts, counts, strict=False):
            which = np.r_[:len(Scatter._fields), start:start + count]
            variances = np.exp(2.0 * logs[which])
            lower = cholesky(np.tensordot(variances, parts, 1), lower=True)
            inverse = cho_solve((lower, True), np.eye(len(lower)))
            solved = inverse @ person.values
            total += float(np.log(np.diag(lower)).sum() + 0.5 * person.values @ solved)
            slope[which] += variances * (np.einsum("ij,kji->k", inverse, parts)
                                         - np.einsum("i,kij,j->k", solved, parts, solved))
        return total, slope

    found = minimize(cost, centres, jac=True, method="L-BFGS-B", bounds=[(-6.0, 1.0)] * len(centres))
    return Scatter(*np.exp(found.x[:len(Scatter._fields)]).tolist())


def simulated(recording: StimulationRecording, scatter: Scatter, drift_s: float, rng: np.random.Generator
              ) -> StimulationRecording:
    """The recording of people whose repeats scatter by `scatter` and by their device's friction alone.

    Torques are lines in the angles, fitted to the recorded ones and as much greater as friction hides.
    A visit begins anywhere within the friction; between two trials the torque is gone (chosen).
    """
    steady = recording.steady
    if steady is None:
        raise InputError(recording.source, "has no steady trials", "each posture more than once")
    friction = np.array([FRICTION_NM[JOINTS.index(name)] for name in recording.joints])
    evoked, stimulus = steady.evoked_nm, steady.stimulus
    torque = np.zeros(steady.device_torque_nm.shape)
    logs = np.zeros(len(steady))
    slow = cholesky(np.exp(-np.abs(np.subtract.outer(steady.time_s, steady.time_s)) / drift_s)
                    + 1e-9 * np.eye(len(steady)), lower=True)
    for number in np.unique(steady.muscle[steady.stimulated]):
        rows = np.flatnonzero(steady.muscle == number)
        logs[rows] = scatter.muscle_drift * (slow @ rng.normal(size=len(steady)))[rows]
    for number in np.unique(stimulus[steady.stimulated]):
        rows = np.flatnonzero(stimulus == number)
        torque[rows] = _lines(steady.reference_rad[rows], evoked[rows])
    logs += scatter.muscle_trial * rng.normal(size=len(steady))
    logs += scatter.drift * (slow @ rng.normal(size=len(steady)))
    logs += scatter.trial * rng.normal(size=steady.visit.max() + 1)[steady.visit]
    torque *= 1.0 + friction / np.hypot(torque, friction)
    torque *= np.exp(logs - 0.5 * np.square(scatter).sum())[:, np.newaxis]
    for number in np.unique(steady.visit):
        rows = np.flatnonzero(steady.visit == number)
        rows = rows[np.argsort(steady.order[rows])]
        course = np.zeros((2 * len(rows), len(friction)))
        course[1::2] = torque[rows]
        torque[rows] = play(course, friction, rng.uniform(-1.0, 1.0, len(friction)) * friction)[1::2]
    return replace(recording, steady=replace(steady, device_torque_nm=-torque))
