"""Activation and fitness of all muscles at many instants between two changes of their drive, compiled."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fesloop.loop.clock import NS_PER_S
from plants.muscle_models.fitness import tire
from plants.muscle_models.lags import settle_lags

Array = NDArray[np.float64]


@njit(cache=True)
def follow(
    levels: Array, drive: Array, lags_s: tuple[float, float], changed_ns: int, fitness: Array, effort: Array,
    fatigue: tuple[float, float, float], worn_ns: int, times_ns: NDArray[np.int64], activation: Array,
    fit: Array,
) -> None:
    """Fill `activation` and `fit` (n, muscles) at `times_ns` (n,).

    Two lags, of `lags_s`, have had `levels` (2, muscles) at `changed_ns`, and `drive` (muscles,) since; the
    muscles have had `fitness` (muscles,) at `worn_ns`, and `effort` (muscles,) since, under a `fatigue`
    (floor, wear, repair) as `tire` takes it.
    """
    settled = np.empty_like(levels)
    for k in range(times_ns.size):
        settle_lags(levels, drive, lags_s[0], lags_s[1], (times_ns[k] - changed_ns) / NS_PER_S, settled)
        tire(fitness, effort, fatigue[0], fatigue[1], fatigue[2], (times_ns[k] - worn_ns) / NS_PER_S, fit[k])
        for i in range(drive.size):
            activation[k, i] = min(settled[1, i], 1.0) * fit[k, i]
