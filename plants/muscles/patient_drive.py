"""Natural drive of a patient's muscles: voluntary effort, stretch reflexes, tremor."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.forms.schema import require_not_negative, require_positive
from fesloop.hand.movements import MUSCLES, each_muscle, muscle
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.noise import NoiseStream, stream_key

Array = NDArray[np.float64]
EXTENSORS = frozenset({
    "ECRL", "ECRB", "EDC2", "EDC3", "EDC4", "EDC5", "EDM", "ECU", "EIP", "EPL", "EPB", "APL"})
"""Muscles that a tremor drives in alternation with all others."""
COMPONENTS = 6
"""Sinusoids of a tremor (chosen: its amplitude then varies like that of narrow-band noise)."""


def chosen(names: tuple[str, ...], where: str) -> Array:
    """Marks (muscles,), 1 for named muscles, or for all if none is named; InputError for unknown names."""
    if not names:
        return np.ones(len(MUSCLES))
    marks = np.zeros(len(MUSCLES))
    for name in names:
        try:
            marks[muscle(name)] = 1.0
        except InputError as fault:
            raise InputError(where, fault.found, fault.allowed, fault.remedy) from fault
    return marks


def greatest_efforts(limit: float, limits: Mapping[str, float]) -> Array:
    """Greatest effort of each muscle, (muscles,): from `limits` by name, `limit` for all others.

    Raises InputError for an unknown muscle and for a limit outside 0 to 1.
    """
    efforts = each_muscle(limit, limits, "muscles.voluntary_limits")
    for key, values in (("voluntary_limit", (limit,)), ("voluntary_limits", limits.values())):
        for value in values:
            if not 0.0 <= value <= 1.0:
                raise InputError(f"muscles.{key}", f"{value}", "from 0 to 1")
    return efforts


def within(values: Array, highest: float | Array) -> Array:
    """Clip values to 0 and `highest`."""
    limited: Array = np.minimum(np.maximum(values, 0.0), highest)
    return limited


@dataclass(frozen=True, slots=True, kw_only=True)
class StretchReflex:
    """Spasticity: drive = gain (velocity - threshold) of a muscle stretched faster than that, up to a limit.

    The threshold's decrease with muscle length is omitted: it accounts for 15 % of the reflex's dependence
    on speed, the gain for 74 % (McPherson 2018, doi 10.1007/s00221-018-5389-x, elbow).

    Attributes
    ----------
    gain_s: drive for each optimal fibre length per s (chosen: a wrist turned by 100 deg/s stretches its
        flexors by about 0.4 lengths/s, which then gives a drive of 0.15).
    threshold_per_s: stretch velocity below which there is no reflex, optimal fibre lengths per s (chosen).
    delay_ms: delay from stretch to the muscle's nerve, in addition to the electromechanical delay (chosen:
        that of short-latency reflexes of the forearm).
    limit: largest drive (chosen).
    muscles: names of the spastic muscles; empty: all.
    """

    gain_s: float = 0.5
    threshold_per_s: float = 0.1
    delay_ms: float = 30.0
    limit: float = 0.5
    muscles: tuple[str, ...] = ()
    _spastic: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_not_negative("reflex", self, "gain_s", "threshold_per_s")
        if not 0.0 <= self.limit <= 1.0:
            raise InputError("reflex.limit", f"{self.limit}", "from 0 to 1")
        duration_ns(self.delay_ms, NS_PER_MS, "reflex.delay_ms")
        object.__setattr__(self, "_spastic", chosen(self.muscles, "reflex.muscles"))

    def drive(self, velocity: Array) -> Array:
        """Drive of each muscle, (muscles,), at fibre velocities (muscles,), 1/s, positive in stretch."""
        beyond = self.gain_s * (velocity - self.threshold_per_s)
        drive: Array = np.minimum(np.maximum(beyond, 0.0), self.limit * self._spastic)
        return drive


@compiled
def oscillation(waves: Array, time_s: float) -> float:
    """Sum of the sinusoids `waves` (3, c): amplitude, frequency in Hz, phase in rad."""
    sum_of_waves = 0.0
    for k in range(waves.shape[1]):
        sum_of_waves += waves[0, k] * math.sin(2.0 * math.pi * waves[1, k] * time_s + waves[2, k])
    return sum_of_waves


@dataclass(frozen=True, slots=True, kw_only=True)
class MuscleTremor:
    """Alternating contraction of extensors and all other muscles, at a frequency that the patient keeps.

    The frequency is random by the experiment's seed, phases are random in each trial.

    Attributes
    ----------
    activation: rms of the drive of either group before clipping at 0 (chosen).
    band_hz: range of the patient's frequency (4-12, all kinds of tremor together).
    spread_hz: sd of the components' frequencies (chosen: the tremor swells and fades within seconds).
    muscles: names of the muscles that tremble; empty: all.
    """

    activation: float = 0.03
    band_hz: tuple[float, float] = (4.0, 12.0)
    spread_hz: float = 0.3
    muscles: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        require_not_negative("tremor", self, "activation")
        require_positive("tremor", self, "band_hz", "spread_hz")
        if self.band_hz[0] > self.band_hz[1]:
            raise InputError("tremor.band_hz", f"{self.band_hz}", "the lower frequency, then the upper")
        chosen(self.muscles, "tremor.muscles")

    def waves(self, context: Context) -> Array:
        """Sinusoids (3, c) of this patient in this trial: amplitude, frequency in Hz, phase in rad."""
        lasting = NoiseStream(stream_key(context.seed, f"{context.name}/tremor", 0), 1, "uniform")
        low, high = self.band_hz
        centre_hz = low + (high - low) * float(lasting.row(0)[0])
        spread = context.noise(COMPONENTS, "normal", "tremor frequencies").row(0)
        phases = context.noise(COMPONENTS, "uniform", "tremor phases").row(0)
        amplitude = self.activation * math.sqrt(2.0 / COMPONENTS)
        return np.stack([np.full(COMPONENTS, amplitude), np.abs(centre_hz + self.spread_hz * spread),
                         2.0 * math.pi * phases])

    def sides(self) -> Array:
        """Sign of each muscle's tremor, (muscles,): 1 for extensors, -1 for others, 0 for none."""
        sign = np.array([1.0 if name in EXTENSORS else -1.0 for name in MUSCLES])
        return sign * chosen(self.muscles, "tremor.muscles")


def trembling(waves: Array, sides: Array, time_ns: int) -> Array:
    """Activation of each muscle, (muscles,), by tremor at an instant; never negative."""
    activation: Array = np.maximum(oscillation(waves, time_ns / NS_PER_S) * sides, 0.0)
    return activation
