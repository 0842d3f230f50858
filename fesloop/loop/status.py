"""Statuses told once, when they begin, so that the event record holds changes and not ticks."""

from __future__ import annotations

from dataclasses import dataclass, field

from fesloop.loop.block import Tick


@dataclass(slots=True)
class StatusLatch:
    """The statuses that hold now; part of a block's state."""

    holding: set[str] = field(default_factory=set)

    def put(self, tick: Tick, status: str, holds: bool, detail: str = "") -> None:
        """Report `status` if it holds and did not hold before."""
        if holds and status not in self.holding:
            self.holding.add(status)
            tick.report(status, detail)
        elif not holds:
            self.holding.discard(status)
