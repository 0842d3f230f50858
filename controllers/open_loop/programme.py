"""`programme`: open-loop stimulation, way-point after way-point, once or in cycles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, duration_ns
from fesloop.loop.signals import Port, Sample, Value

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class ProgrammeState:
    """Way-points in SI units, constant.

    Attributes
    ----------
    times_s: (points,), s.
    pulses: (points, channels, 2), A and s.
    cycle_ns: length of a cycle; 0: none.
    """

    times_s: Array
    pulses: Array
    cycle_ns: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Programme:
    """Stimulation as a function of time alone: currents and pulse widths, linear between way-points.

    Before the first way-point and after the last, their pulses hold. A step needs two way-points with a short
    time between them.

    Attributes
    ----------
    times_s: (points,), strictly increasing, 0 or more, s.
    current_ma: (points, channels), mA; one row applies to all points.
    width_us: (points, channels), us; one row applies to all points.
    cycle_s: period with which the programme repeats, not below its last way-point; 0: it runs once.

    Output: `stimulation` (channels, 2), A and s.
    """

    times_s: tuple[float, ...]
    current_ma: tuple[tuple[float, ...], ...]
    width_us: tuple[tuple[float, ...], ...]
    cycle_s: float = 0.0

    def __post_init__(self) -> None:
        times = self.times_s
        if not times or not all(isfinite(t) and t >= 0.0 for t in times) or any(
                b <= a for a, b in pairwise(times)):
            raise InputError("times_s", f"{times}", "one or more finite, strictly increasing times from 0 on")
        for key in ("current_ma", "width_us"):
            rows = getattr(self, key)
            if len(rows) not in (1, len(times)):
                raise InputError(key, f"{len(rows)} rows", f"{len(times)}, one for each of times_s, or 1")
            for number, row in enumerate(rows):
                for channel, value in enumerate(row):
                    if not (isfinite(value) and value >= 0.0):
                        raise InputError(f"{key}[{number}][{channel}]", f"{value:g}",
                                         "a finite number, 0 or more")
        sizes = {len(row) for row in self.current_ma + self.width_us}
        if len(sizes) != 1 or 0 in sizes:
            raise InputError("current_ma, width_us", f"rows of {', '.join(map(str, sorted(sizes)))} channels",
                             "equally many in every row, one or more")
        if duration_ns(self.cycle_s, NS_PER_S, "cycle_s") and self.cycle_s < times[-1]:
            raise InputError("cycle_s", f"{self.cycle_s:g}", f"at least {times[-1]:g}, the last of times_s")

    @property
    def channels(self) -> int:
        """Number of channels."""
        return len(self.current_ma[0])

    @property
    def inputs(self) -> tuple[Port, ...]:
        """None: a source."""
        return ()

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`stimulation`."""
        return (Port("stimulation", (self.channels, 2), "A,s"),)

    def init(self, context: Context) -> ProgrammeState:
        """Way-points in SI units."""
        shape = len(self.times_s), self.channels
        pulses = np.stack([np.broadcast_to(self.current_ma, shape) / 1e3,
                           np.broadcast_to(self.width_us, shape) / 1e6], axis=-1)
        return ProgrammeState(np.array(self.times_s), pulses, duration_ns(self.cycle_s, NS_PER_S, "cycle_s"))

    def step(self, state: ProgrammeState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Pulses of this instant."""
        now_ns = tick.time_ns % state.cycle_ns if state.cycle_ns else tick.time_ns
        return (pulses_at(state.times_s, state.pulses, now_ns / NS_PER_S),)


def pulses_at(times_s: Array, pulses: Array, now_s: float) -> Array:
    """Linear interpolation of `pulses` (points, ...) at an instant; the ends hold."""
    after = int(np.searchsorted(times_s, now_s, side="right"))
    if after in (0, times_s.size):
        ends: Array = pulses[min(after, times_s.size - 1)].copy()
        return ends
    share = (now_s - times_s[after - 1]) / (times_s[after] - times_s[after - 1])
    between: Array = (1.0 - share) * pulses[after - 1] + share * pulses[after]
    return between
