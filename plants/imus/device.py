"""Errors of a device's sensors and of their mounting, constant in a run, and presets of real hardware."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.loop.noise import NoiseStream, stream_key

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class TriadErrors:
    """Errors of three axes of one kind, in the sensor's unit u: rad/s, m/s^2 or T; None: the preset's value.

    Scale, tilt and constant bias belong to the device and are random once per run; the wandering of the bias
    starts again with each trial.

    Attributes
    ----------
    noise_sd: white noise of a sample, u.
    bias_sd: sd of each axis's constant bias, u; for a magnetometer, hard iron that moves with it.
    instability_sd, instability_time_s: stationary sd, u, and correlation time, s, of a first-order
        Gauss-Markov process in the bias.
    walk: random walk of the bias, u per square root of a second, 0 at the start of a trial.
    scale_sd: sd of each axis's scale factor, as a fraction.
    axes_deg: sd of the tilt of each axis towards each of the other two, which makes them non-orthogonal.
    turn_deg: sd, about each axis, of the triad's rotation in the sensor's case, and so between its triads.
    limit: largest magnitude of a reading, u; 0: none.
    resolution: size of a digit, u; 0: no rounding.
    """

    noise_sd: float | None = None
    bias_sd: float | None = None
    instability_sd: float | None = None
    instability_time_s: float | None = None
    walk: float | None = None
    scale_sd: float | None = None
    axes_deg: float | None = None
    turn_deg: float | None = None
    limit: float | None = None
    resolution: float | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            above = field.name == "instability_time_s"
            if value is not None and not (math.isfinite(value) and (value > 0.0 if above else value >= 0.0)):
                raise InputError(f"triad_errors.{field.name}", f"{value}",
                                 "a finite number above 0" if above else "a finite number, 0 or more")

    def filled(self, preset: TriadErrors) -> TriadErrors:
        """A copy with None replaced by values of a complete preset."""
        given = {name: getattr(self, name) for name in NUMBERS if getattr(self, name) is not None}
        return replace(preset, **given)

    def scaled(self, size: float) -> TriadErrors:
        """A copy with all errors times `size`; range and digits are none."""
        return replace(self, **{name: size * getattr(self, name) for name in (
            "noise_sd", "bias_sd", "instability_sd", "walk", "scale_sd", "axes_deg", "turn_deg")})

    def numbers(self) -> Array:
        """All values in the order of `NUMBERS`, (10,)."""
        return np.array([getattr(self, name) for name in NUMBERS], dtype=np.float64)


NUMBERS = tuple(field.name for field in fields(TriadErrors))
"""Names of the values of a triad."""
NO_ERRORS = TriadErrors(
    noise_sd=0.0, bias_sd=0.0, instability_sd=0.0, instability_time_s=1.0, walk=0.0, scale_sd=0.0,
    axes_deg=0.0, turn_deg=0.0, limit=0.0, resolution=0.0)
"""An ideal triad."""


KINDS = ("gyr", "acc", "mag")
ACC, MAG = KINDS.index("acc"), KINDS.index("mag")


class Device:
    """Random constants of a device's sensors: a function of seed, device name and site number.

    They do not depend on which sites and kinds are read.

    Parameters
    ----------
    seed: seed of the run.
    name: name of the device.
    sites: number of sites.
    """

    __slots__ = ("name", "seed", "sites")

    def __init__(self, seed: int, name: str, sites: int) -> None:
        self.seed, self.name, self.sites = seed, name, sites

    def _random(self, purpose: str, width: int, kind: str = "normal") -> Array:
        """Random numbers (sites, width), the same in every trial."""
        key = stream_key(self.seed, f"{self.name}/{purpose}", 0)
        return NoiseStream(key, self.sites * width, kind).row(0).reshape(self.sites, width)

    def mountings(self, sd_deg: float, angle_deg: tuple[float, float]) -> Array:
        """Matrices (sites, 3, 3) from the segments' frames to the sensors'.

        Each is a rotation of `sd_deg` about each axis, after one about an axis of any direction by an angle
        uniform in `angle_deg`.
        """
        axis = self._random("mounting_axis", 3)
        axis = axis / np.linalg.norm(axis, axis=1, keepdims=True)
        low, high = np.radians(angle_deg)
        angle = low + (high - low) * self._random("mounting_angle", 1, "uniform")
        scatter = math.radians(sd_deg) * self._random("mounting", 3)
        return rotations(scatter) @ rotations(angle * axis)

    def triads(self, kind: str, errors: TriadErrors, soft_iron: float = 0.0) -> tuple[Array, Array]:
        """Matrices (sites, 3, 3) from the sensors' frames to the readings of the axes, and biases (sites, 3).

        The rows of a matrix are the sensitive directions of the axes, times their scale; `soft_iron` is the
        sd of the entries of the symmetric matrix that iron adds to the identity.
        """
        numbers = dict(zip(errors.__slots__, errors.numbers(), strict=True))
        iron = np.eye(3) + soft_iron * _symmetric(self._random(f"{kind}/iron", 6))
        turned = rotations(math.radians(numbers["turn_deg"]) * self._random(f"{kind}/turn", 3))
        tilts = math.radians(numbers["axes_deg"]) * self._random(f"{kind}/axes", 6)
        directions = np.tile(np.eye(3), (self.sites, 1, 1))
        directions[:, ~np.eye(3, dtype=np.bool_)] = tilts
        directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
        scale = 1.0 + numbers["scale_sd"] * self._random(f"{kind}/scale", 3)
        matrices = scale[:, :, np.newaxis] * (directions @ turned @ iron)
        return matrices, numbers["bias_sd"] * self._random(f"{kind}/bias", 3)


def rotations(turns: Array) -> Array:
    """Matrices (n, 3, 3) of coordinate rotations by rotation vectors (n, 3), rad."""
    angle = np.linalg.norm(turns, axis=-1)[:, np.newaxis, np.newaxis]
    x, y, z = turns.T
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(-1, 3, 3)
    # sin a / a and (1 - cos a) / a^2, without division by zero
    first, half = np.sinc(angle / math.pi), np.sinc(angle / (2.0 * math.pi))
    return np.asarray(np.eye(3) + first * cross + 0.5 * half * half * (cross @ cross))


def _symmetric(entries: Array) -> Array:
    """Symmetric matrices (n, 3, 3) from their six entries (n, 6)."""
    return entries[:, [[0, 1, 2], [1, 3, 4], [2, 4, 5]]]


PresetName = Literal["ideal", "kortier2014", "salchow2019", "salchow2019_raw"]
_DEG = math.pi / 180.0
_MILLI_G = 1e-3 * STANDARD_GRAVITY
_MILLI_GAUSS = 1e-7
_MICRO_TESLA = 1e-6


class Preset(NamedTuple):
    """Sensors of a hand.

    Attributes
    ----------
    gyroscope, accelerometer, magnetometer: complete errors of the triads.
    soft_iron: sd of the entries of the distortion by iron beside the magnetometer.
    without: sites without a sensor.
    mag_sites: sites with a magnetometer; None: every site with a sensor.
    mounting_angle_deg: smallest and largest error angle of the mounting.
    """

    gyroscope: TriadErrors
    accelerometer: TriadErrors
    magnetometer: TriadErrors
    soft_iron: float
    without: tuple[str, ...]
    mag_sites: tuple[str, ...] | None
    mounting_angle_deg: tuple[float, float]


PRESETS: dict[PresetName, Preset] = {
    "ideal": Preset(NO_ERRORS, NO_ERRORS, NO_ERRORS, 0.0, (), None, (0.0, 0.0)),
    "kortier2014": Preset(
        # Noise and walk: K14, table 1 (e_b read as a density). Digit, range, zero-rate and cross-axis: data
        # sheet at 2000 deg/s, from memory: 70 mdeg/s a digit, +-75 deg/s, which a still hand reveals and
        # removes: 1e-3 rad/s remains (chosen).
        gyroscope=TriadErrors(
            noise_sd=5e-4, bias_sd=1e-3, instability_sd=20.0 * _DEG / 3600.0, instability_time_s=100.0,
            walk=1e-4, scale_sd=0.01, axes_deg=0.4, turn_deg=0.3, limit=2000.0 * _DEG,
            resolution=0.070 * _DEG),
        # Noise: K14, table 1. Data sheet at 16 g, from memory: 12 mg a digit; raw +-60 mg at zero.
        accelerometer=TriadErrors(
            noise_sd=4e-2, bias_sd=0.05, instability_sd=0.1 * _MILLI_G, instability_time_s=100.0,
            walk=0.0, scale_sd=0.002, axes_deg=0.2, turn_deg=0.3, limit=16.0 * STANDARD_GRAVITY,
            resolution=12.0 * _MILLI_G),
        # Table 1 prints 1e-3 mG, a thousandth of the device's digit: read as 1e-3 G. Data sheet at 1.3 G,
        # from memory: 1090 digits a gauss. The rest of hard and soft iron after calibration is chosen.
        magnetometer=TriadErrors(
            noise_sd=1.0 * _MILLI_GAUSS, bias_sd=0.5 * _MICRO_TESLA, instability_sd=0.0,
            instability_time_s=100.0, walk=0.0, scale_sd=0.01, axes_deg=0.4, turn_deg=0.3,
            limit=1.3e3 * _MILLI_GAUSS, resolution=1e3 / 1090.0 * _MILLI_GAUSS),
        soft_iron=0.01, without=("forearm",), mag_sites=("hand", "F1d", "F2d", "F3d", "F4d", "F5d"),
        # The paper calibrates each sensor to its segment (eq. 34); the remaining error is not stated.
        mounting_angle_deg=(0.0, 0.0)),
    "salchow2019": Preset(
        # .01 deg/s a root hertz, scale +-3 %, cross-axis +-2 %, 16.4 digits a deg/s; zero rate +-5 deg/s raw.
        gyroscope=TriadErrors(
            noise_sd=0.01 * math.sqrt(50.0) * _DEG, bias_sd=0.0035,
            instability_sd=10.0 * _DEG / 3600.0, instability_time_s=100.0, walk=0.0, scale_sd=0.01,
            axes_deg=0.02 / 3.0 / _DEG, turn_deg=0.3, limit=2000.0 * _DEG, resolution=_DEG / 16.4),
        # .3 mg a root hertz, 2048 digits a g; raw: zero +-60 mg, scale +-3 %, cross-axis +-2 %.
        accelerometer=TriadErrors(
            noise_sd=0.3 * math.sqrt(50.0) * _MILLI_G, bias_sd=0.05,
            instability_sd=0.05 * _MILLI_G, instability_time_s=100.0, walk=0.0, scale_sd=0.002,
            axes_deg=0.2, turn_deg=0.3, limit=16.0 * STANDARD_GRAVITY,
            resolution=STANDARD_GRAVITY / 2048.0),
        # AK8963, from memory: .15 uT a digit, 4912 uT; noise of .6 uT and the rest after calibration: chosen.
        magnetometer=TriadErrors(
            noise_sd=0.6 * _MICRO_TESLA, bias_sd=1.0 * _MICRO_TESLA, instability_sd=0.0,
            instability_time_s=100.0, walk=0.0, scale_sd=0.01, axes_deg=0.02 / 3.0 / _DEG, turn_deg=0.5,
            limit=4912.0 * _MICRO_TESLA, resolution=0.15 * _MICRO_TESLA),
        soft_iron=0.01, without=("forearm",), mag_sites=None,
        # "in the order of 5 to 10 degrees" (section 4, of sensor-to-segment alignment).
        mounting_angle_deg=(5.0, 10.0)),
}
_CALIBRATED = PRESETS["salchow2019"]
PRESETS["salchow2019_raw"] = _CALIBRATED._replace(
    # Without the paper's calibration by a robot (section 2.1: bias, scale, axes, common orientation):
    # a third of the data sheet's limits, as above, is the sd; a magnetometer on a die of its own: chosen.
    gyroscope=replace(_CALIBRATED.gyroscope, bias_sd=5.0 / 3.0 * _DEG, turn_deg=1.0),
    accelerometer=replace(_CALIBRATED.accelerometer, bias_sd=20.0 * _MILLI_G, scale_sd=0.01,
                          axes_deg=0.02 / 3.0 / _DEG, turn_deg=1.0),
    magnetometer=replace(_CALIBRATED.magnetometer, bias_sd=20.0 * _MICRO_TESLA, scale_sd=0.05, turn_deg=3.0))
