"""Exact time: integer nanoseconds, rates as ratios, tick k by one floor division.

Nothing here accumulates, so tick k is within 1 ns of (offset + k x period) for ever.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from itertools import count, repeat
from typing import Protocol, TypeGuard

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError

NS_PER_S = 1_000_000_000
NS_PER_MS = 1_000_000
FOREVER = 2**62
"""An instant after every run (146 years), in ns: the tick of a clock that has stopped."""

RATE_FORMS = 'a positive rate in hertz such as "60", "285.714" or "2000/7"'
_MOST_ZEROS = 100
"""Greatest power of ten in the text of a rate (chosen: no rate is beyond it)."""


def exact_ratio(text: str) -> Fraction:
    """Exact number of a text such as "285.714", "1e3" or "2000/7".

    Raises ValueError or ZeroDivisionError for other text, and for an exponent beyond any rate's: the digits
    of "1e999999999" would fill the memory.
    """
    if "/" not in text:
        try:
            number = Decimal(text)
        except InvalidOperation:
            raise ValueError(f"{text!r} is no number") from None
        if number.is_finite() and abs(number.adjusted()) > _MOST_ZEROS:
            raise ValueError(f"{text!r} is beyond any rate")
    return Fraction(text)


def parse_rate(rate: str | int | float | Fraction, where: str = "rate") -> Fraction:
    """Hertz as an exact ratio. A float counts as its shortest decimal text (285.714 is 285714/1000).

    Raises InputError, naming `where`, for anything that is not a positive finite number.
    """
    if isinstance(rate, bool) or not isinstance(rate, (str, int, float, Fraction)):
        raise InputError(where, f"{rate!r} is not a rate", RATE_FORMS)
    try:
        hertz = rate if isinstance(rate, Fraction) else exact_ratio(str(rate).strip())
    except (ValueError, ZeroDivisionError):
        raise InputError(where, f"{rate!r} is not a rate", RATE_FORMS) from None
    if hertz <= 0:
        raise InputError(where, f"{rate!r} is not positive", RATE_FORMS)
    if hertz > NS_PER_S:
        raise InputError(where, f"{rate!r} is above 1 GHz", "a period of at least 1 ns")
    return hertz


def duration_ns(value: str | int | float | Decimal, unit_ns: int, where: str) -> int:
    """A duration in units of `unit_ns` (1_000_000 for ms), through its decimal text, to the nearest ns.

    Raises InputError for a negative, non-finite or non-numeric value, and for one of 146 years or more.
    """
    if isinstance(value, bool):
        raise InputError(where, f"{value!r} is not a duration", "a number")
    try:
        exact = Decimal(str(value)) * unit_ns
    except InvalidOperation:
        raise InputError(where, f"{value!r} is not a duration", "a number") from None
    if not exact.is_finite():
        raise InputError(where, f"{value!r} is not a duration", "a finite number, zero or more")
    if exact < 0:
        raise InputError(where, f"{value!r} is negative", "zero or more")
    if exact >= FOREVER:
        raise InputError(where, f"{value!r} is longer than any run", f"below {FOREVER / unit_ns:.3g}")
    return int(exact.to_integral_value())


class Clock(Protocol):
    """Instants at which something ticks, numbered from 0 and strictly increasing."""

    @property
    def period_s(self) -> float:
        """Usual distance between ticks, s: for coefficients, never for time."""

    @property
    def shortest_ns(self) -> int:
        """Shortest distance between two ticks, ns."""

    def tick(self, index: int) -> int:
        """Instant of tick `index` in ns, FOREVER if the clock has stopped before it."""

    def first_at_or_after(self, time_ns: int) -> int:
        """Index of the first tick at or after `time_ns`."""


def ticks_from(clock: Clock, index: int) -> Callable[[], int]:
    """Function that returns tick `index` when first called, then the next, and so on.

    Where the period is whole ns, counting up is as exact as the division, and much quicker. A clock of
    arrivals has no tick that is known beforehand: FOREVER, again and again.
    """
    if waits_for_arrivals(clock):
        return repeat(FOREVER).__next__
    if isinstance(clock, RateClock) and clock.period_den == 1:
        return count(clock.tick(index), clock.period_num).__next__
    return map(clock.tick, count(index)).__next__


@dataclass(frozen=True, slots=True)
class RateClock:
    """Ticks at floor(offset + k x period), period = `period_num` / `period_den` ns.

    Attributes
    ----------
    period_num, period_den, offset_ns: as above, ns.
    arrivals: name of the live stream whose messages these ticks are, empty for a plain clock. Its rate is
        then nominal, and good for all that is computed beforehand; in operation its blocks tick at the
        instants given to `Loop.arrive`, and only then.
    """

    period_num: int
    period_den: int
    offset_ns: int = 0
    arrivals: str = ""

    @classmethod
    def from_rate(
        cls, rate: str | int | float | Fraction, offset_ns: int = 0, where: str = "rate", arrivals: str = ""
    ) -> RateClock:
        """Clock of an exact rate in hertz; raises InputError for a bad rate or a negative offset."""
        period = NS_PER_S / parse_rate(rate, where)
        if offset_ns < 0:
            raise InputError(where, f"offset of {offset_ns} ns is negative", "zero or more")
        return cls(period.numerator, period.denominator, offset_ns, arrivals)

    @property
    def rate(self) -> Fraction:
        """Hertz."""
        return Fraction(NS_PER_S * self.period_den, self.period_num)

    @property
    def period_s(self) -> float:
        """Period in s, rounded to a float: for coefficients, never for time."""
        return self.period_num / (self.period_den * NS_PER_S)

    @property
    def shortest_ns(self) -> int:
        """Shortest distance between two ticks, ns."""
        return self.period_num // self.period_den

    def tick(self, index: int) -> int:
        """Instant of tick `index`, ns."""
        return self.offset_ns + index * self.period_num // self.period_den

    def first_at_or_after(self, time_ns: int) -> int:
        """Index of the first tick at or after `time_ns`."""
        return max(0, -((self.offset_ns - time_ns) * self.period_den // self.period_num))

    def last_at_or_before(self, time_ns: int) -> int:
        """Index of the last tick at or before `time_ns`; -1 before the first."""
        return max(-1, ((time_ns + 1 - self.offset_ns) * self.period_den - 1) // self.period_num)

    def __str__(self) -> str:
        rate = self.rate
        text = str(rate.numerator) if rate.denominator == 1 else f"{float(rate):.9g}"
        offset = f" + {self.offset_ns / NS_PER_MS:g} ms" if self.offset_ns else ""
        return f"{text} Hz{offset}" + (f" nominal, as {self.arrivals} arrives" if self.arrivals else "")


def waits_for_arrivals(clock: Clock | None) -> TypeGuard[RateClock]:
    """True for a clock that ticks when messages of a live stream arrive."""
    return isinstance(clock, RateClock) and clock.arrivals != ""


class StampClock:
    """Ticks at given instants, such as the sample stamps of a recording.

    Parameters
    ----------
    stamps_ns: int64 (n,), strictly increasing, from 0 on.
    """

    __slots__ = ("stamps_ns",)

    def __init__(self, stamps_ns: NDArray[np.int64], where: str = "stamps") -> None:
        stamps = np.ascontiguousarray(stamps_ns, dtype=np.int64)
        if stamps.ndim != 1 or stamps.size == 0 or stamps[0] < 0:
            raise InputError(where, "stamps are empty or negative", "one or more, from 0 on")
        steps = np.diff(stamps)
        if (steps <= 0).any():
            at = int(np.argmax(steps <= 0)) + 1
            raise InputError(where, f"stamp {at} does not come after the one before it", "increasing")
        stamps.flags.writeable = False
        self.stamps_ns = stamps

    @property
    def period_s(self) -> float:
        """Median distance between ticks, s: for coefficients, never for time."""
        if self.stamps_ns.size < 2:
            return 1.0
        return float(np.median(np.diff(self.stamps_ns))) / NS_PER_S

    @property
    def shortest_ns(self) -> int:
        """Shortest distance between two ticks, ns."""
        return int(np.diff(self.stamps_ns).min()) if self.stamps_ns.size > 1 else FOREVER

    def tick(self, index: int) -> int:
        """Instant of tick `index`, ns; FOREVER past the last."""
        return int(self.stamps_ns[index]) if index < self.stamps_ns.size else FOREVER

    def first_at_or_after(self, time_ns: int) -> int:
        """Index of the first tick at or after `time_ns`."""
        return int(np.searchsorted(self.stamps_ns, time_ns, side="left"))

    def last_at_or_before(self, time_ns: int) -> int:
        """Index of the last tick at or before `time_ns`; -1 before the first."""
        return int(np.searchsorted(self.stamps_ns, time_ns, side="right")) - 1

    def __str__(self) -> str:
        return f"{self.stamps_ns.size} stamps, about {1 / self.period_s:.6g} Hz"
