"""Samples of sensors that turn and are shaken at random."""

import numpy as np
from scipy.spatial.transform import Rotation

G = 9.80665


def waves(rng, times, size, fastest_hz):
    """Smooth random numbers (n, 3) of about a size."""
    hz, phase = rng.uniform(0.05, fastest_hz, (6, 3)), rng.uniform(0.0, 2.0 * np.pi, (6, 3))
    return size * np.sin(2.0 * np.pi * hz * times[:, None, None] + phase).sum(axis=1) / np.sqrt(3.0)


def motion(seed, rate=100.0, seconds=40.0, turning=1.0, shaking=0.5, bias=0.01):
    """Samples of a sensor that turns and is shaken at random, as truth gives them: times, gyr and acc."""
    rng = np.random.default_rng(seed)
    times = np.arange(round(rate * seconds)) / rate
    gyr = waves(rng, times, turning, 1.0)
    turns, reach = Rotation.from_rotvec(np.vstack([rng.standard_normal(3), gyr[:-1] / rate])), 1
    while reach < times.size:
        turns = Rotation.concatenate([turns[:reach], turns[:-reach] * turns[reach:]])
        reach *= 2
    force = waves(rng, times, shaking, 3.0) + np.array([0.0, 0.0, G])
    acc = turns.inv().apply(force) + 0.05 * rng.standard_normal(gyr.shape)
    return times, gyr + bias * rng.standard_normal(3) + 2e-3 * rng.standard_normal(gyr.shape), acc
