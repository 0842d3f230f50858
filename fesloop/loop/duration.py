"""Durations: jitter of a wire, execution time of a block."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import Literal

from fesloop.errors import InputError
from fesloop.loop.clock import FOREVER, NS_PER_MS

Kind = Literal["zero", "fixed", "uniform", "normal", "exponential", "measured", "recorded"]
_GREATEST_SCALE = 1e6
"""Greatest scale of a measured time: a step of an hour is still below the range of stamps, 2^62 ns."""
_DISTRIBUTIONS = ("uniform", "normal", "exponential")
_STANDARD_NORMAL = NormalDist()
_NEEDS: dict[str, tuple[str, ...]] = {
    "zero": (),
    "fixed": ("ms",),
    "uniform": ("low_ms", "high_ms"),
    "normal": ("mean_ms", "sd_ms", "low_ms", "high_ms"),
    "exponential": ("mean_ms", "high_ms"),
    "measured": (),
    "recorded": ("recorded_ns",),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Duration:
    """A duration, or a distribution of durations with a new value for each tick.

    Attributes
    ----------
    kind: "zero"; "fixed" (`ms`); "uniform" in [`low_ms`, `high_ms`]; "normal" with `mean_ms` and `sd_ms`,
        clipped to [`low_ms`, `high_ms`]; "exponential" with `mean_ms`, clipped at `high_ms`; and, for an
        execution time only, "measured" (the block's own wall time times `scale`) or "recorded"
        (`recorded_ns`: what an earlier run measured, per trial and executed tick).
    """

    kind: Kind = "zero"
    ms: float | None = None
    low_ms: float | None = None
    high_ms: float | None = None
    mean_ms: float | None = None
    sd_ms: float | None = None
    scale: float = 1.0
    recorded_ns: tuple[tuple[int, ...], ...] | None = None

    def __post_init__(self) -> None:
        if self.kind not in _NEEDS:
            raise InputError("kind", f"{self.kind!r}", ", ".join(_NEEDS))
        every = ("ms", "low_ms", "high_ms", "mean_ms", "sd_ms", "recorded_ns")
        for key in every:
            given, needed = getattr(self, key) is not None, key in _NEEDS[self.kind]
            if given != needed:
                raise InputError(key, "is missing" if needed else f"has no meaning for kind {self.kind!r}",
                                 f"{self.kind}: {', '.join(_NEEDS[self.kind]) or 'no other key'}")
        for key in every[:-1]:
            value = getattr(self, key)
            if value is not None and not math.isfinite(value):
                raise InputError(key, f"{value}", "a finite number of ms")
            if value is not None and abs(value) * NS_PER_MS >= FOREVER:
                raise InputError(key, f"{value:g} is longer than any run", f"below {FOREVER / NS_PER_MS:.3g}")
        if self.low_ms is not None and self.high_ms is not None and self.low_ms > self.high_ms:
            raise InputError("low_ms", f"{self.low_ms} is above high_ms {self.high_ms}", "at most high_ms")
        for key in ("sd_ms", "mean_ms") if self.kind == "exponential" else ("sd_ms",):
            if (getattr(self, key) or 0.0) < 0.0:
                raise InputError(key, f"{getattr(self, key)} is negative", "zero or more")
        if not 0.0 < self.scale <= _GREATEST_SCALE:
            raise InputError("scale", f"{self.scale}", f"above 0, at most {_GREATEST_SCALE:g}")

    def __str__(self) -> str:
        """How long, in words: a table of wires shows it."""
        if self.kind == "uniform":
            return f"{self.low_ms:g} to {self.high_ms:g} ms"
        if self.kind == "normal":
            return f"{self.mean_ms:g} +- {self.sd_ms:g} ms ({self.low_ms:g} to {self.high_ms:g})"
        if self.kind == "exponential":
            return f"{self.mean_ms:g} ms on average (at most {self.high_ms:g})"
        return f"{self.ms or 0.0:g} ms" if self.kind in ("zero", "fixed") else self.kind

    @property
    def random(self) -> bool:
        """True if durations differ from tick to tick by a distribution."""
        return self.kind in _DISTRIBUTIONS and self.least_ns != self.most_ns

    @property
    def least_ns(self) -> int:
        """The least it can be; 0 where that is known only at run time."""
        if self.kind == "fixed":
            return _ns(self.ms)
        if self.kind in ("uniform", "normal"):
            return _ns(self.low_ms)
        return 0

    @property
    def most_ns(self) -> int | None:
        """The most it can be; None where that is known only at run time."""
        if self.kind in ("measured", "recorded"):
            return None
        if self.kind == "fixed":
            return _ns(self.ms)
        return _ns(self.high_ms) if self.kind != "zero" else 0

    def share_within(self, limit_ns: int) -> float:
        """Probability that a duration is at most `limit_ns`: the distribution function of `draw_ns`.

        Raises InputError for a kind without a distribution.
        """
        if self.kind not in _DISTRIBUTIONS:
            raise InputError("kind", f"{self.kind!r}", "uniform, normal, exponential")
        low, high = self.least_ns, _ns(self.high_ms)
        if limit_ns < low:
            return 0.0
        if limit_ns >= high:
            return 1.0
        if self.kind == "uniform":
            return (limit_ns - low + 1) / (high - low + 1)
        limit_ms = (limit_ns + 0.5) / NS_PER_MS  # up to here a draw is rounded down to the limit
        mean_ms, sd_ms = self.mean_ms or 0.0, self.sd_ms or 0.0
        if self.kind == "normal":
            return _STANDARD_NORMAL.cdf((limit_ms - mean_ms) / sd_ms) if sd_ms else float(limit_ms >= mean_ms)
        return -math.expm1(-limit_ms / mean_ms) if mean_ms else 1.0

    def draw_ns(self, uniform: float) -> int:
        """The duration that belongs to a number of the unit interval (inverse distribution function)."""
        if self.kind == "uniform":
            low, high = self.least_ns, _ns(self.high_ms)
            return low + int(uniform * (high - low + 1))
        if self.kind == "normal":
            ms = (self.mean_ms or 0.0) + (self.sd_ms or 0.0) * _STANDARD_NORMAL.inv_cdf(uniform or 2**-54)
            return min(max(_ns(ms), self.least_ns), _ns(self.high_ms))
        if self.kind == "exponential":
            return min(_ns(-(self.mean_ms or 0.0) * math.log1p(-uniform)), _ns(self.high_ms))
        return _ns(self.ms)


ZERO = Duration()


def _ns(ms: float | None) -> int:
    """Milliseconds, None as none, to whole ns."""
    return round((ms or 0.0) * NS_PER_MS)
