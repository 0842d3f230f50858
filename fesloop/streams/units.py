"""Units as files name them, in SI."""

from __future__ import annotations

import math
from collections.abc import Mapping

from fesloop.errors import InputError

GRAVITY = 9.80665
"""Standard gravity, m/s^2, exact by definition (BIPM, The International System of Units, 2019)."""
_DEG = math.pi / 180.0

_NAMES: dict[str, dict[str, float]] = {
    "gyr": {"rad/s": 1.0, "rads-1": 1.0, "rad*s^-1": 1.0, "rads": 1.0, "rads/s": 1.0, "radians/s": 1.0,
            "rad/sec": 1.0, "mrad/s": 1e-3, "deg/s": _DEG, "degree/s": _DEG, "degrees/s": _DEG, "°/s": _DEG,
            "dps": _DEG, "deg/sec": _DEG, "mdeg/s": 1e-3 * _DEG, "mdps": 1e-3 * _DEG},
    "acc": {"m/s^2": 1.0, "m/s2": 1.0, "m/s²": 1.0, "ms-2": 1.0, "m*s^-2": 1.0, "m/s/s": 1.0, "ms^-2": 1.0,
            "mm/s^2": 1e-3, "g": GRAVITY, "mg": 1e-3 * GRAVITY},
    "mag": {"t": 1.0, "tesla": 1.0, "mt": 1e-3, "ut": 1e-6, "µt": 1e-6, "μt": 1e-6, "microtesla": 1e-6,
            "nt": 1e-9, "g": 1e-4, "ga": 1e-4, "gs": 1e-4, "gauss": 1e-4, "mg": 1e-7, "mgauss": 1e-7,
            "milligauss": 1e-7},
    "angle": {"rad": 1.0, "radian": 1.0, "radians": 1.0, "deg": _DEG, "degree": _DEG, "degrees": _DEG,
              "°": _DEG},
    "time": {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "milliseconds": 1e-3, "us": 1e-6, "µs": 1e-6,
             "μs": 1e-6, "ns": 1e-9, "min": 60.0},
}
"""By quantity, so that "g" of an acceleration is not the gauss of a field."""
SI: Mapping[str, str] = {"gyr": "rad/s", "acc": "m/s^2", "mag": "T", "angle": "rad", "time": "s"}
"""The unit of each quantity here."""


def factor(quantity: str, unit: str, where: str, remedy: str = "state the unit in a layout") -> float:
    """By what to multiply numbers of a quantity ("gyr", "acc", "mag", "angle", "time") to have them in SI.

    Case and blanks do not matter. Raises InputError, with that remedy, for a unit that is not known.
    """
    names = _NAMES[quantity]
    folded = "".join(unit.split()).lower()
    if folded not in names:
        shown = dict.fromkeys(name for name in names if name.isascii())
        raise InputError(where, f"{unit!r} is no unit of {quantity}" if unit.strip() else "states no unit",
                         ", ".join(shown), remedy)
    return names[folded]
