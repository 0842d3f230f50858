"""Safety limits between a controller and a stimulator."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from controllers.safety_kernel import CHARGE, CURRENT, ENERGY, SIGN, SLEW, WIDTH, limit_pulses
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, duration_ns
from fesloop.loop.guard import is_finite
from fesloop.loop.signals import NEVER, Port, Sample, Value
from fesloop.loop.status import StatusLatch

Array = NDArray[np.float64]
ENERGY_MAX_J = 0.3
"""Greatest energy of a pulse into 500 ohm of IEC 60601-2-10 (transcutaneous stimulators)."""
_LIMITED = ((SIGN, "negative", "a negative current or width: no pulse"),
            (CURRENT, "current_limited", "current above its limit"),
            (WIDTH, "width_limited", "pulse width above its limit"),
            (CHARGE, "charge_limited", "charge per phase above its limit"),
            (ENERGY, "energy_limited", "energy per pulse above its limit"),
            (SLEW, "slew_limited", "charge rises faster than its limit"))


@dataclass(slots=True, eq=False)
class SafetyState:
    """What was let through last.

    Attributes
    ----------
    limits: as `limit_pulses` takes them; never written to.
    charges: (channels,), charge per phase of the tick before, C.
    accepted: (channels, 2), the last pulses let through from good input.
    ramp_from_ns: when the ramp to zero began; NEVER while the input is good.
    hit: bits of what was limited at the tick before.
    """

    limits: Array
    charges: Array
    accepted: Array
    ramp_from_ns: int = NEVER
    hit: int = 0
    latch: StatusLatch = field(default_factory=StatusLatch)


@dataclass(frozen=True, slots=True, kw_only=True)
class Safety:
    """Limits what reaches the stimulator, whatever comes in.

    Current and pulse width are cut first; charge per phase, energy per pulse and the rise of charge a
    tick are then met by shortening the pulse. A fall of charge is never limited. Input that is older than
    `max_age_ms`, counted from the oldest capture behind it, or not finite, ramps the last good pulses to
    zero. Every limitation is a status when it begins. The terms are those of IEC 60601-2-10 (300 mJ a
    pulse into 500 ohm, both phases counted); no certification is meant.

    Attributes
    ----------
    channels: number of channels; 0 takes it from what is wired in.
    current_max_ma, width_max_us, charge_max_uc, energy_max_mj: of each channel.
    charge_rise_uc: greatest rise of charge per phase from one tick to the next.
    max_age_ms: of the input.
    ramp_ms: length of the ramp to zero; 0 cuts at once.

    Input and output: `stimulation` (channels, 2).
    """

    channels: int = 0
    current_max_ma: float = 60.0
    width_max_us: float = 500.0
    charge_max_uc: float = 20.0
    energy_max_mj: float = 1e3 * ENERGY_MAX_J
    charge_rise_uc: float = 5.0
    max_age_ms: float = 500.0
    ramp_ms: float = 200.0

    def __post_init__(self) -> None:
        if self.channels < 0:
            raise InputError("channels", f"{self.channels}", "1 or more, or 0 for what is wired in")
        for key in ("current_max_ma", "width_max_us", "charge_max_uc", "energy_max_mj", "charge_rise_uc"):
            value = getattr(self, key)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(key, f"{value}", "a finite limit above 0")
        if self.energy_max_mj > 1e3 * ENERGY_MAX_J:
            raise InputError("energy_max_mj", f"{self.energy_max_mj}", f"at most {1e3 * ENERGY_MAX_J:g}")
        duration_ns(self.max_age_ms, NS_PER_MS, "max_age_ms")
        duration_ns(self.ramp_ms, NS_PER_MS, "ramp_ms")

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`stimulation`."""
        return (Port("stimulation", (self.channels or None, 2), "A,s"),)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`stimulation`."""
        return (Port("stimulation", (self.channels or None, 2), "A,s"),)

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> Safety:
        """For the number of channels that is wired in."""
        return replace(self, channels=shapes["stimulation"][0])

    def init(self, context: Context) -> SafetyState:
        """Nothing let through yet."""
        limits = np.array([self.current_max_ma / 1e3, self.width_max_us / 1e6, self.charge_max_uc / 1e6,
                           self.energy_max_mj / 1e3, self.charge_rise_uc / 1e6])
        return SafetyState(limits, np.zeros(self.channels), np.zeros((self.channels, 2)))

    def step(self, state: SafetyState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Pulses within the limits."""
        value, oldest_ns, _, arrived_ns = inputs[0]
        pulses = cast(Array, value)
        fresh = arrived_ns >= 0 and tick.time_ns - oldest_ns <= self.max_age_ms * NS_PER_MS
        if not (fresh and is_finite(pulses)):
            return (self._ramp(state, tick, arrived_ns >= 0, fresh),)
        if state.ramp_from_ns >= 0:
            state.ramp_from_ns = NEVER
            state.latch.holding.clear()
        hit, limited = limit_pulses(pulses, state.limits, state.charges)
        if hit != state.hit:
            self._report(state, hit, tick)
        state.accepted = limited
        return (limited,)

    def _ramp(self, state: SafetyState, tick: Tick, arrived: bool, fresh: bool) -> Array:
        """The last good pulses, shortened linearly to nothing."""
        if not arrived:
            state.latch.put(tick, "no_input", True, "nothing has arrived: no stimulation")
        else:
            state.latch.put(tick, "stale_input", not fresh,
                            f"older than {self.max_age_ms:g} ms: ramp to zero")
            state.latch.put(tick, "non_finite", fresh, "input is not finite: ramp to zero")
        if state.ramp_from_ns < 0:
            state.ramp_from_ns = tick.time_ns
        elapsed_ms = (tick.time_ns - state.ramp_from_ns) / NS_PER_MS
        share = 1.0 - elapsed_ms / self.ramp_ms if elapsed_ms < self.ramp_ms else 0.0
        pulses: Array = state.accepted * (1.0, share) if share > 0.0 else np.zeros((self.channels, 2))
        state.charges = pulses[:, 0] * pulses[:, 1]
        return pulses

    def _report(self, state: SafetyState, hit: int, tick: Tick) -> None:
        """Tell the limitations that begin with this tick."""
        for bit, status, detail in _LIMITED:
            if hit & ~state.hit & bit:
                tick.report(status, detail)
        state.hit = hit
