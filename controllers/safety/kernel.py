"""Arithmetic of the safety limits of each channel, and the watchdog of the tracker."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.signals import NEVER, Sample, is_finite

Array = NDArray[np.float64]
TEST_LOAD_OHM = 500.0
"""Load of IEC 60601-2-10, for the energy of a pulse."""
PHASES = 2.0
"""Both phases of a biphasic pulse deliver energy."""
SIGN, CURRENT, WIDTH, CHARGE, ENERGY, SLEW, RATE, TOTAL = 1, 2, 4, 8, 16, 32, 64, 128
"""Bits of the limits that acted."""
LIMITED = ((SIGN, "negative", "a negative current or width: no pulse"),
           (CURRENT, "current_limited", "current above its limit"),
           (WIDTH, "width_limited", "pulse width above its limit"),
           (CHARGE, "charge_limited", "charge per phase above its limit"),
           (ENERGY, "energy_limited", "energy per pulse above its limit"),
           (SLEW, "slew_limited", "charge rises faster than its limit"),
           (RATE, "charge_rate_limited", "the charge of one second is used up"),
           (TOTAL, "charge_exhausted", "the charge of the whole run is used up"))
"""Status and detail of each bit."""
ROUND_OFF = 1e-3
"""Tolerance as a share of a period: ticks lie on whole ns."""
_SHAVE = 1.0 - 2.0**-51
"""Factor that brings a rounded quotient below its limit."""
_SHAVE_SUM = 1.0 - 2.0**-40
"""The same for sums of up to thousands of messages, in whatever order they are added."""


@compiled
def limit_pulses(wanted: Array, limits: Array, charges: Array) -> tuple[int, Array]:
    """Bits of the limits that acted, and pulses (channels, 2) within the limits.

    Parameters
    ----------
    wanted: (channels, 2), requested pulses, finite, A and s.
    limits: (channels, 5): current A, width s, charge C, energy J, rise of charge C a tick.
    charges: (channels,), charge per phase of the tick before, C; updated in place.
    """
    hit = 0
    pulses = np.zeros((wanted.shape[0], 2))
    for i in range(wanted.shape[0]):
        current, width = wanted[i, 0], wanted[i, 1]
        if current < 0.0 or width < 0.0:
            hit |= SIGN
            current = 0.0
        if current > limits[i, 0]:
            hit |= CURRENT
            current = limits[i, 0]
        if width > limits[i, 1]:
            hit |= WIDTH
            width = limits[i, 1]
        if current <= 0.0 or width <= 0.0:
            charges[i] = 0.0
            continue
        if current * width > limits[i, 2]:
            hit |= CHARGE
            width = limits[i, 2] / current * _SHAVE
        energy_per_s = PHASES * TEST_LOAD_OHM * current * current
        if energy_per_s * width > limits[i, 3]:
            hit |= ENERGY
            width = limits[i, 3] / energy_per_s * _SHAVE
        if current * width > charges[i] + limits[i, 4]:
            hit |= SLEW
            width = (charges[i] + limits[i, 4]) / current * _SHAVE
        charges[i] = current * width
        pulses[i, 0], pulses[i, 1] = current, width
    return hit, pulses


@compiled
def limit_dose(pulses: Array, charges: Array, phases: float, second: Array, total: Array,
               budgets: Array) -> int:
    """Shorten pulses to the remaining charge; return the bits of the limits that acted.

    Parameters
    ----------
    pulses: (channels, 2), A and s; shortened in place.
    charges: (channels,), charge per phase of `pulses`, C; updated in place.
    phases: number of pulses that the device gives of a message before the next one.
    second: (channels,), charge given in the window that ends with this message, C.
    total: (channels,), charge given before this message, C; this message's is added.
    budgets: (channels, 2), limits in the window and in total, C.
    """
    hit = 0
    for i in range(pulses.shape[0]):
        left_now, left_ever = budgets[i, 0] - second[i], budgets[i, 1] - total[i]
        left = max(0.0, min(left_now, left_ever)) / phases * _SHAVE_SUM
        if charges[i] > left:
            hit |= RATE if left_now <= left_ever else TOTAL
            pulses[i, 1] = left / pulses[i, 0]
            if pulses[i, 1] == 0.0:
                pulses[i, 0] = 0.0
            charges[i] = pulses[i, 0] * pulses[i, 1]
        total[i] += phases * charges[i]
    return hit


@compiled
def fall(pulses: Array, charges: Array) -> None:
    """Shorten pulses (channels, 2) to the charge of the tick before, and update `charges`, in place."""
    for i in range(pulses.shape[0]):
        if pulses[i, 0] * pulses[i, 1] > charges[i]:
            pulses[i, 1] = charges[i] / pulses[i, 0] * _SHAVE
        charges[i] = pulses[i, 0] * pulses[i, 1]


@dataclass(slots=True, eq=False)
class Dose:
    """Charge given on each channel.

    Attributes
    ----------
    budgets: constant argument of `limit_dose`.
    frequency_hz: rate at which the device repeats each message.
    phases: number of pulses of each message.
    given: (ticks of a second, channels), charge of each message, C, at its number modulo their count.
    total: (channels,), charge since the run began, C.
    index, time_ns: number and instant of the tick before.
    """

    budgets: Array
    frequency_hz: float
    phases: float
    given: Array
    total: Array
    index: int = -1
    time_ns: int = 0

    def book_repeated(self, charges: Array, now_ns: int) -> None:
        """Add the charge that the device repeated after the last tick's period, if this tick is late."""
        pulses = self.frequency_hz * (now_ns - self.time_ns) / NS_PER_S - self.phases
        if self.index >= 0 and pulses > ROUND_OFF * self.phases:
            self.given[self.index % len(self.given)] += pulses * charges
            self.total += pulses * charges
        self.time_ns = now_ns

    def limit(self, pulses: Array, charges: Array, index: int) -> int:
        """Shorten pulses to the remaining charge and book them; return the bits of the limits that acted."""
        ticks = len(self.given)
        for skipped in range(max(self.index + 1, index - ticks + 1), index + 1):
            self.given[skipped % ticks] = 0.0
        hit: int = limit_dose(pulses, charges, self.phases, self.given.sum(axis=0), self.total,
                                     self.budgets)
        self.given[index % ticks] = self.phases * charges
        self.index = index
        return hit


SOUND = ("", "")


@dataclass(slots=True, eq=False)
class WatchState:
    """State of the watchdog.

    Attributes
    ----------
    last: last posture; None before the first.
    newest_ns: its newest capture.
    changed_ns: newest capture of the last posture that differed from the one before.
    fault: status that prevents stimulation; "" for none.
    sound_ns: instant from which the tracker has been sound again; NEVER while it is not.
    """

    last: Array | None = None
    newest_ns: int = NEVER
    changed_ns: int = NEVER
    fault: str = ""
    sound_ns: int = NEVER


@dataclass(frozen=True, slots=True, kw_only=True)
class Watchdog:
    """Limits beyond which a tracker counts as failed.

    Attributes
    ----------
    silence_ms: longest time without a new message (chosen: two periods of 40 Hz).
    frozen_ms: longest time in which new captures may have the same posture to the last bit; 0: no limit, for
        noise-free trackers of a resting hand (chosen: two samples of 100 Hz; real samples have noise).
    rate_max_deg_s: fastest physiological rate (chosen: 1.5 times a flicked finger's 1000).
    jump_deg: additional change allowed between two samples (chosen: a tracker's own corrections).
    sd_max_deg: greatest standard deviation of an angle (chosen: posture unknown, not merely inexact).
    recover_s: duration of sound samples after which stimulation may restart; 0: not in this trial.
    """

    silence_ms: float = 50.0
    frozen_ms: float = 20.0
    rate_max_deg_s: float = 1500.0
    jump_deg: float = 10.0
    sd_max_deg: float = 90.0
    recover_s: float = 0.0

    def __post_init__(self) -> None:
        for key in ("silence_ms", "rate_max_deg_s", "sd_max_deg"):
            if not (math.isfinite(getattr(self, key)) and getattr(self, key) > 0.0):
                raise InputError(f"watchdog.{key}", f"{getattr(self, key)}", "a finite value above 0")
        if not (math.isfinite(self.jump_deg) and self.jump_deg >= 0.0):
            raise InputError("watchdog.jump_deg", f"{self.jump_deg}", "0 or more")
        duration_ns(self.frozen_ms, NS_PER_MS, "watchdog.frozen_ms")
        duration_ns(self.recover_s, NS_PER_S, "watchdog.recover_s")

    def look(self, state: WatchState, posture: Sample, sd: Sample, now_ns: int, max_age_ms: float,
             stimulating: bool) -> tuple[str, str]:
        """Status and detail of the reason against stimulation, `SOUND` without one; records the input.

        A fault without stimulation, such as a tracker that settles, ends when it is over; a fault under
        stimulation persists, because a tracker that jumped and then stays still looks sound.
        """
        found = self._present(posture, sd, now_ns, max_age_ms)
        if found == SOUND:
            found = self._plausible(state, posture)
        if found != SOUND:
            state.fault = found[0] if stimulating else state.fault
            state.sound_ns = NEVER
            return found
        if not state.fault:
            return SOUND
        if state.sound_ns < 0:
            state.sound_ns = now_ns
        if self.recover_s > 0.0 and now_ns - state.sound_ns >= self.recover_s * NS_PER_S:
            state.fault = ""
            return SOUND
        return state.fault, "the tracker failed"

    def _present(self, posture: Sample, sd: Sample, now_ns: int, max_age_ms: float) -> tuple[str, str]:
        """Faults of a missing, old, non-finite or uncertain posture."""
        if not posture.present:
            return "no_posture", "no posture has arrived: no stimulation"
        if not is_finite(posture.value):
            return "posture_non_finite", "posture is not finite: ramp to zero"
        if now_ns - posture.arrived_ns > self.silence_ms * NS_PER_MS:
            return "posture_silent", f"no posture for more than {self.silence_ms:g} ms: ramp to zero"
        if now_ns - posture.oldest_ns > max_age_ms * NS_PER_MS:
            return "posture_stale", f"posture older than {max_age_ms:g} ms: ramp to zero"
        if sd.present and not np.all((sd.value >= 0.0) & (sd.value <= math.radians(self.sd_max_deg))):
            return "posture_uncertain", f"sd of posture is not in 0 to {self.sd_max_deg:g} deg: ramp to zero"
        return SOUND

    def _plausible(self, state: WatchState, posture: Sample) -> tuple[str, str]:
        """Faults of a change that no hand makes, or of a frozen posture; records the posture."""
        value, before = cast(Array, posture.value), state.last
        if before is not None and posture.newest_ns == state.newest_ns and np.array_equal(before, value):
            return SOUND
        elapsed_s = max(0, posture.newest_ns - state.newest_ns) / NS_PER_S
        state.last, state.newest_ns = value, posture.newest_ns
        if before is None:
            state.changed_ns = posture.newest_ns
            return SOUND
        moved_deg = math.degrees(np.max(np.abs(value - before), initial=0.0))
        if moved_deg > 0.0:
            state.changed_ns = posture.newest_ns
        if moved_deg > self.jump_deg + self.rate_max_deg_s * elapsed_s:
            return "posture_jumped", f"{moved_deg:.3g} deg within {1e3 * elapsed_s:.3g} ms: ramp to zero"
        frozen_ns = posture.newest_ns - state.changed_ns
        if self.frozen_ms > 0.0 and frozen_ns >= self.frozen_ms * NS_PER_MS:
            return "posture_frozen", (f"posture is exactly constant for {frozen_ns / NS_PER_MS:.3g} ms: "
                                      "ramp to zero")
        return SOUND
