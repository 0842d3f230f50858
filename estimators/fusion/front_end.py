"""The front end of a tracker: what fuses each sensor by itself, chosen by name, behind one protocol."""

from __future__ import annotations

from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from estimators.fusion.seel_ruppin import SeelRuppinBank
from estimators.fusion.vqf_bank import VqfBank
from fesloop.errors import InputError, did_you_mean

Array = NDArray[np.float64]
FrontEndName = Literal["vqf", "seel_ruppin"]
NAMES: tuple[FrontEndName, ...] = ("vqf", "seel_ruppin")


class FrontEnd(Protocol):
    """Filters of n inertial sensors; it pickles, and continues bit for bit."""

    def update(self, gyr: Array, acc: Array | None, mag: Array | None) -> None:
        """One sample of every sensor, (n, 3) each, rad/s, m/s^2, T; None where there is none."""

    def update_only(
        self, used: NDArray[np.bool_], gyr: Array, acc: Array | None, mag: Array | None
    ) -> None:
        """One sample of the sensors that are `used`, (n,); the others stay where they are."""

    def begin(
        self, used: NDArray[np.bool_], bias: Array, acc: Array, mag: Array | None, samples: int
    ) -> None:
        """Begin anew after a rest of so many samples, in which the sensors read this, (n, 3) each."""

    def orientation(self) -> Array:
        """Sensor to earth frame (z up; with magnetometers y to magnetic north), (n, 4); a new array."""


def require_front_end(name: str) -> None:
    """Raise InputError for a name that is no front end's."""
    if name not in NAMES:
        raise InputError("front_end", f"{name!r}", ", ".join(NAMES), did_you_mean(name, NAMES))


def front_end_of(
    name: FrontEndName, sensors: int, periods_s: tuple[float, float, float], magnetometer: bool,
    tau_acc_s: float | None, tau_mag_s: float | None
) -> FrontEnd:
    """A new front end.

    Parameters
    ----------
    periods_s: of the samples of gyroscopes, accelerometers and magnetometers.
    magnetometer: whether magnetometers are used.
    tau_acc_s, tau_mag_s: time constants of the corrections; None: those that the method's authors give.

    Raises InputError for another name, and for times that are not positive.
    """
    require_front_end(name)
    of_vqf = name == "vqf"
    given = {key: tau for key, tau in (("tauAcc" if of_vqf else "tau_acc_s", tau_acc_s),
                                       ("tauMag" if of_vqf else "tau_mag_s", tau_mag_s)) if tau is not None}
    bank = VqfBank if of_vqf else SeelRuppinBank
    return bank(sensors, periods_s[0], magnetometer, acc_period_s=periods_s[1], mag_period_s=periods_s[2],
                **given)
