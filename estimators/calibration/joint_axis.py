"""Axis of a hinge in the frames of the sensors on its two segments, from any motion of both.

Two sensors on neighbouring segments of a hinge have equally large parts of their rates across the axis and,
while the joint's rotation is slow, equal parts of their accelerations along it
(Olsson, Kok, Seel and Halvorsen 2020, doi 10.3390/s20123534). Neither a pose nor a magnetometer is needed.
The accelerations distinguish the axis of one sensor from its opposite; the rates do not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import least_squares

from fesloop.errors import InputError

Array = NDArray[np.float64]
_FEW = 300
"""Number of samples for the trial of all starts (chosen)."""
_STARTS = np.eye(3)
_LEAST = 50
_SINGULAR = 1e12
_NO_RATE = 1e-9
"""Rate below which there is none, rad/s (far below any sensor's noise)."""
_RIVALS = 3
"""Number of other minima that are computed on all samples (chosen)."""
_SAME = math.cos(math.radians(20.0))
"""Axes closer than this are one minimum (chosen)."""


class HingeAxes(NamedTuple):
    """Axis of a hinge in the frames of its two sensors.

    Attributes
    ----------
    axes: (2, 3), unit vectors in the first and second sensor's frame, one direction. The sign of
        both is arbitrary: the first one's largest component is positive.
    sd_deg: (2,), sd from the residuals, deg, which count as independent; those of soft tissue are not.
    gyr_rms: rms of the difference of the rates across the axis, rad/s.
    rival: cost of the best other minimum over the cost of this one, infinite where there is none; near 1 the
        motion does not distinguish the two.
    """

    axes: Array
    sd_deg: Array
    gyr_rms: float
    rival: float


@dataclass(frozen=True, slots=True, kw_only=True)
class HingeFit:
    """Weights of residuals, and limits beyond which a fit is refused.

    Attributes
    ----------
    gyr_sd, acc_sd: sd of the two residuals, rad/s and m/s^2 (their ratio, 50, is that of the authors' own
        program; their size, of soft tissue, is chosen).
    robust: whether residuals beyond their sd count by their size instead of its square (soft L1), so that
        knocks and fast turns weigh less. Off, the cost is the authors'.
    most_sd_deg: greatest sd of an axis (chosen: usual error of a sensor's mounting,
        doi 10.3390/s19010208, section 4).
    least_rival: least `HingeAxes.rival` (chosen).

    Raises InputError for values that are not positive.
    """

    gyr_sd: float = 0.02
    acc_sd: float = 1.0
    robust: bool = True
    most_sd_deg: float = 5.0
    least_rival: float = 1.05

    def __post_init__(self) -> None:
        for name in ("gyr_sd", "acc_sd", "most_sd_deg", "least_rival"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise InputError(name, f"{getattr(self, name)} is not positive", "a finite number above 0")


USUAL_FIT = HingeFit()


def hinge_axes(gyr: ArrayLike, acc: ArrayLike, fit: HingeFit = USUAL_FIT) -> HingeAxes:
    """Axis of a hinge from samples of the sensors on its two segments.

    Every pair of the sensors' own axes is a start, so that a local minimum is not mistaken for the best. Soft
    tissue moves faster than joints: samples of sensors on it are better low-passed first, both kinds alike.

    Parameters
    ----------
    gyr, acc: (m, 2, 3), rad/s and m/s^2, synchronous, each in its sensor's frame. Samples that are not
        finite are ignored.

    Raises InputError for too few samples, and where the motion does not determine the axis or its direction.
    """
    rates, forces = _both(gyr, acc)
    found = _best_axes(rates, forces, fit)
    if not found.sd_deg.max() <= fit.most_sd_deg:
        raise InputError("hinge axis", f"the motion leaves it unsure by {found.sd_deg.max():.0f} deg (sd)",
                         f"{fit.most_sd_deg:g} deg or less", "move the joint itself, widely")
    if not found.rival >= fit.least_rival:
        raise InputError("hinge axis", f"another one fits as well: its cost is {found.rival:.3f} times as "
                         "high", f"{fit.least_rival:g} or more",
                         "move the joint itself, widely, and with its axis leaning, not only level")
    return found


def _both(gyr: ArrayLike, acc: ArrayLike) -> tuple[Array, Array]:
    rates, forces = np.asarray(gyr, dtype=np.float64), np.asarray(acc, dtype=np.float64)
    if rates.ndim != 3 or rates.shape[1:] != (2, 3) or rates.shape != forces.shape:
        raise InputError("gyr and acc", f"shapes {rates.shape} and {forces.shape}", "(samples, 2, 3) both")
    sound = np.isfinite(rates).all(axis=(1, 2)) & np.isfinite(forces).all(axis=(1, 2))
    if sound.sum() < _LEAST:
        raise InputError("gyr and acc", f"{sound.sum()} samples are sound", f"{_LEAST} or more",
                         "record a longer motion")
    return rates[sound], forces[sound]


def _best_axes(rates: Array, forces: Array, fit: HingeFit) -> HingeAxes:
    few = np.unique(np.linspace(0, len(rates) - 1, _FEW).astype(int))
    tried = [_refined(np.stack([first, sign * second]), rates[few], forces[few], fit)
             for first in _STARTS for second in _STARTS for sign in (1.0, -1.0)]
    tried.sort(key=lambda one: one[1])
    starts = [tried[0][0], tried[0][0] * [[1.0], [-1.0]]]
    starts += [axes for axes, _ in tried if _apart(axes, starts[0])][:_RIVALS]
    minima = [_refined(axes, rates, forces, fit) for axes in starts]
    best, cost = min(minima, key=lambda one: one[1])
    rival = min((other for axes, other in minima if _apart(axes, best)), default=math.inf)
    # A cost of nearly nothing, as of ideal sensors, is nothing to measure a rival by.
    ratio = rival / cost if cost > 1e-9 * rival else math.inf
    across = rates_across(rates, best)
    gyr_rms = float(np.sqrt(np.mean((across[:, 0] - across[:, 1]) ** 2)))
    sign = 1.0 if best[0, np.argmax(np.abs(best[0]))] > 0.0 else -1.0
    return HingeAxes(sign * best, _sd_deg(best, rates, forces, fit), gyr_rms, ratio)


def _apart(axes: Array, others: Array) -> bool:
    """Whether two pairs of axes (2, 3) differ in more than their common sign."""
    cosines = np.sum(axes * others, axis=1)
    return bool(max(cosines.min(), (-cosines).min()) < _SAME)


def rates_across(rates: Array, axes: Array) -> Array:
    """Size of the rates (m, 2, 3) across the axes (2, 3), (m, 2)."""
    return np.asarray(np.linalg.norm(np.cross(rates, axes), axis=2))


def hinge_residuals(axes: Array, rates: Array, forces: Array, fit: HingeFit) -> Array:
    """Residuals of rates, then of accelerations, over their sd, (2 m,)."""
    across, along = rates_across(rates, axes), np.sum(forces * axes, axis=2)
    return np.concatenate([(across[:, 0] - across[:, 1]) / fit.gyr_sd,
                           (along[:, 0] - along[:, 1]) / fit.acc_sd])


def hinge_slopes(axes: Array, frames: Array, rates: Array, forces: Array, fit: HingeFit) -> Array:
    """Derivatives of the residuals by small turns of each axis towards its frame's rows, (2 m, 4)."""
    sweep = np.cross(rates, axes)
    size = np.maximum(np.linalg.norm(sweep, axis=2), _NO_RATE)
    by_rates = np.einsum("mki,mkji->mkj", sweep, np.cross(rates[:, :, np.newaxis], frames))
    by_rates *= (np.array([1.0, -1.0]) / (fit.gyr_sd * size))[:, :, np.newaxis]
    by_forces = np.einsum("mki,kji->mkj", forces, frames) * (np.array([[1.0], [-1.0]]) / fit.acc_sd)
    return np.concatenate([by_rates, by_forces]).reshape(-1, 4)


def _frames(axes: Array) -> Array:
    """Two unit vectors at right angles to each axis and to each other, (2, 2, 3)."""
    return np.stack([np.linalg.svd(axis[np.newaxis])[2][1:] for axis in axes])


def _refined(axes: Array, rates: Array, forces: Array, fit: HingeFit) -> tuple[Array, float]:
    """Axes (2, 3) of the nearest minimum, and its cost."""
    frames = _frames(axes)

    def turned(steps: Array) -> tuple[Array, Array]:
        moved = axes + np.einsum("ki,kij->kj", steps.reshape(2, 2), frames)
        length = np.linalg.norm(moved, axis=1, keepdims=True)
        return moved / length, length

    def residuals(steps: Array) -> Array:
        return hinge_residuals(turned(steps)[0], rates, forces, fit)

    def slopes(steps: Array) -> Array:
        now, length = turned(steps)
        across = frames - np.einsum("kji,ki->kj", frames, now)[:, :, np.newaxis] * now[:, np.newaxis]
        return hinge_slopes(now, across / length[:, np.newaxis], rates, forces, fit)

    found = least_squares(residuals, np.zeros(4), slopes, loss="soft_l1" if fit.robust else "linear")
    return turned(found.x)[0], float(found.cost)


def _sd_deg(axes: Array, rates: Array, forces: Array, fit: HingeFit) -> Array:
    """Sd of both axes in their worst direction, (2,), deg; 180 where it is undetermined."""
    residuals = hinge_residuals(axes, rates, forces, fit)
    # Soft L1 is least squares with these weights.
    weights = 1.0 / np.sqrt(1.0 + residuals**2) if fit.robust else np.ones_like(residuals)
    slopes = hinge_slopes(axes, _frames(axes), rates, forces, fit)
    information = slopes.T @ (weights[:, np.newaxis] * slopes)
    if np.linalg.cond(information) > _SINGULAR:
        return np.full(2, 180.0)
    variance = weights @ residuals**2 / (residuals.size - 4)
    covariance = variance * np.linalg.inv(information)
    worst = [np.linalg.eigvalsh(covariance[k:k + 2, k:k + 2])[1] for k in (0, 2)]
    return np.minimum(np.degrees(np.sqrt(worst)), 180.0)
