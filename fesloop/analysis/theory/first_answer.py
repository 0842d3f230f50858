"""Theory of an experiment as far as it takes no longer than about a second, for `fesloop check`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from fesloop.analysis.theory.critical_latency import critical_latency_ms
from fesloop.analysis.theory.linear_loop import linear_loop
from fesloop.analysis.theory.loop import LinearLoop
from fesloop.analysis.theory.period_map import period_map
from fesloop.analysis.theory.schedule import schedule
from fesloop.analysis.theory.second_moments import SecondMoments
from fesloop.analysis.theory.stationary_cost import StationaryCost, stationary_cost
from fesloop.errors import FesloopError
from fesloop.experiment.running import Experiment
from fesloop.loop.clock import NS_PER_MS

T = TypeVar("T")
COST, CRITICAL = "rms at rest", "critical latencies"
_UP_TO_MS = 500.0
"""Greatest critical latency to search for (chosen: above any latency of a tracker and a stimulator)."""
_MOST_NUMBERS, _MOST_EVENTS = 30_000, 200
"""Most second moments under jitter or loss, and most events of a period that is run many times: each takes
about half a second (measured)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FirstAnswer:
    """Theory of a linear loop.

    Attributes
    ----------
    cost: at rest; None where it is not known.
    critical_ms: present and critical latency by wire, of wires with a latency or into the plant; the critical
        latency is None where there is none up to 500 ms.
    not_known: the reason why `COST` or `CRITICAL` is not known.
    """

    cost: StationaryCost | None
    critical_ms: dict[str, tuple[float, float | None]]
    not_known: dict[str, str]

    def as_table(self) -> dict[str, Any]:
        """The table that `fesloop check --json` prints."""
        cost = self.cost
        table: dict[str, Any] = {
            "critical_latency_ms": {wire: critical for wire, (_, critical) in self.critical_ms.items()},
            "missing": self.not_known}
        if cost is None:
            return table
        values = [float(value) if cost.stable else None for value in cost.rms]
        return {**table, "stable": cost.stable, "rms": dict(zip(cost.names, values, strict=True)),
                "unit": cost.unit}


def first_answer(experiment: Experiment) -> FirstAnswer:
    """Cost and critical latencies of an experiment's linear loop, or the reasons why they are missing."""
    not_known: dict[str, str] = {}
    try:
        loop = linear_loop(experiment)
    except FesloopError as fault:
        return FirstAnswer(cost=None, critical_ms={}, not_known=dict.fromkeys((COST, CRITICAL), str(fault)))
    cost = _unless_refused(COST, lambda: _cost(loop, not_known), not_known)
    critical_ms = _unless_refused(CRITICAL, lambda: _critical_ms(loop, not_known), not_known)
    return FirstAnswer(cost=cost, critical_ms=critical_ms or {}, not_known=not_known)


def _unless_refused(what: str, answer: Callable[[], T], not_known: dict[str, str]) -> T | None:
    """The answer; None, with the reason in `not_known`, where the theory refuses the loop."""
    try:
        return answer()
    except FesloopError as fault:
        not_known[what] = str(fault)
        return None


def _cost(loop: LinearLoop, not_known: dict[str, str]) -> StationaryCost | None:
    if loop.random and SecondMoments(period_map(loop)).numbers > _MOST_NUMBERS:
        not_known[COST] = ("with this jitter or loss it takes long: "
                           "fesloop.analysis.theory.stationary_cost gives it")
        return None
    return stationary_cost(loop)


def _critical_ms(loop: LinearLoop, not_known: dict[str, str]) -> dict[str, tuple[float, float | None]]:
    why = "under jitter or loss" if loop.random else "with rates that come together so seldom" \
        if len(schedule(loop, read=False).events) > _MOST_EVENTS else ""
    if why:
        not_known[CRITICAL] = f"{why} they take long: fesloop.analysis.theory.critical_latency_ms gives them"
        return {}
    return {c.wire.name: (c.wire.latency_ns / NS_PER_MS, critical_latency_ms(loop, c.wire.name, _UP_TO_MS))
            for c in loop.connections if c.wire.latency_ns or c.target is loop.plant}
