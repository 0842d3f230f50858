"""What stimulation does to sensors on the stimulated hand: spikes at the pulses, and tremor.

A pulse reaches the sensors when its message does. Tremor is a vibration of the segments about axes drawn
for each sensor: about `axis` with an angular rate, which at a lever arm is an acceleration along `swing`.
It is a function of time, so that two blocks that read one device feel the same.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.loop.signals import Sample
from plants.checks import require_not_negative, require_positive, require_shape

Array = NDArray[np.float64]
COMPONENTS = 6
"""Sinusoids of the physiological tremor (chosen: its envelope then varies as that of narrow-band noise)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PulseArtefacts:
    """Spikes on samples taken shortly after a pulse; all sizes are chosen, none is published.

    Each sensor's spike has a direction of its own, the same for the run.

    Attributes
    ----------
    window_ms: how long after a pulse a sample is still spoilt.
    gyr, acc, mag: size at full charge, rad/s, m/s^2, T; in proportion to the largest channel's charge.
    """

    window_ms: float = 1.0
    gyr: float = 0.02
    acc: float = 0.3
    mag: float = 2e-6

    def __post_init__(self) -> None:
        require_positive("pulse_artefacts", self, "window_ms")
        require_not_negative("pulse_artefacts", self, "gyr", "acc", "mag")

    def directed(self, seed: int, device: str, sites: int) -> Array:
        """Spike of each sensor at full charge, (3, sites, 3): gyr, acc, mag."""
        drawn = NoiseStream(stream_key(seed, f"{device}/artefacts", 0), 9 * sites).row(0).reshape(3, sites, 3)
        sizes = np.array([self.gyr, self.acc, self.mag])[:, np.newaxis, np.newaxis]
        return np.asarray(sizes * drawn / np.linalg.norm(drawn, axis=-1, keepdims=True))


@dataclass(frozen=True, slots=True, kw_only=True)
class Tremor:
    """Physiological tremor, always there, and the tetanic one of muscles that twitch with every pulse.

    Attributes
    ----------
    physiological: rms of its angular rate, rad/s (chosen: 0.1 m/s^2 at the lever, as of hands held out).
    band_hz: in which it lies (8-12: Elble and Koller 1990, as usually quoted).
    tetanic: rms of the angular rate at the stimulation frequency at full charge, rad/s (chosen).
    rise_s: time constant by which it follows the charge, s (that of activation, 1 / 25 s, grip-force data).
    lever_m: from the axis to the sensor, m (chosen: half a hand).
    """

    physiological: float = 0.03
    band_hz: tuple[float, float] = (8.0, 12.0)
    tetanic: float = 0.1
    rise_s: float = 0.04
    lever_m: float = 0.05

    def __post_init__(self) -> None:
        require_not_negative("tremor", self, "physiological", "tetanic", "lever_m")
        require_positive("tremor", self, "band_hz", "rise_s")
        require_shape("tremor", self, (2,), "lowest, highest", "band_hz")
        if self.band_hz[0] > self.band_hz[1]:
            raise InputError("tremor.band_hz", f"{self.band_hz}", "the lowest first")

    def numbers(self) -> Array:
        """As the kernel takes it, (3,): tetanic amplitude, rad/s, time constant, s, lever, m."""
        return np.array([math.sqrt(2.0) * self.tetanic, self.rise_s, self.lever_m])

    def components(self, seed: int, device: str, trial: int) -> Array:
        """Sinusoids of a trial, (3, COMPONENTS): angular frequency, rad/s, phase, rad, amplitude, rad/s."""
        drawn = NoiseStream(stream_key(seed, f"{device}/tremor", trial), 2 * COMPONENTS, "uniform").row(0)
        low, high = self.band_hz
        # One frequency in each equal part of the band.
        hertz = low + (high - low) * (np.arange(COMPONENTS) + drawn[:COMPONENTS]) / COMPONENTS
        amplitude = np.full(COMPONENTS, self.physiological * math.sqrt(2.0 / COMPONENTS))
        return 2.0 * math.pi * np.stack([hertz, drawn[COMPONENTS:], amplitude / (2.0 * math.pi)])


def axes(seed: int, device: str, sites: int) -> Array:
    """Axis of each sensor's tremor, and the direction at right angles in which it swings, (2, sites, 3)."""
    drawn = NoiseStream(stream_key(seed, f"{device}/tremor_axes", 0), 6 * sites).row(0).reshape(2, sites, 3)
    axis = drawn[0] / np.linalg.norm(drawn[0], axis=-1, keepdims=True)
    swing = np.cross(axis, drawn[1])
    return np.stack([axis, swing / np.linalg.norm(swing, axis=-1, keepdims=True)])


@dataclass(frozen=True, slots=True, kw_only=True)
class Pulses:
    """How stimulation pulses come out of the messages of currents and pulse widths.

    Attributes
    ----------
    rate_hz: at which the stimulator repeats the newest message's pulses; 0: one pulse a message.
    full_charge_uc: of one pulse, that counts as full (chosen: 25 mA for 400 us).
    """

    rate_hz: float = 0.0
    full_charge_uc: float = 10.0

    def __post_init__(self) -> None:
        require_not_negative("pulses", self, "rate_hz")
        require_positive("pulses", self, "full_charge_uc")


@dataclass(slots=True, eq=False)
class PulseWatch:
    """The pulses seen so far.

    Attributes
    ----------
    newest_ns: arrival of the newest message; -1 before the first.
    interval_s: between the last two; 0 before there are two.
    share: of full charge, the newest one's.
    """

    newest_ns: int = -1
    interval_s: float = 0.0
    share: float = 0.0

    def now(self, pulses: Pulses, sample: Sample, time_ns: int) -> tuple[float, float, float]:
        """(share of full charge, s since the last pulse, s between pulses); share 0 before the first."""
        if not sample.present:
            return 0.0, math.inf, 0.0
        if sample.arrived_ns > self.newest_ns:
            if self.newest_ns >= 0:
                self.interval_s = (sample.arrived_ns - self.newest_ns) / NS_PER_S
            self.newest_ns = sample.arrived_ns
            self.share = charge(np.asarray(sample.value), pulses.full_charge_uc)
        since, interval = (time_ns - self.newest_ns) / NS_PER_S, self.interval_s
        if pulses.rate_hz > 0.0:
            interval = 1.0 / pulses.rate_hz
            since %= interval
        return self.share, since, interval


def charge(stimulation: Array, full_charge_uc: float) -> float:
    """Charge of the largest channel's pulse as a share of full; stimulation (channels, 2) in A and s."""
    return float((stimulation[:, 0] * stimulation[:, 1]).max()) / (1e-6 * full_charge_uc)


@compiled
def vibration(
    numbers: Array, components: Array, time_s: float, elapsed_s: float, stimulation: Array, level: Array
) -> tuple[float, float]:
    """Angular rate, rad/s, and acceleration at the lever, m/s^2, of the tremor at `time_s`.

    `stimulation` (3,): share of full charge, s since the last pulse and between pulses; `level` (1,), the
    share that the muscles have followed to, is brought on by `elapsed_s`.
    """
    share, since, interval = stimulation[0], stimulation[1], stimulation[2]
    level[0] += (share - level[0]) * -math.expm1(-elapsed_s / numbers[1])
    rate, change = 0.0, 0.0
    for k in range(components.shape[1]):
        angle = components[0, k] * time_s + components[1, k]
        rate += components[2, k] * math.cos(angle)
        change -= components[2, k] * components[0, k] * math.sin(angle)
    if interval > 0.0:
        pulse = 2.0 * math.pi / interval
        amplitude = numbers[0] * level[0]
        rate += amplitude * math.cos(pulse * since)
        change -= amplitude * pulse * math.sin(pulse * since)
    return rate, numbers[2] * change
