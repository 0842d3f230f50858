"""What the drives of a trial may be: boxes, slew, and charge over the trial."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from controllers.limits.allocation import Allocation, allocate

Array = NDArray[np.float64]
_HALVINGS = 40
_LEAST_DRIVE = 0.01
"""Sum of a channel's drives over a trial below which it counts as resting (chosen: 1 % of a muscle, once)."""


def pulses_of(allocation: Allocation, drives: Array) -> Array:
    """Pulses (samples, muscles, 2) in A and s for drives (samples, muscles)."""
    pulses, table = np.empty((*drives.shape, 2)), allocation.table()
    for k, drive in enumerate(np.ascontiguousarray(drives)):
        allocate(table, drive, pulses[k])
    return pulses


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Limits:
    """0 <= v <= reach, |v_k - v_{k-1}| <= slew from rest, and a charge that each channel may give in a trial.

    Attributes
    ----------
    reach: (muscles,), greatest drive.
    slew: greatest change of a drive a tick.
    allocation: how drives become pulses, where charge counts; else None.
    charge_c: charge of each channel over a trial, one pulse a tick, C; infinite for no limit.
    """

    reach: Array
    slew: float
    allocation: Allocation | None = None
    charge_c: float = np.inf

    @property
    def counts_charge(self) -> bool:
        """Whether charge is limited."""
        return self.allocation is not None and bool(np.isfinite(self.charge_c))

    def within(self, drives: Array) -> Array:
        """Drives clipped into their box, then tick by tick into the slew limit, then scaled to the charge."""
        limited = np.clip(drives, 0.0, self.reach)
        before = np.zeros(drives.shape[1])
        for k in range(drives.shape[0]):
            before = limited[k] = np.clip(limited[k], before - self.slew, before + self.slew)
        if not self.counts_charge:
            return limited
        low, high = np.zeros(drives.shape[1]), np.ones(drives.shape[1])
        if (self.charges(limited) <= self.charge_c).all():
            return limited
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            fits = self.charges(middle * limited) <= self.charge_c
            low, high = np.where(fits, middle, low), np.where(fits, high, middle)
        return np.where(self.charges(limited) <= self.charge_c, 1.0, low) * limited

    def charges(self, drives: Array) -> Array:
        """Charge of each channel over the trial, (muscles,) C; zero where it is not counted."""
        if self.allocation is None:
            return np.zeros(drives.shape[1])
        pulses = pulses_of(self.allocation, drives)
        total: Array = np.abs(pulses[:, :, 0] * pulses[:, :, 1]).sum(axis=0)
        return total

    def charge_slopes(self, drives: Array) -> Array:
        """Charge per unit of drive over a trial, (muscles,) C, by which the programme counts charge.

        One a channel, so that it does not matter when in the trial the drives act; exact at `drives`, and
        for a channel that these leave at rest that of half its reach.
        """
        if self.allocation is None:
            return np.zeros(drives.shape[1])
        total = drives.sum(axis=0)
        resting = total < _LEAST_DRIVE
        half = np.tile(0.5 * np.minimum(self.reach, 1.0), (1, 1))
        slopes: Array = np.where(resting, self.charges(half) / half[0],
                                 self.charges(drives) / np.maximum(total, _LEAST_DRIVE))
        return slopes
