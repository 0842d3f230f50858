"""What theory says of an experiment at once: as much of it as takes no longer than a second."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fesloop.experiment.experiment import Experiment
from fesloop.loop.clock import NS_PER_MS
from fesloop.theory.critical_latency import critical_latency_ms
from fesloop.theory.linear_loop import LinearLoop, linear_loop
from fesloop.theory.period_map import period_map
from fesloop.theory.schedule import schedule
from fesloop.theory.second_moments import SecondMoments
from fesloop.theory.stationary_cost import StationaryCost, stationary_cost

_UP_TO_MS = 500.0
"""Of critical latencies (chosen: what a loop through a tracker and a stimulator never has)."""
_MOST_NUMBERS, _MOST_EVENTS = 30_000, 200
"""Second moments under jitter or loss, events in a period that is run through many times: each takes about
half a second (measured)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FirstAnswer:
    """Theory of a linear loop.

    Attributes
    ----------
    cost: at rest; None where it takes longer.
    critical_ms: by wire, latency that it has and critical latency; the latter None where there is none up to
        500 ms. Of wires that take time or lead to the plant; empty where it takes longer, as with jitter and
        loss.
    """

    cost: StationaryCost | None
    critical_ms: dict[str, tuple[float, float | None]]

    def as_table(self) -> dict[str, Any]:
        """As `fesloop check --json` prints it."""
        cost = self.cost
        told = {"critical_latency_ms": {wire: critical for wire, (_, critical) in self.critical_ms.items()}}
        if cost is None:
            return told
        values = [float(value) if cost.stable else None for value in cost.rms]
        return {**told, "stable": cost.stable, "rms": dict(zip(cost.names, values, strict=True)),
                "unit": cost.unit}


def first_answer(experiment: Experiment) -> FirstAnswer:
    """Cost and critical latencies of an experiment's linear loop.

    Raises InputError as `linear_loop` does, and for rates that do not soon come together.
    """
    loop = linear_loop(experiment)
    small = not loop.random or SecondMoments(period_map(loop)).numbers <= _MOST_NUMBERS
    quick = not loop.random and len(schedule(loop, read=False).events) <= _MOST_EVENTS
    return FirstAnswer(cost=stationary_cost(loop) if small else None,
                       critical_ms=_critical_ms(loop) if quick else {})


def _critical_ms(loop: LinearLoop) -> dict[str, tuple[float, float | None]]:
    return {c.wire.name: (c.wire.latency_ns / NS_PER_MS, critical_latency_ms(loop, c.wire.name, _UP_TO_MS))
            for c in loop.connections if c.wire.latency_ns or c.target is loop.plant}
