"""`stimulator`: from commands for its channels to pulses of array elements, one channel at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, RateClock, duration_ns, parse_rate
from fesloop.loop.passages import Passage
from fesloop.loop.signals import Port, Sample, Value
from plants.checks import MOST_ELEMENTS, require_positive
from plants.stimulator.generations import IEC_VOLTAGE_V, PRESETS, Limits, PresetName
from plants.stimulator.state import StimulatorState, VirtualElectrode, multiplexing, share_out

Array = NDArray[np.float64]
_RANGES = ("current_max_ma", "current_step_ma", "width_min_us", "width_max_us", "width_step_us", "latency_ms",
           "compliance_v")


@dataclass(frozen=True, slots=True, kw_only=True)
class Stimulator:
    """A multi-channel stimulator with a multiplexer that switches each channel onto elements of an array.

    Channels are interleaved: a stimulation period is divided into equal slots, one for every channel of the
    device, and the biphasic pulse of channel c is given in slot c. The block has a clock of its own whose
    tick k is slot k; a message leaves at every tick and holds the pulses of that instant only. A pulse
    follows the newest command that arrived at least the device's latency before it. What the device cannot
    give is cut and told, once when it begins: statuses `bad_input`, `current_limited`, `voltage_limited`,
    `current_too_small`, `width_limited`, `width_too_short`, `charge_limited`, `energy_limited`, with the
    channel; `bad_multiplexing`; `current_density` for elements under which it passes 2 mA/cm^2 r.m.s.
    The terms are those of IEC 60601-2-10; no certification is meant.

    Inputs: `stimulation` (channels, 2): current, A, and pulse width, s; optional `multiplexing` (channels,
    elements): share of each channel's current that each element has, rows that add up to 1, or to 0 for a
    channel switched onto nothing; it holds from the next slot on, in place of `electrodes`. Outputs:
    `elements` (elements, 3): current, A, pulse width, s, and stimulation frequency, Hz, 0 for elements that
    have no pulse in this slot; and of the newest pulses `charge` (channels,), C a phase, `charge_rate`
    (channels,), C/s of that phase, `element_charge` and `element_charge_rate` (elements,).

    Attributes
    ----------
    preset: device that stands for all that is not given (`plants.stimulator.generations`).
    channels: in use, as many as the device has at most; 0 takes them from what is wired in.
    elements: of the arrays.
    electrodes: virtual electrode of each channel; empty: channel c has element c.
    frequency_hz: stimulation frequency, an exact rate.
    charge_max_uc: the user's limit of a phase's charge (chosen: that of the `safety` block).
    load_ohm: between the poles; the compliance voltage drives no more current through it (chosen: the
        500 ohm of IEC 60601-2-10).
    element_area_cm2: of an element, for current density (chosen: a disc of 7 mm radius).
    current_max_ma, current_step_ma, width_min_us, width_max_us, width_step_us: range and resolution.
    latency_ms: from a command to the pulses that follow it.
    compliance_v: the device's greatest voltage, at most 500 (IEC 60601-2-10).
    """

    preset: PresetName = "generation2"
    channels: int = 0
    elements: int = 59
    electrodes: tuple[VirtualElectrode, ...] = ()
    frequency_hz: str = "40"
    charge_max_uc: float = 20.0
    load_ohm: float = 500.0
    element_area_cm2: float = 1.54
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
                             f"1 to {device.channels}, the device's, or 0 for what is wired in")
        limits = self.limits
        if limits.current_step > limits.current_max or not (
                limits.width_step <= limits.width_min < limits.width_max):
            raise InputError("stimulator", "ranges that hold no pulse", "current_step_ma <= current_max_ma, "
                             "width_step_us <= width_min_us < width_max_us")
        if self.compliance_v is not None and self.compliance_v > IEC_VOLTAGE_V:
            raise InputError("stimulator.compliance_v", f"{self.compliance_v:g}",
                             f"at most {IEC_VOLTAGE_V:g}")
        self._require_frequency()
        if self.elements > MOST_ELEMENTS:
            raise InputError("stimulator.elements", f"{self.elements}", f"at most {MOST_ELEMENTS}")
        if self.channels or self.electrodes:
            multiplexing(self.electrodes, self.channels or len(self.electrodes), self.elements)

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
        """The pulse slots."""
        return RateClock.from_rate(Fraction(self.frequency_hz) * PRESETS[self.preset].channels)

    @property
    def limits(self) -> Limits:
        """Range, resolution and the user's limit, in A, s, C."""
        current, step, low, high, width, _, volt = (getattr(self, key) for key in _RANGES)
        return Limits(current / 1e3, step / 1e3, volt / self.load_ohm, low / 1e6, high / 1e6, width / 1e6,
                      self.charge_max_uc / 1e6)

    @property
    def shares(self) -> Array:
        """Share of a channel's current that each element has without `multiplexing`, (channels, elements)."""
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
        """The device's latency, and the wait of each channel for its slot; charges stay until its next."""
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
        """For the number of channels that is wired in; raises InputError where the device has fewer."""
        return replace(self, channels=shapes["stimulation"][0])

    def init(self, context: Context) -> StimulatorState:
        """No command yet."""
        latency_ns = duration_ns(self.latency_ms or 0.0, NS_PER_MS, "stimulator.latency_ms")
        return StimulatorState.of(self.limits, float(Fraction(self.frequency_hz)), self.element_area_cm2,
                                  latency_ns, self.shares)

    def step(self, state: StimulatorState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """The pulses of one slot."""
        stimulation, shares = inputs
        state.take_command(stimulation, tick.time_ns)
        state.take_shares(shares, tick)
        elements = np.zeros((self.elements, 3))
        slot = tick.index % PRESETS[self.preset].channels
        if slot < self.channels:
            state.fire(slot, tick)
            share_out(state.given[slot], state.shares[slot], state.hertz, elements)
        account = state.account
        return elements, account.channel, account.channel_rate, account.element, account.element_rate
