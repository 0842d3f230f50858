"""Conversion of muscle drives to pulses: recruitment inverted at a fixed current (Hammerstein inversion).

The drive of a muscle is v = recruitment(current, width). With the current of each channel fixed, the width
for a given v is the inverse of the controller's nominal recruitment curve, so that a linear controller sees
an almost linear plant (Hunt, Munih, Donaldson and Barr 1998, doi 10.1109/10.720204, for the approach and for
how far the nominal curve may be off).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.models.linear_model import LinearModel, Recruitment

Array = NDArray[np.float64]
SQRT_HALF = math.sqrt(0.5)
SQRT_TWO_PI = math.sqrt(2.0 * math.pi)
LEAST_FRACTION = 1e-6
"""Drive up to which there is no pulse: no muscle has a million axons, programmes are solved to 1e-6, and a
drive that rounding leaves at 1e-17 in place of 0 would be a pulse of some us (chosen)."""
LEAST_REACH = 0.01
"""Fraction of a muscle that its channel must be able to recruit (chosen: less shows a wrong current)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Allocation:
    """Conversion of each muscle's drive to its channel's pulse; channel i stimulates muscle i.

    Attributes
    ----------
    recruitment: nominal curves; None takes v = pulse width / `full_scale_us`, signed and unlimited.
    current_ma: current of each channel while its pulse width is above zero.
    width_max_us: longest pulse.
    full_scale_us: pulse width of v = 1 where `recruitment` is None.
    charge_max_uc: greatest charge per phase, which may shorten the longest pulse; without effect where
        `recruitment` is None.
    """

    recruitment: Recruitment | None
    current_ma: tuple[float, ...]
    width_max_us: float = 500.0
    full_scale_us: float = 500.0
    charge_max_uc: float = math.inf
    _table: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not self.current_ma or not all(math.isfinite(i) and i > 0.0 for i in self.current_ma):
            raise InputError("current_ma", f"{self.current_ma}", "a finite current above 0 for each channel")
        for key in ("width_max_us", "full_scale_us"):
            value = getattr(self, key)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(key, f"{value}", "a finite width above 0")
        if not self.charge_max_uc > 0.0:
            raise InputError("charge_max_uc", f"{self.charge_max_uc}", "a charge above 0")
        if self.recruitment is not None and self.recruitment.muscles != len(self.current_ma):
            raise InputError("current_ma", f"{len(self.current_ma)} currents",
                             f"{self.recruitment.muscles}, one a muscle of the recruitment")
        if (self.reach() < LEAST_REACH).any():
            raise InputError(
                "current_ma", f"{self.current_ma} mA within {self.width_max_us:g} us and "
                f"{self.charge_max_uc:g} uC recruits less than {LEAST_REACH} of muscle "
                f"{int(np.argmin(self.reach()))}", "limits within which every channel recruits its muscle",
                "raise the current, width_max_us or charge_max_uc, or leave the channel out of the model")
        object.__setattr__(self, "_table", self._rows())

    @property
    def channels(self) -> int:
        """Number of channels."""
        return len(self.current_ma)

    def longest_s(self) -> Array:
        """Longest pulse of each channel, (channels,), s."""
        longest_us = np.minimum(self.width_max_us, 1e3 * self.charge_max_uc / np.asarray(self.current_ma))
        return longest_us / 1e6

    def reach(self) -> Array:
        """Largest drive of each muscle, (channels,): recruitment at the longest pulse; infinite if linear."""
        if self.recruitment is None:
            return np.full(self.channels, np.inf)
        pulses = np.column_stack([np.asarray(self.current_ma) / 1e3, self.longest_s()])
        return self.recruitment.fraction(pulses)

    def table(self) -> Array:
        """Rows for `allocate`, (channels, 6), not to be changed: current A, width limit s, linear width s (0
        if lognormal), threshold mA, spread, chronaxie s."""
        return self._table

    def _rows(self) -> Array:
        rows = np.zeros((self.channels, 6))
        rows[:, 0] = np.asarray(self.current_ma) / 1e3
        if self.recruitment is None:
            rows[:, 1], rows[:, 2] = np.inf, self.full_scale_us / 1e6
        else:
            rows[:, 1] = self.longest_s()
            rows[:, 3], rows[:, 4] = self.recruitment.threshold_ma, self.recruitment.spread
            rows[:, 5] = self.recruitment.chronaxie_us / 1e6
        return rows

    def stimulation(self, drive: Array) -> Array:
        """New pulses (channels, 2) in A and s for a drive (channels,), limited to the longest pulse."""
        pulses = np.empty((self.channels, 2))
        allocate(self.table(), np.ascontiguousarray(drive, dtype=np.float64), pulses)
        return pulses

    def drives(self, pulses: Array) -> Array:
        """Drives (samples, channels) that pulses (samples, channels, 2), A and s, recruit."""
        if self.recruitment is None:
            return pulses[:, :, 1] / (1e-6 * self.full_scale_us)
        return np.array([self.recruitment.fraction(each) for each in pulses])

    def charge(self, drive: Array) -> Array:
        """Charge per phase of each channel for a drive (channels,), (channels,) C."""
        pulses = self.stimulation(drive)
        charge: Array = pulses[:, 0] * pulses[:, 1]
        return charge

    def risen(self, charge_rise_c: float) -> Array:
        """Greatest drive of each channel that a rise of charge per phase from rest allows, (channels,)."""
        drive = np.empty(self.channels)
        risen(self.table(), np.zeros((self.channels, 2)), charge_rise_c, drive)
        return drive


class Allocating(Protocol):
    """Parameters shared by controllers that convert drives to pulses (`Allocation`)."""

    @property
    def model(self) -> LinearModel:
        """Nominal plant, with its recruitment."""

    @property
    def current_ma(self) -> tuple[float, ...]:
        """Current of each channel."""

    @property
    def width_max_us(self) -> float:
        """Longest pulse."""

    @property
    def full_scale_us(self) -> float:
        """Pulse width of drive 1 where the model has no recruitment."""

    @property
    def charge_max_uc(self) -> float:
        """Greatest charge per phase."""


def allocation_of(controller: Allocating) -> Allocation:
    """Conversion of a controller's drives to pulses."""
    return Allocation(recruitment=controller.model.recruitment, current_ma=controller.current_ma,
                      width_max_us=controller.width_max_us, full_scale_us=controller.full_scale_us,
                      charge_max_uc=controller.charge_max_uc)


@compiled
def normal_quantile(p: float) -> float:
    """Inverse of the normal distribution function for p in (0, 1), to rounding; smaller p count as 1e-300.

    Starts from Abramowitz and Stegun 26.2.23 (error below 4.5e-4) and refines by Halley's method against
    erfc, on the smaller tail, where the relative error stays small.
    """
    tail = max(min(p, 1.0 - p), 1e-300)
    t = math.sqrt(-2.0 * math.log(tail))
    below = 1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308))
    z = t - (2.515517 + t * (0.802853 + t * 0.010328)) / below
    for _ in range(2):
        error = 0.5 * math.erfc(z * SQRT_HALF) - tail
        step = error * SQRT_TWO_PI * math.exp(0.5 * z * z)
        z += step / (1.0 - 0.5 * z * step)
    return -z if p < 0.5 else z


@compiled
def allocate(table: Array, drive: Array, pulses: Array) -> int:
    """Fill the pulses (channels, 2) of a drive; return the number of channels at their longest pulse."""
    saturated = 0
    for i in range(drive.size):
        current, longest, linear = table[i, 0], table[i, 1], table[i, 2]
        v = drive[i]
        width = 0.0
        if linear > 0.0:
            width = v * linear
        elif v >= 1.0:
            width = longest
            saturated += 1
        elif v > LEAST_FRACTION:
            effective_ma = table[i, 3] * math.exp(table[i, 4] * normal_quantile(v))
            room = 1e3 * current - effective_ma
            width = table[i, 5] * effective_ma / room if room > 0.0 else longest
            if width >= longest:
                width = longest
                saturated += 1
        pulses[i, 0] = current if width != 0.0 else 0.0
        pulses[i, 1] = width
    return saturated


@compiled
def risen(table: Array, pulses: Array, charge_rise_c: float, drive: Array) -> None:
    """Fill `drive` (channels,) with the greatest one for a rise of charge per phase above `pulses`.

    Infinite where recruitment is linear.
    """
    for i in range(drive.size):
        if table[i, 2] > 0.0:
            drive[i] = math.inf
            continue
        width = pulses[i, 1] + charge_rise_c / table[i, 0]
        effective_ma = 1e3 * table[i, 0] / (1.0 + table[i, 5] / width)
        drive[i] = 0.5 * math.erfc(-math.log(effective_ma / table[i, 3]) / table[i, 4] * SQRT_HALF)


@compiled
def planned_charge(table: Array, drives: Array) -> float:
    """Sum of the charges per phase of drives (steps, channels), C."""
    total, pulses = 0.0, np.empty((drives.shape[1], 2))
    for k in range(drives.shape[0]):
        allocate(table, drives[k], pulses)
        for i in range(drives.shape[1]):
            total += abs(pulses[i, 0] * pulses[i, 1])
    return total


def check_reach(drive_max: float, allocation: Allocation) -> None:
    """Raise InputError for a greatest drive below `LEAST_REACH`."""
    if drive_max < LEAST_REACH and allocation.recruitment is not None:
        raise InputError("drive_max", f"{drive_max:g}", f"{LEAST_REACH:g} or more",
                         "raise it, or leave the channel out of the model")


def require_kept(controller: Any, allocation: Allocation) -> None:
    """Raise InputError for given limits of pulses that have no effect without recruitment.

    Where a model has no recruitment, pulses are signed and unlimited (see `Allocation`).
    """
    if allocation.recruitment is not None:
        return
    for each in fields(controller):
        if each.name in ("width_max_us", "charge_max_uc") and getattr(controller, each.name) != each.default:
            raise InputError(each.name, f"{getattr(controller, each.name):g} has no effect: the model "
                             "has no recruitment, and pulses are signed and unlimited", "no such limit",
                             "leave it out, and limit stimulation in the safety block")


def posture_within(model: LinearModel, reach: Array, least: Array, greatest: Array) -> Array | None:
    """Steady drives (muscles,) that hold the outputs between two postures (outputs,), rad; None if none do.

    Drives are between 0 and `reach` (muscles,). They are zero where the model has no steady state, or no end
    is finite.
    """
    bounded = np.concatenate([np.isfinite(greatest), np.isfinite(least)])
    if not bounded.any() or np.linalg.matrix_rank(model.a) < model.a.shape[0]:
        return np.zeros(reach.size)
    from scipy.optimize import linprog  # 0.1 s to import

    gain = -model.c @ np.linalg.solve(model.a, model.b)
    ends = np.concatenate([greatest - model.offset, model.offset - least])
    found = linprog(np.ones(reach.size), np.vstack([gain, -gain])[bounded], ends[bounded],
                    bounds=[(0.0, float(most)) for most in reach])
    return np.asarray(found.x) if found.status == 0 else None
