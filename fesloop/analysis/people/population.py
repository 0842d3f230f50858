"""A population of arms from recordings of people, and a person from their own few trials.

`ArmPopulation.of` estimates the spreads of `evoked_torque` by the marginal likelihood of all people's steady
trials, and keeps what is common to them. `ArmPopulation.person` continues from there with a person's own
trials: few of them leave the population's spread, many replace it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize, minimize_scalar
from scipy.special import expit, logit

from fesloop.errors import InputError
from fesloop.hand.muscle_paths import JOINTS
from fesloop.models.arm_people import ArmPeople, ArmPerson
from fesloop.models.evoked_torque import (
    Postures,
    Spreads,
    Weights,
    common_shares,
    features,
    log_density,
    muscles_under,
    scaled,
)
from fesloop.streams.stimulation import StimulationRecording

Array = NDArray[np.float64]
NEUTRAL_RAD = np.deg2rad([90.0, 0.0, 0.0, 0.0])
"""Angles of joints that a recording does not have."""
_START = Spreads(muscles=1.0, constants=(0.3,) * 4, slopes=(0.3,) * 4, curvatures=(0.3,) * 4,
                 common_muscles=0.5, common_constants=0.5, common_slopes=0.5, coupling=0.1)
"""Centre of the prior of the spreads' logarithms (shares: logits), whose standard deviation is 1 (chosen)."""
GAIN_LOG_SD, GAIN_LOGS = 0.3, (-2.5, 3.5)
"""Spread between people of the logarithm of a gain, and its bounds (chosen; of the five it is .14)."""
_LEAST_SCALE_NM = 1e-3
_ITERATIONS = 15


class Cells(NamedTuple):
    """Mean evoked torque of one electrode by posture.

    Attributes
    ----------
    postures: n of them.
    torque_nm: (n, j), of the recording's joints. trials: (n,), their numbers.
    """

    postures: Postures
    torque_nm: Array
    trials: NDArray[np.int64]


class Trials(NamedTuple):
    """A person's steady trials.

    Attributes
    ----------
    person: name.
    joints: (j,), rows of `JOINTS` that the recording has.
    cells: by electrode.
    scale_nm: (j,), standard deviation of a repeat, by the same pulses; NaN without repeats. free: its
        degrees of freedom.
    """

    person: str
    joints: NDArray[np.int64]
    cells: Mapping[str, Cells]
    scale_nm: Array
    free: int


def trials_of(recording: StimulationRecording, postures: Sequence[str] | None = None) -> Trials:
    """Steady trials of a recording, in all or the named postures.

    Raises InputError without any, or with a joint or electrode that the model does not have.
    """
    steady = recording.steady
    if steady is None:
        raise InputError(recording.source, "has no steady trials", "isometric trials, one row each")
    for name in recording.joints:
        if name not in JOINTS:
            raise InputError(f"{recording.source}: joints", f"{name!r}", f"of {', '.join(JOINTS)}")
    joints = np.array([JOINTS.index(name) for name in recording.joints])
    zero = np.where(np.isnan(recording.zero_rad), 0.0, recording.zero_rad)
    evoked = steady.evoked_nm
    found: dict[str, list[tuple[Array, Array, int]]] = {}
    for (muscle, posture), rows in steady.cells().items():
        if postures is not None and posture not in postures:
            continue
        electrode = recording.muscles[muscle]
        muscles_under(electrode, f"{recording.source}: muscles")
        angles = NEUTRAL_RAD.copy()
        angles[joints] = zero + steady.reference_rad[rows].mean(axis=0)
        found.setdefault(electrode, []).append((angles, evoked[rows].mean(axis=0), len(rows)))
    if not found:
        raise InputError(recording.source, "has no trial of a muscle" + (
            "" if postures is None else f" in {', '.join(postures)}"), "one or more")
    cells = {}
    for name, seen in found.items():
        angles, means, repeats = (np.array(column) for column in zip(*seen, strict=True))
        cells[name] = Cells(Postures.of(name, angles), means, repeats)
    squares, free = np.zeros(len(joints)), 0
    for rows in steady.repeats():
        if postures is None or steady.posture[rows[0]] in postures:
            squares += ((evoked[rows] - evoked[rows].mean(axis=0))**2).sum(axis=0)
            free += len(rows) - 1
    scale = np.maximum(np.sqrt(squares / free), _LEAST_SCALE_NM) if free else np.full(len(joints), np.nan)
    return Trials(recording.person, joints, cells, scale, free)


class ArmPopulation(ArmPeople):
    """People whose spreads are estimated from recordings, and whom a person's own trials tell apart."""

    __slots__ = ()

    @classmethod
    def of(cls, people: Sequence[Trials]) -> ArmPopulation:
        """Estimate a population from two people or more with repeated trials of all four joints.

        Raises InputError for fewer people or joints.
        """
        if len(people) < 2:
            raise InputError("population", f"{len(people)} people", "two or more")
        for each in people:
            if len(each.joints) < len(JOINTS) or not each.free:
                raise InputError(each.person, "lacks joints or repeated trials", "all of "
                                 f"{', '.join(JOINTS)}, each posture more than once")
        spreads = _fitted_spreads(people)
        electrodes = sorted({name for each in people for name in each.cells})
        logs = np.log([each.scale_nm for each in people])
        persons = logs.mean(axis=1)
        left = logs - logs.mean(axis=0) - (persons - persons.mean())[:, np.newaxis]
        free = (len(people) - 1) * (len(JOINTS) - 1)
        return cls(people=tuple(each.person for each in people), spreads=spreads,
                   common={name: _common(name, people, spreads) for name in electrodes},
                   scale_log_mean=logs.mean(axis=0), scale_log_sd=float(persons.std(ddof=1)),
                   scale_log_sd_joint=float(np.sqrt((left**2).sum() / free)))

    def person(self, trials: Trials) -> ArmPerson:
        """Posterior of a person after their own trials.

        How much torque a person's stimulation evokes for the scatter of its repeats, over what is usual, is
        the gain of greatest posterior density.
        """
        scale = self._scale(trials)
        spreads = scaled(self.spreads, self._gain(trials, scale))
        weights = {}
        for electrode in sorted({*self.common, *trials.cells}):
            prior = self.newcomer(electrode)
            if electrode in trials.cells:
                rows, seen, variance = _stacked(electrode, trials, scale, spreads)
                prior = prior.given(rows, seen, variance)
            weights[electrode] = prior
        return ArmPerson(trials.person, spreads, scale, weights, tuple(trials.cells))

    def _gain(self, trials: Trials, scale: Array) -> float:
        """Factor on a person's spreads, around 1."""
        stacked = [(self.newcomer(name), *_stacked(name, trials, scale, self.spreads))
                   for name in trials.cells]

        def cost(log: float) -> float:
            return 0.5 * (log / GAIN_LOG_SD)**2 - sum(
                log_density(np.exp(log) * rows, seen, prior, variance)
                for prior, rows, seen, variance in stacked)

        return float(np.exp(minimize_scalar(cost, bounds=GAIN_LOGS, method="bounded").x))

    def _scale(self, trials: Trials) -> Array:
        """Standard deviation of a repeat (4,): the person's, the population's as far as repeats are few."""
        between = self.scale_log_sd**2 + self.scale_log_sd_joint**2
        logs = self.scale_log_mean.copy()
        if trials.free:
            weight = 2.0 * trials.free  # over the variance of the logarithm of an estimated sd
            logs[trials.joints] = ((weight * np.log(trials.scale_nm) + logs[trials.joints] / between)
                                   / (weight + 1.0 / between))
        return np.asarray(np.exp(logs))


def _stacked(electrode: str, trials: Trials, scale: Array, spreads: Spreads) -> tuple[Array, Array, Array]:
    """Rows, values and noise variances of one electrode's cells, all joints below each other."""
    cells = trials.cells[electrode]
    rows = features(cells.postures, scale, spreads)[:, trials.joints]
    variance = scale[trials.joints]**2 / cells.trials[:, np.newaxis]
    return rows.reshape(-1, rows.shape[2]), cells.torque_nm.ravel(), variance.ravel()


def _common(electrode: str, people: Sequence[Trials], spreads: Spreads) -> Weights:
    """Distribution of the common part of an electrode's weights, given all people."""
    shares = common_shares(electrode, spreads)
    own = Weights(np.zeros(len(shares)), np.diag(1.0 - shares))
    precision, weighted = np.diag(1.0 / shares), np.zeros(len(shares))
    for each in people:
        if electrode in each.cells:
            rows, seen, variance = _stacked(electrode, each, each.scale_nm, spreads)
            total = rows @ own.covariance @ rows.T
            total[np.diag_indices_from(total)] += variance
            solved = np.linalg.solve(total, rows)
            precision = precision + rows.T @ solved
            weighted = weighted + solved.T @ seen
    covariance = np.linalg.inv(precision)
    return Weights(covariance @ weighted, 0.5 * (covariance + covariance.T))


def _fitted_spreads(people: Sequence[Trials]) -> Spreads:
    """Spreads of greatest posterior density: marginal likelihood times a prior of their logarithms."""
    start = _as_logs(_START)

    def cost(logs: Array) -> float:
        spreads = _of_logs(logs)
        return 0.5 * float(((logs - start)**2).sum()) - sum(
            _log_likelihood(name, people, spreads)
            for name in sorted({name for each in people for name in each.cells}))

    found = minimize(cost, start, method="L-BFGS-B", bounds=[(-5.0, 5.0)] * len(start),
                     options={"maxiter": _ITERATIONS})
    return _of_logs(found.x)


def _log_likelihood(electrode: str, people: Sequence[Trials], spreads: Spreads) -> float:
    """Log density of all people's cells of an electrode, by the chain rule: one person after the other."""
    shares = common_shares(electrode, spreads)
    common = Weights(np.zeros(len(shares)), np.diag(shares))
    total = 0.0
    for each in people:
        if electrode not in each.cells:
            continue
        rows, seen, variance = _stacked(electrode, each, each.scale_nm, spreads)
        own = rows * np.sqrt(1.0 - shares)
        stacked, weights = np.hstack([rows, own]), Weights(
            np.concatenate([common.mean, np.zeros(len(shares))]),
            np.block([[common.covariance, np.zeros((len(shares),) * 2)],
                      [np.zeros((len(shares),) * 2), np.eye(len(shares))]]))
        total += log_density(stacked, seen, weights, variance)
        mean, covariance = weights.given(stacked, seen, variance)
        common = Weights(mean[:len(shares)], covariance[:len(shares), :len(shares)])
    return total


def _as_logs(spreads: Spreads) -> Array:
    return np.concatenate([np.log([spreads.muscles, *spreads.constants, *spreads.slopes,
                                   *spreads.curvatures, spreads.coupling]),
                           logit([spreads.common_muscles, spreads.common_constants, spreads.common_slopes])])


def _of_logs(logs: Array) -> Spreads:
    sizes, shares = np.exp(logs[:14]).tolist(), expit(logs[14:]).tolist()
    return Spreads(
        muscles=sizes[0], constants=tuple(sizes[1:5]), slopes=tuple(sizes[5:9]),
        curvatures=tuple(sizes[9:13]), coupling=sizes[13], common_muscles=shares[0],
        common_constants=shares[1], common_slopes=shares[2])
