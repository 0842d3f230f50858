"""`force_sensors`: force sensors of a glove, on palm and bones, or at the fingertips alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.forms.schema import require_not_negative, require_positive
from fesloop.hand.anthropometry import PARTS
from fesloop.hand.grip import require_places
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample, Sensors, Value

Array = NDArray[np.float64]


class Errors(NamedTuple):
    """Noise sd, threshold, range, resolution (0: none), and sd of the offset's step in a tick, N."""

    noise_sd: float
    threshold: float
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
        if value < errors.threshold:
            value = 0.0
        samples[i] = min(max(value, 0.0), errors.range)
    return saturated


class ForceSensorsState:
    """State of the sensors.

    Attributes
    ----------
    felt: (k,), numbers of the places among `PARTS`.
    gain, offset: (k,), gain and offset, N, of each sensor; the offset wanders.
    noise: random numbers of this trial's ticks.
    last_ns: instant of the last tick; -1 before the first.
    latch: statuses that hold.
    """

    __slots__ = ("felt", "gain", "last_ns", "latch", "noise", "offset")

    def __init__(self, felt: NDArray[np.intp], gain: Array, offset: Array, noise: NoiseStream) -> None:
        self.felt = felt
        self.gain, self.offset, self.noise = gain, offset, noise
        self.last_ns = -1
        self.latch = StatusLatch()


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceSensors:
    """Thin resistive force sensors on parts of a hand: those of a glove, or those at the fingertips alone.

    Input `contact_force` (16,), N, on each of `fesloop.hand.anthropometry.PARTS`; output `force` (k,), N, on
    `places`, from 0 to the range:

        force = clip(round(gain contact_force + offset + noise)), 0 below the threshold

    What touches a part without a sensor is not felt. Gain and initial offset are random once per run, and the
    same in every trial; the drift of the offset starts again with each trial. Hysteresis is omitted. Status
    `saturated` names sensors at the end of their range.

    Attributes
    ----------
    places: the k parts that have a sensor: "palm", and bones such as "F1m" or "F2d".
    gain_sd: sd of the gain about 1 (chosen: that of sensors that were calibrated once).
    offset_sd: sd of the initial offset, N (chosen).
    drift: random walk of the offset, N per square root of a second (chosen: .15 N after a minute).
    noise_sd: white noise of a sample, N (chosen).
    threshold_n: force below which a sensor shows none, N; 0: none such. .1 N for FSR 402 of Interlink (data
        sheet, actuation force).
    range_n: force at which samples saturate, N (chosen: a firm pinch; S19 names no sensor).
    resolution: size of a digit, N (range over ten bits); 0: no rounding.
    """

    places: tuple[str, ...] = PARTS
    gain_sd: float = 0.05
    offset_sd: float = 0.05
    drift: float = 0.02
    noise_sd: float = 0.02
    threshold_n: float = 0.0
    range_n: float = 25.0
    resolution: float = 25.0 / 1024.0

    def __post_init__(self) -> None:
        require_not_negative("force_sensors", self, "gain_sd", "offset_sd", "drift", "noise_sd",
                             "threshold_n", "resolution")
        require_positive("force_sensors", self, "range_n")
        require_places(self.places, "force_sensors.places")
        if not self.places:
            raise InputError("force_sensors.places", "is empty", ", ".join(PARTS), "name a part")
        if not self.threshold_n < self.range_n:
            raise InputError("force_sensors.threshold_n", f"{self.threshold_n:g}",
                             f"below range_n, {self.range_n:g}")

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Contact forces on the parts of the hand."""
        return (Port("contact_force", (len(PARTS),), "N"),)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Readings of the sensors."""
        return (Port("force", (len(self.places),), "N", sensors=Sensors(self.places)),)

    def init(self, context: Context) -> ForceSensorsState:
        """State with the sensors of this run."""
        count = len(self.places)
        normal = NoiseStream(stream_key(context.seed, f"{context.name}/sensors", 0), 2 * count).row(0)
        felt = np.array([PARTS.index(place) for place in self.places])
        return ForceSensorsState(felt, 1.0 + self.gain_sd * normal[:count], self.offset_sd * normal[count:],
                                 context.noise(2 * count))

    def step(self, state: ForceSensorsState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Readings of one tick; none before the first forces."""
        if not inputs[0].present:
            return ()
        elapsed_s = (tick.time_ns - state.last_ns) / NS_PER_S if state.last_ns >= 0 else 0.0
        state.last_ns = tick.time_ns
        samples = np.empty(len(self.places))
        saturated = read_forces(
            cast(Array, inputs[0].value)[state.felt], state.gain, state.offset, state.noise.row(tick.index),
            Errors(self.noise_sd, self.threshold_n, self.range_n, self.resolution,
                   self.drift * math.sqrt(elapsed_s)), samples)
        if saturated or "saturated" in state.latch.holding:
            names = ", ".join(place for i, place in enumerate(self.places) if saturated >> i & 1)
            state.latch.put(tick, "saturated", bool(saturated), f"on {names}")
        return (samples,)
