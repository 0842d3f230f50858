"""`stimulator_device`: a real stimulator at the end of the loop."""

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
from fesloop.loop.abilities import Surroundings
from fesloop.loop.block import Block, Context, Tick
from fesloop.loop.clock import NS_PER_MS, parse_rate
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample, Value
from plants.checks import require_positive
from plants.devices.driver import StimulatorDriver, stated_ms
from plants.devices.kept_device import KeptDevice
from plants.devices.messages import Terms
from plants.stimulator.generations import IEC_LOAD_OHM, LIMITED, Limits, given_pulse

if TYPE_CHECKING:
    from fesloop.loop.abilities import Present

GROUP = "fesloop.stimulators"


@cache
def _entries() -> dict[str, EntryPoint]:
    return {entry.name: entry for entry in entry_points(group=GROUP)}


def driver_names() -> list[str]:
    """Every registered driver."""
    return sorted(_entries())


def driver_place(name: str) -> str:
    """Where the driver of that name is, as "module:Class"; InputError where there is none."""
    if name not in _entries():
        raise InputError("driver", f"there is no stimulator driver {name!r}", ", ".join(driver_names()),
                         did_you_mean(name, driver_names()))
    return _entries()[name].value


def find_driver(name: str) -> type[StimulatorDriver]:
    """The driver's class; InputError for one that does not exist or does not import."""
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
    """A device in use.

    Attributes
    ----------
    device: with its keeper.
    cut: bits of what the newest command of each channel lacked.
    """

    device: KeptDevice
    cut: list[int] = field(default_factory=list)
    latch: StatusLatch = field(default_factory=StatusLatch)


@dataclass(frozen=True, slots=True, kw_only=True)
class StimulatorDevice:
    """A stimulator outside this computer, in the hands of a keeper.

    At every tick the newest command goes to the keeper, a process of its own that alone holds the device
    (`plants.devices.keeper`), without waiting for anything. What the device cannot give is cut and told as
    `stimulator` tells it; numbers are rounded down to the device's steps, so that nobody gets more than the
    safety block let through. The keeper stops the device, for good, without a fresh command for `hold_ms`,
    when the loop's process ends, and when device or line fail; the run then fails at its next tick, with the
    cause. A command belongs to the instant of its tick: that of a loop which lags so far behind the wall
    clock is not fresh any more, and where a loop begins so nothing is given until it has caught up (status
    `loop_late`). What the loop's process or the keeper suffer, current at the device is zero within the time
    that `fesloop check` states. It runs in real time only (`fesloop run --realtime`), and `stimulation` must
    come straight from a `safety` block whose `frequency_hz` is the same, for it counts the pulses given.
    Status `keeper_ready` says what the operating system grants the keeper.

    Inputs: `stimulation` (channels, 2), current, A, and pulse width, s. Outputs: `sent` (channels, 2), what
    went to the device; `answer`, s, from sending to the device's answer, of the newest command answered.

    Attributes
    ----------
    driver: speaks to the device (entry points of the group "fesloop.stimulators").
    port: where the device is, such as "/dev/ttyUSB0"; for `dry` the file of its log.
    channels: in use; 0 takes them from what is wired in.
    frequency_hz: at which the device repeats the newest pulses.
    charge_max_uc: the user's limit of a phase's charge (chosen: that of the `safety` block).
    hold_ms: without a fresh command for so long the keeper stops the device (chosen: four periods of 40 Hz,
        beyond what a plain kernel delays a loop, and as long as the rise of a single twitch, so that the
        muscle hardly follows what nobody commands any more).
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
                             f"1 to {device.channels}, the device's, or 0 for what is wired in")
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
        """Ranges and resolutions, and the user's limit, in A, s, C."""
        device = find_driver(self.driver).preset
        return Limits(device.current_max_ma / 1e3, device.current_step_ma / 1e3,
                      device.compliance_v / IEC_LOAD_OHM, device.width_min_us / 1e6,
                      device.width_max_us / 1e6, device.width_step_us / 1e6, self.charge_max_uc / 1e6)

    @property
    def stated_ms(self) -> tuple[float, float]:
        """The longest from the last fresh command to zero current, ms: by the keeper, by the device alone."""
        return stated_ms(find_driver(self.driver), self.hold_ms)

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> StimulatorDevice:
        """For the number of channels that is wired in; raises InputError where the device has fewer."""
        return replace(self, channels=shapes["stimulation"][0])

    def faults(self, context: Context, surroundings: Surroundings) -> list[InputError]:
        """A device that would be stopped by a loop that is never late."""
        period_ms = 1e3 * context.clock.period_s if context.clock is not None else 0.0
        if self.hold_ms >= 2.0 * period_ms:
            return []
        return [InputError("hold_ms", f"{self.hold_ms:g}, with a command every {period_ms:g} ms",
                           f"at least two periods, {2.0 * period_ms:g}")]

    def faults_behind(self, guard: Block) -> list[InputError]:
        """A guard that counts other pulses than are given: its budgets of charge would not hold."""
        counted: float | None = getattr(guard, "frequency_hz", None)
        if counted is None or counted == float(parse_rate(self.frequency_hz)):
            return []
        return [InputError("frequency_hz", f"{self.frequency_hz}, and the safety block counts {counted:g} "
                           "pulses a second", "the same for both")]

    def cautions(self, context: Context) -> list[tuple[str, str]]:
        """Where current goes, when it ends if something fails, and what a run would lack now."""
        kept_ms, alone_ms = self.stated_ms
        where = f" at {self.port}" if self.port else ""
        told = [("device", f"commands go to `{self.driver}`{where}; zero current at most {kept_ms:g} ms "
                 f"after the last fresh command, {alone_ms:g} ms where keeper or line are cut off")]
        try:
            self._check_driver()
        except InputError as fault:
            told.append(("not_ready", str(fault)))
        return told

    def _check_driver(self) -> None:
        """Raise InputError for what the driver says now that the device cannot do, or that is missing."""
        find_driver(self.driver).check(self.port, self.channels, float(parse_rate(self.frequency_hz)))

    def stand_in(self) -> DeviceStandIn:
        """The same ports, and nothing behind them."""
        return DeviceStandIn(channels=self.channels)

    def init(self, context: Context) -> DeviceInUse:
        """The device, open and giving nothing.

        Raises InputError for what the device cannot do and for a driver that is not installed, RunError where
        it does not answer.
        """
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
        """Know when t = 0 is, without which nothing is sent."""
        state.device.origin_ns = present.origin_ns

    def step(self, state: DeviceInUse, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Hear what became of earlier commands, send the newest.

        RunError where the device is stopped, and in a loop that is not in step with the wall clock.
        """
        if not state.device.origin_ns:
            raise RunError(f"{state.device.name}: commands go to a device in real time only")
        state.device.hear()
        of_ns = state.device.origin_ns + tick.time_ns
        behind = state.device.number < 0 and time.monotonic_ns() - of_ns > self.hold_ms * NS_PER_MS
        state.latch.put(tick, "loop_late", behind, "the loop begins late: nothing is given until it keeps up")
        if behind:
            return np.zeros((self.channels, 2)), 0.0
        state.latch.put(tick, "keeper_ready", True, state.device.granted)
        limits, wanted = self.limits, cast(Array, inputs[0].value)
        pulses = []
        for channel, (current, width) in enumerate(wanted.tolist()):
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
        """Zero current, and the keeper's end; RunError where the device does not confirm it."""
        state.device.close()


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceStandIn:
    """The ports of a stimulator, for rehearsals.

    Attributes
    ----------
    channels: as the device's.
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
        """There is nothing to remember."""

    def step(self, state: None, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """The command, which goes nowhere."""
        return inputs[0].value, 0.0
