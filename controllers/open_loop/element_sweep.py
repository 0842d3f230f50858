"""`element_sweep`: a staircase of current on one element of the arrays after another."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite
from typing import Any

import numpy as np

from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, duration_ns
from fesloop.loop.signals import Port, Sample, Value
from fesloop.models.electrode_arrays import ElectrodeArrays


@dataclass(frozen=True, slots=True, kw_only=True)
class ElementSweep:
    """Pulses of rising current on one element after another, with a rest after each.

    One channel of the stimulator is switched from element to element through the multiplexing. After the last
    element nothing is stimulated.

    Attributes
    ----------
    count: number of elements of the arrays.
    elements: numbers of the elements, in order; empty: all.
    current_ma: currents, strictly increasing, mA.
    width_us: pulse width.
    stair_s: duration of each current.
    rest_s: pause before the next element.

    Outputs: `stimulation` (1, 2), A and s; `multiplexing` (1, count), share of the current that each element
    has; `element`, number of the present one, -1 after the last; `stair`, number of the current,
    -1 at rest.
    """

    count: int = 59
    elements: tuple[int, ...] = ()
    current_ma: tuple[float, ...] = (5.0, 10.0, 15.0, 20.0, 25.0, 30.0)
    width_us: float = 300.0
    stair_s: float = 0.5
    rest_s: float = 1.0

    def __post_init__(self) -> None:
        if self.count < 1:
            raise InputError("count", f"{self.count}", "1 or more elements")
        for element in self.elements:
            if not 0 <= element < self.count:
                raise InputError("elements", f"element {element} does not exist", f"0 to {self.count - 1}")
        stairs = (0.0, *self.current_ma)
        if len(stairs) < 2 or not all(map(isfinite, stairs)) or any(b <= a for a, b in pairwise(stairs)):
            raise InputError("current_ma", f"{self.current_ma}", "one or more finite currents above 0, "
                             "strictly increasing")
        if not (isfinite(self.width_us) and self.width_us > 0.0):
            raise InputError("width_us", f"{self.width_us}", "a finite width above 0")
        if duration_ns(self.stair_s, NS_PER_S, "stair_s") == 0:
            raise InputError("stair_s", f"{self.stair_s}", "above 0")
        duration_ns(self.rest_s, NS_PER_S, "rest_s")

    @property
    def order(self) -> tuple[int, ...]:
        """Numbers of the elements in order."""
        return self.elements or tuple(range(self.count))

    @property
    def duration_s(self) -> float:
        """Duration of the whole sweep."""
        return len(self.order) * (len(self.current_ma) * self.stair_s + self.rest_s)

    @classmethod
    def for_arrays(cls, arrays: ElectrodeArrays, own: Mapping[str, Any], wired: Collection[str]
                   ) -> dict[str, int]:
        """The number of elements."""
        return {"count": arrays.elements}

    def of_arrays(self) -> list[tuple[str, str]]:
        """Duration of the sweep over the elements."""
        return [("sweep", f"of {len(self.order)} elements takes {self.duration_s:g} s")]

    @property
    def inputs(self) -> tuple[Port, ...]:
        """None: a source."""
        return ()

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`stimulation`, `multiplexing`, `element`, `stair`."""
        return (Port("stimulation", (1, 2), "A,s"), Port("multiplexing", (1, self.count), "1"),
                Port("element", (), "1", -1.0), Port("stair", (), "1", -1.0))

    def init(self, context: Context) -> None:
        """No state: outputs depend on time alone."""
        return

    def step(self, state: None, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Outputs of this instant."""
        stair_ns = duration_ns(self.stair_s, NS_PER_S, "stair_s")
        lasting_ns = len(self.current_ma) * stair_ns + duration_ns(self.rest_s, NS_PER_S, "rest_s")
        turn, since_ns = divmod(tick.time_ns, lasting_ns)
        pulses, shares = np.zeros((1, 2)), np.zeros((1, self.count))
        if turn >= len(self.order):
            return pulses, shares, -1.0, -1.0
        element, stair = self.order[turn], since_ns // stair_ns
        shares[0, element] = 1.0
        if stair >= len(self.current_ma):
            return pulses, shares, float(element), -1.0
        pulses[0] = self.current_ma[stair] / 1e3, self.width_us / 1e6
        return pulses, shares, float(element), float(stair)
