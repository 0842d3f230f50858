"""Exact theory of linear loops, from the same experiments that are simulated."""

from fesloop.analysis.theory.critical_latency import critical_latency_ms
from fesloop.analysis.theory.linear_loop import linear_loop
from fesloop.analysis.theory.loop import LinearLoop
from fesloop.analysis.theory.open_loop import open_loop
from fesloop.analysis.theory.stationary_cost import StationaryCost, stationary_cost

__all__ = ["LinearLoop", "StationaryCost", "critical_latency_ms", "linear_loop", "open_loop",
           "stationary_cost"]
