"""What fingertip forces say of a grasp: that it has begun, that it is lost, that the object slips."""

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
"""Contact is lost below this share of the force at which it begins (chosen: noise does not pass between)."""
_WEIGHT = 0.3
"""Of the newest change in the mean of squares: about three samples count (chosen)."""


def grip_of(force: Array, thumb: int) -> float:
    """Grip force, N: the thumb's or that of all fingers together, whichever is greater.

    What presses on an object at rest from one side is met from the other, by fingertips or by parts of the
    hand that no sensor is on.
    """
    return float(max(force[thumb], force.sum() - force[thumb]))


@dataclass(slots=True, eq=False)
class Touch:
    """What is remembered of the forces.

    Attributes
    ----------
    holding: whether the object is in the grip.
    since_ns: since when forces say otherwise; NEVER while they agree with `holding`.
    force: (k,), N, the newest that was felt, `taken_ns` its capture; None before the first.
    variation: mean square of what the most restless fingertip's force changes from sample to sample, N^2.
    raised: factor by which slips have raised the force that is wanted, `raised_ns` when they last did.
    """

    holding: bool = False
    since_ns: int = NEVER
    force: Array | None = None
    taken_ns: int = NEVER
    variation: float = 0.0
    raised: float = 1.0
    raised_ns: int = NEVER

    def let_go(self) -> None:
        """Nothing is in the grip."""
        self.holding, self.since_ns, self.raised = False, NEVER, 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """When an object counts as held.

    Attributes
    ----------
    force_n, lasts_ms: grip force above this for so long begins it (chosen: ten times the offset of a thin
        resistive sensor; four periods of 25 ms).
    lost_ms: below half of it for so long ends it (chosen: longer than a finger bounces).
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
        """Note in `touch` whether the object is held."""
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
    """When an object counts as slipping: it sticks and slides by turns, and the forces tremble.

    Slips call for a firmer grip (Westling and Johansson 1984, doi 10.1007/BF00238156).

    Attributes
    ----------
    change_n: RMS change of a fingertip's force from sample to sample (chosen: five times that of sensors
        with a noise of .02 N).
    raise_by: factor of the force wanted for each slip (chosen). pause_ms: not more often (chosen: the time
        that force takes to follow).
    """

    change_n: float = 0.15
    raise_by: float = 1.15
    pause_ms: float = 300.0

    def __post_init__(self) -> None:
        if not self.change_n > 0.0:
            raise InputError("slip.change_n", f"{self.change_n}", "above 0; inf heeds no slip")
        if not (math.isfinite(self.raise_by) and self.raise_by >= 1.0):
            raise InputError("slip.raise_by", f"{self.raise_by}", "1 or more")
        duration_ns(self.pause_ms, NS_PER_MS, "slip.pause_ms")

    def feel(self, touch: Touch, force: Array, taken_ns: int) -> float:
        """Take in a sample (k,), N; RMS change from sample to sample, N, of the most restless fingertip."""
        if taken_ns > touch.taken_ns:
            if touch.force is not None:
                change = float(np.max((force - touch.force) ** 2))
                touch.variation += _WEIGHT * (change - touch.variation)
            touch.force, touch.taken_ns = force.copy(), taken_ns
        return math.sqrt(touch.variation)

    def heed(self, touch: Touch, restless_n: float, now_ns: int) -> bool:
        """Raise what is wanted if there is a slip; whether there is."""
        rested = touch.raised_ns < 0 or now_ns - touch.raised_ns >= self.pause_ms * NS_PER_MS
        if restless_n <= self.change_n or not rested:
            return False
        touch.raised, touch.raised_ns = touch.raised * self.raise_by, now_ns
        return True
