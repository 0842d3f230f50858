"""What the sensors of an `imus` block remember from tick to tick, and a tick of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.hand.kinematics_kernels import turned
from fesloop.hand.quaternion_kernels import conjugate
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.noise import NoiseStream
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Sample, Value
from plants.imus.device import KINDS
from plants.imus.disturbances import (
    Pulses,
    PulseWatch,
    add_sources,
    own_rate,
    place_carried,
    turn_back,
    vibration,
    wobble,
)

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
Flags = NDArray[np.bool_]


class Sensors(NamedTuple):
    """The sensors of a run: read-only.

    Attributes
    ----------
    kinds: (m,), the kinds that are measured.
    sites: (n,), number of the site that each sensor sits on.
    there: (3, n), whether the sensor has a triad of the kind.
    matrices: (3, n, 3, 3), from the segment's frame to what the axes read.
    constants: (3, n, 3), biases.
    numbers: (3, 10), of each kind's `TriadErrors`, in the order of its `NUMBERS`.
    columns: (3, 3), first column in the tick's noise of white noise, instability and walk of each kind; -1
        for what has none.
    spikes: (3, n, 3), artefact of a pulse of full charge.
    axes: (2, n, 3), of the tremor.
    tissue: (7,), of the soft tissue; the first is 0 where there is none.
    tremor: (3,) and components: (3, c), of the tremor; no component where there is none.
    losing: (2,), probability to lose a sample after one that was not lost, and after one that was.
    """

    kinds: Numbers
    sites: Numbers
    there: Flags
    matrices: Array
    constants: Array
    numbers: Array
    columns: Numbers
    spikes: Array
    axes: Array
    tissue: Array
    tremor: Array
    components: Array
    losing: Array


class Surroundings(NamedTuple):
    """The Earth's field (3,), T; dipoles in the room (k, 7) and carried (c, 7), and their sites (c,)."""

    earth: Array
    fixed: Array
    carried: Array
    carriers: Numbers


class Memory(NamedTuple):
    """What changes from tick to tick.

    Attributes
    ----------
    drift: (2, 3, n, 3), biases that come back, and that do not.
    wobble: (n, 4, 3), as `imus.soft_tissue.wobble` takes it.
    lost: (n,), whether the last sample was lost.
    level: (1,), of the tetanic tremor.
    true: (3, n, 3), what the sensors feel now, in the frames of their segments.
    """

    drift: Array
    wobble: Array
    lost: Flags
    level: Array
    true: Array


@compiled
def feel_field(
    sensors: Sensors, around: Surroundings, orientation: Array, position: Array, true: Array
) -> None:
    """Fill `true` (n, 3) with the field at the sensors, T, in the frames of their segments."""
    count = sensors.sites.size
    points, field = np.empty((count, 3)), np.empty((count, 3))
    for i in range(count):
        points[i] = position[sensors.sites[i]]
        field[i] = around.earth
    add_sources(around.fixed, points, field)
    if around.carriers.size:
        placed = np.empty(around.carried.shape)
        place_carried(around.carried, around.carriers, orientation, position, placed)
        add_sources(placed, points, field)
    for i in range(count):
        q = orientation[sensors.sites[i]]
        back = conjugate((q[0], q[1], q[2], q[3]))
        true[i, 0], true[i, 1], true[i, 2] = turned(back, field[i, 0], field[i, 1], field[i, 2])


@compiled
def feel_motion(
    sensors: Sensors, memory: Memory, rate: Array, force: Array, shaking: tuple[float, float],
    elapsed_s: float,
) -> None:
    """Fill `memory.true` with rates and forces at the sensors; turn all of it into frames that wobble."""
    true = memory.true
    for i in range(sensors.sites.size):
        site = sensors.sites[i]
        for axis in range(3):
            true[0, i, axis] = rate[site, axis] + shaking[0] * sensors.axes[0, i, axis]
            true[1, i, axis] = force[site, axis] + shaking[1] * sensors.axes[1, i, axis]
        if sensors.tissue[0] > 0.0:
            motion = memory.wobble[i]
            wobble(sensors.tissue, true[0, i], true[1, i], elapsed_s, motion)
            for kind in range(3):
                turn_back(motion[0], true[kind, i])
            own_rate(motion[0], motion[1], true[0, i])


@compiled
def wander(numbers: Array, columns: Numbers, noise: Array, elapsed_s: float, drift: Array, kind: int) -> None:
    """Bring the biases `drift` (2, 3, n, 3) of one kind on; with 0 s elapsed, draw the trial's first."""
    if columns[1] >= 0:
        decay = math.exp(-elapsed_s / numbers[3]) if elapsed_s > 0.0 else 0.0
        fresh = numbers[2] * math.sqrt(1.0 - decay * decay)
        for i in range(drift.shape[2]):
            for axis in range(3):
                drift[0, kind, i, axis] = (decay * drift[0, kind, i, axis]
                                           + fresh * noise[columns[1] + 3 * i + axis])
    if columns[2] >= 0:
        step = numbers[4] * math.sqrt(elapsed_s)
        for i in range(drift.shape[2]):
            for axis in range(3):
                drift[1, kind, i, axis] += step * noise[columns[2] + 3 * i + axis]


@compiled
def read(
    sensors: Sensors, memory: Memory, kind: int, noise: Array, spike: float, samples: Array, clipped: Flags
) -> int:
    """Fill `samples` (n, 3) of a kind and `clipped` (n,), lost or not; how many sensors clipped."""
    sd, limit, digit = sensors.numbers[kind, 0], sensors.numbers[kind, 8], sensors.numbers[kind, 9]
    white, count = sensors.columns[kind, 0], 0
    for i in range(samples.shape[0]):
        if not sensors.there[kind, i]:
            samples[i] = np.nan
            continue
        x, y, z = memory.true[kind, i, 0], memory.true[kind, i, 1], memory.true[kind, i, 2]
        for axis in range(3):
            row = sensors.matrices[kind, i, axis]
            value = row[0] * x + row[1] * y + row[2] * z + sensors.constants[kind, i, axis]
            value += memory.drift[0, kind, i, axis] + memory.drift[1, kind, i, axis]
            value += spike * sensors.spikes[kind, i, axis]
            if white >= 0:
                value += sd * noise[white + 3 * i + axis]
            if digit > 0.0:
                value = round(value / digit) * digit
            if 0.0 < limit < abs(value):
                value = math.copysign(limit, value)
                clipped[i] = True
            samples[i, axis] = value
        if memory.lost[i]:
            samples[i] = np.nan
        count += clipped[i]
    return count


@compiled
def lose(losing: Array, chances: Array, first: bool, lost: Flags) -> None:
    """Which samples are lost now, by uniform numbers `chances` (n,) and by what was lost before.

    The first sample of a trial is lost with the share that is lost in the long run.
    """
    share = losing[0] / (1.0 - losing[1] + losing[0])
    for i in range(lost.size):
        threshold = share if first else losing[1] if lost[i] else losing[0]
        lost[i] = chances[i] < threshold


@compiled
def measure(
    sensors: Sensors, around: Surroundings, memory: Memory, orientation: Array, position: Array, rate: Array,
    force: Array, instants: Array, stimulation: Array, window_s: float, noise: Array, chances: Array,
    samples: Array, clipped: Flags,
) -> int:
    """Fill `samples` (m, n, 3) and `clipped` (m, n) of a tick; how many sensors of all kinds clipped.

    `orientation` (s, 4), `position`, `rate`, `force` (s, 3) as sites put them out; `instants` (2,): now and
    since the last tick, s; `stimulation` (3,) as `vibration` takes it, and the window of its spikes, s;
    `noise` normal, `chances` uniform numbers of this tick.
    """
    elapsed_s, count = instants[1], 0
    if chances.size:
        lose(sensors.losing, chances, elapsed_s <= 0.0, memory.lost)
    shaking = (0.0, 0.0)
    if sensors.components.shape[1]:
        shaking = vibration(
            sensors.tremor, sensors.components, instants[0], elapsed_s, stimulation, memory.level)
    if sensors.kinds[-1] == 2:
        feel_field(sensors, around, orientation, position, memory.true[2])
    feel_motion(sensors, memory, rate, force, shaking, elapsed_s)
    spike = stimulation[0] if stimulation[1] < window_s else 0.0
    for k in range(sensors.kinds.size):
        kind = sensors.kinds[k]
        wander(sensors.numbers[kind], sensors.columns[kind], noise, elapsed_s, memory.drift, kind)
        count += read(sensors, memory, kind, noise, spike, samples[k], clipped[k])
    return count


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
