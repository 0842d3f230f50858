"""`imus`: inertial and magnetic sensors on the segments of a hand, with their errors and disturbances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from fesloop.errors import InputError, did_you_mean
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree, pairs_of_names
from fesloop.loop.block import Context, Tick
from fesloop.loop.signals import Port, Sample, Value
from fesloop.loop.signals import Sensors as StatedSensors
from plants.checks import require_not_negative, require_shape
from plants.imus.device import KINDS, MAG, PRESETS, Device, PresetName, TriadErrors
from plants.imus.disturbances import (
    NO_TISSUE,
    MagneticField,
    PulseArtefacts,
    Pulses,
    SoftTissue,
    Tremor,
    axes,
)
from plants.imus.state import ErrorSizes, ImusState, Sensors, Surroundings, new_state, noise_columns

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
    preset: hardware of S19, K14 (`plants.imus.device`) or "ideal", for all parameters not given.
    site_names: names of the s input sites.
    sites: names or numbers of sites with a sensor, in the order of the samples. Empty: those of the preset
        (all but the forearm).
    mag_sites: sites whose sensors have a magnetometer; None: those of the preset.
    device: name of the device; empty: that of the node.
    gyroscope, accelerometer, magnetometer: errors of the triads.
    soft_iron: sd of the entries of the symmetric matrix that iron by the sensor adds to the identity.
    mounting_sd_deg: sd of the mounting's rotation about each axis.
    mounting_angle_deg: smallest and largest angle of a second rotation about any axis: S19 has 5 to 10.
    soft_tissue: tissue between bone and sensor; None: rigid.
    loss: long-run fraction of samples of each sensor that is lost.
    burst_samples: mean length of a gap; 0: samples are lost independently.
    magnetic_field: magnetic field; its carried dipoles move with sites.
    artefacts, tremor: effects of stimulation; None: none.
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
    soft_tissue: SoftTissue | None = None
    loss: float = 0.0
    burst_samples: float = 0.0
    magnetic_field: MagneticField = _EARTH
    artefacts: PulseArtefacts | None = None
    tremor: Tremor | None = None
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
        require_not_negative("imus", self, "soft_iron", "mounting_sd_deg", "burst_samples", "channels")
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

    def _require_loss(self) -> None:
        if not 0.0 <= self.loss < 1.0:
            raise InputError("imus.loss", f"{self.loss}", "a share from 0 to below 1")
        least = max(1.0, self.loss / (1.0 - self.loss))
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
            self._needed(), context, bool(self.loss))

    def _sensors(self, device: Device, kinds: Sequence[str], trial: int) -> Sensors:
        rows, every = np.array(self._sites), len(self.site_names)
        errors = (self.gyroscope, self.accelerometer, self.magnetometer)
        assert self.soft_iron is not None
        assert self.mounting_angle_deg is not None
        mounting = device.mountings(self.mounting_sd_deg, self.mounting_angle_deg)
        triads = [device.triads(kind, each, self.soft_iron if kind == "mag" else 0.0)
                  for kind, each in zip(KINDS, errors, strict=True)]
        present = np.ones((3, rows.size), dtype=np.bool_)
        present[MAG] = np.isin(rows, self._mag_sites)
        sizes = ErrorSizes(*(np.array([getattr(each, name) for each in errors], dtype=np.float64)
                             for name in ErrorSizes._fields))
        stays = 1.0 - 1.0 / self.burst_samples if self.burst_samples else self.loss
        begins = self.loss * (1.0 - stays) / (1.0 - self.loss)
        tremor, artefacts = self.tremor or Tremor(), self.artefacts or PulseArtefacts()
        components = tremor.components(device.seed, device.name, trial)
        return Sensors(
            kinds=np.array([KINDS.index(kind) for kind in kinds]), sites=rows, present=present,
            matrices=np.stack([matrices @ mounting for matrices, _ in triads])[:, rows],
            constants=np.stack([bias for _, bias in triads])[:, rows], errors=sizes,
            columns=noise_columns(sizes, [KINDS.index(kind) for kind in kinds], rows.size),
            spikes=artefacts.directed(device.seed, device.name, every)[:, rows] * bool(self.artefacts),
            axes=axes(device.seed, device.name, every)[:, rows],
            tissue=self.soft_tissue.coefficients() if self.soft_tissue else NO_TISSUE,
            tremor=tremor.size(), components=components if self.tremor else np.empty((3, 0)),
            losing=np.array([begins, stays]))

    def _surroundings(self) -> Surroundings:
        around = self.magnetic_field
        carriers = [self.site_names.index(name) for name in around.carriers]
        return Surroundings(around.earth, around.fixed, around.carried, np.array(carriers, dtype=np.int64))

    def step(self, state: ImusState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Samples of one tick."""
        return state.sample(inputs, self.pulses, self._window_s(), tick)

    def _window_s(self) -> float:
        return 1e-3 * self.artefacts.window_ms if self.artefacts is not None else 0.0
