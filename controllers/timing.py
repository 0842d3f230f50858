"""Period and actuation delay that a sampled controller is designed for."""

from __future__ import annotations

from fesloop.errors import InputError
from fesloop.loop.abilities import Surroundings
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, RateClock, StampClock

DELAY_STATUS = "delay_differs"


def period_ns(context: Context) -> int:
    """Period of a block's clock, rounded to 1 ns; the median one where the clock is a list of stamps.

    For coefficients, never for time. Raises InputError for a block without a clock.
    """
    clock = context.clock
    if not isinstance(clock, (RateClock, StampClock)):
        raise InputError(context.name, "is a sampled controller without a clock", "a rate")
    return max(1, round(clock.period_s * NS_PER_S))


def missed_ns(stated_ns: int, surroundings: Surroundings, period_ns: int) -> float:
    """Excess of the delay to the plant over the stated one; 0 where it is within a period."""
    if surroundings.actuation_ns is None:
        return 0.0
    missed = surroundings.actuation_ns - stated_ns
    return missed if abs(missed) > period_ns else 0.0


def delay_text(stated_ms: float, surroundings: Surroundings) -> str:
    """The stated delay, the actual one, and the remedy."""
    actual_ms = (surroundings.actuation_ns or 0.0) / NS_PER_MS
    return (f"actuation_delay_ms is {stated_ms:g}, but outputs reach the plant after {actual_ms:.4g} ms on "
            f"average; set actuation_delay_ms = {actual_ms:.4g}")
