"""The one period that a sampled-data design is made for."""

from __future__ import annotations

from fesloop.errors import InputError
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_S, RateClock, StampClock


def period_ns(context: Context) -> int:
    """Period of a block's clock, rounded to 1 ns; the median one where the clock is a list of stamps.

    For coefficients, never for time. Raises InputError for a block without a clock.
    """
    clock = context.clock
    if not isinstance(clock, (RateClock, StampClock)):
        raise InputError(context.name, "a sampled controller without a clock", "a rate")
    return max(1, round(clock.period_s * NS_PER_S))
