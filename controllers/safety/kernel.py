"""The arithmetic of the safety limits, channel by channel."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.guard import is_finite
from fesloop.loop.signals import NEVER, Sample

Array = NDArray[np.float64]
TEST_LOAD_OHM = 500.0
"""Load of IEC 60601-2-10 into which the energy of a pulse is reckoned."""
PHASES = 2.0
"""Both phases of a biphasic pulse deliver energy."""
SIGN, CURRENT, WIDTH, CHARGE, ENERGY, SLEW, RATE, TOTAL = 1, 2, 4, 8, 16, 32, 64, 128
"""Bits of what was limited."""
LIMITED = ((SIGN, "negative", "a negative current or width: no pulse"),
           (CURRENT, "current_limited", "current above its limit"),
           (WIDTH, "width_limited", "pulse width above its limit"),
           (CHARGE, "charge_limited", "charge per phase above its limit"),
           (ENERGY, "energy_limited", "energy per pulse above its limit"),
           (SLEW, "slew_limited", "charge rises faster than its limit"),
           (RATE, "charge_rate_limited", "the charge of one second is used up"),
           (TOTAL, "charge_exhausted", "the charge of the whole run is used up"))
"""Status and detail of each."""
ROUND_OFF = 1e-3
"""Of a period: ticks lie on whole ns."""
_SHAVE = 1.0 - 2.0**-51
"""Takes a rounded quotient below the limit that it was made for."""
_SHAVE_SUM = 1.0 - 2.0**-40
"""The same for sums of up to thousands of messages, in whatever order they are added."""


@compiled
def limit_pulses(wanted: Array, limits: Array, charges: Array) -> tuple[int, Array]:
    """(bits of what was limited, pulses (channels, 2) within the limits).

    Parameters
    ----------
    wanted: (channels, 2), finite, A and s.
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
    """Shorten pulses to what is left of the budgets; bits of what was limited.

    Parameters
    ----------
    pulses: (channels, 2), A and s; shortened in place.
    charges: (channels,), charge per phase of `pulses`, C; updated in place.
    phases: how many of a message's pulses are given before the next message.
    second: (channels,), what was given within the window that ends with this message, C.
    total: (channels,), what was given before this message, C; this message's is added.
    budgets: (channels, 2): in the window, in all, C.
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
    """Shorten pulses (channels, 2) to the charge of the tick before, in place; `charges` becomes theirs."""
    for i in range(pulses.shape[0]):
        if pulses[i, 0] * pulses[i, 1] > charges[i]:
            pulses[i, 1] = charges[i] / pulses[i, 0] * _SHAVE
        charges[i] = pulses[i, 0] * pulses[i, 1]


@dataclass(slots=True, eq=False)
class Dose:
    """Charge given on each channel.

    Attributes
    ----------
    budgets: as `limit_dose` takes them; never written to.
    frequency_hz: of the device, which repeats each message at it.
    phases: pulses that the device gives of each message.
    given: (ticks of a second, channels), C of each message, by its number modulo their count.
    total: (channels,), C since the run began.
    index, time_ns: of the tick before, and its instant.
    """

    budgets: Array
    frequency_hz: float
    phases: float
    given: Array
    total: Array
    index: int = -1
    time_ns: int = 0

    def book_repeated(self, charges: Array, now_ns: int) -> None:
        """Add what the device gave of `charges` beyond the period of the tick before, if this one is late."""
        pulses = self.frequency_hz * (now_ns - self.time_ns) / NS_PER_S - self.phases
        if self.index >= 0 and pulses > ROUND_OFF * self.phases:
            self.given[self.index % len(self.given)] += pulses * charges
            self.total += pulses * charges
        self.time_ns = now_ns

    def limit(self, pulses: Array, charges: Array, index: int) -> int:
        """Shorten what the budgets do not hold, and book the rest; bits of what was limited."""
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
    """What is remembered of the tracker.

    Attributes
    ----------
    last: posture read last; None before any.
    newest_ns: newest capture behind it.
    changed_ns: newest capture of the posture that was the last to differ from the one before.
    fault: status that keeps stimulation off, "" for none.
    sound_ns: since when the tracker has been sound again; NEVER while it is not.
    """

    last: Array | None = None
    newest_ns: int = NEVER
    changed_ns: int = NEVER
    fault: str = ""
    sound_ns: int = NEVER


@dataclass(frozen=True, slots=True, kw_only=True)
class Watchdog:
    """When a tracker counts as failed.

    Attributes
    ----------
    silence_ms: longest time without a new message (chosen: two periods of 40 Hz).
    frozen_ms: for how long fresh captures may hold the same posture to the last bit; 0: not watched, as for
        noise-free trackers of a hand that rests (chosen: two samples of 100 Hz; real samples have noise).
    rate_max_deg_s: fastest physiological angle (chosen: half as fast again as a flicked finger's 1000).
    jump_deg: what may be added to that between two samples (chosen: a tracker's own corrections).
    sd_max_deg: greatest standard deviation of an angle (chosen: posture unknown, not merely inexact).
    recover_s: after so long of sound samples stimulation may begin anew; 0: not in this trial.
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
        """(status, detail) of what keeps stimulation off now, `SOUND` if nothing; remembers what is read.

        What happens while nothing is stimulated, such as a tracker finding its posture, passes when it is
        over; what happens under stimulation lasts, as a tracker that jumped and stands still looks sound.
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
        """Whether there is a posture at all that can be read."""
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
        """Whether a hand can have moved so since the posture read before; takes this one in."""
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
            return "posture_frozen", f"not a bit has changed for {frozen_ns / NS_PER_MS:.3g} ms: ramp to zero"
        return SOUND
