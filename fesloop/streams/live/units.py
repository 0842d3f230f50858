"""Units that streams state, as factors to SI."""

from __future__ import annotations

import math

from fesloop.errors import InputError

GRAVITY = 9.80665
"""Standard gravity, m/s^2 (ISO 80000-3)."""
_DEGREE = math.pi / 180.0
_FACTORS: dict[str, dict[str, float]] = {
    "gyr": {"rad/s": 1.0, "rads": 1.0, "mrad/s": 1e-3, "deg/s": _DEGREE, "dps": _DEGREE, "degrees/s": _DEGREE,
            "degree/s": _DEGREE, "°/s": _DEGREE, "mdps": 1e-3 * _DEGREE},
    "acc": {"m/s^2": 1.0, "m/s2": 1.0, "m/s²": 1.0, "m/s/s": 1.0, "ms-2": 1.0, "g": GRAVITY,
            "mg": 1e-3 * GRAVITY},
    "mag": {"t": 1.0, "tesla": 1.0, "mt": 1e-3, "ut": 1e-6, "µt": 1e-6, "μt": 1e-6, "microtesla": 1e-6,
            "nt": 1e-9, "gauss": 1e-4, "ga": 1e-4, "g": 1e-4, "mgauss": 1e-7, "mg": 1e-7},
    "angle": {"rad": 1.0, "radian": 1.0, "radians": 1.0, "deg": _DEGREE, "degree": _DEGREE,
              "degrees": _DEGREE, "°": _DEGREE},
}
"""By kind of quantity, so that "g" of an acceleration is not the gauss of a field. One gauss is 1e-4 T."""


def factor(kind: str, unit: str, where: str) -> float:
    """What a number in `unit` is to be multiplied with; kind "gyr", "acc", "mag" or "angle".

    Raises InputError, naming `where`, for a unit that this quantity does not have.
    """
    known = _FACTORS[kind]
    found = known.get(unit.strip().replace(" ", "").lower())
    if found is None:
        raise InputError(where, f"its unit is {unit!r}" if unit.strip() else "no unit is stated",
                         ", ".join(known))
    return found
