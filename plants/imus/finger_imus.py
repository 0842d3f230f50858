"""`finger_imus`: inertial sensors on the hand and on the three phalanges of the index finger."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.forms.schema import require_not_negative, require_positive, require_shape
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.loop.block import Context, Tick
from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample, Value
from plants.finger.dynamics import INDEX_LENGTHS_MM
from plants.imus.device import rotations

Array = NDArray[np.float64]


@compiled
def chain_samples(
    angles: Array, rates: Array, accelerations: Array, lengths: Array, up: Array, samples: Array
) -> None:
    """Fill `samples` (2, 4, 3) with angular rate and specific force at the middle of each segment.

    Segments are hand, proximal, middle, distal; values are in each segment's own frame, rad/s and m/s^2.

    Parameters
    ----------
    angles, rates, accelerations: (3,), motion of MCP, PIP, DIP, rad, s.
    lengths: (3,), lengths of the phalanges, m.
    up: (3,), reading of an accelerometer at rest in the hand's frame, m/s^2.
    """
    samples[0] = 0.0
    x, y, z = up[0], up[1], up[2]
    samples[1, 0, 0], samples[1, 0, 1], samples[1, 0, 2] = x, y, z
    turning, turning_up = 0.0, 0.0
    for k in range(3):
        cosine, sine = math.cos(angles[k]), math.sin(angles[k])
        x, y = cosine * x + sine * y, -sine * x + cosine * y
        turning += rates[k]
        turning_up += accelerations[k]
        # A point r = (0, -s, 0) of the segment gains alpha x r + omega x (omega x r) over its joint.
        tangential, centripetal = turning_up * lengths[k], turning * turning * lengths[k]
        samples[0, k + 1, 2] = turning
        samples[1, k + 1, 0] = x + 0.5 * tangential
        samples[1, k + 1, 1] = y + 0.5 * centripetal
        samples[1, k + 1, 2] = z
        x += tangential
        y += centripetal


class Errors(NamedTuple):
    """Sizes of errors: noise sd, limit and resolution (0: none), (2,) each, of gyroscopes and accelerometers,
    and the gyroscopes' random walk since the last tick, rad/s."""

    noise_sd: Array
    limit: Array
    resolution: Array
    walk: float


class Geometry(NamedTuple):
    """Lengths of the phalanges (3,), m, and an accelerometer's reading at rest in the hand's frame, (3,)."""

    lengths: Array
    up: Array


@compiled
def corrupt(samples: Array, mounting: Array, bias: Array, noise: Array, errors: Errors) -> int:
    """Add errors to ideal samples, in place; returns a bit mask of the sensors that clip.

    Samples are rotated into the sensor's frame, then biased, noisy, rounded and clipped, in this order.

    Parameters
    ----------
    samples, bias: (2, sensors, 3), gyroscopes then accelerometers.
    mounting: (sensors, 3, 3), from segment to sensor frame.
    noise: (6 sensors,) standard normal.
    """
    clipped = 0
    for kind in range(2):
        limit, step = errors.limit[kind], errors.resolution[kind]
        for sensor in range(samples.shape[1]):
            x, y, z = samples[kind, sensor, 0], samples[kind, sensor, 1], samples[kind, sensor, 2]
            for axis in range(3):
                turn = mounting[sensor, axis]
                value = turn[0] * x + turn[1] * y + turn[2] * z + bias[kind, sensor, axis]
                value += errors.noise_sd[kind] * noise[(kind * samples.shape[1] + sensor) * 3 + axis]
                if step > 0.0:
                    value = round(value / step) * step
                if abs(value) > limit:
                    value = math.copysign(limit, value)
                    clipped |= 1 << sensor
                samples[kind, sensor, axis] = value
    return clipped


@compiled
def walk_bias(bias: Array, noise: Array, sd: float) -> None:
    """Do one step of the gyroscopes' random walk in `bias` (2, sensors, 3); `noise` (3 sensors,) normal."""
    for sensor in range(bias.shape[1]):
        for axis in range(3):
            bias[0, sensor, axis] += sd * noise[sensor * 3 + axis]


@compiled
def measure(
    angles: Array, rates: Array, accelerations: Array, geometry: Geometry, mounting: Array, bias: Array,
    noise: Array, errors: Errors, samples: Array,
) -> int:
    """Fill `samples` (2, 4, 3) of one tick, advance `bias`, and return the mask of clipped sensors.

    `noise` (36,) serves samples, then the walk.
    """
    chain_samples(angles, rates, accelerations, geometry.lengths, geometry.up, samples)
    walk_bias(bias, noise[24:], errors.walk)
    clipped: int = corrupt(samples, mounting, bias, noise, errors)
    return clipped


SENSORS = ("hand", "proximal", "middle", "distal")


class FingerImusState:
    """State of the sensors.

    Attributes
    ----------
    mounting: (4, 3, 3), from each segment's frame to its sensor's.
    bias: (2, 4, 3), of gyroscopes (rad/s) and accelerometers (m/s^2); the former walks.
    noise: random numbers of this trial's ticks.
    errors: sizes of errors, with the walk of one tick.
    last: number of the last tick; -1 before the first.
    latch: statuses that hold.
    """

    __slots__ = ("bias", "errors", "last", "latch", "mounting", "noise")

    def __init__(self, mounting: Array, bias: Array, noise: NoiseStream, errors: Errors) -> None:
        self.mounting, self.bias, self.noise, self.errors = mounting, bias, noise, errors
        self.last = -1
        self.latch = StatusLatch()

    def errors_at(self, index: int) -> Errors:
        """Errors of a tick, with a walk that includes skipped ticks before it."""
        ticks, self.last = index - self.last, index
        if ticks == 1:
            return self.errors
        return self.errors._replace(walk=self.errors.walk * math.sqrt(ticks))


@dataclass(frozen=True, slots=True, kw_only=True)
class FingerImus:
    """Gyroscope and accelerometer mid-segment on hand, proximal, middle and distal phalanx.

    Inputs: `angles`, `rates`, `accelerations` of MCP, PIP, DIP (3,), positive in flexion. Outputs: `gyr`
    and `acc`, (4, 3), in the sensors' frames, which are those of the segments (right hand: x palmar,
    y proximal, z radial, bones along -y) rotated by the mounting error. An accelerometer reads specific
    force: at rest, upward gravity. The hand does not move; the noise follows Kortier 2014
    (doi 10.1186/1743-0003-11-70), table 1. Status `clipped` names sensors at the end of their range.

    Bias and mounting are random once per run, and the same in each trial; the random walk starts again with
    each trial.

    Attributes
    ----------
    lengths_mm: lengths of the phalanges.
    hand_orientation: quaternion (w, x, y, z) from the hand's frame to the global one (ENU, gravity along
        -z). By default palm down with fingers to the north, so the flexion axis is horizontal.
    gyroscope_noise_sd, accelerometer_noise_sd: white noise of a sample, rad/s and m/s^2.
    gyroscope_walk: random walk of the bias, rad/s per square root of a second.
    gyroscope_bias_sd, accelerometer_bias_sd: sd of the constant bias, rad/s and m/s^2 (chosen: for a sensor
        whose bias at rest was removed before).
    misalignment_deg: sd of the mounting error about each axis (5-10 in Salchow-Hoemmen 2019,
        doi 10.3390/s19010208, before alignment).
    gyroscope_range_deg_s, accelerometer_range_g: magnitude at which samples clip.
    gyroscope_resolution, accelerometer_resolution: size of a digit, rad/s and m/s^2; 0: no rounding.
    """

    lengths_mm: tuple[float, float, float] = INDEX_LENGTHS_MM
    hand_orientation: tuple[float, float, float, float] = (0.0, math.sqrt(0.5), 0.0, -math.sqrt(0.5))
    gyroscope_noise_sd: float = 5e-4
    accelerometer_noise_sd: float = 4e-2
    gyroscope_walk: float = 1e-4
    gyroscope_bias_sd: float = 1e-3
    accelerometer_bias_sd: float = 2e-2
    misalignment_deg: float = 0.0
    gyroscope_range_deg_s: float = 2000.0
    accelerometer_range_g: float = 16.0
    gyroscope_resolution: float = 0.0
    accelerometer_resolution: float = 0.0
    _geometry: Geometry = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_shape("finger_imus", self, (3,), "proximal, middle, distal", "lengths_mm")
        require_shape("finger_imus", self, (4,), "w, x, y, z", "hand_orientation")
        require_positive("finger_imus", self, "lengths_mm", "gyroscope_range_deg_s", "accelerometer_range_g")
        require_not_negative("finger_imus", self, "gyroscope_noise_sd", "accelerometer_noise_sd",
                             "gyroscope_walk", "gyroscope_bias_sd", "accelerometer_bias_sd",
                             "misalignment_deg", "gyroscope_resolution", "accelerometer_resolution")
        if abs(math.hypot(*self.hand_orientation) - 1.0) > 1e-6:
            raise InputError("finger_imus.hand_orientation", f"{self.hand_orientation}",
                             "a quaternion (w, x, y, z) of length 1")
        up = STANDARD_GRAVITY * _third_row(self.hand_orientation)
        object.__setattr__(self, "_geometry", Geometry(1e-3 * np.asarray(self.lengths_mm), up))

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Joint angles, rates and accelerations."""
        return (Port("angles", (3,), "rad"), Port("rates", (3,), "rad/s"),
                Port("accelerations", (3,), "rad/s^2"))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Samples of the sensors on hand, proximal, middle, distal segment."""
        return Port("gyr", (4, 3), "rad/s"), Port("acc", (4, 3), "m/s^2")

    def init(self, context: Context) -> FingerImusState:
        """State with the sensors of this run; InputError without a clock."""
        if context.clock is None:
            raise InputError(context.name, "no rate", 'a rate such as "100"', "give the node a rate")
        bias = np.empty((2, len(SENSORS), 3))
        constant = self._random(context, "bias", 24).reshape(bias.shape)
        bias[0] = self.gyroscope_bias_sd * constant[0]
        bias[1] = self.accelerometer_bias_sd * constant[1]
        turns = math.radians(self.misalignment_deg) * self._random(context, "mounting", 12).reshape(-1, 3)
        errors = Errors(
            noise_sd=np.array([self.gyroscope_noise_sd, self.accelerometer_noise_sd]),
            limit=np.array([math.radians(self.gyroscope_range_deg_s),
                            self.accelerometer_range_g * STANDARD_GRAVITY]),
            resolution=np.array([self.gyroscope_resolution, self.accelerometer_resolution]),
            walk=self.gyroscope_walk * math.sqrt(context.clock.period_s))
        return FingerImusState(rotations(turns), bias, context.noise(36), errors)

    def _random(self, context: Context, purpose: Literal["bias", "mounting"], width: int) -> Array:
        """Normal random numbers, the same in every trial."""
        return NoiseStream(stream_key(context.seed, f"{context.name}/{purpose}", 0), width).row(0)

    def step(self, state: FingerImusState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """(gyr, acc) of one tick."""
        if not inputs[0].present or "waiting" in state.latch.holding:
            state.latch.put(tick, "waiting", not inputs[0].present,
                            "no posture has arrived; samples are those at angles of 0")
        angles: Any = inputs[0][0]
        rates: Any = inputs[1][0]
        accelerations: Any = inputs[2][0]
        samples = np.empty((2, 4, 3))
        clipped = measure(angles, rates, accelerations, self._geometry, state.mounting, state.bias,
                          state.noise.row(tick.index), state.errors_at(tick.index), samples)
        if clipped or "clipped" in state.latch.holding:
            names = (name for bit, name in enumerate(SENSORS) if clipped >> bit & 1)
            state.latch.put(tick, "clipped", bool(clipped), "out of range: " + ", ".join(names))
        return samples[0], samples[1]


def _third_row(quaternion: tuple[float, float, float, float]) -> Array:
    """Global vertical in a body's frame: the last row of its rotation matrix to the global frame."""
    w, x, y, z = quaternion
    return np.array([2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z])
