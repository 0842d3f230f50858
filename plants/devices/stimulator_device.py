"""`stimulator_device`: a real stimulator at the end of the loop, held by a keeper."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, ClassVar, cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, RunError, did_you_mean
from fesloop.forms.schema import require_positive
from fesloop.loop.abilities import Surroundings
from fesloop.loop.block import Block, Context, Tick
from fesloop.loop.clock import NS_PER_MS, parse_rate
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample, Value
from fesloop.posix import require_linux
from plants.devices.driver import StimulatorDriver, stated_ms
from plants.devices.kept_device import KeptDevice
from plants.devices.messages import Terms
from plants.stimulator import IEC_LOAD_OHM, LIMITED, Limits, given_pulse

if TYPE_CHECKING:
    from fesloop.loop.abilities import Present

GROUP = "fesloop.stimulators"


@cache
def _entries() -> dict[str, EntryPoint]:
    return {entry.name: entry for entry in entry_points(group=GROUP)}


def driver_names() -> list[str]:
    """Names of all registered drivers."""
    return sorted(_entries())


def driver_place(name: str) -> str:
    """Import path "module:Class" of a driver; InputError for an unknown name."""
    if name not in _entries():
        raise InputError("driver", f"no stimulator driver is named {name!r}", ", ".join(driver_names()),
                         did_you_mean(name, driver_names()))
    return _entries()[name].value


def find_driver(name: str) -> type[StimulatorDriver]:
    """Class of a driver; InputError if it does not exist or does not import."""
    place = driver_place(name)
    try:
        return cast("type[StimulatorDriver]", _entries()[name].load())
    except (ImportError, AttributeError) as fault:
        raise InputError("driver", f"{name!r} ({place}) does not import: {fault}",
                         remedy="reinstall the package that provides it") from fault


Array = NDArray[np.float64]
_HOLD_RANGE_MS = (20.0, 1000.0)


@dataclass(slots=True, eq=False)
class DeviceInUse:
    """State of a device in use.

    Attributes
    ----------
    device: the device with its keeper.
    cut: bit mask of the limits that changed each channel's newest command.
    """

    device: KeptDevice
    cut: list[int] = field(default_factory=list)
    latch: StatusLatch = field(default_factory=StatusLatch)


@dataclass(frozen=True, slots=True, kw_only=True)
class StimulatorDevice:
    """A real stimulator outside this computer, held by a keeper.

    At every tick the newest command goes, without waiting, to the keeper, a separate process that alone holds
    the device (`plants.devices.keeper`). Commands are limited to the device's range, with the statuses of
    `stimulator`, and rounded down to its steps, never above the output of the safety block. The keeper stops
    the device permanently without a fresh command for `hold_ms`, when the loop's process ends, and when
    device or line fail; the run then fails at its next tick, with the cause. A command has the instant of its
    tick: it is not fresh if the loop lags that far behind the wall clock, and a loop that starts late gives
    nothing until it has caught up (status `loop_late`). Whatever happens to the loop's process or the keeper,
    current at the device is zero within the time that `fesloop check` states. The block runs in real time
    only (`fesloop run --realtime`), and `stimulation` must come directly from a `safety` block with the same
    `frequency_hz`, as that block counts pulses. Status `keeper_ready` gives the memory and scheduling granted
    to the keeper.

    Inputs: `stimulation` (channels, 2), current, A, and pulse width, s. Outputs: `sent` (channels, 2), the
    command sent to the device; `answer`, s, time from sending to answer of the newest answered command.

    Attributes
    ----------
    driver: driver of the device (entry points of the group "fesloop.stimulators").
    port: port of the device, such as "/dev/ttyUSB0"; for `dry` the file of its log.
    channels: channels in use; 0 takes the number from the wire.
    frequency_hz: frequency at which the device repeats the newest pulses.
    charge_max_uc: the user's limit of a phase's charge (chosen: that of the `safety` block).
    hold_ms: time without a fresh command after which the keeper stops the device (chosen: four periods of
        40 Hz, longer than a plain kernel delays a loop, and as long as the rise of a single twitch, so that
        the muscle hardly follows an outdated command).
    """

    guarded: ClassVar[tuple[str, ...]] = ("stimulation",)

    driver: str = "dry"
    port: str = ""
    channels: int = 0
    frequency_hz: str = "40"
    charge_max_uc: float = 20.0
    hold_ms: float = 100.0

    def __post_init__(self) -> None:
        device = find_driver(self.driver).preset
        require_positive("stimulator_device", self, "charge_max_uc")
        if not _HOLD_RANGE_MS[0] <= self.hold_ms <= _HOLD_RANGE_MS[1]:
            raise InputError("hold_ms", f"{self.hold_ms:g}",
                             f"{_HOLD_RANGE_MS[0]:g} to {_HOLD_RANGE_MS[1]:g}")
        if not 0 <= self.channels <= device.channels:
            raise InputError("channels", f"{self.channels}",
                             f"1 to {device.channels}, the device's, or 0 for the number of wired channels")
        hertz = parse_rate(self.frequency_hz, "frequency_hz")
        if not device.frequency_min_hz <= hertz <= device.frequency_max_hz:
            raise InputError("frequency_hz", self.frequency_hz,
                             f"{device.frequency_min_hz:g} to {device.frequency_max_hz:g}")

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`stimulation`."""
        return (Port("stimulation", (self.channels or None, 2), "A,s"),)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`sent`, `answer`."""
        return Port("sent", (self.channels or None, 2), "A,s"), Port("answer", (), "s")

    @property
    def limits(self) -> Limits:
        """Ranges and resolutions of the device, and the user's limit, in A, s, C."""
        device = find_driver(self.driver).preset
        return Limits(device.current_max_ma / 1e3, device.current_step_ma / 1e3,
                      device.compliance_v / IEC_LOAD_OHM, device.width_min_us / 1e6,
                      device.width_max_us / 1e6, device.width_step_us / 1e6, self.charge_max_uc / 1e6)

    @property
    def stated_ms(self) -> tuple[float, float]:
        """Longest time from the last fresh command to zero current, ms: by keeper, and by device alone."""
        return stated_ms(find_driver(self.driver), self.hold_ms)

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> StimulatorDevice:
        """This block with the number of wired channels; InputError if the device has fewer."""
        return replace(self, channels=shapes["stimulation"][0])

    def faults(self, context: Context, surroundings: Surroundings) -> list[InputError]:
        """A `hold_ms` so short that a punctual loop would stop the device."""
        period_ms = 1e3 * context.clock.period_s if context.clock is not None else 0.0
        if self.hold_ms >= 2.0 * period_ms:
            return []
        return [InputError("hold_ms", f"{self.hold_ms:g}, with a command every {period_ms:g} ms",
                           f"at least two periods, {2.0 * period_ms:g}")]

    def faults_behind(self, guard: Block) -> list[InputError]:
        """A safety block that counts pulses at another frequency, so that its charge budgets fail."""
        counted: float | None = getattr(guard, "frequency_hz", None)
        if counted is None or counted == float(parse_rate(self.frequency_hz)):
            return []
        return [InputError("frequency_hz", f"{self.frequency_hz}, but the safety block counts {counted:g} "
                           "pulses a second", "the same frequency for both")]

    def cautions(self, context: Context) -> list[tuple[str, str]]:
        """Destination of current, stated times to zero current after a failure, and unmet requirements."""
        kept_ms, alone_ms = self.stated_ms
        where = f" at {self.port}" if self.port else ""
        cautions = [("device", f"commands go to `{self.driver}`{where}; zero current at most {kept_ms:g} ms "
                     f"after the last fresh command, {alone_ms:g} ms without keeper or line")]
        try:
            self._check_driver()
        except InputError as fault:
            cautions.append(("not_ready", str(fault)))
        return cautions

    def _check_driver(self) -> None:
        """Raise InputError for settings beyond the device, or a missing library or port."""
        find_driver(self.driver).check(self.port, self.channels, float(parse_rate(self.frequency_hz)))

    def stand_in(self) -> DeviceStandIn:
        """A block with the same ports and no device."""
        return DeviceStandIn(channels=self.channels)

    def init(self, context: Context) -> DeviceInUse:
        """Open the device, without current.

        Raises InputError for settings beyond the device, for a missing library and on another system than
        Linux, RunError if the device does not answer.
        """
        require_linux(f"blocks.{context.name}", "the process that holds a stimulator",
                      "run it on Linux; experiments without a device run here")
        driver: type[StimulatorDriver] = find_driver(self.driver)
        try:
            self._check_driver()
        except InputError as fault:
            raise InputError(f"blocks.{context.name}.{fault.where}", fault.found, fault.allowed,
                             fault.remedy) from None
        terms = Terms(driver=driver_place(self.driver), port=self.port, channels=self.channels,
                      hertz=float(parse_rate(self.frequency_hz)),
                      charge_max=self.limits.charge_max, hold_ms=self.hold_ms, loop=os.getpid())
        device = KeptDevice.started(context.name, terms, driver.answer_ms, driver.open_s)
        return DeviceInUse(device, [0] * self.channels)

    def attach(self, state: DeviceInUse, present: Present) -> None:
        """Take the wall-clock instant of t = 0, before which nothing is sent."""
        state.device.origin_ns = present.origin_ns

    def step(self, state: DeviceInUse, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Receive answers to earlier commands and send the newest.

        Raises RunError if the device is stopped, and outside real time.
        """
        if not state.device.origin_ns:
            raise RunError(f"{state.device.name}: commands go to a device in real time only")
        state.device.hear()
        of_ns = state.device.origin_ns + tick.time_ns
        behind = state.device.number < 0 and time.monotonic_ns() - of_ns > self.hold_ms * NS_PER_MS
        state.latch.put(tick, "loop_late", behind, "the loop starts late: no current until it has caught up")
        if behind:
            return np.zeros((self.channels, 2)), 0.0
        state.latch.put(tick, "keeper_ready", True, state.device.granted)
        limits, commands = self.limits, cast(Array, inputs[0].value)
        pulses = []
        for channel, (current, width) in enumerate(commands.tolist()):
            given, given_width, cut = given_pulse(limits, current, width, never_more=True)
            pulses.append((given, given_width))
            before, state.cut[channel] = state.cut[channel], cut
            for bit, status, detail in LIMITED:
                if cut & ~before & bit:
                    tick.report(status, f"channel {channel}: {detail} ({1e3 * current:g} mA, "
                                f"{1e6 * width:g} us)")
        state.device.send(pulses, of_ns)
        return np.array(pulses), state.device.answer_s

    def close(self, state: DeviceInUse) -> None:
        """Set zero current and end the keeper; RunError if the device does not confirm."""
        state.device.close()


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceStandIn:
    """Block with the ports of a stimulator and no device, for rehearsals.

    Attributes
    ----------
    channels: number of channels.
    """

    guarded: ClassVar[tuple[str, ...]] = ("stimulation",)

    channels: int

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`stimulation`."""
        return (Port("stimulation", (self.channels, 2), "A,s"),)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`sent`, `answer`."""
        return Port("sent", (self.channels, 2), "A,s"), Port("answer", (), "s")

    def init(self, context: Context) -> None:
        """No state."""

    def step(self, state: None, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Return the command."""
        return inputs[0].value, 0.0
