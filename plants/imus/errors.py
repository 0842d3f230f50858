"""What is wrong with a triad of gyroscopes, accelerometers or magnetometers."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class TriadErrors:
    """Errors of three axes of one kind, in the sensor's unit u: rad/s, m/s^2 or T. None: as the preset says.

    The axes' scale, their tilt and the constant bias belong to the device and are drawn once for a run; the
    wandering of the bias starts anew with each trial.

    Attributes
    ----------
    noise_sd: white noise of a sample, u.
    bias_sd: of each axis's constant bias, u; of a magnetometer, hard iron that moves with it.
    instability_sd, instability_time_s: of a bias that wanders and comes back, a Gauss-Markov process of
        first order: stationary sd, u, and correlation time, s.
    walk: of a bias that wanders off, u per square root of a second, 0 at the start of a trial.
    scale_sd: of each axis's scale factor, as a fraction.
    axes_deg: sd of the tilt of each axis towards each of the two others, which leaves them not orthogonal.
    turn_deg: sd, about each axis, of the triad's rotation in the sensor's case, so between its triads.
    limit: largest magnitude that an axis reads, u; 0: none.
    resolution: of a digit, u; 0 does not round.
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
        """The same, with what is None taken from a preset that leaves nothing open."""
        given = {name: getattr(self, name) for name in NUMBERS if getattr(self, name) is not None}
        return replace(preset, **given)

    def numbers(self) -> Array:
        """Every number in the order of `NUMBERS`, (10,)."""
        return np.array([getattr(self, name) for name in NUMBERS], dtype=np.float64)


NUMBERS = tuple(field.name for field in fields(TriadErrors))
"""The numbers of a triad, in the order in which kernels take them."""
NO_ERRORS = TriadErrors(
    noise_sd=0.0, bias_sd=0.0, instability_sd=0.0, instability_time_s=1.0, walk=0.0, scale_sd=0.0,
    axes_deg=0.0, turn_deg=0.0, limit=0.0, resolution=0.0)
"""An ideal triad."""
