"""What `stimulator` remembers: commands under way, what its channels give, and the charge of it."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.loop.block import Tick
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import NEVER, Sample
from plants.checks import require_positive
from plants.stimulator.generations import IEC_DENSITY_MA_CM2, LIMITED, Limits, given_pulse

Array = NDArray[np.float64]
_TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualElectrode:
    """Elements that share a channel's current.

    Attributes
    ----------
    elements: their numbers.
    shares: of the current, adding up to 1; empty: equal ones.
    """

    elements: tuple[int, ...]
    shares: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not self.elements or len(set(self.elements)) < len(self.elements) or min(self.elements) < 0:
            raise InputError("virtual_electrode.elements", f"{self.elements}",
                             "one or more numbers, each once")
        if self.shares:
            require_positive("virtual_electrode", self, "shares")
            if len(self.shares) != len(self.elements) or abs(sum(self.shares) - 1.0) > _TOLERANCE:
                raise InputError("virtual_electrode.shares", f"{self.shares}",
                                 f"{len(self.elements)} numbers, one an element, that add up to 1")


def multiplexing(electrodes: Sequence[VirtualElectrode], channels: int, elements: int) -> Array:
    """Share of each channel's current that each element has, (channels, elements).

    Without electrodes channel c has element c. Raises InputError for elements that do not exist and for
    another number of electrodes than channels.
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
    """What is wrong with shares (channels, elements); empty where nothing is.

    Every row holds no number below 0 and adds up to 1, or to 0 for a channel that is switched onto nothing.
    """
    if not np.isfinite(shares).all() or (shares < 0.0).any():
        return "a share is negative or not finite"
    total = shares.sum(axis=1)
    wrong = np.flatnonzero((np.abs(total - 1.0) > _TOLERANCE) & (total != 0.0))
    if not wrong.size:
        return ""
    return f"the shares of channel {wrong[0]} add up to {total[wrong[0]]:g}, not to 1 or 0"


@compiled
def share_out(given: Array, shares: Array, hertz: float, elements: Array) -> None:
    """Put a pulse, current and width (2,), on the `elements` (e, 3) that have `shares` (e,) of it."""
    if given[0] > 0.0:
        for e in range(shares.size):
            if shares[e] > 0.0:
                elements[e, 0] = given[0] * shares[e]
                elements[e, 1] = given[1]
                elements[e, 2] = hertz


@compiled
def tally(
    given: Array, shares: Array, hertz: float, area_cm2: float
) -> tuple[Array, Array, Array, Array, Array]:
    """Account for biphasic pulses (channels, 2), each given `hertz` times a second through `shares`.

    Charge of each channel, C a phase and C/s; of each element, C a phase (of the channel that gives it most)
    and C/s of all channels; and the r.m.s. current density under it, mA/cm^2. Over a period the mean square
    of a pulse I, w is 2 I^2 w f: both phases count.
    """
    channels, elements = shares.shape
    charge, charge_rate = np.empty(channels), np.empty(channels)
    most, rate, density = np.zeros(elements), np.zeros(elements), np.zeros(elements)
    for c in range(channels):
        charge[c] = given[c, 0] * given[c, 1]
        charge_rate[c] = charge[c] * hertz
        for e in range(elements):
            share = shares[c, e]
            if share > 0.0:
                most[e] = max(most[e], share * charge[c])
                rate[e] += share * charge_rate[c]
                density[e] += 2.0 * (share * given[c, 0]) ** 2 * given[c, 1] * hertz
    for e in range(elements):
        density[e] = 1e3 * math.sqrt(density[e]) / area_cm2
    return charge, charge_rate, most, rate, density


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
