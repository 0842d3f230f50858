"""Whether a controller is told the delay that lies between it and the plant."""

from __future__ import annotations

from fesloop.loop.abilities import Surroundings
from fesloop.loop.clock import NS_PER_MS

STATUS = "delay_differs"


def missed_ns(told_ns: int, surroundings: Surroundings, period_ns: int) -> float:
    """By how much the delay to the plant is longer than told; 0 where that is a period or less."""
    if surroundings.actuation_ns is None:
        return 0.0
    missed = surroundings.actuation_ns - told_ns
    return missed if abs(missed) > period_ns else 0.0


def in_words(told_ms: float, surroundings: Surroundings) -> str:
    """What is told, what it is, and what to do."""
    actual_ms = (surroundings.actuation_ns or 0.0) / NS_PER_MS
    return (f"actuation_delay_ms is {told_ms:g}, and what is put out reaches the plant after "
            f"{actual_ms:.4g} ms on average; set actuation_delay_ms = {actual_ms:.4g}")
