"""The magnetic field that hand-worn sensors meet: the Earth's, and that of magnets and iron nearby.

Global frame ENU; its y axis points to magnetic north unless a declination is given. Kernels take sources as
rows (7,): position (3,), m, moment (3,), A m^2, radius, m.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.hand.kinematics_kernels import turned
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.loop.signals import Sample
from plants.checks import require_not_negative, require_positive, require_shape

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
_MU_0_OVER_4_PI = 1e-7
"""T m/A: mu_0 / (4 pi), exact to 6e-10 (CODATA 2018)."""


@compiled
def add_sources(sources: Array, points: Array, field: Array) -> None:
    """Add to `field` (n, 3), T, at `points` (n, 3) what `sources` (k, 7) give there."""
    for source in sources:
        mx, my, mz, radius = source[3], source[4], source[5], source[6]
        for i in range(points.shape[0]):
            x, y, z = points[i, 0] - source[0], points[i, 1] - source[1], points[i, 2] - source[2]
            square = x * x + y * y + z * z
            # Inside a uniformly magnetised sphere the field is 2/3 mu_0 M, everywhere alike.
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
    """A magnet, or iron magnetised for good, as a sphere: outside it, the field is that of a dipole.

        B(r) = mu_0 / (4 pi r^3) (3 (m . e) e - m),   e = r / |r|        (Griffiths, eq. 5.89)

    Attributes
    ----------
    position: of the centre, m: in the global frame, or in that of the site that carries it.
    moment: A m^2, in the same frame (a neodymium cube of 10 mm has about 1).
    radius_m: of the sphere, inside which the field is uniform.
    carrier: name of the site that it moves with; empty: fixed in the room.
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
        """As the kernels take it, (7,)."""
        return np.array([*self.position, *self.moment, self.radius_m])


@dataclass(frozen=True, slots=True, kw_only=True)
class MagneticField:
    """The Earth's field, homogeneous, and that of dipoles in the room and on the hand.

    Attributes
    ----------
    strength_ut, inclination_deg: of the Earth's field, uT, and downwards from the horizontal (Berlin in
        2019, rounded from the IGRF-13 model, doi 10.1186/s40623-020-01288-x).
    declination_deg: of its horizontal part from the global y axis towards east; 0: y is magnetic north, as
        trackers take it (from true north it is about 4 in Berlin).
    dipoles: fixed in the room or carried.
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
        """Names of the sites that carry them, (c,)."""
        return tuple(dipole.carrier for dipole in self.dipoles if dipole.carrier)

    def in_room(self, points: ArrayLike) -> Array:
        """Field (..., 3), T, at points (..., 3), m, of everything that is not carried; all global."""
        where = np.asarray(points, dtype=np.float64)
        field = np.broadcast_to(self.earth, where.shape).copy()
        add_sources(self.fixed, np.ascontiguousarray(where).reshape(-1, 3), field.reshape(-1, 3))
        return field


def _rows(dipoles: list[Dipole]) -> Array:
    return np.array([dipole.row for dipole in dipoles]).reshape(-1, 7)


@dataclass(frozen=True, slots=True, kw_only=True)
class SoftTissue:
    """Elastic mount of every sensor.

    The sensor turns against its bone; that it also shifts a little is left out. The default numbers are
    medians of fits to five sensors on foam (recording chain5, first half of trial 1), where the model
    explains half of what foam adds to gyroscopes in the second half; that skin is like foam is chosen.

    Attributes
    ----------
    natural_hz, damping: of the oscillation; damping ratio above 0 and below 1.
    share: of the bone's angular acceleration that tissue does not pass on at once: 1 for a sensor held by
        tissue alone, less for one that tape ties to the skin around, more for one whose weight lies off
        its middle.
    sag_deg: turned by 1 g of specific force along the skin, at rest, deg.
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

    def numbers(self) -> Array:
        """As the kernel takes it, (7,): natural frequency, rad/s, damping, share, rad per m/s^2, outwards."""
        return np.array([2.0 * math.pi * self.natural_hz, self.damping, self.share,
                         math.radians(self.sag_deg) / STANDARD_GRAVITY, *self.outwards])


@compiled(inline="always")
def _leaning(tissue: Array, force: Array, axis: int) -> float:
    """Rotation about an axis at which a held specific force (3,) is balanced, rad."""
    b, c = (axis + 1) % 3, (axis + 2) % 3
    turned: float = -tissue[3] * (tissue[4 + b] * force[c] - tissue[4 + c] * force[b])
    return turned


@compiled
def wobble(tissue: Array, rate: Array, force: Array, elapsed_s: float, motion: Array) -> None:
    """Bring `motion` (4, 3) on by `elapsed_s`: rotation, rad, its rate, bone's rate and force before.

    `rate` (3,), rad/s, and `force` (3,), m/s^2, are the bone's now. With 0 s elapsed the sensor is put at
    rest where the force balances it: the start of a trial.
    """
    w, z = tissue[0], tissue[1]
    for i in range(3):
        now = _leaning(tissue, force, i)
        if elapsed_s <= 0.0:
            motion[0, i], motion[1, i] = now, 0.0
            continue
        before = _leaning(tissue, motion[3], i)
        slope = (now - before) / elapsed_s
        inertial = -tissue[2] * (rate[i] - motion[2, i]) / (elapsed_s * w * w)
        # y_p = u - 2 z u' / w solves the equation for u linear in time; what is left rings down.
        offset = before + inertial - 2.0 * z * slope / w
        left, speed = motion[0, i] - offset, motion[1, i] - slope
        damped = w * math.sqrt(1.0 - z * z)
        decay = math.exp(-z * w * elapsed_s)
        cosine, sine = math.cos(damped * elapsed_s), math.sin(damped * elapsed_s) / damped
        motion[0, i] = offset + slope * elapsed_s + decay * (left * (cosine + z * w * sine) + speed * sine)
        motion[1, i] = slope + decay * (speed * (cosine - z * w * sine) - left * w * w * sine)
    motion[2] = rate
    motion[3] = force


@compiled
def turn_back(rotation: Array, vector: Array) -> None:
    """Coordinates (3,) in the bone's frame to those in a frame turned by a rotation vector (3,), in place."""
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
    """Add to `vector` (3,), rad/s, what a rotation vector (3,) that changes at `speed` (3,) turns by.

    In the turned frame: the right Jacobian of the rotation times its rate.
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
"""Sinusoids of the physiological tremor (chosen: its envelope then varies as that of narrow-band noise)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PulseArtefacts:
    """Spikes on samples taken shortly after a pulse; all sizes are chosen, none is published.

    Each sensor's spike has a direction of its own, the same for the run.

    Attributes
    ----------
    window_ms: how long after a pulse a sample is still spoilt.
    gyr, acc, mag: size at full charge, rad/s, m/s^2, T; in proportion to the largest channel's charge.
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
        drawn = NoiseStream(stream_key(seed, f"{device}/artefacts", 0), 9 * sites).row(0).reshape(3, sites, 3)
        sizes = np.array([self.gyr, self.acc, self.mag])[:, np.newaxis, np.newaxis]
        return np.asarray(sizes * drawn / np.linalg.norm(drawn, axis=-1, keepdims=True))


@dataclass(frozen=True, slots=True, kw_only=True)
class Tremor:
    """Physiological tremor, always there, and the tetanic one of muscles that twitch with every pulse.

    Attributes
    ----------
    physiological: rms of its angular rate, rad/s (chosen: 0.1 m/s^2 at the lever, as of hands held out).
    band_hz: in which it lies (8-12: Elble and Koller 1990, as usually quoted).
    tetanic: rms of the angular rate at the stimulation frequency at full charge, rad/s (chosen).
    rise_s: time constant by which it follows the charge, s (that of activation, 1 / 25 s, grip-force data).
    lever_m: from the axis to the sensor, m (chosen: half a hand).
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

    def numbers(self) -> Array:
        """As the kernel takes it, (3,): tetanic amplitude, rad/s, time constant, s, lever, m."""
        return np.array([math.sqrt(2.0) * self.tetanic, self.rise_s, self.lever_m])

    def components(self, seed: int, device: str, trial: int) -> Array:
        """Sinusoids of a trial, (3, COMPONENTS): angular frequency, rad/s, phase, rad, amplitude, rad/s."""
        drawn = NoiseStream(stream_key(seed, f"{device}/tremor", trial), 2 * COMPONENTS, "uniform").row(0)
        low, high = self.band_hz
        # One frequency in each equal part of the band.
        hertz = low + (high - low) * (np.arange(COMPONENTS) + drawn[:COMPONENTS]) / COMPONENTS
        amplitude = np.full(COMPONENTS, self.physiological * math.sqrt(2.0 / COMPONENTS))
        return 2.0 * math.pi * np.stack([hertz, drawn[COMPONENTS:], amplitude / (2.0 * math.pi)])


def axes(seed: int, device: str, sites: int) -> Array:
    """Axis of each sensor's tremor, and the direction at right angles in which it swings, (2, sites, 3)."""
    drawn = NoiseStream(stream_key(seed, f"{device}/tremor_axes", 0), 6 * sites).row(0).reshape(2, sites, 3)
    axis = drawn[0] / np.linalg.norm(drawn[0], axis=-1, keepdims=True)
    swing = np.cross(axis, drawn[1])
    return np.stack([axis, swing / np.linalg.norm(swing, axis=-1, keepdims=True)])


@dataclass(frozen=True, slots=True, kw_only=True)
class Pulses:
    """How stimulation pulses come out of the messages of currents and pulse widths.

    Attributes
    ----------
    rate_hz: at which the stimulator repeats the newest message's pulses; 0: one pulse a message.
    full_charge_uc: of one pulse, that counts as full (chosen: 25 mA for 400 us).
    """

    rate_hz: float = 0.0
    full_charge_uc: float = 10.0

    def __post_init__(self) -> None:
        require_not_negative("pulses", self, "rate_hz")
        require_positive("pulses", self, "full_charge_uc")


@dataclass(slots=True, eq=False)
class PulseWatch:
    """The pulses seen so far.

    Attributes
    ----------
    newest_ns: arrival of the newest message; -1 before the first.
    interval_s: between the last two; 0 before there are two.
    share: of full charge, the newest one's.
    """

    newest_ns: int = -1
    interval_s: float = 0.0
    share: float = 0.0

    def now(self, pulses: Pulses, sample: Sample, time_ns: int) -> tuple[float, float, float]:
        """(share of full charge, s since the last pulse, s between pulses); share 0 before the first."""
        if not sample.present:
            return 0.0, math.inf, 0.0
        if sample.arrived_ns > self.newest_ns:
            if self.newest_ns >= 0:
                self.interval_s = (sample.arrived_ns - self.newest_ns) / NS_PER_S
            self.newest_ns = sample.arrived_ns
            self.share = charge(np.asarray(sample.value), pulses.full_charge_uc)
        since, interval = (time_ns - self.newest_ns) / NS_PER_S, self.interval_s
        if pulses.rate_hz > 0.0:
            interval = 1.0 / pulses.rate_hz
            since %= interval
        return self.share, since, interval


def charge(stimulation: Array, full_charge_uc: float) -> float:
    """Charge of the largest channel's pulse as a share of full; stimulation (channels, 2) in A and s."""
    return float((stimulation[:, 0] * stimulation[:, 1]).max()) / (1e-6 * full_charge_uc)


@compiled
def vibration(
    numbers: Array, components: Array, time_s: float, elapsed_s: float, stimulation: Array, level: Array
) -> tuple[float, float]:
    """Angular rate, rad/s, and acceleration at the lever, m/s^2, of the tremor at `time_s`.

    `stimulation` (3,): share of full charge, s since the last pulse and between pulses; `level` (1,), the
    share that the muscles have followed to, is brought on by `elapsed_s`.
    """
    share, since, interval = stimulation[0], stimulation[1], stimulation[2]
    level[0] += (share - level[0]) * -math.expm1(-elapsed_s / numbers[1])
    rate, change = 0.0, 0.0
    for k in range(components.shape[1]):
        angle = components[0, k] * time_s + components[1, k]
        rate += components[2, k] * math.cos(angle)
        change -= components[2, k] * components[0, k] * math.sin(angle)
    if interval > 0.0:
        pulse = 2.0 * math.pi / interval
        amplitude = numbers[0] * level[0]
        rate += amplitude * math.cos(pulse * since)
        change -= amplitude * pulse * math.sin(pulse * since)
    return rate, numbers[2] * change
