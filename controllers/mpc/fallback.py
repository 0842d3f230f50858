"""What a predictive controller gives out while it is kept from control: its declared safe output."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.signals import NEVER

if TYPE_CHECKING:
    pass

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class Fallback:
    """The last good plan, and the drive from which a ramp to zero starts.

    Attributes
    ----------
    planned: (steps muscles,), as solved; size 0 before any plan.
    used: number of its steps given out.
    trouble: what keeps the controller from control; "" while all is well.
    held, held_ns: (muscles,), drive that is held, then ramped to zero, and since when; NEVER if none is.
    """

    planned: Array = field(default_factory=lambda: np.empty(0))
    used: int = 0
    trouble: str = ""
    held: Array = field(default_factory=lambda: np.empty(0))
    held_ns: int = NEVER

    def solved(self, planned: Array) -> None:
        """All is well: a plan whose first step is in force."""
        self.planned, self.used, self.trouble, self.held_ns = planned, 1, "", NEVER

    def next_planned(self, muscles: int, steps: int) -> Array | None:
        """The next step of the last plan, (muscles,); None when `steps` have been given out."""
        if self.used >= steps or self.planned.size == 0:
            return None
        following = self.planned[self.used * muscles:(self.used + 1) * muscles]
        self.used, self.held_ns = self.used + 1, NEVER
        return following

    def ramped(self, drive: Array, now_ns: int, hold_ms: float, ramp_ms: float) -> Array:
        """The drive in force (muscles,) when this began, held, then ramped to zero."""
        if self.held_ns == NEVER:
            self.held, self.held_ns = drive, now_ns
        ramping_ms = (now_ns - self.held_ns) / NS_PER_MS - hold_ms
        return self.held * (1.0 if ramping_ms <= 0.0 else max(0.0, 1.0 - ramping_ms / max(ramp_ms, 1e-9)))


