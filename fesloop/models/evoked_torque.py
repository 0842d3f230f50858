"""Torque that stimulation through an electrode evokes at held joints, by posture: a Bayesian linear model.

Torque is a sum of features of the posture, each times a weight that is the person's own:

- muscles: moment arms of the muscles under the electrode (`MusclePaths`), each times a force. A device that
  holds the hand feels part of the elbow's torque at the wrist, about the axis that is horizontal in the
  world: `coupling` of it deviates a neutral forearm's hand and extends or flexes a rotated one's;
- a constant of each joint, slopes over the angles, and a curvature over the elbow's, which has the widest
  range, for what moment arms do not say: fibre length, skin that moves over the muscles, and an electrode
  that lies beside its muscle.

Weights are normal. Their spread is that of people (`Spreads`), in units of the standard deviation of a
repeat, by which people scale: where stimulation evokes much torque, repeats scatter much, too. A share of
each variance is common to all people, so that a population tells where a person's weights begin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from fesloop.errors import InputError
from fesloop.hand.muscle_paths import JOINTS, muscle_paths

Array = NDArray[np.float64]
UNDER_ELECTRODES = {
    "biceps": ("BIClong", "BRA"), "triceps": ("TRIlong",),
    "pronator teres": ("PT", "FCR", "PL", "FDS3", "BRD"),
    "brachioradialis": ("BRD", "ECRL", "PT", "ECRB"),
    "flexor carpi radialis": ("FCR", "PL", "PT", "FDS3"),
    "palmaris longus": ("PL", "FCR", "FCU", "FDS3"),
    "flexor carpi ulnaris": ("FCU", "FDP3", "FDS3"),
    "extensor carpi radialis longus": ("ECRL", "ECRB", "BRD", "EDC3", "ECU"),
}
"""Muscles under an electrode, which is named after the one that it is to stimulate: this one, its neighbours
and what lies below (chosen by anatomy). FDS3, FDP3 and EDC3 stand for all four tendons."""
REFERENCE_RAD = np.deg2rad([57.5, 0.0, 0.0, 0.0])
"""Posture at which constants are the torque, where slopes are 0."""
SLOPE_RAD = np.deg2rad([30.0, 40.0, 10.0, 10.0])
"""Angles over which slopes are stated."""
MEAN_SQUARE = 2.0 / 3.0
"""Mean square of the elbow's angle at -1, 0 and 1 slope angle from the reference; curvatures average to 0
there."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Spreads:
    """Standard deviations of weights between people, in units of a repeat's standard deviation.

    Attributes
    ----------
    muscles: of the torque of each muscle (`muscle_torques`), over the mean of the joints' repeats.
    constants: (4,) by joint. slopes: (4,) by angle, over `SLOPE_RAD`, of every joint. curvatures: (4,) by
        joint, over the square of the elbow's.
    common_muscles, common_constants, common_slopes: share of the variance that is common to all people; that
        of curvatures is that of slopes.
    coupling: share of the elbow's torque that the device feels at the wrist.
    """

    muscles: float
    constants: tuple[float, ...]
    slopes: tuple[float, ...]
    curvatures: tuple[float, ...]
    common_muscles: float
    common_constants: float
    common_slopes: float
    coupling: float


def scaled(spreads: Spreads, gain: float) -> Spreads:
    """Spreads of weights that are all `gain` times as large."""
    def times(values: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(gain * value for value in values)

    return replace(spreads, muscles=gain * spreads.muscles, constants=times(spreads.constants),
                   slopes=times(spreads.slopes), curvatures=times(spreads.curvatures))


class Weights(NamedTuple):
    """Normal distribution of weights: mean (k,) and covariance (k, k)."""

    mean: Array
    covariance: Array

    def drawn(self, rng: np.random.Generator) -> Array:
        """Random weights (k,)."""
        return rng.multivariate_normal(self.mean, self.covariance, method="cholesky")

    def given(self, rows: Array, seen: Array, variance: Array) -> Weights:
        """Posterior after `seen` (n,): `rows` (n, k) times the weights, and noise of `variance` (n,)."""
        if not len(rows):
            return self
        gain = rows @ self.covariance
        total = gain @ rows.T
        total[np.diag_indices_from(total)] += variance
        factor = cho_factor(total)
        mean = self.mean + gain.T @ cho_solve(factor, seen - rows @ self.mean)
        covariance = self.covariance - gain.T @ cho_solve(factor, gain)
        return Weights(mean, 0.5 * (covariance + covariance.T))


def muscles_under(electrode: str, where: str) -> tuple[str, ...]:
    """Muscles under an electrode; InputError for a name without any."""
    if electrode not in UNDER_ELECTRODES:
        raise InputError(where, f"{electrode!r}", f"one of {', '.join(UNDER_ELECTRODES)}",
                         "name an electrode after the muscle that it is to stimulate")
    return UNDER_ELECTRODES[electrode]


class Postures(NamedTuple):
    """Postures in which an electrode stimulates.

    Attributes
    ----------
    electrode: name in `UNDER_ELECTRODES`.
    angles: (n, 4), rad, of `JOINTS`.
    arms: (n, m, 4), m, moment arms of the muscles under it.
    """

    electrode: str
    angles: Array
    arms: Array

    @classmethod
    def of(cls, electrode: str, angles: Array) -> Postures:
        """Postures with their moment arms."""
        paths = muscle_paths()
        rows = [paths.muscles.index(name) for name in muscles_under(electrode, "electrode")]
        return cls(electrode, angles, paths.moment_arms(angles)[:, rows])


def muscle_torques(postures: Postures, coupling: float) -> Array:
    """Torque (n, m, 4) of each muscle as the device feels it: 1 on average over usual postures.

    The average is the root mean square of the torque's length over 27 postures, two thirds of the usual
    ranges about `REFERENCE_RAD`.
    """
    usual = _felt(_usual(postures.electrode), coupling)
    return np.asarray(_felt(postures, coupling)
                      / np.sqrt((usual**2).sum(axis=2).mean(axis=0))[:, np.newaxis])


def _felt(postures: Postures, coupling: float) -> Array:
    felt = postures.arms.copy()
    turn = postures.angles[:, 1, np.newaxis]
    felt[:, :, 2] -= coupling * np.sin(turn) * postures.arms[:, :, 0]
    felt[:, :, 3] += coupling * np.cos(turn) * postures.arms[:, :, 0]
    return felt


@cache
def _usual(electrode: str) -> Postures:
    steps = np.array([-1.0, 0.0, 1.0])
    grid = np.stack(np.meshgrid(steps, steps, steps, [0.0], indexing="ij"), axis=-1).reshape(-1, 4)
    return Postures.of(electrode, REFERENCE_RAD + grid * SLOPE_RAD)


def feature_sizes(electrode: str, where: str = "electrode") -> tuple[int, int, int]:
    """Numbers of features of muscles, of constants, and of slopes and curvatures."""
    return len(muscles_under(electrode, where)), len(JOINTS), len(JOINTS) * (len(JOINTS) + 1)


def features(postures: Postures, scale_nm: Array, spreads: Spreads) -> Array:
    """Features (n, 4, k) of a unit of prior variance each, N m.

    `scale_nm` (4,) is the standard deviation of a repeat, by joint.
    """
    joints, count = len(JOINTS), len(postures.angles)
    of_muscles = spreads.muscles * scale_nm.mean() * muscle_torques(postures, spreads.coupling)
    constants = np.broadcast_to(np.diag(scale_nm * np.array(spreads.constants)), (count, joints, joints))
    away = (postures.angles - REFERENCE_RAD) / SLOPE_RAD
    slopes = np.einsum("na,jl->njal", away * np.array(spreads.slopes), np.diag(scale_nm))
    curvatures = ((away[:, 0]**2 - MEAN_SQUARE)[:, np.newaxis, np.newaxis]
                  * np.diag(scale_nm * np.array(spreads.curvatures)))
    return np.concatenate([of_muscles.transpose(0, 2, 1), constants,
                           slopes.reshape(count, joints, joints**2), curvatures], axis=2)


def common_shares(electrode: str, spreads: Spreads) -> Array:
    """Share (k,) of each weight's variance that is common to all people."""
    return np.repeat([spreads.common_muscles, spreads.common_constants, spreads.common_slopes],
                     feature_sizes(electrode))


def log_density(rows: Array, seen: Array, weights: Weights, variance: Array) -> float:
    """Log density of `seen` (n,): `rows` (n, k) times the weights, and noise of `variance` (n,)."""
    total = rows @ weights.covariance @ rows.T
    total[np.diag_indices_from(total)] += variance
    lower, _ = factor = cho_factor(total, lower=True)
    left = seen - rows @ weights.mean
    return float(-0.5 * left @ cho_solve(factor, left) - np.log(np.diag(lower)).sum()
                 - 0.5 * len(seen) * math.log(2.0 * math.pi))
