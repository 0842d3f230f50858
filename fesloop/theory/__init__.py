"""Theory beside simulation: exact answers for linear loops, read off the same experiment that runs."""

from fesloop.theory.critical_latency import critical_latency_ms
from fesloop.theory.linear_loop import LinearLoop, linear_loop
from fesloop.theory.stationary_cost import StationaryCost, stationary_cost

__all__ = ["LinearLoop", "StationaryCost", "critical_latency_ms", "linear_loop", "stationary_cost"]
