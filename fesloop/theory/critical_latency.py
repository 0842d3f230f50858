"""The latency of a wire at which a linear loop loses stability, by eigenvalues."""

from __future__ import annotations

from fesloop.errors import InputError
from fesloop.experiment.experiment import Experiment
from fesloop.loop.clock import NS_PER_MS, duration_ns
from fesloop.theory.linear_loop import LinearLoop, linear_loop
from fesloop.theory.period_map import period_map
from fesloop.theory.second_moments import SecondMoments

_STEPS_A_PERIOD = 2
"""Of the search, in the quickest clock's period (chosen). An instability that ends again within a step could
be passed over."""


def growth(loop: LinearLoop) -> float:
    """The factor by which second moments grow in a period; without draws the spectral radius squared."""
    return SecondMoments(period_map(loop, read=False)).spectral_radius()


def critical_latency_ms(loop: Experiment | LinearLoop, wire: str, up_to_ms: float = 1000.0) -> float | None:
    """The smallest latency of a wire at which the loop does not come to rest, ms, to the nanosecond.

    Without random wires that is where an eigenvalue of the sampled loop reaches modulus 1; with jitter or
    loss, where second moments cease to be bounded. Into a block, latency acts in whole ticks of the reader,
    so the answer is then one ns above a staircase's step. None where the loop is stable up to `up_to_ms`.

    Parameters
    ----------
    loop: with all else as it is.
    wire: its name, "a.b->c.d".

    Raises InputError as `linear_loop` does, and for a wire that is not on the loop.
    """
    loop = loop if isinstance(loop, LinearLoop) else linear_loop(loop)
    stable_ns = max(0, -loop.wire(wire).wire.jitter.least_ns)
    most_ns = duration_ns(up_to_ms, NS_PER_MS, "up_to_ms")
    if most_ns <= stable_ns:
        raise InputError("up_to_ms", f"{up_to_ms:g}", f"above {stable_ns / NS_PER_MS:g}, the least latency")

    def unstable(latency_ns: int) -> bool:
        return growth(loop.with_latency(wire, latency_ns)) >= 1.0

    if unstable(stable_ns):
        return stable_ns / NS_PER_MS
    step_ns = max(1, min(clock.shortest_ns for clock in loop.clocks) // _STEPS_A_PERIOD)
    unstable_ns = stable_ns
    while not unstable(unstable_ns := min(unstable_ns + step_ns, most_ns)):
        stable_ns = unstable_ns
        if unstable_ns == most_ns:
            return None
    while unstable_ns - stable_ns > 1:
        middle = (stable_ns + unstable_ns) // 2
        stable_ns, unstable_ns = (stable_ns, middle) if unstable(middle) else (middle, unstable_ns)
    return unstable_ns / NS_PER_MS
