"""What drives all muscles from a change to the next, and what it makes of them at many instants, compiled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.loop.clock import NS_PER_S
from plants.muscles.fitness import FASTEST_HZ, tire
from plants.muscles.lags import settle_lags

Array = NDArray[np.float64]


@compiled
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


@compiled
def limit_pulses(
    recruitment: Array, frequency: Array, highest_hz: float, before: Array, pulses: Array
) -> bool:
    """Fill `pulses` (2, muscles) with both, put within 0 and 1, and 0 and `highest_hz`; whether they changed.

    `before` (2, muscles): what they were.
    """
    changed = False
    for i in range(recruitment.size):
        pulses[0, i] = min(max(recruitment[i], 0.0), 1.0)
        pulses[1, i] = min(max(frequency[i], 0.0), highest_hz)
        changed = changed or pulses[0, i] != before[0, i] or pulses[1, i] != before[1, i]
    return changed


@compiled
def held_drives(
    pulses: Array, effort: Array, reflex: Array, fusion_hz: float, frequency_weight: float
) -> tuple[Array, Array, Array]:
    """Steady activation, the effort that wears the muscles, and their natural drive, (muscles,) each.

    Activation is the recruited fraction times h(f) = r / (1 + r), r = (f / fusion_hz)^2; what wears is
    `MuscleFatigue.effort`; `effort` and `reflex` (muscles,) have the fibres that stimulation does not hold.
    """
    count = effort.size
    steady, wearing, natural = np.empty(count), np.empty(count), np.empty(count)
    for i in range(count):
        recruited, hertz = pulses[0, i], pulses[1, i]
        ratio = (hertz / fusion_hz) ** 2
        steady[i] = recruited * (ratio / (1.0 + ratio))
        share = min(hertz, FASTEST_HZ) / FASTEST_HZ
        wearing[i] = steady[i] * (1.0 - frequency_weight + frequency_weight * share**2)
        natural[i] = min(effort[i] + reflex[i], 1.0 - recruited if hertz > 0.0 else 1.0)
    return steady, wearing, natural
