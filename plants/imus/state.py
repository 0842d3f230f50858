"""What the sensors of an `imus` block remember from tick to tick, and a tick of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.noise import NoiseStream
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Sample, Value
from plants.imus.device import KINDS
from plants.imus.kernels import Memory, Sensors, Surroundings, measure
from plants.imus.stimulation_artefacts import Pulses, PulseWatch

Array = NDArray[np.float64]
_NOTHING = np.empty(0)


class ImusState:
    """Sensors as drawn, and what changes.

    Attributes
    ----------
    sensors, around, memory: as the kernels take them.
    needed: which of the sites' four signals are read; idle stands in for the others.
    names: of the sensors.
    noise, chances: rows for the ticks of this trial; chances None: nothing is lost.
    watch: of the pulses.
    clipped: (kinds, n), which sensors clipped at the last tick.
    last_ns: instant of the last tick with sites; -1 before the first.
    latch: the statuses that hold.
    """

    __slots__ = ("around", "chances", "clipped", "idle", "last_ns", "latch", "memory", "names", "needed",
                 "noise", "sensors", "watch")

    def __init__(self, sensors: Sensors, around: Surroundings, memory: Memory, names: tuple[str, ...],
                 needed: tuple[bool, ...], noise: NoiseStream | None, chances: NoiseStream | None,
                 sites: int) -> None:
        self.sensors, self.around, self.memory, self.names = sensors, around, memory, names
        self.needed, self.noise, self.chances = needed, noise, chances
        self.idle = (np.tile([1.0, 0.0, 0.0, 0.0], (sites, 1)), *np.zeros((3, sites, 3)))
        self.watch = PulseWatch()
        self.clipped = np.zeros((sensors.kinds.size, sensors.sites.size), dtype=np.bool_)
        self.last_ns = -1
        self.latch = StatusLatch()

    def sample(
        self, inputs: Sequence[Sample], pulses: Pulses, window_s: float, tick: Tick
    ) -> tuple[Value, ...]:
        """Samples of the measured kinds, one array each, at this tick."""
        kinds, count = self.clipped.shape
        if not self._arrived(inputs, tick):
            return tuple(np.full((kinds, count, 3), np.nan))
        now = tick.time_ns
        elapsed_s = (now - self.last_ns) / NS_PER_S if self.last_ns >= 0 else 0.0
        self.last_ns = now
        stimulation = _NO_PULSE
        if len(inputs) > 4:
            stimulation = np.array(self.watch.now(pulses, inputs[4], now))
        samples, clipped = np.empty((kinds, count, 3)), np.zeros((kinds, count), dtype=np.bool_)
        sites: list[Any] = [given[0] if read else idle
                            for given, read, idle in zip(inputs, self.needed, self.idle, strict=False)]
        found = measure(
            self.sensors, self.around, self.memory, sites[0], sites[1], sites[2], sites[3],
            np.array((now / NS_PER_S, elapsed_s)), stimulation, window_s,
            _NOTHING if self.noise is None else self.noise.row(tick.index),
            _NOTHING if self.chances is None else self.chances.row(tick.index), samples, clipped)
        if found:
            self._report(clipped, tick)
        self.clipped = clipped
        return tuple(samples)

    def _arrived(self, inputs: Sequence[Sample], tick: Tick) -> bool:
        """Whether every signal that is read has come; reported while it has not."""
        waiting = any(read and not given.present for given, read in zip(inputs, self.needed, strict=False))
        if waiting or "waiting" in self.latch.holding:
            self.latch.put(tick, "waiting", waiting, "nothing has arrived from the sites: no samples")
        return not waiting

    def _report(self, clipped: NDArray[np.bool_], tick: Tick) -> None:
        """Name the sensors that clip and did not clip at the last tick."""
        new = clipped & ~self.clipped
        if new.any():
            kinds = [KINDS[kind] for kind in self.sensors.kinds]
            tick.report("clipped", "; ".join(
                f"{kind} of " + ", ".join(self.names[i] for i in np.flatnonzero(row))
                for kind, row in zip(kinds, new, strict=True) if row.any()))


_NO_PULSE = np.array([0.0, np.inf, 0.0])


def noise_columns(numbers: Array, kinds: list[int], sensors: int) -> NDArray[np.int64]:
    """First column, in a row of noise, of white noise, instability and walk of each kind, (3, 3).

    -1 for what is not measured or has sd 0 in `numbers` (3, 10): nothing is drawn for it.
    """
    columns, width = np.full((3, 3), -1), 0
    for kind in kinds:
        for process, number in enumerate(_PROCESSES):
            if numbers[kind, number] > 0.0:
                columns[kind, process] = width
                width += 3 * sensors
    return columns


_PROCESSES = (0, 2, 4)
"""Where `TriadErrors.numbers` holds the sd of white noise, of instability and of the walk."""


def new_state(
    sensors: Sensors, around: Surroundings, names: tuple[str, ...], needed: tuple[bool, ...],
    context: Context, loses: bool,
) -> ImusState:
    """At the start of a trial; `names` of all sites."""
    count, sites = sensors.sites.size, len(names)
    drawn = int((sensors.columns >= 0).sum()) * 3 * count
    memory = Memory(
        drift=np.zeros((2, 3, count, 3)), wobble=np.zeros((count, 4, 3)),
        lost=np.zeros(count, dtype=np.bool_), level=np.zeros(1), true=np.zeros((3, count, 3)))
    return ImusState(
        sensors, around, memory, tuple(names[i] for i in sensors.sites), needed,
        context.noise(drawn) if drawn else None,
        context.noise(count, "uniform", "loss") if loses else None, sites)
