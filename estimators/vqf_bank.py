"""One `vqf` filter a sensor, as a state that can be copied, pickled and continued bit for bit.

The filter is VQF (Laidig and Seel 2023, doi 10.1016/j.inffus.2022.10.014), from the package of its
authors; its objects live in C++, so what pickles is their parameters and their state.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from vqf import VQF

Array = NDArray[np.float64]


class VqfBank:
    """Filters of `sensors` inertial sensors, with or without their magnetometers.

    Parameters
    ----------
    sensors: how many.
    period_s: of the samples; VQF takes it as constant.
    magnetometer: 9-axis fusion in place of 6-axis.
    settings: further parameters of VQF, under its own names (tauAcc, tauMag, ...).
    """

    __slots__ = ("_filters", "_quaternions", "_settings", "_updates", "magnetometer", "period_s")

    def __init__(self, sensors: int, period_s: float, magnetometer: bool, **settings: float) -> None:
        self.period_s, self.magnetometer, self._settings = period_s, magnetometer, settings
        self._fill([VQF(period_s, **settings) for _ in range(sensors)])

    def _fill(self, filters: list[Any]) -> None:
        self._filters = filters
        self._updates = [f.update for f in filters]
        self._quaternions = [f.getQuat9D if self.magnetometer else f.getQuat6D for f in filters]

    def update(self, gyr: Array, acc: Array, mag: Array | None) -> None:
        """One sample of every sensor, (n, 3) each, C-contiguous: rad/s, m/s^2, any unit of field."""
        if mag is None:
            for update, rate, specific_force in zip(self._updates, gyr, acc, strict=True):
                update(rate, specific_force)
        else:
            for update, rate, specific_force, field in zip(self._updates, gyr, acc, mag, strict=True):
                update(rate, specific_force, field)

    def update_only(self, used: NDArray[np.bool_], gyr: Array, acc: Array, mag: Array | None) -> None:
        """One sample of the sensors that are `used`, (n,); the others stay where they are."""
        for i in np.flatnonzero(used):
            self._updates[i](gyr[i], acc[i], *(() if mag is None else (mag[i],)))

    def orientation(self) -> Array:
        """Sensor to earth frame (z up; with magnetometers y north), (n, 4), w x y z."""
        return np.concatenate([quaternion() for quaternion in self._quaternions]).reshape(-1, 4)

    def __getstate__(self) -> tuple[float, bool, dict[str, float], list[Any]]:
        return self.period_s, self.magnetometer, self._settings, [f.state for f in self._filters]

    def __setstate__(self, saved: tuple[float, bool, dict[str, float], list[Any]]) -> None:
        self.period_s, self.magnetometer, self._settings, states = saved
        filters = []
        for state in states:
            made = VQF(self.period_s, **self._settings)
            made.state = state
            filters.append(made)
        self._fill(filters)
