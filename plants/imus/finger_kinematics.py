"""What ideal inertial sensors on hand and index finger feel, by the chain's recursion.

Frames (right hand): x palmar, y proximal, z radial; bones lie along -y; flexion is positive about +z, so
each segment is turned about its parent's z by its joint's angle. The hand stands still.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled

Array = NDArray[np.float64]


@compiled
def chain_samples(
    angles: Array, rates: Array, accelerations: Array, lengths: Array, up: Array, samples: Array
) -> None:
    """Fill `samples` with angular rate and specific force at hand, proximal, middle and distal segment.

    (2, 4, 3), each in its segment's own frame, rad/s and m/s^2, at the middle of the segment.

    Parameters
    ----------
    angles, rates, accelerations: (3,), of MCP, PIP, DIP, rad, s.
    lengths: (3,), of the phalanges, m.
    up: (3,), what an accelerometer at rest reads in the hand's frame, m/s^2.
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


@compiled
def corrupt(
    samples: Array, mounting: Array, bias: Array, noise: Array, noise_sd: Array, limits: Array,
    resolution: Array,
) -> int:
    """Make ideal samples real, in place; returns a bit mask of the sensors that clipped.

    Turned into the sensor's frame, then biased, noisy, rounded and clipped, in this order.

    Parameters
    ----------
    samples, bias: (2, sensors, 3), gyroscopes then accelerometers.
    mounting: (sensors, 3, 3), from segment to sensor frame.
    noise: (6 sensors,) standard normal; noise_sd, limits: (2,).
    resolution: (2,); 0 rounds nothing.
    """
    clipped = 0
    for kind in range(2):
        limit, step = limits[kind], resolution[kind]
        for sensor in range(samples.shape[1]):
            x, y, z = samples[kind, sensor, 0], samples[kind, sensor, 1], samples[kind, sensor, 2]
            for axis in range(3):
                turn = mounting[sensor, axis]
                value = turn[0] * x + turn[1] * y + turn[2] * z + bias[kind, sensor, axis]
                value += noise_sd[kind] * noise[(kind * samples.shape[1] + sensor) * 3 + axis]
                if step > 0.0:
                    value = round(value / step) * step
                if abs(value) > limit:
                    value = math.copysign(limit, value)
                    clipped |= 1 << sensor
                samples[kind, sensor, axis] = value
    return clipped


@compiled
def walk_bias(bias: Array, noise: Array, sd: float) -> None:
    """One step of the gyroscopes' random walk on `bias` (2, sensors, 3); `noise` (3 sensors,) normal."""
    for sensor in range(bias.shape[1]):
        for axis in range(3):
            bias[0, sensor, axis] += sd * noise[sensor * 3 + axis]


@compiled
def measure(
    angles: Array, rates: Array, accelerations: Array, geometry: Array, mounting: Array, bias: Array,
    noise: Array, errors: Array, samples: Array,
) -> int:
    """Fill `samples` (2, 4, 3) of one tick, step `bias` on, return the mask of clipped sensors.

    `geometry` stacks lengths and up, (2, 3); `noise` (36,) serves samples, then walk; `errors` (4, 2) has
    rows noise sd, limits, resolution and (walk a tick, 0), for gyroscopes and accelerometers.
    """
    chain_samples(angles, rates, accelerations, geometry[0], geometry[1], samples)
    walk_bias(bias, noise[24:], errors[3, 0])
    clipped: int = corrupt(samples, mounting, bias, noise, errors[0], errors[1], errors[2])
    return clipped
