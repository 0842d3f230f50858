"""Detection of contact, loss and slip of an object from fingertip forces."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_MS, duration_ns
from fesloop.loop.signals import NEVER

Array = NDArray[np.float64]
_LOST = 0.5
"""Share of the force at contact below which contact is lost (chosen: noise does not cross both)."""
_WEIGHT = 0.3
"""Weight of the newest change in the mean of squares: about three samples count (chosen)."""


def grip_of(force: Array, thumb: int) -> float:
    """Grip force, N: the thumb's or that of all fingers together, whichever is greater.

    An object at rest is pressed equally from both sides, by fingertips or by parts of the hand without a
    sensor.
    """
    return float(max(force[thumb], force.sum() - force[thumb]))


@dataclass(slots=True, eq=False)
class Touch:
    """State of the detection.

    Attributes
    ----------
    holding: whether an object is held.
    since_ns: instant from which forces contradict `holding`; NEVER while they agree.
    force: (k,), N, last sample; None before the first.
    taken_ns: its capture.
    variation: mean square change from sample to sample of the fingertip force that changes most, N^2.
    raised: factor by which slips have raised the target force.
    raised_ns: instant of the last rise.
    """

    holding: bool = False
    since_ns: int = NEVER
    force: Array | None = None
    taken_ns: int = NEVER
    variation: float = 0.0
    raised: float = 1.0
    raised_ns: int = NEVER

    def let_go(self) -> None:
        """Set to nothing held."""
        self.holding, self.since_ns, self.raised = False, NEVER, 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """Limits beyond which an object counts as held.

    Attributes
    ----------
    force_n, lasts_ms: grip force, and its duration, above which contact begins (chosen: ten times the offset
        of a thin resistive sensor; four periods of 25 ms).
    lost_ms: duration below half of that force after which contact ends (chosen: longer than a finger
        bounces).
    """

    force_n: float = 0.5
    lasts_ms: float = 100.0
    lost_ms: float = 300.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.force_n) and self.force_n > 0.0):
            raise InputError("contact.force_n", f"{self.force_n}", "a finite force above 0")
        for key in ("lasts_ms", "lost_ms"):
            duration_ns(getattr(self, key), NS_PER_MS, f"contact.{key}")

    def look(self, touch: Touch, grip_n: float, now_ns: int) -> None:
        """Update in `touch` whether an object is held."""
        against = grip_n < _LOST * self.force_n if touch.holding else grip_n > self.force_n
        if not against:
            touch.since_ns = NEVER
            return
        if touch.since_ns < 0:
            touch.since_ns = now_ns
        if now_ns - touch.since_ns >= (self.lost_ms if touch.holding else self.lasts_ms) * NS_PER_MS:
            touch.holding, touch.since_ns = not touch.holding, NEVER


@dataclass(frozen=True, slots=True, kw_only=True)
class Slip:
    """Limits beyond which an object slips: it sticks and slides by turns, and the forces tremble.

    Slips call for a firmer grip (Westling and Johansson 1984, doi 10.1007/BF00238156).

    Attributes
    ----------
    change_n: RMS change of a fingertip's force from sample to sample (chosen: five times that of sensors
        with a noise of .02 N).
    raise_by: factor on the target force for each slip (chosen).
    pause_ms: least time between two rises (chosen: response time of the force).
    """

    change_n: float = 0.15
    raise_by: float = 1.15
    pause_ms: float = 300.0

    def __post_init__(self) -> None:
        if not self.change_n > 0.0:
            raise InputError("slip.change_n", f"{self.change_n}", "above 0; inf for no reaction to slips")
        if not (math.isfinite(self.raise_by) and self.raise_by >= 1.0):
            raise InputError("slip.raise_by", f"{self.raise_by}", "1 or more")
        duration_ns(self.pause_ms, NS_PER_MS, "slip.pause_ms")

    def record(self, touch: Touch, force: Array, taken_ns: int) -> float:
        """Record a sample (k,), N; return the greatest RMS change of a fingertip from sample to sample, N."""
        if taken_ns > touch.taken_ns:
            if touch.force is not None:
                change = float(np.max((force - touch.force) ** 2))
                touch.variation += _WEIGHT * (change - touch.variation)
            touch.force, touch.taken_ns = force.copy(), taken_ns
        return math.sqrt(touch.variation)

    def react(self, touch: Touch, restless_n: float, now_ns: int) -> bool:
        """Raise the target if there is a slip; return whether there is."""
        rested = touch.raised_ns < 0 or now_ns - touch.raised_ns >= self.pause_ms * NS_PER_MS
        if restless_n <= self.change_n or not rested:
            return False
        touch.raised, touch.raised_ns = touch.raised * self.raise_by, now_ns
        return True
