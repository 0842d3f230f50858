"""`fingertip_force`: pressure sensors taped to the fingertips."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

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


@compiled
def read_forces(
    force: Array, gain: Array, offset: Array, noise: Array, errors: Array, drift_n: float, samples: Array
) -> int:
    """Fill `samples` (k,), N, and bring `offset` (k,) on; returns a bit mask of the saturated sensors.

    `noise` (2 k,) serves samples, then drift; `errors` (3,): noise sd, range, digit, N; `drift_n` is the sd
    of the offset's step since the last tick, N.
    """
    saturated, count = 0, force.size
    for i in range(count):
        offset[i] += drift_n * noise[count + i]
        value = gain[i] * force[i] + offset[i] + errors[0] * noise[i]
        if errors[2] > 0.0:
            value = round(value / errors[2]) * errors[2]
        if value > errors[1]:
            saturated |= 1 << i
        samples[i] = min(max(value, 0.0), errors[1])
    return saturated


class FingertipForceState:
    """What the sensors remember.

    Attributes
    ----------
    gain, offset: (k,), of each sensor, 1 and N; the offset wanders.
    noise: rows for the ticks of this trial.
    last_ns: instant of the last tick; -1 before the first.
    latch: the statuses that hold.
    """

    __slots__ = ("gain", "last_ns", "latch", "noise", "offset")

    def __init__(self, gain: Array, offset: Array, noise: NoiseStream) -> None:
        self.gain, self.offset, self.noise = gain, offset, noise
        self.last_ns = -1
        self.latch = StatusLatch()


@dataclass(frozen=True, slots=True, kw_only=True)
class FingertipForce:
    """Forces at k fingertips as thin resistive sensors give them.

    Input `contact_force` (k,), N, pressing on each fingertip; output `force` (k,), N, from 0 to the range:

        force = clip(round(gain contact_force + offset + noise))

    Gain and first offset belong to the sensors: drawn for a run, the same in its every trial; the drift of
    the offset starts anew. Hysteresis is left out. Status `saturated` names sensors at the end of their
    range.

    Attributes
    ----------
    sensors: k, at most 60; 0 takes it from the wire.
    gain_sd: of the gain about 1 (chosen: that of sensors that were calibrated once).
    offset_sd: N (chosen).
    drift: of the offset, N per square root of a second (chosen: .15 N after a minute).
    noise_sd: of a sample, N (chosen).
    range_n: where samples saturate, N (chosen: a firm pinch; S19 names no sensor).
    resolution: of a digit, N (range over ten bits); 0 does not round.
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
        """What presses on the fingertips."""
        return (Port("contact_force", (self.sensors or None,), "N"),)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """What the sensors read."""
        return (Port("force", (self.sensors or None,), "N"),)

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> FingertipForce:
        """For the fingertips that are wired in; raises InputError where they are no vector."""
        shape = shapes["contact_force"]
        if len(shape) != 1:
            raise InputError("contact_force", f"a signal of shape {shape} is wired in",
                             "a vector: shape (k,)")
        return replace(self, sensors=shape[0])

    def init(self, context: Context) -> FingertipForceState:
        """Sensors as drawn for this run."""
        drawn = NoiseStream(stream_key(context.seed, f"{context.name}/sensors", 0), 2 * self.sensors).row(0)
        gain = 1.0 + self.gain_sd * drawn[:self.sensors]
        return FingertipForceState(gain, self.offset_sd * drawn[self.sensors:],
                                   context.noise(2 * self.sensors))

    def step(self, state: FingertipForceState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """The forces of one tick; nothing before the first forces."""
        if not inputs[0].present:
            return ()
        elapsed_s = (tick.time_ns - state.last_ns) / NS_PER_S if state.last_ns >= 0 else 0.0
        state.last_ns = tick.time_ns
        samples = np.empty(self.sensors)
        saturated = read_forces(
            np.asarray(inputs[0].value), state.gain, state.offset, state.noise.row(tick.index),
            np.array((self.noise_sd, self.range_n, self.resolution)), self.drift * math.sqrt(elapsed_s),
            samples)
        if saturated or "saturated" in state.latch.holding:
            names = ", ".join(str(i) for i in range(self.sensors) if saturated >> i & 1)
            state.latch.put(tick, "saturated", bool(saturated), f"sensor {names}")
        return (samples,)
