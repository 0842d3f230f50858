"""Front ends of trackers: fusion of single inertial sensors, chosen by name, behind one protocol."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray
from vqf import VQF

from fesloop.compiled import compiled
from fesloop.errors import InputError, did_you_mean
from fesloop.hand.kinematics_kernels import turned
from fesloop.hand.quaternion_kernels import Components, about_z, conjugate, multiply

Array = NDArray[np.float64]
Rows = Array | Sequence[Array]


class VqfBank:
    """VQF filters of `sensors` inertial sensors, with or without their magnetometers.

    Parameters
    ----------
    sensors: number of sensors.
    period_s: sampling period of the gyroscopes; VQF assumes it to be constant.
    magnetometer: whether to use 9-axis fusion in place of 6-axis.
    acc_period_s, mag_period_s: sampling periods of the others, where they are slower.
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

    def update(self, gyr: Rows, acc: Rows | None, mag: Rows | None) -> None:
        """Process one sample of every sensor, n rows (3,), C-contiguous: rad/s, m/s^2, any unit of field.

        None means that this tick has no sample of that kind.
        """
        if acc is None:
            self.update_sound(gyr, None, mag, np.zeros((3, len(self._filters)), dtype=np.bool_))
        elif mag is None:
            deque(map(VQF.update, self._filters, gyr, acc), maxlen=0)
        else:
            deque(map(VQF.update, self._filters, gyr, acc, mag), maxlen=0)

    def update_sound(
        self, gyr: Rows, acc: Rows | None, mag: Rows | None, lost: NDArray[np.bool_]
    ) -> None:
        """As `update`, without the samples in `lost`, (3, n), of gyr, acc and mag."""
        for i, filter_ in enumerate(self._filters):
            if not lost[0, i]:
                filter_.updateGyr(gyr[i])
            if acc is not None and not lost[1, i]:
                filter_.updateAcc(acc[i])
            if mag is not None and not lost[2, i]:
                filter_.updateMag(mag[i])

    def begin(
        self, used: NDArray[np.bool_], bias: Array, acc: Array, mag: Array | None, samples: int
    ) -> None:
        """Restart the sensors in `used` after a rest of `samples` samples with these readings.

        Parameters
        ----------
        bias: (n, 3), rad/s, of the gyroscopes.
        acc, mag: (n, 3), readings at rest; without mag the heading starts at zero.
        """
        filters = list(self._filters)
        for i in np.flatnonzero(used):
            filters[i] = self._new()
            filters[i].setBiasEstimate(np.ascontiguousarray(bias[i]))
            rest = [np.tile(kind[i], (samples, 1)) for kind in (bias, acc, mag) if kind is not None]
            filters[i].updateBatch(*rest)
        self._filters = filters

    def orientation(self) -> Array:
        """Orientations (n, 4), w x y z, sensor to earth frame (z up; with magnetometers y north)."""
        quaternion = VQF.getQuat9D if self.magnetometer else VQF.getQuat6D
        # Joining bytes costs less than concatenating small arrays; the result is read-only.
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


HALVING = 1.4
"""Ratio of a time constant to a halving time, 1 / ln 2, as rounded by `qmt.oriEstIMU`."""
GRAVITY = 9.81
"""Reference of the accelerometers' rating, m/s^2, as rounded by `qmt.oriEstIMU`."""
RATED_SAMPLES = 10
"""Number of latest samples of which the worst rates the accelerometer."""
BIAS_SHARE = HALVING / 160.0
"""Factor of zeta^2 k^2 / ((1 - k) T), the gain of the bias estimate."""
_START = np.array([0.5, 0.5, 0.5, 0.5])


@compiled(inline="always")
def _turn(x: float, y: float, z: float) -> Components:
    """Rotation by the vector (x, y, z), rad."""
    angle = math.sqrt(x * x + y * y + z * z)
    share = 0.5 * math.sin(0.5 * angle) / (0.5 * angle) if angle > 1e-12 else 0.5
    return math.cos(0.5 * angle), share * x, share * y, share * z


@compiled
def gain(tau_s: float, step: int, period_s: float, rating: float) -> float:
    """Fraction k of an error that a sample corrects.

    Parameters
    ----------
    tau_s: halving time of an error, s.
    step: number of samples so far, 1 or more; before it reaches 2 tau / T the gain is that of a shorter tau.
    rating: factor on 1 / k, 1 or more.
    """
    reached = min(tau_s, 0.5 * step * period_s)
    return 1.0 / ((1.0 + HALVING * reached / period_s) * rating)


@compiled
def _learn(
    bias: Array, q: Components, error: tuple[float, float, float], share: float, period_s: float, zeta: float
) -> None:
    """Correct a gyroscope's bias (3,) by `error`, an earth-frame rotation of which `share` is corrected."""
    scale = BIAS_SHARE * zeta * zeta * share * share / ((1.0 - share) * period_s)
    x, y, z = turned(conjugate(q), error[0], error[1], error[2])
    bias[0] -= scale * x
    bias[1] -= scale * y
    bias[2] -= scale * z


@compiled
def predict(gyr: Array, lost: NDArray[np.bool_], period_s: float, q: Array, bias: Array) -> None:
    """Integrate rates (n, 3), rad/s, less `bias` (n, 3), into q (n, 4), but of sensors in `lost`."""
    for s in range(q.shape[0]):
        if not lost[s]:
            now = multiply((q[s, 0], q[s, 1], q[s, 2], q[s, 3]),
                           _turn(period_s * (gyr[s, 0] - bias[s, 0]), period_s * (gyr[s, 1] - bias[s, 1]),
                                 period_s * (gyr[s, 2] - bias[s, 2])))
            _keep(q[s], now)


@compiled
def correct_inclination(
    acc: Array, lost: NDArray[np.bool_], settings: Array, q: Array, bias: Array, steps: NDArray[np.int64],
    deviations: Array
) -> None:
    """Rotate q (n, 4) about horizontal axes towards the vertical of acc (n, 3), m/s^2.

    Parameters
    ----------
    lost: (n,), mask of sensors without a sample.
    settings: sampling period and halving time, s, zeta, rating, time from which the bias is estimated, s.
    steps: (n,), samples so far; deviations: (n, RATED_SAMPLES), from gravity, m/s^2.
    """
    period, tau, zeta, rating = settings[0], settings[1], settings[2], settings[3]
    for s in range(q.shape[0]):
        size = math.sqrt(acc[s, 0] ** 2 + acc[s, 1] ** 2 + acc[s, 2] ** 2)
        if lost[s] or size == 0.0:
            continue
        deviations[s, steps[s] % RATED_SAMPLES] = abs(size - GRAVITY)
        steps[s] += 1
        before = (q[s, 0], q[s, 1], q[s, 2], q[s, 3])
        x, y, z = turned(before, acc[s, 0], acc[s, 1], acc[s, 2])
        level = math.sqrt(x * x + y * y)
        if level == 0.0:
            continue
        share = gain(tau, steps[s], period, 1.0 + rating * deviations[s].max())
        # acc x vertical is the axis of the rotation that takes acc to the vertical.
        angle = math.atan2(level, z)
        error = (angle * y / level, -angle * x / level, 0.0)
        now = multiply(_turn(share * error[0], share * error[1], 0.0), before)
        _keep(q[s], now)
        if zeta > 0.0 and steps[s] * period >= settings[4]:
            _learn(bias[s], now, error, share, period, zeta)


@compiled
def correct_heading(
    mag: Array, lost: NDArray[np.bool_], settings: Array, q: Array, bias: Array, steps: NDArray[np.int64]
) -> None:
    """Rotate q (n, 4) about the vertical to turn mag (n, 3), any unit, to y; as `correct_inclination`."""
    period, tau, zeta = settings[0], settings[1], settings[2]
    for s in range(q.shape[0]):
        if lost[s]:
            continue
        before = (q[s, 0], q[s, 1], q[s, 2], q[s, 3])
        x, y, _ = turned(before, mag[s, 0], mag[s, 1], mag[s, 2])
        if x == 0.0 and y == 0.0:
            continue
        steps[s] += 1
        share = gain(tau, steps[s], period, 1.0)
        error = (0.0, 0.0, math.atan2(x, y))
        now = multiply(_turn(0.0, 0.0, share * error[2]), before)
        _keep(q[s], now)
        if zeta > 0.0 and steps[s] * period >= settings[4]:
            _learn(bias[s], now, error, share, period, zeta)


@compiled
def level_at(acc: Array, used: NDArray[np.bool_], q: Array) -> None:
    """Set q (n, 4) of the sensors in `used` to the smallest rotation that makes acc (n, 3) vertical."""
    for s in range(q.shape[0]):
        if used[s]:
            x, y, z = acc[s, 0], acc[s, 1], acc[s, 2]
            upright = z + math.sqrt(x * x + y * y + z * z)
            _keep(q[s], (upright, y, -x, 0.0) if upright > 1e-9 else (0.0, 1.0, 0.0, 0.0))


@compiled
def face_north(mag: Array, used: NDArray[np.bool_], q: Array) -> None:
    """Rotate q (n, 4) of the sensors in `used` about the vertical so that mag (n, 3) points to y."""
    for s in range(q.shape[0]):
        if used[s]:
            now = (q[s, 0], q[s, 1], q[s, 2], q[s, 3])
            x, y, _ = turned(now, mag[s, 0], mag[s, 1], mag[s, 2])
            _keep(q[s], multiply(about_z(math.atan2(x, y)), now))


@compiled(inline="always")
def _keep(row: Array, q: Components) -> None:
    scale = 1.0 / math.sqrt(q[0] ** 2 + q[1] ** 2 + q[2] ** 2 + q[3] ** 2)
    for i in range(4):
        row[i] = scale * q[i]


class SeelRuppinBank:
    """Seel-Ruppin filters of `sensors` inertial sensors, with or without magnetometers; can be pickled.

    Parameters
    ----------
    sensors: number of sensors.
    period_s: sampling period of the gyroscopes.
    acc_period_s, mag_period_s: sampling periods of the others, where they are slower.
    magnetometer: whether to use 9-axis fusion in place of 6-axis.
    tau_acc_s, tau_mag_s: halving times of an error, s (1 and 3: defaults of `qmt.oriEstIMU`).
    zeta: strength of the bias estimation; 0: none.
    acc_rating: loss of trust in an accelerometer that deviates from gravity, per m/s^2.

    Raises InputError for times that are not positive and for negative strengths.
    """

    __slots__ = ("acc_settings", "acc_steps", "bias", "deviations", "mag_settings", "mag_steps",
                 "magnetometer", "none_lost", "period_s", "q")

    def __init__(
        self, sensors: int, period_s: float, magnetometer: bool, *, acc_period_s: float | None = None,
        mag_period_s: float | None = None, tau_acc_s: float = 1.0, tau_mag_s: float = 3.0, zeta: float = 0.0,
        acc_rating: float = 1.0
    ) -> None:
        for name, value, least in (("tau_acc_s", tau_acc_s, 1e-9), ("tau_mag_s", tau_mag_s, 1e-9),
                                   ("zeta", zeta, 0.0), ("acc_rating", acc_rating, 0.0)):
            if not (math.isfinite(value) and value >= least):
                raise InputError(name, f"{value}", "a finite number above 0" if least else "0 or more")
        self.period_s, self.magnetometer = period_s, magnetometer
        self.acc_settings = np.array([acc_period_s or period_s, tau_acc_s, zeta, acc_rating, tau_acc_s])
        self.mag_settings = np.array([mag_period_s or period_s, tau_mag_s, zeta, 0.0, tau_acc_s])
        self.none_lost = np.zeros((3, sensors), dtype=np.bool_)
        self.q, self.bias = np.tile(_START, (sensors, 1)), np.zeros((sensors, 3))
        self.acc_steps = np.zeros(sensors, dtype=np.int64)
        self.mag_steps = np.zeros(sensors, dtype=np.int64)
        self.deviations = np.zeros((sensors, RATED_SAMPLES))

    def update(self, gyr: Array, acc: Array | None, mag: Array | None) -> None:
        """Process one sample of every sensor, (n, 3) each; None where the tick has none of that kind."""
        self.update_sound(gyr, acc, mag, self.none_lost)

    def update_sound(
        self, gyr: Array, acc: Array | None, mag: Array | None, lost: NDArray[np.bool_]
    ) -> None:
        """As `update`, without the samples in `lost`, (3, n), of gyr, acc and mag."""
        predict(gyr, lost[0], self.period_s, self.q, self.bias)
        if acc is not None:
            correct_inclination(acc, lost[1], self.acc_settings, self.q, self.bias, self.acc_steps,
                                self.deviations)
        if mag is not None:
            correct_heading(mag, lost[2], self.mag_settings, self.q, self.bias, self.mag_steps)

    def begin(
        self, used: NDArray[np.bool_], bias: Array, acc: Array, mag: Array | None, samples: int
    ) -> None:
        """Restart the sensors in `used` as after a rest of `samples` samples with these readings.

        Parameters
        ----------
        bias: (n, 3), rad/s, of the gyroscopes.
        acc, mag: (n, 3), readings at rest; without mag the heading starts at zero.
        """
        level_at(acc, used, self.q)
        if mag is not None:
            face_north(mag, used, self.q)
        self.bias[used], self.deviations[used] = bias[used], 0.0
        self.acc_steps[used] = self.mag_steps[used] = samples

    def orientation(self) -> Array:
        """Orientations (n, 4), w x y z, sensor to earth frame (z up; with magnetometers y north)."""
        return self.q.copy()


FrontEndName = Literal["vqf", "seel_ruppin"]
NAMES: tuple[FrontEndName, ...] = ("vqf", "seel_ruppin")


class FrontEnd(Protocol):
    """Filters of n inertial sensors, which can be pickled and then continue bit for bit."""

    def update(self, gyr: Array, acc: Array | None, mag: Array | None) -> None:
        """Process one sample of every sensor, (n, 3) each, rad/s, m/s^2, T; None where there is none."""

    def update_sound(
        self, gyr: Array, acc: Array | None, mag: Array | None, lost: NDArray[np.bool_]
    ) -> None:
        """As `update`, without the samples in `lost`, (3, n), of gyr, acc and mag."""

    def begin(
        self, used: NDArray[np.bool_], bias: Array, acc: Array, mag: Array | None, samples: int
    ) -> None:
        """Restart the sensors in `used` after a rest of `samples` samples with these readings (n, 3)."""

    def orientation(self) -> Array:
        """New array of orientations (n, 4), sensor to earth frame (z up; with magnetometers y north)."""


def require_front_end(name: str) -> None:
    """Raise InputError if `name` is not a front end."""
    if name not in NAMES:
        raise InputError("front_end", f"{name!r}", ", ".join(NAMES), did_you_mean(name, NAMES))


def front_end_of(
    name: FrontEndName, sensors: int, periods_s: tuple[float, float, float], magnetometer: bool,
    tau_acc_s: float | None, tau_mag_s: float | None
) -> FrontEnd:
    """Create the front end `name`.

    Parameters
    ----------
    periods_s: sampling periods of gyroscopes, accelerometers and magnetometers.
    magnetometer: whether magnetometers are used.
    tau_acc_s, tau_mag_s: time constants of the corrections; None: those of the method's authors.

    Raises InputError for an unknown name, and for times that are not positive.
    """
    require_front_end(name)
    of_vqf = name == "vqf"
    given = {key: tau for key, tau in (("tauAcc" if of_vqf else "tau_acc_s", tau_acc_s),
                                       ("tauMag" if of_vqf else "tau_mag_s", tau_mag_s)) if tau is not None}
    bank = VqfBank if of_vqf else SeelRuppinBank
    return bank(sensors, periods_s[0], magnetometer, acc_period_s=periods_s[1], mag_period_s=periods_s[2],
                **given)
