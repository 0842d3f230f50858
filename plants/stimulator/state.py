"""What `stimulator` remembers: commands under way, what its channels give, and the charge of it."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.block import Tick
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import NEVER, Sample
from plants.stimulator.channels import fault_of
from plants.stimulator.generations import IEC_DENSITY_MA_CM2, LIMITED, Limits, given_pulse
from plants.stimulator.kernels import tally

Array = NDArray[np.float64]


class Account(NamedTuple):
    """Charge of the pulses that are given; its arrays are never written to.

    Attributes
    ----------
    channel, channel_rate: (channels,), C a phase and C/s.
    element, element_rate: (elements,), C a phase (of the channel that gives it most) and C/s of all.
    density: (elements,), current density, r.m.s., mA/cm^2.
    """

    channel: Array
    channel_rate: Array
    element: Array
    element_rate: Array
    density: Array


@dataclass(slots=True, eq=False)
class StimulatorState:
    """A device in use.

    Attributes
    ----------
    limits: of the device; constants.
    hertz: stimulation frequency.
    area_cm2: of an element.
    latency_ns: from a command to the pulses that follow it.
    shares: (channels, elements), the multiplexing in force; never written to.
    command: (channels, 2), in force; never written to.
    given: (channels, 2), the newest pulse of each channel.
    account: of `given`.
    pending: commands under way, with the instants at which they come into force.
    command_ns, shares_ns: arrival of the newest message of each input.
    cut: (channels,), bits of what the newest pulse of each channel lacked.
    dense: elements whose current density calls for attention.
    """

    limits: Limits
    hertz: float
    area_cm2: float
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
        cls, limits: Limits, hertz: float, area_cm2: float, latency_ns: int, shares: Array
    ) -> StimulatorState:
        """A device that has no command yet."""
        channels = len(shares)
        idle = np.zeros((channels, 2))
        account = Account(*tally(idle, shares, hertz, area_cm2))
        return cls(limits, hertz, area_cm2, latency_ns, shares, idle, idle.copy(), account,
                   cut=[0] * channels)

    def take_command(self, sample: Sample, now_ns: int) -> None:
        """Queue a new command, and bring into force what is due."""
        if sample.arrived_ns > self.command_ns:
            self.command_ns = sample.arrived_ns
            self.pending.append((sample.arrived_ns + self.latency_ns, np.asarray(sample.value)))
        while self.pending and self.pending[0][0] <= now_ns:
            self.command = self.pending.popleft()[1]

    def take_shares(self, sample: Sample, tick: Tick) -> None:
        """Bring a new multiplexing into force; a faulty one is told and left."""
        if sample.arrived_ns <= self.shares_ns:
            return
        self.shares_ns = sample.arrived_ns
        shares = np.asarray(sample.value)
        fault = fault_of(shares)
        self.latch.put(tick, "bad_multiplexing", bool(fault), f"{fault}: the one before stays in force")
        if not fault and not np.array_equal(shares, self.shares):
            self.shares = shares
            self.count_charge(tick)

    def fire(self, channel: int, tick: Tick) -> None:
        """Settle the pulse that a channel gives now."""
        wished, width = self.command[channel].tolist()
        current, given_width, cut = given_pulse(self.limits, wished, width)
        before, self.cut[channel] = self.cut[channel], cut
        for bit, status, detail in LIMITED:
            if cut & ~before & bit:
                tick.report(status, f"channel {channel}: {detail} ({1e3 * wished:g} mA, {1e6 * width:g} us)")
        if self.given[channel, 0] != current or self.given[channel, 1] != given_width:
            self.given[channel] = current, given_width
            self.count_charge(tick)

    def count_charge(self, tick: Tick) -> None:
        """Account for the charge anew; elements whose current density has become too high are told."""
        self.account = Account(*tally(self.given, self.shares, self.hertz, self.area_cm2))
        density = self.account.density
        dense = frozenset((density > IEC_DENSITY_MA_CM2).nonzero()[0].tolist())
        joined = sorted(dense - self.dense)
        if joined:
            told = ", ".join(f"{element} ({density[element]:.2g})" for element in joined)
            tick.report("current_density", "calls for the operator's attention: above "
                        f"{IEC_DENSITY_MA_CM2:g} mA/cm2 r.m.s. under element {told}")
        self.dense = dense
