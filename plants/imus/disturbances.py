"""Disturbances of hand-worn sensors: magnetic fields, soft tissue, stimulation artefacts and tremor.

Magnetic fields are those of the Earth and of magnets and iron nearby, in the global frame (ENU), whose y axis
points to magnetic north unless a declination is given. Kernels take sources as rows (7,): position (3,), m,
moment (3,), A m^2, radius, m.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.forms.schema import require_not_negative, require_positive, require_shape
from fesloop.hand.kinematics_kernels import turned
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.loop.signals import Sample

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
_MU_0_OVER_4_PI = 1e-7
"""T m/A: mu_0 / (4 pi), exact to 6e-10 (CODATA 2018)."""


@compiled
def add_sources(sources: Array, points: Array, field: Array) -> None:
    """Add the field of `sources` (k, 7) at `points` (n, 3) to `field` (n, 3), T."""
    for source in sources:
        mx, my, mz, radius = source[3], source[4], source[5], source[6]
        for i in range(points.shape[0]):
            x, y, z = points[i, 0] - source[0], points[i, 1] - source[1], points[i, 2] - source[2]
            square = x * x + y * y + z * z
            # Inside a uniformly magnetised sphere the field is 2/3 mu_0 M everywhere.
            along, across = 0.0, -2.0 / (radius * radius * radius)
            if square >= radius * radius:
                across = 1.0 / (square * math.sqrt(square))
                along = 3.0 * across / square * (mx * x + my * y + mz * z)
            field[i, 0] += _MU_0_OVER_4_PI * (along * x - across * mx)
            field[i, 1] += _MU_0_OVER_4_PI * (along * y - across * my)
            field[i, 2] += _MU_0_OVER_4_PI * (along * z - across * mz)


@compiled
def place_carried(
    carried: Array, carriers: NDArray[np.int64], orientation: Array, position: Array, sources: Array
) -> None:
    """Fill `sources` (c, 7) with sources (c, 7) fixed in the frames of the sites that `carriers` (c,) number.

    `orientation` (s, 4) and `position` (s, 3), m: from each site's frame to the global one.
    """
    for i in range(carriers.size):
        site = carriers[i]
        q = (orientation[site, 0], orientation[site, 1], orientation[site, 2], orientation[site, 3])
        x, y, z = turned(q, carried[i, 0], carried[i, 1], carried[i, 2])
        sources[i, 0] = position[site, 0] + x
        sources[i, 1] = position[site, 1] + y
        sources[i, 2] = position[site, 2] + z
        sources[i, 3], sources[i, 4], sources[i, 5] = turned(q, carried[i, 3], carried[i, 4], carried[i, 5])
        sources[i, 6] = carried[i, 6]


@dataclass(frozen=True, slots=True, kw_only=True)
class Dipole:
    """A magnet, or permanently magnetised iron, as a sphere whose outer field is that of a dipole.

        B(r) = mu_0 / (4 pi r^3) (3 (m . e) e - m),   e = r / |r|        (Griffiths, eq. 5.89)

    Attributes
    ----------
    position: position of the centre, m, in the global frame, or in that of the carrier.
    moment: magnetic moment, A m^2, in the same frame (a neodymium cube of 10 mm has about 1).
    radius_m: radius of the sphere, inside which the field is uniform.
    carrier: name of the site that carries it; empty: fixed in the room.
    """

    position: Vector
    moment: Vector
    radius_m: float = 0.005
    carrier: str = ""

    def __post_init__(self) -> None:
        require_shape("dipole", self, (3,), "x, y, z", "position", "moment")
        require_positive("dipole", self, "radius_m")

    @property
    def row(self) -> Array:
        """Row (7,) for the kernels."""
        return np.array([*self.position, *self.moment, self.radius_m])


@dataclass(frozen=True, slots=True, kw_only=True)
class MagneticField:
    """Homogeneous field of the Earth, and fields of dipoles in the room and on the hand.

    Attributes
    ----------
    strength_ut, inclination_deg: strength of the Earth's field, uT, and its angle below the horizontal
        (Berlin in 2019, rounded from the IGRF-13 model, doi 10.1186/s40623-020-01288-x).
    declination_deg: angle of its horizontal part from the global y axis towards east; 0: y is magnetic north,
        as trackers assume (about 4 from true north in Berlin).
    dipoles: dipoles fixed in the room or carried.
    """

    strength_ut: float = 49.7
    inclination_deg: float = 67.9
    declination_deg: float = 0.0
    dipoles: tuple[Dipole, ...] = ()

    def __post_init__(self) -> None:
        require_not_negative("magnetic_field", self, "strength_ut")
        for key, most in (("inclination_deg", 90.0), ("declination_deg", 180.0)):
            value = getattr(self, key)
            if not abs(value) <= most:
                raise InputError(f"magnetic_field.{key}", f"{value}", f"from -{most:g} to {most:g}")

    @property
    def earth(self) -> Array:
        """The Earth's field, (3,), T, global (east, north, up)."""
        down, east = math.radians(self.inclination_deg), math.radians(self.declination_deg)
        level = math.cos(down)
        return 1e-6 * self.strength_ut * np.array(
            [level * math.sin(east), level * math.cos(east), -math.sin(down)])

    @property
    def fixed(self) -> Array:
        """Rows (k, 7) of the dipoles fixed in the room."""
        return _rows([dipole for dipole in self.dipoles if not dipole.carrier])

    @property
    def carried(self) -> Array:
        """Rows (c, 7) of the carried dipoles, each in its carrier's frame."""
        return _rows([dipole for dipole in self.dipoles if dipole.carrier])

    @property
    def carriers(self) -> tuple[str, ...]:
        """Names of the sites that carry dipoles, (c,)."""
        return tuple(dipole.carrier for dipole in self.dipoles if dipole.carrier)

    def in_room(self, points: ArrayLike) -> Array:
        """Field (..., 3), T, without carried dipoles, at points (..., 3), m; all global."""
        where = np.asarray(points, dtype=np.float64)
        field = np.broadcast_to(self.earth, where.shape).copy()
        add_sources(self.fixed, np.ascontiguousarray(where).reshape(-1, 3), field.reshape(-1, 3))
        return field


def _rows(dipoles: list[Dipole]) -> Array:
    return np.array([dipole.row for dipole in dipoles]).reshape(-1, 7)


class Tissue(NamedTuple):
    """Coefficients of soft tissue: natural frequency, rad/s, damping ratio, share, sag, rad per m/s^2, and
    the direction out of the skin, (3,)."""

    natural_rad_s: float
    damping: float
    share: float
    sag: float
    outwards: Array


NO_TISSUE = Tissue(0.0, 0.0, 0.0, 0.0, np.zeros(3))


@dataclass(frozen=True, slots=True, kw_only=True)
class SoftTissue:
    """Elastic mount of every sensor.

    The sensor rotates against its bone; its small translation is omitted. Defaults are medians of fits to
    five sensors on foam (recording chain5, first half of trial 1), where the model explains half of the
    effect of foam on gyroscopes in the second half; that skin is like foam is an assumption.

    Attributes
    ----------
    natural_hz, damping: natural frequency and damping ratio of the oscillation; ratio above 0 and below 1.
    share: fraction of the bone's angular acceleration that tissue does not transmit at once: 1 for a sensor
        held by tissue alone, less if tape ties it to the skin around, more if its weight is off its middle.
    sag_deg: static rotation by 1 g of specific force along the skin, deg.
    outwards: direction out of the skin in the segments' frames, a unit vector (right hand: -x is dorsal;
        left hand: +x).
    """

    natural_hz: float = 11.0
    damping: float = 0.1
    share: float = 1.2
    sag_deg: float = 3.0
    outwards: tuple[float, float, float] = (-1.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        require_positive("soft_tissue", self, "natural_hz")
        require_not_negative("soft_tissue", self, "share", "sag_deg")
        require_shape("soft_tissue", self, (3,), "x, y, z", "outwards")
        if not 0.0 < self.damping < 1.0:
            raise InputError("soft_tissue.damping", f"{self.damping}", "above 0 and below 1")
        if abs(math.hypot(*self.outwards) - 1.0) > 1e-6:
            raise InputError("soft_tissue.outwards", f"{self.outwards}", "a vector of length 1")

    def scaled(self, size: float) -> SoftTissue:
        """Tissue under which sensors rotate `size` times as far."""
        return replace(self, share=size * self.share, sag_deg=size * self.sag_deg)

    def coefficients(self) -> Tissue:
        """Coefficients for the kernels."""
        return Tissue(2.0 * math.pi * self.natural_hz, self.damping, self.share,
                      math.radians(self.sag_deg) / STANDARD_GRAVITY,
                      np.array(self.outwards, dtype=np.float64))


ROTATION, SPEED, BONE_RATE, BONE_FORCE = range(4)
"""Rows of a sensor's motion on soft tissue: its rotation, rad, and rate, rad/s; the bone's last rate and
force."""


@compiled(inline="always")
def _static_rotation(tissue: Tissue, force: Array, axis: int) -> float:
    """Rotation about an axis that balances a constant specific force (3,), rad."""
    b, c = (axis + 1) % 3, (axis + 2) % 3
    rotation: float = -tissue.sag * (tissue.outwards[b] * force[c] - tissue.outwards[c] * force[b])
    return rotation


@compiled
def wobble(tissue: Tissue, rate: Array, force: Array, elapsed_s: float, motion: Array) -> None:
    """Advance a sensor's `motion` (4, 3) on soft tissue by `elapsed_s`.

    `rate` (3,), rad/s, and `force` (3,), m/s^2, are those of the bone at this instant. With 0 s elapsed, the
    start of a trial, the sensor is at rest in balance with the force.
    """
    w, z = tissue.natural_rad_s, tissue.damping
    for i in range(3):
        now = _static_rotation(tissue, force, i)
        if elapsed_s <= 0.0:
            motion[ROTATION, i], motion[SPEED, i] = now, 0.0
            continue
        before = _static_rotation(tissue, motion[BONE_FORCE], i)
        slope = (now - before) / elapsed_s
        inertial = -tissue.share * (rate[i] - motion[BONE_RATE, i]) / (elapsed_s * w * w)
        # y_p = u - 2 z u' / w solves the equation for u linear in time; the rest decays.
        offset = before + inertial - 2.0 * z * slope / w
        left, speed = motion[ROTATION, i] - offset, motion[SPEED, i] - slope
        damped = w * math.sqrt(1.0 - z * z)
        decay = math.exp(-z * w * elapsed_s)
        cosine, sine = math.cos(damped * elapsed_s), math.sin(damped * elapsed_s) / damped
        motion[ROTATION, i] = (offset + slope * elapsed_s
                               + decay * (left * (cosine + z * w * sine) + speed * sine))
        motion[SPEED, i] = slope + decay * (speed * (cosine - z * w * sine) - left * w * w * sine)
    motion[BONE_RATE] = rate
    motion[BONE_FORCE] = force


@compiled
def turn_back(rotation: Array, vector: Array) -> None:
    """Transform a vector (3,) from the bone's frame to one rotated by a rotation vector (3,), in place."""
    x, y, z = rotation[0], rotation[1], rotation[2]
    square = x * x + y * y + z * z
    angle = math.sqrt(square)
    first = math.sin(angle) / angle if square > 1e-12 else 1.0 - square / 6.0
    # 1 - cos a without cancellation
    second = 2.0 * (math.sin(0.5 * angle) / angle) ** 2 if square > 1e-12 else 0.5 - square / 24.0
    a, b, c = vector[0], vector[1], vector[2]
    p, q, r = y * c - z * b, z * a - x * c, x * b - y * a
    vector[0] = a - first * p + second * (y * r - z * q)
    vector[1] = b - first * q + second * (z * p - x * r)
    vector[2] = c - first * r + second * (x * q - y * p)


@compiled
def own_rate(rotation: Array, speed: Array, vector: Array) -> None:
    """Add to `vector` (3,) the angular rate, rad/s, of a rotation vector (3,) that changes at `speed` (3,).

    The rate is in the rotated frame: the right Jacobian of the rotation times `speed`.
    """
    x, y, z = rotation[0], rotation[1], rotation[2]
    square = x * x + y * y + z * z
    angle = math.sqrt(square)
    first = 2.0 * (math.sin(0.5 * angle) / angle) ** 2 if square > 1e-6 else 0.5 - square / 24.0
    second = (angle - math.sin(angle)) / (square * angle) if square > 1e-6 else 1.0 / 6.0 - square / 120.0
    a, b, c = speed[0], speed[1], speed[2]
    p, q, r = y * c - z * b, z * a - x * c, x * b - y * a
    vector[0] += a - first * p + second * (y * r - z * q)
    vector[1] += b - first * q + second * (z * p - x * r)
    vector[2] += c - first * r + second * (x * q - y * p)


COMPONENTS = 6
"""Sinusoids of the physiological tremor (chosen: its envelope then varies like that of narrow-band noise)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PulseArtefacts:
    """Spikes on samples taken shortly after a pulse; all sizes are chosen, none is published.

    Each sensor's spike has its own direction, constant in a run.

    Attributes
    ----------
    window_ms: time after a pulse in which samples have a spike.
    gyr, acc, mag: size at full charge, rad/s, m/s^2, T; proportional to the largest channel's charge.
    """

    window_ms: float = 1.0
    gyr: float = 0.02
    acc: float = 0.3
    mag: float = 2e-6

    def __post_init__(self) -> None:
        require_positive("pulse_artefacts", self, "window_ms")
        require_not_negative("pulse_artefacts", self, "gyr", "acc", "mag")

    def directed(self, seed: int, device: str, sites: int) -> Array:
        """Spike of each sensor at full charge, (3, sites, 3): gyr, acc, mag."""
        normal = NoiseStream(stream_key(seed, f"{device}/artefacts", 0), 9 * sites).row(0)
        normal = normal.reshape(3, sites, 3)
        sizes = np.array([self.gyr, self.acc, self.mag])[:, np.newaxis, np.newaxis]
        return np.asarray(sizes * normal / np.linalg.norm(normal, axis=-1, keepdims=True))


class TremorSize(NamedTuple):
    """Coefficients of a tremor: tetanic amplitude, rad/s, its time constant, s, and the lever, m."""

    tetanic: float
    rise_s: float
    lever_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Tremor:
    """Constant physiological tremor, and tetanic tremor of muscles that twitch with every pulse.

    Attributes
    ----------
    physiological: rms of its angular rate, rad/s (chosen: 0.1 m/s^2 at the lever, as of outstretched hands).
    band_hz: its frequency band (8-12: Elble and Koller 1990, as usually quoted).
    tetanic: rms of the angular rate at the stimulation frequency at full charge, rad/s (chosen).
    rise_s: time constant with which it follows the charge, s (that of activation, 1 / 25 s, grip-force data).
    lever_m: distance from the axis to the sensor, m (chosen: half a hand).
    """

    physiological: float = 0.03
    band_hz: tuple[float, float] = (8.0, 12.0)
    tetanic: float = 0.1
    rise_s: float = 0.04
    lever_m: float = 0.05

    def __post_init__(self) -> None:
        require_not_negative("tremor", self, "physiological", "tetanic", "lever_m")
        require_positive("tremor", self, "band_hz", "rise_s")
        require_shape("tremor", self, (2,), "lowest, highest", "band_hz")
        if self.band_hz[0] > self.band_hz[1]:
            raise InputError("tremor.band_hz", f"{self.band_hz}", "the lowest first")

    def size(self) -> TremorSize:
        """Coefficients for the kernels."""
        return TremorSize(math.sqrt(2.0) * self.tetanic, self.rise_s, self.lever_m)

    def components(self, seed: int, device: str, trial: int) -> Array:
        """Sinusoids of a trial, (3, COMPONENTS): angular frequency, rad/s, phase, rad, amplitude, rad/s."""
        chance = NoiseStream(stream_key(seed, f"{device}/tremor", trial), 2 * COMPONENTS, "uniform").row(0)
        low, high = self.band_hz
        # One frequency in each equal part of the band.
        hertz = low + (high - low) * (np.arange(COMPONENTS) + chance[:COMPONENTS]) / COMPONENTS
        amplitude = np.full(COMPONENTS, self.physiological * math.sqrt(2.0 / COMPONENTS))
        return 2.0 * math.pi * np.stack([hertz, chance[COMPONENTS:], amplitude / (2.0 * math.pi)])


@dataclass(frozen=True, slots=True, kw_only=True)
class Knocks:
    """Knocks against single sensors: accelerations of one sample, in any direction, at any time.

    Attributes
    ----------
    per_s: mean number of knocks of each sensor in a second.
    size: acceleration of each, m/s^2 (chosen: a hand that meets a table's edge; 50 is five times gravity).
    """

    per_s: float
    size: float = 50.0

    def __post_init__(self) -> None:
        require_not_negative("knocks", self, "per_s", "size")


@compiled
def knock(per_s: float, size: float, elapsed_s: float, chances: Array, force: Array) -> None:
    """Add knocks to the specific forces (n, 3), m/s^2, by uniform numbers `chances` (n, 3)."""
    for i in range(force.shape[0]):
        if chances[i, 0] < -math.expm1(-per_s * elapsed_s):
            up, around = 2.0 * chances[i, 1] - 1.0, 2.0 * math.pi * chances[i, 2]
            level = math.sqrt(1.0 - up * up)
            force[i, 0] += size * level * math.cos(around)
            force[i, 1] += size * level * math.sin(around)
            force[i, 2] += size * up


def axes(seed: int, device: str, sites: int) -> Array:
    """Axis of each sensor's tremor, and the perpendicular direction in which it swings, (2, sites, 3)."""
    normal = NoiseStream(stream_key(seed, f"{device}/tremor_axes", 0), 6 * sites).row(0).reshape(2, sites, 3)
    axis = normal[0] / np.linalg.norm(normal[0], axis=-1, keepdims=True)
    swing = np.cross(axis, normal[1])
    return np.stack([axis, swing / np.linalg.norm(swing, axis=-1, keepdims=True)])


@dataclass(frozen=True, slots=True, kw_only=True)
class Pulses:
    """Timing and size of stimulation pulses from messages of currents and pulse widths.

    Attributes
    ----------
    rate_hz: rate at which the stimulator repeats the pulses of the newest message; 0: one pulse per message.
    full_charge_uc: charge of one pulse that counts as full (chosen: 25 mA for 400 us).
    """

    rate_hz: float = 0.0
    full_charge_uc: float = 10.0

    def __post_init__(self) -> None:
        require_not_negative("pulses", self, "rate_hz")
        require_positive("pulses", self, "full_charge_uc")


class Stimulation(NamedTuple):
    """Stimulation at an instant: share of full charge, time since the last pulse, and between pulses, s."""

    share: float
    since_s: float
    interval_s: float


NO_STIMULATION = Stimulation(0.0, math.inf, 0.0)


@dataclass(slots=True, eq=False)
class PulseWatch:
    """Timing of the messages with pulses.

    Attributes
    ----------
    newest_ns: arrival of the newest message; -1 before the first.
    interval_s: time between the last two; 0 before there are two.
    share: charge of the newest, as a share of full charge.
    """

    newest_ns: int = -1
    interval_s: float = 0.0
    share: float = 0.0

    def now(self, pulses: Pulses, sample: Sample, time_ns: int) -> Stimulation:
        """Stimulation at an instant, from the newest message."""
        if not sample.present:
            return NO_STIMULATION
        if sample.arrived_ns > self.newest_ns:
            if self.newest_ns >= 0:
                self.interval_s = (sample.arrived_ns - self.newest_ns) / NS_PER_S
            self.newest_ns = sample.arrived_ns
            self.share = charge(np.asarray(sample.value), pulses.full_charge_uc)
        since, interval = (time_ns - self.newest_ns) / NS_PER_S, self.interval_s
        if pulses.rate_hz > 0.0:
            interval = 1.0 / pulses.rate_hz
            since %= interval
        return Stimulation(self.share, since, interval)


def charge(stimulation: Array, full_charge_uc: float) -> float:
    """Largest charge of all channels as a share of full charge; stimulation (channels, 2) in A and s."""
    return float((stimulation[:, 0] * stimulation[:, 1]).max()) / (1e-6 * full_charge_uc)


@compiled
def vibration(
    tremor: TremorSize, components: Array, time_s: float, elapsed_s: float, stimulation: Stimulation,
    level: Array,
) -> tuple[float, float]:
    """Angular rate, rad/s, and acceleration at the lever, m/s^2, of the tremor at `time_s`.

    `level` (1,), the share of full charge that the muscles have followed, advances by `elapsed_s`.
    """
    share, since, interval = stimulation
    level[0] += (share - level[0]) * -math.expm1(-elapsed_s / tremor.rise_s)
    rate, change = 0.0, 0.0
    for k in range(components.shape[1]):
        angle = components[0, k] * time_s + components[1, k]
        rate += components[2, k] * math.cos(angle)
        change -= components[2, k] * components[0, k] * math.sin(angle)
    if interval > 0.0:
        pulse = 2.0 * math.pi / interval
        amplitude = tremor.tetanic * level[0]
        rate += amplitude * math.cos(pulse * since)
        change -= amplitude * pulse * math.sin(pulse * since)
    return rate, tremor.lever_m * change
