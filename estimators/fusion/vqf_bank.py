"""One `vqf` filter a sensor, as a state that can be copied, pickled and continued bit for bit.

The filter is VQF (Laidig and Seel 2023, doi 10.1016/j.inffus.2022.10.014), from the package of its
authors; its objects live in C++, so what pickles is their parameters and their state.
"""

from __future__ import annotations

from collections import deque
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
    period_s: of the gyroscopes' samples; VQF takes it as constant.
    magnetometer: 9-axis fusion in place of 6-axis.
    acc_period_s, mag_period_s: of the others, where they are slower.
    settings: further parameters of VQF, under its own names (tauAcc, tauMag, ...).
    """

    __slots__ = ("_filters", "_periods_s", "_settings", "magnetometer")

    def __init__(
        self, sensors: int, period_s: float, magnetometer: bool, *, acc_period_s: float | None = None,
        mag_period_s: float | None = None, **settings: float
    ) -> None:
        self._periods_s = (period_s, acc_period_s or period_s, mag_period_s or period_s)
        self.magnetometer, self._settings = magnetometer, settings
        self._filters = [self._new() for _ in range(sensors)]

    def _new(self) -> Any:
        return VQF(*self._periods_s, **self._settings)

    def update(self, gyr: Array, acc: Array | None, mag: Array | None) -> None:
        """One sample of every sensor, (n, 3) each, C-contiguous: rad/s, m/s^2, any unit of field.

        None stands for a kind of which this tick brings no sample.
        """
        if acc is None:
            self.update_only(np.ones(len(self._filters), dtype=np.bool_), gyr, None, mag)
        elif mag is None:
            deque(map(VQF.update, self._filters, gyr, acc), maxlen=0)
        else:
            deque(map(VQF.update, self._filters, gyr, acc, mag), maxlen=0)

    def update_only(
        self, used: NDArray[np.bool_], gyr: Array, acc: Array | None, mag: Array | None
    ) -> None:
        """One sample of the sensors that are `used`, (n,); the others stay where they are."""
        for i in np.flatnonzero(used):
            filter_ = self._filters[i]
            filter_.updateGyr(gyr[i])
            if acc is not None:
                filter_.updateAcc(acc[i])
            if mag is not None:
                filter_.updateMag(mag[i])

    def begin(
        self, used: NDArray[np.bool_], bias: Array, acc: Array, mag: Array | None, samples: int
    ) -> None:
        """Let the sensors that are `used` begin anew, after a rest of so many samples at these readings.

        Parameters
        ----------
        bias: (n, 3), rad/s, of the gyroscopes.
        acc, mag: (n, 3), what they read in the rest; without mag the heading begins at zero.
        """
        filters = list(self._filters)
        for i in np.flatnonzero(used):
            filters[i] = self._new()
            filters[i].setBiasEstimate(np.ascontiguousarray(bias[i]))
            rest = [np.tile(kind[i], (samples, 1)) for kind in (bias, acc, mag) if kind is not None]
            filters[i].updateBatch(*rest)
        self._filters = filters

    def orientation(self) -> Array:
        """Sensor to earth frame (z up; with magnetometers y north), (n, 4), w x y z."""
        quaternion = VQF.getQuat9D if self.magnetometer else VQF.getQuat6D
        # Joining bytes costs less than concatenating small arrays; what comes out cannot be written to.
        return np.frombuffer(b"".join(map(quaternion, self._filters))).reshape(-1, 4)

    def __getstate__(self) -> tuple[tuple[float, float, float], bool, dict[str, float], list[Any]]:
        return self._periods_s, self.magnetometer, self._settings, [f.state for f in self._filters]

    def __setstate__(
        self, saved: tuple[tuple[float, float, float], bool, dict[str, float], list[Any]]
    ) -> None:
        self._periods_s, self.magnetometer, self._settings, states = saved
        filters = []
        for state in states:
            filters.append(self._new())
            filters[-1].state = state
        self._filters = filters
