"""Critical latency: the latency of a wire at which a linear loop loses stability, from eigenvalues."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import cast

import numpy as np

from fesloop.analysis.theory.linear_loop import linear_loop
from fesloop.analysis.theory.loop import LinearLoop, varies
from fesloop.analysis.theory.period_map import period_map
from fesloop.analysis.theory.second_moments import SecondMoments
from fesloop.errors import InputError
from fesloop.experiment.running import Experiment
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, RateClock, duration_ns
from fesloop.loop.duration import ZERO
from fesloop.loop.machine import one_blas_thread
from fesloop.loop.nodes import Connection

_A_PERIOD, _AN_OSCILLATION = 4, 16
"""Number of latencies at which growth is computed, per period of the quickest clock and per oscillation of
the plant's fastest mode (chosen: under delayed feedback, damping rises and falls once per oscillation)."""
_FINEST = 64
"""Most of these latencies per period, whatever the oscillations and the rates (chosen)."""
_WITHIN = 1e-3
"""Resolution of a maximum of growth between them, as a fraction of their distance (chosen)."""
_SAME = 1e-7
"""Difference below which two eigenvalues are equal (chosen: far above rounding)."""
_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def growth(loop: LinearLoop) -> float:
    """Factor by which second moments grow per period; without random wires, the squared spectral radius."""
    return SecondMoments(period_map(loop, read=False)).spectral_radius()


def critical_latency_ms(loop: Experiment | LinearLoop, wire: str, up_to_ms: float = 1000.0) -> float | None:
    """The smallest latency of a wire at which the loop does not come to rest, in ms, exact to the nanosecond.

    Without random wires, an eigenvalue of the sampled loop reaches modulus 1 there; with jitter or loss,
    second moments become unbounded. Latency into a block acts in whole ticks of the reader, so the result is
    one ns above a step of a staircase. None where the loop is stable up to `up_to_ms`.

    Beyond it a loop may be stable again. Growth is computed at latencies close together compared with both
    the period and the plant's fastest oscillation, and its maxima between them are searched where they may
    reach 1, so that a short interval of instability is found too.

    A crossing that is found is exact; the search for the first has a resolution. Into a block without jitter
    every step of the staircase is tried, down to 1/128 of the quicker of the two periods: a shorter interval
    of instability may be missed. Elsewhere one may be missed where growth has several maxima between two of
    the latencies.

    Parameters
    ----------
    loop: the loop, or its experiment; its other latencies stay as they are.
    wire: its name, "a.b->c.d".

    Raises InputError as `linear_loop` does, for a wire that is not on the loop, and for a loop with a mode
    that does not decay and that the wire does not reach, so that it comes to rest at no latency.
    """
    loop = loop if isinstance(loop, LinearLoop) else linear_loop(loop)
    connection = loop.wire(wire)
    least_ns = max(0, -connection.wire.jitter.least_ns)
    most_ns = duration_ns(up_to_ms, NS_PER_MS, "up_to_ms")
    if most_ns <= least_ns:
        raise InputError("up_to_ms", f"{up_to_ms:g}", f"above {least_ns / NS_PER_MS:g}, the least latency")

    def growth_at(latency_ns: int) -> float:
        return growth(loop.with_latency(wire, latency_ns))

    with one_blas_thread():
        _require_reached(loop, wire, [least_ns + (most_ns - least_ns) // part for part in (97, 13, 3)])
        in_ticks = _in_ticks(loop, connection)
        step_ns = _staircase_ns(connection) // 2 if in_ticks else _distance_ns(loop)
        bracket = _first_crossing(growth_at, least_ns, most_ns, max(1, step_ns), smooth=not in_ticks)
        if bracket is None:
            return None
        stable_ns, unstable_ns = bracket
        while unstable_ns - stable_ns > 1:
            middle = (stable_ns + unstable_ns) // 2
            stable = growth_at(middle) < 1.0
            stable_ns, unstable_ns = (middle, unstable_ns) if stable else (stable_ns, middle)
    return unstable_ns / NS_PER_MS


def _require_reached(loop: LinearLoop, wire: str, latencies_ns: Sequence[int]) -> None:
    """Raise InputError for a mode that decays at no latency, as the wire does not reach it.

    Jitter and loss do not reach it either, so they are left out.
    """
    def certain(c: Connection) -> Connection:
        return replace(c, wire=replace(c.wire, jitter=ZERO, loss=0.0, burst_messages=0.0))

    undisturbed = replace(loop, connections=tuple(certain(c) for c in loop.connections))
    common: set[complex] | None = None
    for latency_ns in latencies_ns:
        matrix = period_map(undisturbed.with_latency(wire, latency_ns), read=False).matrix
        assert matrix is not None
        values = np.linalg.eigvals(matrix)
        staying = [value for value in values if abs(value) >= 1.0 - _SAME]
        common = {each for each in staying
                  if common is None or any(abs(each - old) <= _SAME for old in common)}
    if common:
        growth_of = max(abs(value) for value in common)
        raise InputError(f"wire {wire}", f"a mode that it does not reach is multiplied by {growth_of:.9g} "
                         "in each period, so the loop settles at no latency",
                         "a loop all of whose modes decay",
                         "look for an integrator outside the loop")


def _in_ticks(loop: LinearLoop, connection: Connection) -> bool:
    """Whether latency acts in whole ticks of the reader."""
    return connection.target is not loop.plant and not varies(connection)


def _staircase_ns(connection: Connection) -> int:
    """Narrowest step of the staircase by which latency acts between two clocks."""
    source, reader = (1 / cast(RateClock, clock).rate for clock in (
        connection.clock or connection.source.clock, connection.target.clock))
    common = Fraction(math.gcd(source.numerator * reader.denominator, reader.numerator * source.denominator),
                      source.denominator * reader.denominator)
    return int(max(common, min(source, reader) / _FINEST) * NS_PER_S)


def _distance_ns(loop: LinearLoop) -> int:
    """Distance of the latencies at which growth is computed, where latency acts continuously."""
    period_ns = min(clock.shortest_ns for clock in loop.clocks)
    fastest = float(np.abs(np.linalg.eigvals(loop.plant_form.a).imag).max(initial=0.0))
    oscillation_ns = 2.0 * math.pi / fastest * NS_PER_S if fastest else math.inf
    return max(int(min(period_ns / _A_PERIOD, oscillation_ns / _AN_OSCILLATION)), period_ns // _FINEST)


def _first_crossing(
    growth_at: Callable[[int], float], least_ns: int, most_ns: int, step_ns: int, smooth: bool
) -> tuple[int, int] | None:
    """A stable latency and the next unstable one; the same twice where the least latency is unstable."""
    places, values = [least_ns], [growth_at(least_ns)]
    if values[0] >= 1.0:
        return least_ns, least_ns
    while True:
        last = places[-1] == most_ns
        if not last:
            places.append(min(places[-1] + step_ns, most_ns))
            values.append(growth_at(places[-1]))
        peak = len(places) - (1 if last else 2)
        low, high = max(peak - 1, 0), min(peak + 1, len(places) - 1)
        drops = values[peak] - values[low], values[peak] - values[high]
        if smooth and min(drops) >= 0.0 and values[peak] + 2.0 * max(drops) >= 1.0:
            # Where growth is concave, it exceeds this sample at most by the greater drop.
            above = _reached(growth_at, places[low], places[high], max(1, int(step_ns * _WITHIN)))
            if above is not None:
                return max(p for p in places[:peak + 1] if p < above), above
        if last:
            return None
        if values[-1] >= 1.0:
            return places[-2], places[-1]


def _reached(growth_at: Callable[[int], float], low: int, high: int, within: int) -> int | None:
    """A latency between two at which growth is 1 or more, near its only maximum, by golden section."""
    left, right = high - int(_GOLDEN * (high - low)), low + int(_GOLDEN * (high - low))
    at_left, at_right = growth_at(left), growth_at(right)
    while at_left < 1.0 and at_right < 1.0 and high - low > within:
        if at_left >= at_right:
            high, right, at_right = right, left, at_left
            left = high - int(_GOLDEN * (high - low))
            at_left = growth_at(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + int(_GOLDEN * (high - low))
            at_right = growth_at(right)
    return left if at_left >= 1.0 else right if at_right >= 1.0 else None
