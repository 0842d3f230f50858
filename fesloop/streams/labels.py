"""Labels and units of channels, as laboratories and makers write them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

from fesloop.errors import InputError

Kind = Literal["gyr", "acc", "mag"]
_SEPARATOR = r"[\s_.\-]?"
_WORDS: dict[Kind, str] = {
    "gyr": rf"gyr(?:o(?:s(?:cope)?)?)?|ang(?:ular)?{_SEPARATOR}(?:vel(?:ocity)?|rate)|omega",
    "acc": r"acc(?:el(?:eration|erometer)?)?",
    "mag": rf"mag(?:n(?:et(?:ic(?:{_SEPARATOR}field)?|ometer)?)?)?"}
_STARTS = r"(?:(?<![^\W\d_])|(?<=[a-z])(?=[A-Z]))"
_ENDS = r"(?:(?![^\W\d_])|(?<=[a-z])(?=[A-Z])|(?=[xyzXYZ](?![^\W\d_])))"
_QUANTITY = re.compile(
    _STARTS + "(?:" + "|".join(f"(?P<{kind}>(?i:{words}))" for kind, words in _WORDS.items()) + ")" + _ENDS)
_AXES = (re.compile(r"\0[\W_]*([xyzXYZ])(?![^\W\d_])"),
         re.compile(r"(?<![^\W_])([xyzXYZ])\Z"),
         re.compile(r"(?<![^\W_])([xyzXYZ])(?![^\W_])"),
         re.compile(r"([xyzXYZ])\Z"))
"""Places of an axis, \\0 being the quantity: behind it; alone at the end; alone; as the last letter."""
_MOST_SHOWN = 8


class Reading(NamedTuple):
    """Meaning of a label: the sensor's name, empty where there is none, the quantity, and "x", "y" or "z"."""

    sensor: str
    quantity: Kind
    axis: str


def read_label(label: str, channel_type: str = "") -> Reading | None:
    """Meaning of a label such as "F2p_gyr_x", "acc.x.3", "hand_x_gyr", "omega_x" or "hand AccX".

    The word for the quantity is looked for in the label, then in the channel's type ("F2p.x" of the type
    "AngularVelocityX"), between separators or where small and capital letters change: neither
    "vacc_x" nor "accuracy_x" is an acceleration. The rest, but for the axis, names the sensor.

    None for a label of something else, without an axis, or of two quantities.
    """
    in_label = list(_QUANTITY.finditer(label))
    found = in_label or list(_QUANTITY.finditer(channel_type))
    kinds = [kind for kind in _WORDS if any(match[kind] for match in found)]
    if len(kinds) != 1:
        return None
    rest = f"{label[:found[0].start()]}\0{label[found[0].end():]}" if in_label else label
    return _axis_and_sensor(rest.strip(), kinds[0])


def quantity_in(label: str) -> Kind | None:
    """Quantity that a label names, whatever its axis; None for a label of none, or of two."""
    kinds = {kind for match in _QUANTITY.finditer(label) for kind in _WORDS if match[kind]}
    return kinds.pop() if len(kinds) == 1 else None


def not_understood(labels: Sequence[str]) -> str:
    """Message about channels that are left out, the first of them by their labels; empty for none."""
    more = f" and {len(labels) - _MOST_SHOWN} more" if len(labels) > _MOST_SHOWN else ""
    shown = ", ".join(repr(label) for label in labels[:_MOST_SHOWN])
    return f"not understood: {shown}{more}" if labels else ""


def _axis_and_sensor(rest: str, kind: Kind) -> Reading | None:
    """Meaning of a label whose quantity is known, its word replaced by \\0."""
    match = next(filter(None, (axis.search(rest) for axis in _AXES)), None)
    if match is None:
        return None
    left = f"{rest[:match.start(1)]}\0{rest[match.end(1):]}".split("\0")
    name = "_".join(part for part in (re.sub(r"^[\W_]+|[\W_]+$", "", each) for each in left) if part)
    return Reading(name, kind, match[1].lower())


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
"""Factors to SI by quantity, so that "g" of an acceleration is not the gauss of a field."""
SI: Mapping[str, str] = {"gyr": "rad/s", "acc": "m/s^2", "mag": "T", "angle": "rad", "time": "s"}
"""The unit of each quantity here."""


def is_unit(quantity: str, unit: str) -> bool:
    """Return whether a unit is one of a quantity's."""
    return _folded(unit) in _NAMES[quantity]


def _folded(unit: str) -> str:
    return "".join(unit.split()).lower()


def factor(quantity: str, unit: str, where: str, remedy: str = "state the unit in a layout") -> float:
    """Factor to SI of numbers of a quantity ("gyr", "acc", "mag", "angle", "time") in a unit.

    Case and blanks do not matter. Raises InputError, with the remedy, for a unit that is not known.
    """
    names = _NAMES[quantity]
    folded = _folded(unit)
    if folded not in names:
        shown = dict.fromkeys(name for name in names if name.isascii())
        raise InputError(where, f"{unit!r} is no unit of {quantity}" if unit.strip() else "states no unit",
                         ", ".join(shown), remedy)
    return names[folded]
