"""`imus`: inertial and magnetic sensors on the segments of a hand, with their errors and disturbances."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError, did_you_mean
from fesloop.forms.schema import require_not_negative, require_shape
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics_kernels import turned
from fesloop.hand.quaternion_kernels import conjugate
from fesloop.hand.skeleton import hand_tree, pairs_of_names
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.noise import NoiseStream
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample, Value
from fesloop.loop.signals import Sensors as StatedSensors
from fesloop.loop.wire import least_burst, transition_probabilities
from plants.imus.device import ACC, KINDS, MAG, PRESETS, Device, PresetName, TriadErrors, rotations
from plants.imus.disturbances import (
    NO_STIMULATION,
    NO_TISSUE,
    ROTATION,
    SPEED,
    Knocks,
    MagneticField,
    PulseArtefacts,
    Pulses,
    PulseWatch,
    SoftTissue,
    Stimulation,
    Tissue,
    Tremor,
    TremorSize,
    add_sources,
    axes,
    knock,
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
    knocks: (2,), mean number of knocks a second, and their size, m/s^2.
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
    knocks: Array


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
    chances: Array, struck: Array, samples: Array, clipped: Flags,
) -> int:
    """Fill `samples` (m, n, 3) and `clipped` (m, n) of a tick; the number of clipping sensors of all kinds.

    `orientation` (s, 4), `position`, `rate`, `force` (s, 3): outputs of the sites; `time_s`, `elapsed_s`:
    this instant, and time since the last tick; `window_s`: length of the spikes of `stimulation`; `noise`,
    `chances`, `struck`: normal and uniform numbers of this tick, for errors, losses and knocks.
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
    if struck.size:
        knock(sensors.knocks[0], sensors.knocks[1], elapsed_s, struck.reshape(-1, 3), memory.true[ACC])
    spike = stimulation.share if stimulation.since_s < window_s else 0.0
    for k in range(sensors.kinds.size):
        kind = sensors.kinds[k]
        wander(sensors, memory, kind, noise, elapsed_s)
        count += read(sensors, memory, kind, noise, spike, samples[k], clipped[k])
    return count


_NOTHING = np.empty(0)
_NOTHING.flags.writeable = False


class ImusState:
    """State of the sensors.

    Attributes
    ----------
    sensors, around, memory: arguments of the kernels.
    needed: whether each of the sites' four signals is read; `idle` replaces the others.
    names: names of the sensors.
    noise, chances, struck: random numbers of this trial's ticks; chances None: no sample is lost; struck
        None: no sensor is knocked.
    watch: timing of the pulses.
    clipped: (kinds, n), whether each sensor clipped at the last tick.
    last_ns: instant of the last tick with sites; -1 before the first.
    latch: statuses that hold.
    """

    __slots__ = ("around", "chances", "clipped", "idle", "last_ns", "latch", "memory", "names", "needed",
                 "noise", "sensors", "struck", "watch")

    def __init__(self, sensors: Sensors, around: Surroundings, memory: Memory, names: tuple[str, ...],
                 needed: tuple[bool, ...], noise: NoiseStream | None, chances: NoiseStream | None,
                 struck: NoiseStream | None, sites: int) -> None:
        self.sensors, self.around, self.memory, self.names = sensors, around, memory, names
        self.needed, self.noise, self.chances, self.struck = needed, noise, chances, struck
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
            _NOTHING if self.chances is None else self.chances.row(tick.index),
            _NOTHING if self.struck is None else self.struck.row(tick.index), samples, clipped)
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
    context: Context, loses: bool, knocked: bool,
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
        context.noise(count, "uniform", "loss") if loses else None,
        context.noise(3 * count, "uniform", "knocks") if knocked else None, sites)


Kind = Literal["gyr", "acc", "mag"]
UNITS = {"gyr": "rad/s", "acc": "m/s^2", "mag": "T"}
HAND_SITES = hand_tree(HandSize()).names
"""Sites of a whole hand, in the order of a hand plant's outputs."""
_AS_PRESET, _EARTH, _PULSES = TriadErrors(), MagneticField(), Pulses()


@dataclass(frozen=True, slots=True, kw_only=True)
class Imus:
    """Gyroscopes, accelerometers and magnetometers of a device, on sites of a hand.

    Inputs: for s sites `site_orientation` (s, 4), segment to global frame (ENU), `site_position` (s, 3), m,
    global, `site_rate` (s, 3), rad/s, and `site_force` (s, 3), m/s^2, specific force, both in the segments'
    frames; with `artefacts` or `tremor` also `pulses` (channels, 2), A and s. Inputs that no measured kind
    needs may be left without a wire. Outputs: for n sensors `gyr` rad/s, `acc` m/s^2, `mag` T, as listed in
    `measures`, (n, 3) each, in the sensors' frames, which are those of the segments rotated by the mounting
    error. At rest an accelerometer reads upward gravity. Missing values are NaN: a row of every kind for a
    lost sample, `mag` of a sensor without magnetometer, all before sites have arrived.

        samples = clip(round(A (u + tremor) + b + b_instability + b_walk + spike + noise))
        A = (1 + scale) axes turn soft_iron mounting (R_tissue)'

    Mounting, scale, axes, iron and constant bias belong to the device: they are random by seed and `device`,
    and the same in every trial. Wandering biases, noise, loss and tremor differ in every trial. Two blocks of
    one device may have different rates, such as gyroscopes at 200 Hz and the rest at 100. A late or drifting
    clock is the node's offset and rate ("100.005" for 50 ppm); a wireless sensor is a block of its own behind
    a wire with latency and loss, joined by `join`.

    Status `clipped` names the sensors that reach the end of their range.

    Attributes
    ----------
    measures: kinds of output.
    preset: hardware of S19, the same without its calibration by a robot ("salchow2019_raw"), K14
        (`plants.imus.device`) or "ideal", for all parameters not given.
    site_names: names of the s input sites.
    sites: names or numbers of sites with a sensor, in the order of the samples. Empty: those of the preset
        (all but the forearm).
    mag_sites: sites whose sensors have a magnetometer; None: those of the preset.
    device: name of the device; empty: that of the node.
    gyroscope, accelerometer, magnetometer: errors of the triads.
    soft_iron: sd of the entries of the symmetric matrix that iron by the sensor adds to the identity.
    mounting_sd_deg: sd of the mounting's rotation about each axis.
    mounting_angle_deg: smallest and largest angle of a second rotation about any axis: S19 has 5 to 10.
    mounting_deg: rotation of single sensors, by site, in place of these: a rotation vector about x, y and z
        of the segment.
    soft_tissue: tissue between bone and sensor; None: rigid.
    error_scale: factor on all of these errors: mounting, soft tissue, iron by the sensor and the triads', but
        for range and digits.
    loss: long-run fraction of samples of each sensor that is lost.
    burst_samples: mean length of a gap; 0: samples are lost independently.
    magnetic_field: magnetic field; its carried dipoles move with sites.
    artefacts, tremor: effects of stimulation; None: none.
    knocks: knocks against the sensors; None: none.
    pulses: timing of pulses.
    channels: stimulation channels; 0 takes the number from the wire.
    """

    measures: tuple[Kind, ...] = ("gyr", "acc", "mag")
    preset: PresetName = "salchow2019"
    site_names: tuple[str, ...] = HAND_SITES
    sites: tuple[str | int, ...] = ()
    mag_sites: tuple[str | int, ...] | None = None
    device: str = ""
    gyroscope: TriadErrors = _AS_PRESET
    accelerometer: TriadErrors = _AS_PRESET
    magnetometer: TriadErrors = _AS_PRESET
    soft_iron: float | None = None
    mounting_sd_deg: float = 0.0
    mounting_angle_deg: tuple[float, float] | None = None
    mounting_deg: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    soft_tissue: SoftTissue | None = None
    error_scale: float = 1.0
    loss: float = 0.0
    burst_samples: float = 0.0
    magnetic_field: MagneticField = _EARTH
    artefacts: PulseArtefacts | None = None
    tremor: Tremor | None = None
    knocks: Knocks | None = None
    pulses: Pulses = _PULSES
    channels: int = 0
    _sites: tuple[int, ...] = field(init=False, repr=False, compare=False)
    _mag_sites: tuple[int, ...] = field(init=False, repr=False, compare=False)
    _stated: StatedSensors = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if self.preset not in PRESETS:
            raise InputError("imus.preset", f"{self.preset!r}", ", ".join(PRESETS),
                             did_you_mean(str(self.preset), list(PRESETS)))
        if not self.measures or sorted(self.measures) != sorted(set(KINDS) & set(self.measures)):
            raise InputError("imus.measures", f"{self.measures}", "one or more of " + ", ".join(KINDS))
        self._take_preset()
        require_not_negative("imus", self, "soft_iron", "mounting_sd_deg", "error_scale", "burst_samples",
                             "channels")
        self._require_mounting()
        self._require_loss()
        object.__setattr__(self, "_sites", tuple(self._number("sites", site) for site in self.sites))
        if len(set(self._sites)) < len(self._sites):
            raise InputError("imus.sites", f"{self.sites}", "each site once")
        names = tuple(self.site_names[site] for site in self._sites)
        object.__setattr__(self, "_stated", StatedSensors(names, pairs_of_names(names)))
        with_mag = self.sites if self.mag_sites is None else self.mag_sites
        object.__setattr__(self, "_mag_sites", tuple(self._number("mag_sites", site) for site in with_mag))
        if "mag" in self.measures and not set(self._mag_sites) & set(self._sites):
            raise InputError("imus.measures", "mag, but no sensor has a magnetometer",
                             "a site of mag_sites among the sites", "remove mag")
        for carrier in self.magnetic_field.carriers:
            self._number("magnetic_field.dipoles.carrier", carrier)

    def _take_preset(self) -> None:
        """Set every parameter not given to the preset's value."""
        preset = PRESETS[self.preset]
        found: dict[str, Any] = {
            "gyroscope": self.gyroscope.filled(preset.gyroscope),
            "accelerometer": self.accelerometer.filled(preset.accelerometer),
            "magnetometer": self.magnetometer.filled(preset.magnetometer),
            "sites": self.sites or tuple(name for name in self.site_names if name not in preset.without)}
        if self.soft_iron is None:
            found["soft_iron"] = preset.soft_iron
        if self.mounting_angle_deg is None:
            found["mounting_angle_deg"] = preset.mounting_angle_deg
        if self.mag_sites is None and preset.mag_sites is not None:
            found["mag_sites"] = tuple(name for name in preset.mag_sites if name in self.site_names)
        for name, value in found.items():
            object.__setattr__(self, name, value)

    def _require_mounting(self) -> None:
        require_shape("imus", self, (2,), "smallest, largest", "mounting_angle_deg")
        assert self.mounting_angle_deg is not None
        smallest, largest = self.mounting_angle_deg
        if not 0.0 <= smallest <= largest <= 180.0:
            raise InputError("imus.mounting_angle_deg", f"{self.mounting_angle_deg}",
                             "smallest <= largest, within 0 to 180 deg")
        for site, turn in self.mounting_deg.items():
            if site not in self.site_names:
                raise InputError(f"imus.mounting_deg.{site}", "is not a site", ", ".join(self.site_names),
                                 did_you_mean(site, self.site_names))
            if not (len(turn) == 3 and math.hypot(*turn) <= 180.0):
                raise InputError(f"imus.mounting_deg.{site}", f"{turn}", "x, y, z of at most 180 deg in all")

    def _require_loss(self) -> None:
        if not 0.0 <= self.loss < 1.0:
            raise InputError("imus.loss", f"{self.loss}", "a share from 0 to below 1")
        least = least_burst(self.loss)
        if self.burst_samples and not self.burst_samples >= least:
            raise InputError("imus.burst_samples", f"{self.burst_samples}",
                             f"{least:g} or more with this loss, or 0 for samples lost one by one")

    def _number(self, parameter: str, site: str | int) -> int:
        """Number of a site given by name or number; raises InputError for one that is not there."""
        names = self.site_names
        if isinstance(site, int) and not isinstance(site, bool) and 0 <= site < len(names):
            return site
        if site not in names:
            raise InputError(f"imus.{parameter}", f"{site!r}", f"0 to {len(names) - 1}, " + ", ".join(names),
                             did_you_mean(str(site), list(names)))
        return names.index(str(site))

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Motion of the sites, and pulses."""
        count = len(self.site_names)
        needed = self._needed()
        ports = [Port("site_orientation", (count, 4), "1", (1.0, 0.0, 0.0, 0.0), optional=not needed[0]),
                 Port("site_position", (count, 3), "m", optional=not needed[1]),
                 Port("site_rate", (count, 3), "rad/s", optional=not needed[2]),
                 Port("site_force", (count, 3), "m/s^2", optional=not needed[3])]
        if self.artefacts is not None or self.tremor is not None:
            # Tremor exists without stimulation; artefacts without `pulses` are a forgotten wire.
            ports.append(Port("pulses", (self.channels or None, 2), "A,s", optional=self.artefacts is None))
        return tuple(ports)

    def _needed(self) -> tuple[bool, bool, bool, bool]:
        """Whether each of the sites' signals is needed for the measured kinds."""
        mag, tissue = "mag" in self.measures, self.soft_tissue is not None
        return mag, mag, tissue or "gyr" in self.measures, tissue or "acc" in self.measures

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Samples of the measured kinds."""
        return tuple(Port(kind, (len(self._sites), 3), UNITS[kind], gaps=True, sensors=self._stated)
                     for kind in KINDS if kind in self.measures)

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> Imus:
        """This block with the number of wired channels; InputError unless they are rows of two numbers."""
        if len(shapes["pulses"]) != 2 or shapes["pulses"][1] != 2:
            raise InputError("pulses", f"the wired signal has shape {shapes['pulses']}",
                             "(channels, 2): current and pulse width")
        return replace(self, channels=shapes["pulses"][0])

    def init(self, context: Context) -> ImusState:
        """State with the sensors of this run at the start of this trial."""
        device = Device(context.seed, self.device or context.name, len(self.site_names))
        kinds = [kind for kind in KINDS if kind in self.measures]
        return new_state(
            self._sensors(device, kinds, context.trial), self._surroundings(), self.site_names,
            self._needed(), context, bool(self.loss), self.knocks is not None)

    def _sensors(self, device: Device, kinds: Sequence[str], trial: int) -> Sensors:
        rows, every = np.array(self._sites), len(self.site_names)
        size = self.error_scale
        errors = [each.scaled(size) for each in (self.gyroscope, self.accelerometer, self.magnetometer)]
        assert self.soft_iron is not None
        assert self.mounting_angle_deg is not None
        smallest, largest = self.mounting_angle_deg
        mounting = device.mountings(size * self.mounting_sd_deg, (size * smallest, size * largest))
        for site, turn in self.mounting_deg.items():
            mounting[self.site_names.index(site)] = rotations(size * np.radians([turn]))[0]
        triads = [device.triads(kind, each, size * self.soft_iron if kind == "mag" else 0.0)
                  for kind, each in zip(KINDS, errors, strict=True)]
        present = np.ones((3, rows.size), dtype=np.bool_)
        present[MAG] = np.isin(rows, self._mag_sites)
        sizes = ErrorSizes(*(np.array([getattr(each, name) for each in errors], dtype=np.float64)
                             for name in ErrorSizes._fields))
        begins, stays = transition_probabilities(self.loss, self.burst_samples)
        tremor, artefacts = self.tremor or Tremor(), self.artefacts or PulseArtefacts()
        components = tremor.components(device.seed, device.name, trial)

        def of_worn(each: Any) -> Array:
            return np.ascontiguousarray(np.asarray(each)[:, rows])

        return Sensors(
            kinds=np.array([KINDS.index(kind) for kind in kinds]), sites=rows, present=present,
            matrices=of_worn([matrices @ mounting for matrices, _ in triads]),
            constants=of_worn([bias for _, bias in triads]), errors=sizes,
            columns=noise_columns(sizes, [KINDS.index(kind) for kind in kinds], rows.size),
            spikes=of_worn(artefacts.directed(device.seed, device.name, every)) * bool(self.artefacts),
            axes=of_worn(axes(device.seed, device.name, every)),
            tissue=self.soft_tissue.scaled(size).coefficients() if self.soft_tissue and size else NO_TISSUE,
            tremor=tremor.size(), components=components if self.tremor else np.empty((3, 0)),
            losing=np.array([begins, stays]),
            knocks=np.array([self.knocks.per_s, self.knocks.size] if self.knocks else [0.0, 0.0]))

    def _surroundings(self) -> Surroundings:
        around = self.magnetic_field
        carriers = [self.site_names.index(name) for name in around.carriers]
        return Surroundings(around.earth, around.fixed, around.carried, np.array(carriers, dtype=np.int64))

    def step(self, state: ImusState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Samples of one tick."""
        return state.sample(inputs, self.pulses, self._window_s(), tick)

    def _window_s(self) -> float:
        return 1e-3 * self.artefacts.window_ms if self.artefacts is not None else 0.0
