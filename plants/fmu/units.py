"""Units of an FMU's variables and of ports, as factor and offset to SI base units."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace

POWERS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True, slots=True)
class BaseUnit:
    """A unit by the SI base units: a value in them is `factor` times the value in this unit, plus `offset`.

    Attributes
    ----------
    powers: of each of POWERS. FMI counts rad among them, so that rad/s is no Hz.
    """

    powers: tuple[int, ...]
    factor: float = 1.0
    offset: float = 0.0

    def like(self, other: BaseUnit) -> BaseUnit:
        """This unit, with rad counted and zero set as in another unit of the same name.

        Many tools leave rad out of definitions, and a difference of temperatures has no zero of its own.
        """
        rad = (*self.powers[:-1], other.powers[-1])
        return replace(self, powers=rad, offset=self.offset if other.offset else 0.0)

    def to(self, other: BaseUnit) -> tuple[float, float] | None:
        """Scale and offset that turn a value in this unit into one in another; None for another quantity."""
        if self.powers != other.powers or other.factor == 0.0:
            return None
        found = self.factor / other.factor, (self.offset - other.offset) / other.factor
        return found if found[0] != 0.0 and all(map(math.isfinite, found)) else None


def _base(factor: float = 1.0, offset: float = 0.0, **powers: int) -> BaseUnit:
    return BaseUnit(tuple(powers.get(name, 0) for name in POWERS), factor, offset)


_ATOMS = {
    "1": _base(), "%": _base(0.01), "rad": _base(rad=1), "deg": _base(math.pi / 180.0, rad=1),
    "s": _base(s=1), "ms": _base(1e-3, s=1), "us": _base(1e-6, s=1), "min": _base(60.0, s=1),
    "Hz": _base(s=-1),
    "m": _base(m=1), "mm": _base(1e-3, m=1), "cm": _base(1e-2, m=1), "kg": _base(kg=1),
    "A": _base(A=1), "mA": _base(1e-3, A=1), "C": _base(A=1, s=1), "uC": _base(1e-6, A=1, s=1),
    "V": _base(kg=1, m=2, s=-3, A=-1), "mV": _base(1e-3, kg=1, m=2, s=-3, A=-1), "T": _base(kg=1, s=-2, A=-1),
    "N": _base(kg=1, m=1, s=-2), "J": _base(kg=1, m=2, s=-2), "W": _base(kg=1, m=2, s=-3),
    "Pa": _base(kg=1, m=-1, s=-2), "K": _base(K=1), "degC": _base(1.0, 273.15, K=1)}
_POWER = re.compile(r"([A-Za-z]+|1|%)(?:\^(-?[1-9]))?")


def unit_of(text: str) -> BaseUnit | None:
    """The unit that a port's text means, such as "rad/s^2" or "N m"; None for one that is not known."""
    if text in _ATOMS:
        return _ATOMS[text]
    unit = _base()
    for number, part in enumerate(text.split("/")):
        for piece in re.split(r"[ *.]+", part):
            match = _POWER.fullmatch(piece)
            atom = _ATOMS.get(match[1]) if match else None
            if match is None or atom is None or atom.offset:
                return None
            power = int(match[2] or 1) * (-1 if number else 1)
            unit = replace(unit, factor=unit.factor * atom.factor**power,
                           powers=tuple(a + power * b for a, b in zip(unit.powers, atom.powers, strict=True)))
    return unit
