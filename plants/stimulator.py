"""`stimulator`: from commands for its channels to interleaved pulses of array elements."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError, did_you_mean
from fesloop.forms.schema import build, plain, require_positive, require_shape
from fesloop.loop.abilities import Passage
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, RateClock, duration_ns, parse_rate
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import NEVER, Port, Sample, Value
from fesloop.models.electrode_arrays import MOST_ELEMENTS, ElectrodeArrays, VirtualElectrode

PresetName = Literal["generation1", "generation2", "generation3"]
_ROUND_OFF = 1e-9
IEC_LOAD_OHM = 500.0
"""Load for which IEC 60601-2-10 states its limits."""
IEC_ENERGY_J = 0.3
"""Greatest energy of a pulse into that load."""
IEC_VOLTAGE_V = 500.0
"""Greatest peak voltage."""
IEC_DENSITY_MA_CM2 = 2.0
"""Current density (r.m.s.) under an electrode above which the operator must be alerted."""

BAD, CURRENT, VOLTAGE, SMALL, WIDTH, SHORT, CHARGE, ENERGY = 1, 2, 4, 8, 16, 32, 64, 128
LIMITED = ((BAD, "bad_input", "negative or not finite: no pulse"),
           (CURRENT, "current_limited", "current above the device's range"),
           (VOLTAGE, "voltage_limited", "current above the limit of the device's voltage at the load"),
           (SMALL, "current_too_small", "current rounds to 0: no pulse"),
           (WIDTH, "width_limited", "pulse width above the device's range"),
           (CHARGE, "charge_limited", "charge per phase above the user's limit: pulse shortened"),
           (ENERGY, "energy_limited", "energy of the pulse above 300 mJ into 500 ohm: pulse shortened"),
           (SHORT, "width_too_short", "pulse width below the device's range: no pulse"))
"""Bits of limits that change or suppress a pulse, with their statuses."""


class Preset(NamedTuple):
    """Ranges of a device.

    Attributes
    ----------
    channels: number of channels.
    current_max_ma, current_step_ma: range from 0, and resolution.
    width_min_us, width_max_us, width_step_us: range and resolution of the pulse width.
    frequency_min_hz, frequency_max_hz: range of the stimulation frequency.
    latency_ms: latency from a command to its pulses.
    compliance_v: greatest voltage.
    """

    channels: int
    current_max_ma: float
    current_step_ma: float
    width_min_us: float
    width_max_us: float
    width_step_us: float
    frequency_min_hz: float
    frequency_max_hz: float
    latency_ms: float
    compliance_v: float


PRESETS = {
    "generation1": Preset(8, 126.0, 2.0, 20.0, 500.0, 1.0, 20.0, 50.0, 24.0, 150.0),
    "generation2": Preset(8, 126.0, 2.0, 20.0, 500.0, 1.0, 20.0, 50.0, 10.0, 150.0),
    "generation3": Preset(8, 126.0, 0.5, 20.0, 500.0, 1.0, 20.0, 50.0, 1.0, 150.0),
}


class Limits(NamedTuple):
    """Ranges and resolutions of one device in use, in A, s, C.

    Attributes
    ----------
    current_max, current_step: range and resolution of the current, A.
    current_driven: current of the compliance voltage through the load, A.
    width_min, width_max, width_step: range and resolution of the pulse width, s.
    charge_max: the user's limit of a phase's charge, C.
    """

    current_max: float
    current_step: float
    current_driven: float
    width_min: float
    width_max: float
    width_step: float
    charge_max: float


def given_pulse(
    limits: Limits, current: float, width: float, *, never_more: bool = False
) -> tuple[float, float, int]:
    """Pulse that a device gives for a command: current, A, width, s, and bits of the limits that changed it.

    Values are rounded to the nearest step, but down if a limit applies, or if the command must not be
    exceeded (`never_more`). Charge per phase and energy are limited by shortening the pulse; the energy, 2 R
    I^2 w, counts both phases.
    """
    return _given_pulse(limits, current, width, never_more)


@compiled
def _given_pulse(limits: Limits, current: float, width: float, never_more: bool) -> tuple[float, float, int]:
    """Result of `given_pulse`."""
    if not (math.isfinite(current) and math.isfinite(width) and current >= 0.0 and width >= 0.0):
        return 0.0, 0.0, BAD
    if current == 0.0 or width == 0.0:
        return 0.0, 0.0, 0
    cut = CURRENT if current > limits.current_max * (1.0 + _ROUND_OFF) else 0
    if current > limits.current_driven * (1.0 + _ROUND_OFF):
        cut |= VOLTAGE
    most = min(limits.current_max, limits.current_driven)
    current = min(_rounded(current, limits.current_step, never_more), _down(most, limits.current_step))
    if current == 0.0:
        return 0.0, 0.0, cut | SMALL
    if width > limits.width_max * (1.0 + _ROUND_OFF):
        cut |= WIDTH
    elif width < limits.width_min * (1.0 - _ROUND_OFF):
        return 0.0, 0.0, cut | SHORT
    width = min(_rounded(width, limits.width_step, never_more), _down(limits.width_max, limits.width_step))
    energetic = IEC_ENERGY_J / (2.0 * IEC_LOAD_OHM * current)
    for charge, bit in ((limits.charge_max, CHARGE), (energetic, ENERGY)):
        if current * width > charge * (1.0 + _ROUND_OFF):
            width, cut = _down(charge / current, limits.width_step), cut | bit
    if width < limits.width_min * (1.0 - _ROUND_OFF):
        return 0.0, 0.0, cut | SHORT
    return current, width, cut


@compiled
def _rounded(value: float, step: float, down: bool) -> float:
    """Nearest multiple of the step, or the greatest up to the value."""
    return _down(value, step) if down else math.floor(value / step + 0.5) * step


@compiled
def _down(value: float, step: float) -> float:
    """Greatest multiple of the step up to the value, within round-off."""
    return math.floor(value / step * (1.0 + _ROUND_OFF)) * step


Array = NDArray[np.float64]
_TOLERANCE = 1e-6


def multiplexing(electrodes: Sequence[VirtualElectrode], channels: int, elements: int) -> Array:
    """Fraction of each channel's current in each element, (channels, elements).

    Without electrodes channel c has element c. Raises InputError for elements that do not exist and unless
    there are as many electrodes as channels.
    """
    electrodes = electrodes or [VirtualElectrode(elements=(channel,)) for channel in range(channels)]
    if len(electrodes) != channels:
        raise InputError("stimulator.electrodes", f"{len(electrodes)} virtual electrodes",
                         f"{channels}, one a channel, or none")
    shares = np.zeros((channels, elements))
    for channel, electrode in enumerate(electrodes):
        numbers = list(electrode.elements)
        if max(numbers) >= elements:
            raise InputError(f"stimulator.electrodes[{channel}].elements",
                             f"element {max(numbers)} does not exist", f"0 to {elements - 1}")
        shares[channel, numbers] = electrode.shares or 1.0 / len(numbers)
    return shares


def fault_of(shares: Array) -> str:
    """Description of the first fault of shares (channels, elements), or "".

    Every row must be non-negative and add up to 1, or to 0 for a disconnected channel.
    """
    if not np.isfinite(shares).all() or (shares < 0.0).any():
        return "a share is negative or not finite"
    total = shares.sum(axis=1)
    wrong = np.flatnonzero((np.abs(total - 1.0) > _TOLERANCE) & (total != 0.0))
    if not wrong.size:
        return ""
    return f"the shares of channel {wrong[0]} add up to {total[wrong[0]]:g}, not to 1 or 0"


@compiled
def give_slots(
    limits: Limits, hertz: float, area_cm2: Array, slot: int, slots: int, command: Array, shares: Array,
    given: Array, account: Account, elements: Array, cut: NDArray[np.int64], accounts: Account,
) -> bool:
    """Give the pulses of consecutive slots, from `slot` of `slots` on, under one command and multiplexing.

    Updates `given` (channels, 2), and fills for n slots `elements` (n, elements, 3), the limits that changed
    the pulse, `cut` (n,), -1 in a slot without a channel, and the `accounts` (n, ...); before them the
    account is `account`. Returns whether a limit changed a pulse, or a current density requires attention.
    """
    noted = False
    for k in range(elements.shape[0]):
        elements[k] = 0.0
        cut[k], channel, changed = -1, (slot + k) % slots, False
        if channel < command.shape[0]:
            current, width, cut[k] = _given_pulse(limits, command[channel, 0], command[channel, 1], False)
            changed = given[channel, 0] != current or given[channel, 1] != width
            given[channel, 0], given[channel, 1] = current, width
            share_out(given[channel], shares[channel], hertz, elements[k])
            noted = noted or cut[k] > 0
        if changed:
            charge, charge_rate, most, rate, density = tally(given, shares, hertz, area_cm2)
        elif k == 0:
            charge, charge_rate, most, rate, density = account
        accounts.channel[k], accounts.channel_rate[k] = charge, charge_rate
        accounts.element[k], accounts.element_rate[k], accounts.density[k] = most, rate, density
        noted = noted or accounts.density[k].max() > IEC_DENSITY_MA_CM2
    return noted


@compiled
def share_out(given: Array, shares: Array, hertz: float, elements: Array) -> None:
    """Distribute a pulse, current and width (2,), to `elements` (e, 3) by `shares` (e,)."""
    current, width = given
    if current > 0.0:
        for e in range(shares.size):
            if shares[e] > 0.0:
                elements[e, 0] = current * shares[e]
                elements[e, 1] = width
                elements[e, 2] = hertz


@compiled
def tally(
    given: Array, shares: Array, hertz: float, area_cm2: Array
) -> tuple[Array, Array, Array, Array, Array]:
    """Charge and current density of biphasic pulses (channels, 2), given `hertz` times a second.

    `area_cm2` (elements,): of each element.
    Returns the fields of `Account`. Over a period the mean square of a pulse I, w is 2 I^2 w f: both phases
    count.
    """
    channels, elements = shares.shape
    charge, charge_rate = np.empty(channels), np.empty(channels)
    most, rate, density = np.zeros(elements), np.zeros(elements), np.zeros(elements)
    for c in range(channels):
        current, width = given[c]
        charge[c] = current * width
        charge_rate[c] = charge[c] * hertz
        for e in range(elements):
            share = shares[c, e]
            if share > 0.0:
                most[e] = max(most[e], share * charge[c])
                rate[e] += share * charge_rate[c]
                density[e] += 2.0 * (share * current) ** 2 * width * hertz
    for e in range(elements):
        density[e] = 1e3 * math.sqrt(density[e]) / area_cm2[e]
    return charge, charge_rate, most, rate, density


class Account(NamedTuple):
    """Charge and current density of the given pulses; never written to.

    Attributes
    ----------
    channel, channel_rate: (channels,), charge per phase, C, and per second, C/s.
    element, element_rate: (elements,), charge per phase of the strongest channel, C, and C/s of all channels.
    density: (elements,), current density, r.m.s., mA/cm^2.
    """

    channel: Array
    channel_rate: Array
    element: Array
    element_rate: Array
    density: Array


@dataclass(slots=True, eq=False)
class StimulatorState:
    """State of the stimulator.

    Attributes
    ----------
    limits: ranges of the device; constant.
    hertz: stimulation frequency.
    area_cm2: (elements,), area of each element; constant.
    latency_ns: latency from a command to its pulses.
    shares: (channels, elements), present multiplexing; never written to.
    command: (channels, 2), present command; never written to.
    given: (channels, 2), newest pulse of each channel.
    account: charge of `given`.
    pending: later commands, with the instants from which they apply.
    command_ns, shares_ns: arrival of the newest message of each input.
    cut: (channels,), bits of the limits that changed each channel's newest pulse.
    dense: elements whose current density is too high.
    """

    limits: Limits
    hertz: float
    area_cm2: Array
    latency_ns: int
    shares: Array
    command: Array
    given: Array
    account: Account
    pending: deque[tuple[int, Array]] = field(default_factory=deque)
    command_ns: int = NEVER
    shares_ns: int = NEVER
    cut: list[int] = field(default_factory=list)
    dense: frozenset[int] = frozenset()
    latch: StatusLatch = field(default_factory=StatusLatch)

    @classmethod
    def of(
        cls, limits: Limits, hertz: float, area_cm2: Array, latency_ns: int, shares: Array
    ) -> StimulatorState:
        """State before the first command."""
        channels = len(shares)
        idle = np.zeros((channels, 2))
        account = Account(*tally(idle, shares, hertz, area_cm2))
        return cls(limits, hertz, area_cm2, latency_ns, shares, idle, idle.copy(), account,
                   cut=[0] * channels)

    def due_command(self, sample: Sample, now_ns: int) -> Array:
        """Queue a new command, and return the newest that is due."""
        if sample.arrived_ns > self.command_ns:
            self.command_ns = sample.arrived_ns
            self.pending.append((sample.arrived_ns + self.latency_ns, np.asarray(sample.value)))
        command = self.command
        while self.pending and self.pending[0][0] <= now_ns:
            command = self.pending.popleft()[1]
        return command

    def take_shares(self, sample: Sample, tick: Tick) -> None:
        """Apply a new multiplexing; a faulty one is reported and ignored."""
        if sample.arrived_ns <= self.shares_ns:
            return
        self.shares_ns = sample.arrived_ns
        shares = np.asarray(sample.value)
        fault = fault_of(shares)
        self.latch.put(tick, "bad_multiplexing", bool(fault), f"{fault}: the multiplexing before it remains")
        if not fault and not np.array_equal(shares, self.shares):
            self.shares = shares
            self.count_charge(tick)

    def give(self, slots: int, ticks: Sequence[Tick], elements: Array, accounts: Account) -> None:
        """Give the pulses of the slots of `ticks`, under the present command and multiplexing."""
        cut = np.empty(len(ticks), np.int64)
        noted = give_slots(
            self.limits, self.hertz, self.area_cm2, ticks[0].index % slots, slots, self.command, self.shares,
            self.given, self.account, elements, cut, accounts)
        self.account = Account(*[each[-1] for each in accounts])
        if noted or self.dense or any(self.cut):
            for tick, bits, density in zip(ticks, cut.tolist(), accounts.density, strict=True):
                if bits >= 0:
                    self.report_limits(tick.index % slots, bits, tick)
                self.report_density(density, tick)

    def report_limits(self, channel: int, cut: int, tick: Tick) -> None:
        """Report limits that change a channel's pulse and did not change the one before."""
        before, self.cut[channel] = self.cut[channel], cut
        current, width = self.command[channel].tolist()
        for bit, status, detail in LIMITED:
            if cut & ~before & bit:
                tick.report(status, f"channel {channel}: {detail} ({1e3 * current:g} mA, {1e6 * width:g} us)")

    def count_charge(self, tick: Tick) -> None:
        """Update the account."""
        self.account = Account(*tally(self.given, self.shares, self.hertz, self.area_cm2))
        self.report_density(self.account.density, tick)

    def report_density(self, density: Array, tick: Tick) -> None:
        """Report elements whose current density has become too high."""
        dense = frozenset((density > IEC_DENSITY_MA_CM2).nonzero()[0].tolist())
        joined = sorted(dense - self.dense)
        if joined:
            found = ", ".join(f"{element} ({density[element]:.2g})" for element in joined)
            tick.report("current_density", "requires the operator's attention: above "
                        f"{IEC_DENSITY_MA_CM2:g} mA/cm2 r.m.s. under element {found}")
        self.dense = dense


_RANGES = ("current_max_ma", "current_step_ma", "width_min_us", "width_max_us", "width_step_us", "latency_ms",
           "compliance_v")


@dataclass(frozen=True, slots=True, kw_only=True)
class Stimulator:
    """A multi-channel stimulator with a multiplexer that switches each channel onto elements of an array.

    Channels are interleaved: a stimulation period has equal slots, one for every channel of the device, and
    the biphasic pulse of channel c is given in slot c. The block has a clock of its own whose tick k is slot
    k; each message has the pulses of that instant only. A pulse follows the newest command that arrived at
    least the device's latency before it. Commands are limited to the device's range, reported once when that
    begins: statuses `bad_input`, `current_limited`, `voltage_limited`, `current_too_small`, `width_limited`,
    `width_too_short`, `charge_limited`, `energy_limited`, with the channel; `bad_multiplexing`;
    `current_density` for elements above 2 mA/cm^2 r.m.s. The terms are those of IEC 60601-2-10; no
    certification is implied.

    Inputs: `stimulation` (channels, 2): current, A, and pulse width, s; optional `multiplexing` (channels,
    elements): fraction of each channel's current in each element, rows that add up to 1, or to 0 for a
    disconnected channel; it applies from the next slot on, in place of `electrodes`. Outputs: `elements`
    (elements, 3): current, A, pulse width, s, and stimulation frequency, Hz, 0 for elements without a pulse
    in this slot; and for the newest pulses `charge` (channels,), C per phase, `charge_rate` (channels,), C/s
    of that phase, `element_charge` and `element_charge_rate` (elements,).

    Attributes
    ----------
    preset: device with the values of all parameters not given (`plants.stimulator`).
    channels: channels in use, at most those of the device; 0 takes the number from the wire.
    elements: number of elements of the arrays.
    electrodes: virtual electrode of each channel; empty: channel c has element c.
    frequency_hz: stimulation frequency, an exact rate.
    charge_max_uc: the user's limit of a phase's charge (chosen: that of the `safety` block).
    load_ohm: load that limits the current of the compliance voltage (chosen: the 500 ohm of IEC 60601-2-10).
    element_area_cm2: area of an element, for current density (chosen: a disc of 7 mm radius), or one for each
        element.
    current_max_ma, current_step_ma, width_min_us, width_max_us, width_step_us: range and resolution.
    latency_ms: latency from a command to its pulses.
    compliance_v: the device's greatest voltage, at most 500 (IEC 60601-2-10).
    """

    preset: PresetName = "generation2"
    channels: int = 0
    elements: int = 59
    electrodes: tuple[VirtualElectrode, ...] = ()
    frequency_hz: str = "40"
    charge_max_uc: float = 20.0
    load_ohm: float = 500.0
    element_area_cm2: float | tuple[float, ...] = 1.54
    current_max_ma: float | None = None
    current_step_ma: float | None = None
    width_min_us: float | None = None
    width_max_us: float | None = None
    width_step_us: float | None = None
    latency_ms: float | None = None
    compliance_v: float | None = None

    def __post_init__(self) -> None:
        if self.preset not in PRESETS:
            raise InputError("stimulator.preset", f"{self.preset!r}", ", ".join(PRESETS),
                             did_you_mean(str(self.preset), list(PRESETS)))
        device = PRESETS[self.preset]
        for key in _RANGES:
            if getattr(self, key) is None:
                object.__setattr__(self, key, getattr(device, key))
        require_positive("stimulator", self, "elements", "charge_max_uc", "load_ohm", "element_area_cm2",
                         *(key for key in _RANGES if key != "latency_ms"))
        duration_ns(self.latency_ms or 0.0, NS_PER_MS, "stimulator.latency_ms")
        if not 0 <= self.channels <= device.channels:
            raise InputError("stimulator.channels", f"{self.channels}",
                             f"1 to {device.channels}, the device's, or 0 for the number of wired channels")
        limits = self.limits
        if limits.current_step > limits.current_max or not (
                limits.width_step <= limits.width_min < limits.width_max):
            raise InputError("stimulator", "its ranges allow no pulse", "current_step_ma <= current_max_ma, "
                             "width_step_us <= width_min_us < width_max_us")
        if self.compliance_v is not None and self.compliance_v > IEC_VOLTAGE_V:
            raise InputError("stimulator.compliance_v", f"{self.compliance_v:g}",
                             f"at most {IEC_VOLTAGE_V:g}")
        self._require_frequency()
        if self.elements > MOST_ELEMENTS:
            raise InputError("stimulator.elements", f"{self.elements}", f"at most {MOST_ELEMENTS}")
        if isinstance(self.element_area_cm2, tuple):
            require_shape("stimulator", self, (self.elements,), "one an element", "element_area_cm2")
        if self.channels or self.electrodes:
            multiplexing(self.electrodes, self.channels or len(self.electrodes), self.elements)

    @classmethod
    def for_arrays(cls, arrays: ElectrodeArrays, own: Mapping[str, Any], wired: Collection[str]
                   ) -> dict[str, Any]:
        """Number and area of the elements, and those of each channel where the multiplexing has no wire."""
        found = {"elements": arrays.elements, "element_area_cm2": plain(arrays.areas_cm2)}
        if "multiplexing" in wired:
            return found
        given = build(tuple[VirtualElectrode, ...], own.get("electrodes", ()), {}, "electrodes")
        if isinstance(arrays.channels, tuple):
            if given and not arrays.channels:
                raise InputError("channels", "is missing: the experiment's channels have elements of other "
                                 f"arrays, {', '.join('+'.join(map(str, each.elements)) for each in given)}",
                                 'a list of virtual electrodes, one a channel, or "nearest"', "add it")
            return found | ({"electrodes": plain(arrays.channels)} if arrays.channels else {})
        if not given:
            raise InputError("channels", '"nearest": the experiment names no elements',
                             "a list of virtual electrodes, one a channel")
        return found | {"electrodes": plain(arrays.in_place_of(given))}

    def of_arrays(self) -> list[tuple[str, str]]:
        """Number and area of the elements, and the elements of each channel."""
        areas = sorted({float(area) for area in np.atleast_1d(self.element_area_cm2)})
        rows = [("elements", f"{self.elements}, of {' or '.join(f'{area:.3g}' for area in areas)} cm2")]
        for channel, electrode in enumerate(self.electrodes):
            shares = f", shares {', '.join(f'{each:.3g}' for each in electrode.shares)}"
            rows.append((f"channel {channel}", f"element {'+'.join(map(str, electrode.elements))}"
                         + shares * bool(electrode.shares)))
        return rows

    def _require_frequency(self) -> None:
        device, hertz = PRESETS[self.preset], parse_rate(self.frequency_hz, "stimulator.frequency_hz")
        if not device.frequency_min_hz <= hertz <= device.frequency_max_hz:
            raise InputError("stimulator.frequency_hz", self.frequency_hz,
                             f"{device.frequency_min_hz:g} to {device.frequency_max_hz:g}")
        if 2.0 * self.limits.width_max > self.clock.period_s:
            raise InputError("stimulator.width_max_us", f"{self.width_max_us}",
                             f"at most {5e5 * self.clock.period_s:g}: both phases within a slot")

    @property
    def clock(self) -> RateClock:
        """Clock of the pulse slots."""
        return RateClock.from_rate(Fraction(self.frequency_hz) * PRESETS[self.preset].channels)

    @property
    def limits(self) -> Limits:
        """Range, resolution and the user's limit, in A, s, C."""
        current, step, low, high, width, _, volt = (getattr(self, key) for key in _RANGES)
        return Limits(current / 1e3, step / 1e3, volt / self.load_ohm, low / 1e6, high / 1e6, width / 1e6,
                      self.charge_max_uc / 1e6)

    @property
    def shares(self) -> Array:
        """Fraction of each channel's current in each element without `multiplexing`, (channels, elements)."""
        return multiplexing(self.electrodes, self.channels, self.elements)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Commands, and the multiplexing."""
        channels = self.channels or None
        return (Port("stimulation", (channels, 2), "A,s"),
                Port("multiplexing", (channels, self.elements), "1", optional=True))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Pulses, and their charge."""
        channels = self.channels or None
        return (Port("elements", (self.elements, 3), "A,s,Hz"), Port("charge", (channels,), "C"),
                Port("charge_rate", (channels,), "C/s"), Port("element_charge", (self.elements,), "C"),
                Port("element_charge_rate", (self.elements,), "C/s"))

    def passages(self, context: Context) -> tuple[Passage, ...]:
        """The device's latency, and each channel's wait for its slot; charges hold until the next slot."""
        pulses = "elements"
        charges = tuple(port.name for port in self.outputs if port.name != pulses)
        latency_ns = duration_ns(self.latency_ms or 0.0, NS_PER_MS, "stimulator.latency_ms")
        channels = tuple(f"channel {channel}" for channel in range(self.channels))
        return tuple(
            Passage(inputs=(given,), outputs=outputs, delay_ns=delay_ns, delay="latency of the device",
                    lanes=channels, slots=PRESETS[self.preset].channels, turn="wait for the channel's slot",
                    holds=outputs is charges)
            for given, delay_ns in (("stimulation", latency_ns), ("multiplexing", 0))
            for outputs in ((pulses,), charges))

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> Stimulator:
        """This block with the number of wired channels; InputError if the device has fewer."""
        return replace(self, channels=shapes["stimulation"][0])

    def init(self, context: Context) -> StimulatorState:
        """State before the first command."""
        latency_ns = duration_ns(self.latency_ms or 0.0, NS_PER_MS, "stimulator.latency_ms")
        area_cm2 = np.array(np.broadcast_to(self.element_area_cm2, self.elements), dtype=np.float64)
        return StimulatorState.of(self.limits, float(Fraction(self.frequency_hz)), area_cm2, latency_ns,
                                  self.shares)

    def step(self, state: StimulatorState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Pulses of one slot."""
        elements, *charges = self.steps_through(state, [[sample] for sample in inputs], [tick])
        return elements[0], *(charge[0] for charge in charges)

    def steps_through(self, state: StimulatorState, inputs: Sequence[Sequence[Sample]], ticks: Sequence[Tick]
                      ) -> tuple[Array, ...]:
        """Pulses of consecutive slots."""
        count, slots = len(ticks), PRESETS[self.preset].channels
        elements = np.empty((count, self.elements, 3))
        accounts = Account(*[np.empty((count, each.size)) for each in state.account])

        def give(first: int, stop: int) -> None:
            if stop > first:
                state.give(slots, ticks[first:stop], elements[first:stop],
                           Account(*[each[first:stop] for each in accounts]))

        first = 0
        for k, (tick, stimulation, shares) in enumerate(zip(ticks, *inputs, strict=True)):
            command = state.due_command(stimulation, tick.time_ns)
            if command is not state.command or shares.arrived_ns > state.shares_ns:
                give(first, k)
                first, state.command = k, command
                state.take_shares(shares, tick)
        give(first, count)
        return elements, *accounts[:4]
