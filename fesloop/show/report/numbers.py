"""Numbers on their way into a page: base64 of little-endian bytes, no more of them than the eye can tell."""

from __future__ import annotations

import base64
import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Encoded = Mapping[str, str | float | int]

_FEW = 64
"""Up to so many numbers stay as they are (chosen: those of bars and short lines are read, not only seen)."""
_HUGE = 1e300
"""From here on differences of numbers may overflow."""
_LEVELS = 65534
"""Of 16 bits, with one left for what is no number."""
_NONE = -32768
"""In 16 bits: NaN."""
_FAR = 50.0
"""Times what is seen (chosen: a level is then a 1300th of it, less than a pixel of a chart's height)."""
_EVEN = 1e-9
"""Share of the span by which evenly spaced numbers may be off (rounding of a few hundred additions)."""


@dataclass(frozen=True, slots=True)
class Numbers:
    """Arrays of a page, each kept once; parts name theirs by its place in `kept`."""

    kept: list[Encoded] = field(default_factory=list)
    places: dict[str, int] = field(default_factory=dict)

    def add(self, values: ArrayLike, seen: float = math.inf) -> int:
        """Place of an array's numbers, in C order; `seen`: range of those that are looked at."""
        return self._place(encoded(np.asarray(values, dtype=np.float64).ravel(), seen))

    def add_whole(self, values: ArrayLike) -> int:
        """Place of whole numbers from 0 on."""
        return self._place(_bytes("u4", np.asarray(values).ravel()))

    def _place(self, made: Encoded) -> int:
        key = hashlib.sha256(repr(sorted(made.items())).encode()).hexdigest()
        if key not in self.places:
            self.places[key] = len(self.kept)
            self.kept.append(made)
        return self.places[key]


def encoded(values: Array, seen: float = math.inf) -> Encoded:
    """As evenly spaced, as 64-bit floats, or as 16-bit levels; (n,).

    The levels divide the numbers' range: what is read back is off by at most half of its 65534th part.
    Numbers that go far beyond what is `seen` of them are floats: levels would be too coarse for the others.
    """
    finite = values[np.isfinite(values)]
    spaced = len(finite) > 0 and not np.isinf(values).any() and float(np.abs(finite).max()) < _HUGE
    if spaced and len(values) > 2 and _even(values):
        return {"from": float(values[0]), "to": float(values[-1]), "count": len(values)}
    if not spaced or len(values) <= _FEW:
        return _bytes("f8", values)
    low, span = float(finite.min()), float(np.ptp(finite))
    if span > _FAR * seen:
        return _bytes("f8", values)
    step = span / _LEVELS or 1.0
    with np.errstate(invalid="ignore"):
        levels = np.where(np.isfinite(values), np.rint((values - low) / step) - 32767, _NONE)
    return {**_bytes("i2", levels), "low": low, "step": step}


def _even(values: Array) -> bool:
    if not np.isfinite(values).all():
        return False
    line = np.linspace(values[0], values[-1], len(values))
    return bool(np.abs(values - line).max() <= _EVEN * abs(values[-1] - values[0]))


def _bytes(kind: str, values: NDArray[np.generic]) -> dict[str, str | float | int]:
    return {kind: base64.b64encode(values.astype(f"<{kind}").tobytes()).decode("ascii")}
