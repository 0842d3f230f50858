"""State of the sensors of an `imus` block, and the kernels that measure at a tick."""

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
from plants.imus.device import KINDS, MAG
from plants.imus.disturbances import (
    NO_STIMULATION,
    ROTATION,
    SPEED,
    Pulses,
    PulseWatch,
    Stimulation,
    Tissue,
    TremorSize,
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


class ErrorSizes(NamedTuple):
    """Sizes of the time-varying errors of each kind, (3,) each, named as in `TriadErrors`."""

    noise_sd: Array
    instability_sd: Array
    instability_time_s: Array
    walk: Array
    limit: Array
    resolution: Array


class Columns(NamedTuple):
    """First column in a tick's row of noise of each kind's processes, (3,) each; -1 for none."""

    noise: Numbers
    instability: Numbers
    walk: Numbers


class Sensors(NamedTuple):
    """Sensors of a run; read-only.

    Attributes
    ----------
    kinds: (m,), measured kinds, as indices of KINDS.
    sites: (n,), number of each sensor's site.
    present: (3, n), whether the sensor has a triad of the kind.
    matrices: (3, n, 3, 3), from the segment's frame to the readings of the axes.
    constants: (3, n, 3), constant biases.
    errors: sizes of errors. columns: columns of noise.
    spikes: (3, n, 3), artefact of a pulse of full charge.
    axes: (2, n, 3), axis and swing of the tremor.
    tissue: soft tissue; natural frequency 0 without.
    tremor: size of the tremor. components: its sinusoids (3, c); none without tremor.
    losing: (2,), probability of losing a sample after one that was kept, and after one that was lost.
    """

    kinds: Numbers
    sites: Numbers
    present: Flags
    matrices: Array
    constants: Array
    errors: ErrorSizes
    columns: Columns
    spikes: Array
    axes: Array
    tissue: Tissue
    tremor: TremorSize
    components: Array
    losing: Array


class Surroundings(NamedTuple):
    """Earth's field (3,), T; dipoles in the room (k, 7) and carried (c, 7), and the carriers' sites (c,)."""

    earth: Array
    fixed: Array
    carried: Array
    carriers: Numbers


class Memory(NamedTuple):
    """Arrays that change from tick to tick.

    Attributes
    ----------
    instability, walk: (3, n, 3), wandering biases that return, and that do not.
    wobble: (n, 4, 3), motion of each sensor on soft tissue, as in `wobble`.
    lost: (n,), whether the last sample was lost.
    level: (1,), level of the tetanic tremor.
    true: (3, n, 3), true quantities at the sensors, in the frames of their segments.
    """

    instability: Array
    walk: Array
    wobble: Array
    lost: Flags
    level: Array
    true: Array


@compiled
def field_at_sensors(
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
def motion_at_sensors(
    sensors: Sensors, memory: Memory, rate: Array, force: Array, shaking: tuple[float, float],
    elapsed_s: float,
) -> None:
    """Fill `memory.true` with rates and forces at the sensors, and rotate all of it into wobbling frames."""
    true = memory.true
    for i in range(sensors.sites.size):
        site = sensors.sites[i]
        for axis in range(3):
            true[0, i, axis] = rate[site, axis] + shaking[0] * sensors.axes[0, i, axis]
            true[1, i, axis] = force[site, axis] + shaking[1] * sensors.axes[1, i, axis]
        if sensors.tissue.natural_rad_s > 0.0:
            motion = memory.wobble[i]
            wobble(sensors.tissue, true[0, i], true[1, i], elapsed_s, motion)
            for kind in range(3):
                turn_back(motion[ROTATION], true[kind, i])
            own_rate(motion[ROTATION], motion[SPEED], true[0, i])


@compiled
def wander(sensors: Sensors, memory: Memory, kind: int, noise: Array, elapsed_s: float) -> None:
    """Advance the wandering biases of one kind; with 0 s elapsed, start those of a trial."""
    errors, instability, walk = sensors.errors, memory.instability[kind], memory.walk[kind]
    column = sensors.columns.instability[kind]
    if column >= 0:
        decay = math.exp(-elapsed_s / errors.instability_time_s[kind]) if elapsed_s > 0.0 else 0.0
        fresh = errors.instability_sd[kind] * math.sqrt(1.0 - decay * decay)
        for i in range(instability.shape[0]):
            for axis in range(3):
                instability[i, axis] = decay * instability[i, axis] + fresh * noise[column + 3 * i + axis]
    column = sensors.columns.walk[kind]
    if column >= 0:
        step = errors.walk[kind] * math.sqrt(elapsed_s)
        for i in range(walk.shape[0]):
            for axis in range(3):
                walk[i, axis] += step * noise[column + 3 * i + axis]


@compiled
def read(
    sensors: Sensors, memory: Memory, kind: int, noise: Array, spike: float, samples: Array, clipped: Flags
) -> int:
    """Fill `samples` (n, 3) of a kind and `clipped` (n,), lost or not; the number of sensors that clip."""
    errors = sensors.errors
    sd, limit, digit = errors.noise_sd[kind], errors.limit[kind], errors.resolution[kind]
    white, count = sensors.columns.noise[kind], 0
    for i in range(samples.shape[0]):
        if not sensors.present[kind, i]:
            samples[i] = np.nan
            continue
        x, y, z = memory.true[kind, i, 0], memory.true[kind, i, 1], memory.true[kind, i, 2]
        for axis in range(3):
            row = sensors.matrices[kind, i, axis]
            value = row[0] * x + row[1] * y + row[2] * z + sensors.constants[kind, i, axis]
            value += memory.instability[kind, i, axis] + memory.walk[kind, i, axis]
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
    """Update which samples are `lost` (n,), by uniform numbers `chances` (n,).

    The first sample of a trial is lost with the long-run probability.
    """
    share = losing[0] / (1.0 - losing[1] + losing[0])
    for i in range(lost.size):
        threshold = share if first else losing[1] if lost[i] else losing[0]
        lost[i] = chances[i] < threshold


@compiled
def measure(
    sensors: Sensors, around: Surroundings, memory: Memory, orientation: Array, position: Array, rate: Array,
    force: Array, time_s: float, elapsed_s: float, stimulation: Stimulation, window_s: float, noise: Array,
    chances: Array, samples: Array, clipped: Flags,
) -> int:
    """Fill `samples` (m, n, 3) and `clipped` (m, n) of a tick; the number of clipping sensors of all kinds.

    `orientation` (s, 4), `position`, `rate`, `force` (s, 3): outputs of the sites; `time_s`, `elapsed_s`:
    this instant, and time since the last tick; `window_s`: length of the spikes of `stimulation`; `noise`,
    `chances`: normal and uniform numbers of this tick.
    """
    count = 0
    if chances.size:
        lose(sensors.losing, chances, elapsed_s <= 0.0, memory.lost)
    shaking = (0.0, 0.0)
    if sensors.components.shape[1]:
        shaking = vibration(
            sensors.tremor, sensors.components, time_s, elapsed_s, stimulation, memory.level)
    if sensors.kinds[-1] == MAG:
        field_at_sensors(sensors, around, orientation, position, memory.true[MAG])
    motion_at_sensors(sensors, memory, rate, force, shaking, elapsed_s)
    spike = stimulation.share if stimulation.since_s < window_s else 0.0
    for k in range(sensors.kinds.size):
        kind = sensors.kinds[k]
        wander(sensors, memory, kind, noise, elapsed_s)
        count += read(sensors, memory, kind, noise, spike, samples[k], clipped[k])
    return count


_NOTHING = np.empty(0)


class ImusState:
    """State of the sensors.

    Attributes
    ----------
    sensors, around, memory: arguments of the kernels.
    needed: whether each of the sites' four signals is read; `idle` replaces the others.
    names: names of the sensors.
    noise, chances: random numbers of this trial's ticks; chances None: no sample is lost.
    watch: timing of the pulses.
    clipped: (kinds, n), whether each sensor clipped at the last tick.
    last_ns: instant of the last tick with sites; -1 before the first.
    latch: statuses that hold.
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
        stimulation = NO_STIMULATION
        if len(inputs) > 4:
            stimulation = self.watch.now(pulses, inputs[4], now)
        samples, clipped = np.empty((kinds, count, 3)), np.zeros((kinds, count), dtype=np.bool_)
        sites: list[Any] = [given[0] if read else idle
                            for given, read, idle in zip(inputs, self.needed, self.idle, strict=False)]
        found = measure(
            self.sensors, self.around, self.memory, sites[0], sites[1], sites[2], sites[3],
            now / NS_PER_S, elapsed_s, stimulation, window_s,
            _NOTHING if self.noise is None else self.noise.row(tick.index),
            _NOTHING if self.chances is None else self.chances.row(tick.index), samples, clipped)
        if found:
            self._report(clipped, tick)
        self.clipped = clipped
        return tuple(samples)

    def _arrived(self, inputs: Sequence[Sample], tick: Tick) -> bool:
        """Whether every needed signal has arrived; reported while one is missing."""
        waiting = any(read and not given.present for given, read in zip(inputs, self.needed, strict=False))
        if waiting or "waiting" in self.latch.holding:
            self.latch.put(tick, "waiting", waiting, "nothing has arrived from the sites: no samples")
        return not waiting

    def _report(self, clipped: NDArray[np.bool_], tick: Tick) -> None:
        """Report the sensors that clip and did not clip at the last tick."""
        new = clipped & ~self.clipped
        if new.any():
            kinds = [KINDS[kind] for kind in self.sensors.kinds]
            tick.report("clipped", "; ".join(
                f"{kind} of " + ", ".join(self.names[i] for i in np.flatnonzero(row))
                for kind, row in zip(kinds, new, strict=True) if row.any()))


def noise_columns(errors: ErrorSizes, kinds: list[int], sensors: int) -> Columns:
    """Columns of noise; -1, without random numbers, for kinds not measured and errors of size 0."""
    columns, width = Columns(*np.full((3, 3), -1)), 0
    for kind in kinds:
        for column, size in zip(columns, (errors.noise_sd, errors.instability_sd, errors.walk), strict=True):
            if size[kind] > 0.0:
                column[kind] = width
                width += 3 * sensors
    return columns


def new_state(
    sensors: Sensors, around: Surroundings, names: tuple[str, ...], needed: tuple[bool, ...],
    context: Context, loses: bool,
) -> ImusState:
    """State at the start of a trial; `names` are those of all sites."""
    count, sites = sensors.sites.size, len(names)
    width = sum(int((column >= 0).sum()) for column in sensors.columns) * 3 * count
    memory = Memory(
        instability=np.zeros((3, count, 3)), walk=np.zeros((3, count, 3)), wobble=np.zeros((count, 4, 3)),
        lost=np.zeros(count, dtype=np.bool_), level=np.zeros(1), true=np.zeros((3, count, 3)))
    return ImusState(
        sensors, around, memory, tuple(names[i] for i in sensors.sites), needed,
        context.noise(width) if width else None,
        context.noise(count, "uniform", "loss") if loses else None, sites)
