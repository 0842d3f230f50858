"""Axes of a hinge, learnt from the samples of its sensors while they arrive.

The method is that of `estimators.calibration.joint_axis`, on means over a tenth of a second in which soft
tissue's own motion is averaged out. It is tried as motion accumulates, until it finds axes: from 10 s of
motion, those of a real chain's hinges are 1 to 4 deg off with rigid sensors, and up to 15 deg on foam.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from estimators.calibration.joint_axis import HingeAxes, hinge_axes
from fesloop.errors import InputError

Array = NDArray[np.float64]
_MEAN_S = 0.1
"""Time over which samples are averaged (chosen: at 10 rad/s no frame has turned much by then)."""
_MOVING_RAD_S = 0.2
"""Rate of the faster sensor below which samples are left out (chosen: above bias and tremor)."""
_FIRST, _MOST = 100, 400
"""Number of means at the first attempt, and the largest one, 10 and 40 s of motion (chosen)."""


@dataclass(slots=True, eq=False)
class AxisSearch:
    """Samples of the two sensors of a hinge from which its axes are learnt.

    Attributes
    ----------
    joint: its number in the table of joints.
    ends: parent and child, numbers of the sensors.
    samples: sound samples in one mean.
    sums: (2, 2, 3), sum of the newest `count` samples, rad/s and m/s^2, of parent and child.
    means: means of samples in motion, (2, 2, 3) each; due: their number at the next attempt.
    """

    joint: int
    ends: tuple[int, int]
    samples: int
    sums: Array = field(default_factory=lambda: np.zeros((2, 2, 3)))
    count: int = 0
    means: list[Array] = field(default_factory=list)
    due: int = _FIRST

    @classmethod
    def of(cls, joint: int, ends: tuple[int, int], period_s: float) -> AxisSearch:
        """Search before the first sample; `period_s` is that of the samples."""
        return cls(joint, ends, max(1, round(_MEAN_S / period_s)))

    def take(self, gyr: Array, acc: Array) -> HingeAxes | InputError | None:
        """Axes, or why they could not be found, where a sample (n, 3) leads to an attempt; else None."""
        self.sums += np.stack([gyr[list(self.ends)], acc[list(self.ends)]])
        self.count += 1
        if self.count < self.samples:
            return None
        mean, self.count = self.sums / self.samples, 0
        self.sums[:] = 0.0
        if math.sqrt(float(np.square(mean[0]).sum(axis=1).max())) < _MOVING_RAD_S:
            return None
        self.means.append(mean)
        if len(self.means) < self.due:
            return None
        means = np.stack(self.means)
        try:
            return hinge_axes(means[:, 0], means[:, 1])
        except InputError as fault:
            if self.due < _MOST:
                self.due *= 2
            else:
                del self.means[:_MOST // 2]
            return fault
