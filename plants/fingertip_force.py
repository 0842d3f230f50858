"""`fingertip_force`: force sensors taped to the fingertips."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample, Value
from plants.checks import require_not_negative, require_positive

Array = NDArray[np.float64]


class Errors(NamedTuple):
    """Noise sd, range, resolution (0: none), and sd of the offset's step since the last tick, N."""

    noise_sd: float
    range: float
    resolution: float
    drift: float


@compiled
def read_forces(
    force: Array, gain: Array, offset: Array, noise: Array, errors: Errors, samples: Array
) -> int:
    """Fill `samples` (k,), N, and advance `offset` (k,); returns a bit mask of the saturated sensors.

    `noise` (2 k,) serves samples, then drift.
    """
    saturated, count = 0, force.size
    for i in range(count):
        offset[i] += errors.drift * noise[count + i]
        value = gain[i] * force[i] + offset[i] + errors.noise_sd * noise[i]
        if errors.resolution > 0.0:
            value = round(value / errors.resolution) * errors.resolution
        if value > errors.range:
            saturated |= 1 << i
        samples[i] = min(max(value, 0.0), errors.range)
    return saturated


class FingertipForceState:
    """State of the sensors.

    Attributes
    ----------
    gain, offset: (k,), gain and offset, N, of each sensor; the offset wanders.
    noise: random numbers of this trial's ticks.
    last_ns: instant of the last tick; -1 before the first.
    latch: statuses that hold.
    """

    __slots__ = ("gain", "last_ns", "latch", "noise", "offset")

    def __init__(self, gain: Array, offset: Array, noise: NoiseStream) -> None:
        self.gain, self.offset, self.noise = gain, offset, noise
        self.last_ns = -1
        self.latch = StatusLatch()


@dataclass(frozen=True, slots=True, kw_only=True)
class FingertipForce:
    """Thin resistive force sensors at k fingertips.

    Input `contact_force` (k,), N, on each fingertip; output `force` (k,), N, from 0 to the range:

        force = clip(round(gain contact_force + offset + noise))

    Gain and initial offset are random once per run, and the same in every trial; the drift of the offset
    starts again with each trial. Hysteresis is omitted. Status `saturated` names sensors at the end of their
    range.

    Attributes
    ----------
    sensors: number k of sensors, at most 60; 0 takes it from the wire.
    gain_sd: sd of the gain about 1 (chosen: that of sensors that were calibrated once).
    offset_sd: sd of the initial offset, N (chosen).
    drift: random walk of the offset, N per square root of a second (chosen: .15 N after a minute).
    noise_sd: white noise of a sample, N (chosen).
    range_n: force at which samples saturate, N (chosen: a firm pinch; S19 names no sensor).
    resolution: size of a digit, N (range over ten bits); 0: no rounding.
    """

    sensors: int = 0
    gain_sd: float = 0.05
    offset_sd: float = 0.05
    drift: float = 0.02
    noise_sd: float = 0.02
    range_n: float = 25.0
    resolution: float = 25.0 / 1024.0

    def __post_init__(self) -> None:
        require_not_negative("fingertip_force", self, "gain_sd", "offset_sd", "drift", "noise_sd",
                             "resolution")
        require_positive("fingertip_force", self, "range_n")
        if not 0 <= self.sensors <= 60:
            raise InputError("fingertip_force.sensors", f"{self.sensors}", "1 to 60, or 0 for the wire's")

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Contact forces on the fingertips."""
        return (Port("contact_force", (self.sensors or None,), "N"),)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Readings of the sensors."""
        return (Port("force", (self.sensors or None,), "N"),)

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> FingertipForce:
        """This block with the number of wired fingertips; InputError unless the signal is a vector."""
        shape = shapes["contact_force"]
        if len(shape) != 1:
            raise InputError("contact_force", f"the wired signal has shape {shape}",
                             "a vector: shape (k,)")
        return replace(self, sensors=shape[0])

    def init(self, context: Context) -> FingertipForceState:
        """State with the sensors of this run."""
        normal = NoiseStream(stream_key(context.seed, f"{context.name}/sensors", 0), 2 * self.sensors).row(0)
        gain = 1.0 + self.gain_sd * normal[:self.sensors]
        return FingertipForceState(gain, self.offset_sd * normal[self.sensors:],
                                   context.noise(2 * self.sensors))

    def step(self, state: FingertipForceState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Readings of one tick; none before the first forces."""
        if not inputs[0].present:
            return ()
        elapsed_s = (tick.time_ns - state.last_ns) / NS_PER_S if state.last_ns >= 0 else 0.0
        state.last_ns = tick.time_ns
        samples = np.empty(self.sensors)
        saturated = read_forces(
            np.asarray(inputs[0].value), state.gain, state.offset, state.noise.row(tick.index),
            Errors(self.noise_sd, self.range_n, self.resolution, self.drift * math.sqrt(elapsed_s)), samples)
        if saturated or "saturated" in state.latch.holding:
            names = ", ".join(str(i) for i in range(self.sensors) if saturated >> i & 1)
            state.latch.put(tick, "saturated", bool(saturated), f"sensor {names}")
        return (samples,)
