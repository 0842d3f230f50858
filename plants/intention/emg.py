"""Surface EMG as amplitude-modulated noise, with the artefacts of stimulation.

    emg = greatest_mv effort n(t) + rest noise + artefact
    n(t): Gaussian, variance 1, power spectrum  f^2 / ((f^2 + fl^2) (f^2 + fh^2)^2)

Voluntary EMG is Gaussian noise whose standard deviation follows the effort (Hogan and Mann 1980, IEEE Trans
Biomed Eng 27(7):382-395), here in proportion. The shape of the spectrum and its two frequencies are those of
Stulen and De Luca 1981, doi 10.1109/TBME.1981.324738. Of a pulse an exponential remains on the electrodes,
whose discharge, and the response of the muscle to the pulse, are not told apart.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, solve_continuous_lyapunov

from fesloop.errors import InputError
from fesloop.forms.schema import require_not_negative, require_positive

Array = NDArray[np.float64]
STATES = 3
"""States of the filter that shapes the noise."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EmgElectrode:
    """A pair of electrodes over a muscle.

    Attributes
    ----------
    muscle: its name.
    greatest_mv: r.m.s. at full effort of the healthy muscle (chosen: some tenths of a mV).
    rest_uv: r.m.s. at rest, of amplifier, skin and other muscles (chosen).
    artefact_mv_per_uc: artefact right after a pulse, for its charge on all elements together; 0 for a place
        far from the stimulated forearm.
    """

    muscle: str
    greatest_mv: float = 0.3
    rest_uv: float = 5.0
    artefact_mv_per_uc: float = 0.0

    def __post_init__(self) -> None:
        require_positive("emg", self, "greatest_mv", "rest_uv")
        require_not_negative("emg", self, "artefact_mv_per_uc")


class Shaping(NamedTuple):
    """Filter that shapes white noise, sampled exactly.

    Attributes
    ----------
    step: (3, 3), transition of the state from sample to sample.
    noise: (3, 3), factor of independent normal numbers.
    output: (3,), weights of the state in a signal of variance 1.
    start: (3, 3), factor of normal numbers for a state at rest.
    """

    step: Array
    noise: Array
    output: Array
    start: Array


def shaping(band_hz: tuple[float, float], period_s: float) -> Shaping:
    """Filter s / ((s + wl) (s + wh)^2) of white noise, at a sampling period; time in units of 1 / wh."""
    low, high = band_hz
    ratio = low / high
    a = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-ratio, -1.0 - 2.0 * ratio, -2.0 - ratio]])
    white = np.diag([0.0, 0.0, 1.0])
    lasting = solve_continuous_lyapunov(a, -white)
    step = expm(a * 2.0 * math.pi * high * period_s)
    output = np.array([0.0, 1.0, 0.0]) / math.sqrt(lasting[1, 1])
    return Shaping(step, _factor(lasting - step @ lasting @ step.T), output, _factor(lasting))


def _factor(covariance: Array) -> Array:
    """F with F F' = a covariance, which may be singular to rounding."""
    values, vectors = np.linalg.eigh(covariance)
    factor: Array = vectors * np.sqrt(np.maximum(values, 0.0))
    return factor


def require_band(band_hz: tuple[float, float]) -> None:
    """Raise InputError unless the frequencies are finite, above 0 and in order."""
    if not 0.0 < band_hz[0] <= band_hz[1] < math.inf:
        raise InputError("band_hz", f"{list(band_hz)}", "the lower frequency, then the upper, above 0")
