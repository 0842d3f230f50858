"""`element_sweep`: a staircase of current on one element of the arrays after another."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import isfinite, radians
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, duration_ns
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample, Value, is_finite
from fesloop.models.electrode_arrays import ElectrodeArrays

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class SweepState:
    """Turn of one element.

    Attributes
    ----------
    turn: number of the element in the order; begun_ns, ends_ns: beginning of its turn and of the next one.
    before: (m,), rad, last measurement before the first current; empty before any.
    responded: whether it has moved the hand far enough.
    latch: status of the input.
    """

    turn: int = -1
    begun_ns: int = 0
    ends_ns: int = 0
    before: Array = field(default_factory=lambda: np.empty(0))
    responded: bool = False
    latch: StatusLatch = field(default_factory=StatusLatch)


@dataclass(frozen=True, slots=True, kw_only=True)
class ElementSweep:
    """Pulses of rising current on one element after another, with a rest after each.

    One channel of the stimulator is switched from element to element through the multiplexing. After the last
    element nothing is stimulated. Where `measured` is wired and an element moves any angle by `enough_deg`,
    its further currents are left out, and its rest begins: strong twitches tire muscles and tell little more.

    Attributes
    ----------
    count: number of elements of the arrays.
    elements: numbers of the elements, in order; empty: all.
    current_ma: currents, strictly increasing, mA.
    width_us: pulse width.
    stair_s: duration of each current.
    rest_s: pause before the next element.
    enough_deg: change of any measured angle, deg, from which an element's further currents are left out;
        0: all currents always.
    measured: number of angles; 0 takes it from the wire.
    begin_s: time before which nothing is stimulated: the hand is held in a pose, or relaxes after it.

    Input: optional `measured` (m,), rad. Outputs: `stimulation` (1, 2), A and s; `multiplexing` (1, count),
    share of the current that each element has; `element`, number of the present one, -1 before the first and
    after the last; `stair`, number of the current, -1 at rest.
    """

    count: int = 59
    elements: tuple[int, ...] = ()
    current_ma: tuple[float, ...] = (5.0, 10.0, 15.0, 20.0, 25.0, 30.0)
    width_us: float = 300.0
    stair_s: float = 0.5
    rest_s: float = 1.0
    enough_deg: float = 0.0
    begin_s: float = 0.0
    measured: int = 0

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
        duration_ns(self.begin_s, NS_PER_S, "begin_s")
        if not (isfinite(self.enough_deg) and self.enough_deg >= 0.0):
            raise InputError("enough_deg", f"{self.enough_deg}", "0, or a finite angle above it")

    @property
    def order(self) -> tuple[int, ...]:
        """Numbers of the elements in order."""
        return self.elements or tuple(range(self.count))

    @property
    def duration_s(self) -> float:
        """Duration of the whole sweep, at most."""
        return self.begin_s + len(self.order) * (len(self.current_ma) * self.stair_s + self.rest_s)

    @classmethod
    def for_arrays(cls, arrays: ElectrodeArrays, own: Mapping[str, Any], wired: Collection[str]
                   ) -> dict[str, int]:
        """The number of elements."""
        return {"count": arrays.elements}

    def of_arrays(self) -> list[tuple[str, str]]:
        """Duration of the sweep over the elements."""
        return [("sweep", f"of {len(self.order)} elements takes {self.duration_s:g} s at most")]

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`measured`."""
        return (Port("measured", (self.measured or None,), "rad", optional=True),)

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> ElementSweep:
        """The block for the wired input; raises InputError unless it is a vector."""
        shape = shapes.get("measured", (self.measured,))
        if len(shape) != 1:
            raise InputError("measured", f"shape {shape}", "a vector")
        return replace(self, measured=shape[0])

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`stimulation`, `multiplexing`, `element`, `stair`."""
        return (Port("stimulation", (1, 2), "A,s"), Port("multiplexing", (1, self.count), "1"),
                Port("element", (), "1", -1.0), Port("stair", (), "1", -1.0))

    def init(self, context: Context) -> SweepState:
        """State before the first element."""
        return SweepState(ends_ns=duration_ns(self.begin_s, NS_PER_S, "begin_s"))

    def step(self, state: SweepState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Outputs of this instant."""
        stair_ns, rest_ns = (duration_ns(getattr(self, key), NS_PER_S, key) for key in ("stair_s", "rest_s"))
        stairs_ns, sample = len(self.current_ma) * stair_ns, inputs[0]
        measured = cast(Array, sample.value) if sample.present and is_finite(sample.value) else None
        while tick.time_ns >= state.ends_ns:
            state.turn, state.begun_ns, state.responded = state.turn + 1, state.ends_ns, False
            state.ends_ns += stairs_ns + rest_ns
            state.before = np.empty(0) if measured is None else measured.copy()
        pulses, shares = np.zeros((1, 2)), np.zeros((1, self.count))
        if not 0 <= state.turn < len(self.order):
            return pulses, shares, -1.0, -1.0
        element, since_ns = self.order[state.turn], tick.time_ns - state.begun_ns
        shares[0, element] = 1.0
        state.latch.put(tick, "no_input", self.enough_deg > 0.0 and not state.before.size,
                        f"no finite measurement: element {element} gets all currents, however far it moves")
        if self.enough_deg and measured is not None and state.before.size and not state.responded:
            state.responded = bool(np.abs(measured - state.before).max() >= radians(self.enough_deg))
            if state.responded and since_ns < stairs_ns:
                state.ends_ns = tick.time_ns + rest_ns
        if state.responded or since_ns >= stairs_ns:
            return pulses, shares, float(element), -1.0
        stair = since_ns // stair_ns
        pulses[0] = self.current_ma[stair] / 1e3, self.width_us / 1e6
        return pulses, shares, float(element), float(stair)
