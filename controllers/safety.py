"""`safety`: limits between a controller and a stimulator."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, cast

import numpy as np
from numpy.typing import NDArray

from controllers.timing import period_ns
from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.loop.abilities import AgeLimit
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import NEVER, Port, Sample, Value, is_finite
from fesloop.models.linear_form import BlockToControl, SampledForm, memoryless

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
        """Status and detail of the fault that blocks stimulation, or `SOUND`; updates the watchdog's state.

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
        # Halves do not overflow, whatever is finite.
        moved_deg = math.degrees(2.0 * float(np.max(np.abs(0.5 * value - 0.5 * before), initial=0.0)))
        if moved_deg > 0.0:
            state.changed_ns = posture.newest_ns
        if moved_deg > self.jump_deg + self.rate_max_deg_s * elapsed_s:
            return "posture_jumped", f"{moved_deg:.3g} deg within {1e3 * elapsed_s:.3g} ms: ramp to zero"
        frozen_ns = posture.newest_ns - state.changed_ns
        if self.frozen_ms > 0.0 and frozen_ns >= self.frozen_ms * NS_PER_MS:
            return "posture_frozen", (f"posture is exactly constant for {frozen_ns / NS_PER_MS:.3g} ms: "
                                      "ramp to zero")
        return SOUND


PerChannel = float | tuple[float, ...]
ENERGY_MAX_J = 0.3
"""Greatest energy of a pulse into 500 ohm by IEC 60601-2-10 (transcutaneous stimulators)."""
_LIMITS = ("current_max_ma", "width_max_us", "charge_max_uc", "energy_max_mj", "charge_rise_uc")
_BUDGETS = ("charge_per_s_max_uc", "charge_total_max_mc")
_USUAL = Watchdog()


@dataclass(slots=True, eq=False)
class SafetyState:
    """State of the limits: the last pulses and the charge given so far.

    Attributes
    ----------
    limits: constant argument of `limit_pulses`.
    dose: charge given, and its limits.
    charges: (channels,), charge per phase of the tick before, C.
    accepted: (channels, 2), last pulses from sound input.
    ramp_from_ns: start of the ramp to zero; NEVER while the input is sound.
    stopped: whether the emergency stop was ever on.
    hit: bits of the limits that acted in the tick before.
    aligned_ns: first tick of all those since which `aligned` has been 1; NEVER while it is not.
    """

    limits: Array
    dose: Dose
    charges: Array
    accepted: Array
    watch: WatchState
    ramp_from_ns: int = NEVER
    stopped: bool = False
    hit: int = 0
    aligned_ns: int = NEVER
    latch: StatusLatch = field(default_factory=StatusLatch)


@dataclass(frozen=True, slots=True, kw_only=True)
class Safety(BlockToControl):
    """Limits of all stimulation, for any input.

    Guarantees: let i and w be current and pulse width of a channel in an output, q = i w, and n the ticks of
    one second. For any inputs, in any order and at any times:

    1. i and w are finite, 0 <= i <= `current_max_ma`, 0 <= w <= `width_max_us`;
    2. q <= `charge_max_uc`, and 2 x 500 ohm x i^2 w <= `energy_max_mj`;
    3. q exceeds that of the tick before, 0 before the first, by `charge_rise_uc` at most;
    4. the sum of q `frequency_hz` / tick rate over any n successive ticks of a trial is
       `charge_per_s_max_uc` at most, and over all ticks of all trials of a run `charge_total_max_mc`; where a
       tick is late (a live stream's, or one after skipped ticks) the device has repeated q until then, which
       counts; 5. from the first tick that reads `stop` above 0.5, or not finite, i = w = 0, in all later
       trials too; 6. `ramp_ms` after stimulation ceases to be sound, i = w = 0 for as long as it is not, and
       no q rises meanwhile. It is sound while `stimulation` is finite and not older than `max_age_ms`,
       counted from its oldest capture, if `aligned` is wired, all of it has been 1 for `wait_s`, and, if
       `posture` is wired, the tracker has not failed (`Watchdog`).

    A tracker that needs an initial pose has an output `aligned`, which is 0 until the pose has been taken. An
    experiment in which stimulation could disturb that pose is refused unless each such `aligned` is wired
    here, several of them through a `join` with `columns = 0`.

    Limits first cut current and width, then shorten the pulse; a fall of charge is never limited. Every
    limitation is reported when it begins. The terms are those of IEC 60601-2-10 (300 mJ a
    pulse into 500 ohm, both phases counted); no certification is meant.

    Attributes
    ----------
    channels: number of channels; 0 takes it from the wire.
    joints: size of `posture`; 0 takes it from the wire, if there is one.
    trackers: size of `aligned`, likewise.
    current_max_ma, width_max_us, charge_max_uc, energy_max_mj: one value for all channels, or one a channel.
    charge_rise_uc: greatest rise of charge per phase from one tick to the next, likewise.
    charge_per_s_max_uc, charge_total_max_mc: limits on the sum of the charges of one phase, likewise (chosen:
        20 uC at 50 Hz, and an hour of it).
    frequency_hz: pulse rate of the device: it repeats each message at this rate.
    max_age_ms: greatest age of `stimulation` and `posture`.
    ramp_ms: duration of the ramp to zero; 0 cuts at once.
    wait_s: time that `aligned` must have been 1: a hand that was held in its initial pose is released and
        relaxes.
    watchdog: limits beyond which the tracker counts as failed.

    Inputs: `stimulation` (channels, 2); optional `posture` and `posture_sd` (joints,), rad; optional `stop`,
    the emergency stop; optional `aligned` (trackers,), 1 once a tracker's initial pose has been taken.
    Output: `stimulation` (channels, 2).
    """

    guards: ClassVar[bool] = True
    interlock: ClassVar[str] = "aligned"

    channels: int = 0
    joints: int = 0
    trackers: int = 0
    current_max_ma: PerChannel = 60.0
    width_max_us: PerChannel = 500.0
    charge_max_uc: PerChannel = 20.0
    energy_max_mj: PerChannel = 1e3 * ENERGY_MAX_J
    charge_rise_uc: PerChannel = 5.0
    charge_per_s_max_uc: PerChannel = 1000.0
    charge_total_max_mc: PerChannel = 3600.0
    frequency_hz: float = 40.0
    max_age_ms: float = 500.0
    ramp_ms: float = 200.0
    wait_s: float = 0.0
    watchdog: Watchdog = _USUAL

    def __post_init__(self) -> None:
        for key in ("channels", "joints", "trackers"):
            if getattr(self, key) < 0:
                raise InputError(key, f"{getattr(self, key)}", "1 or more, or 0 to take it from the wire")
        for key in (*_LIMITS, *_BUDGETS, "frequency_hz"):
            values = np.atleast_1d(getattr(self, key))
            if not (np.isfinite(values).all() and (values > 0.0).all()):
                raise InputError(key, f"{getattr(self, key)}", "a finite limit above 0")
            if self.channels and values.size not in (1, self.channels):
                raise InputError(key, f"{values.size} values", f"one, or {self.channels}, one a channel")
        if np.max(self.energy_max_mj) > 1e3 * ENERGY_MAX_J:
            raise InputError("energy_max_mj", f"{self.energy_max_mj}", f"at most {1e3 * ENERGY_MAX_J:g}")
        duration_ns(self.max_age_ms, NS_PER_MS, "max_age_ms")
        duration_ns(self.ramp_ms, NS_PER_MS, "ramp_ms")
        duration_ns(self.wait_s, NS_PER_S, "wait_s")

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`stimulation`, `posture`, `posture_sd`, `stop`, `aligned`."""
        joints = self.joints if self.joints or self.channels else None
        trackers = self.trackers if self.trackers or self.channels else None
        return (Port("stimulation", (self.channels or None, 2), "A,s"),
                Port("posture", (joints,), "rad", optional=True),
                Port("posture_sd", (joints,), "rad", optional=True), Port("stop", (), "1", optional=True),
                Port("aligned", (trackers,), "1", optional=True))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`stimulation`."""
        return (Port("stimulation", (self.channels or None, 2), "A,s"),)

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> Safety:
        """The block for the wired channels, posture and `aligned`; raises InputError for other shapes."""
        sizes = {shapes[name] for name in ("posture", "posture_sd") if name in shapes}
        if len(sizes) > 1 or any(len(size) != 1 for size in sizes):
            raise InputError("posture", f"shapes {sorted(sizes)} are wired in", "vectors of one size")
        joints = next(iter(sizes))[0] if sizes else self.joints
        trackers = shapes.get("aligned", (self.trackers,))
        if len(trackers) != 1:
            raise InputError("aligned", f"shape {trackers} is wired in", "a vector: shape (k,)")
        return replace(self, channels=shapes.get("stimulation", (self.channels,))[0], joints=joints,
                       trackers=trackers[0])

    def age_limits(self) -> tuple[AgeLimit, ...]:
        """Age limits of `stimulation` and `posture`."""
        return tuple(AgeLimit(port=port, limit_ms=self.max_age_ms, since="oldest",
                              then="all stimulation is withheld") for port in ("stimulation", "posture"))

    def linear_form(self, context: Context) -> SampledForm:
        """Pulses pass unchanged while no limit acts."""
        return memoryless(("stimulation",), "stimulation", np.eye(self.channels), passes_pulses=True)

    def init(self, context: Context) -> SafetyState:
        """State before any pulse."""
        scales = (1e-3, 1e-6, 1e-6, 1e-3, 1e-6, 1e-6, 1e-3)
        every = np.stack([scale * np.broadcast_to(getattr(self, key), self.channels)
                          for key, scale in zip((*_LIMITS, *_BUDGETS), scales, strict=True)], axis=1)
        period = period_ns(context)
        ticks = math.ceil(NS_PER_S / period)
        dose = Dose(budgets=np.ascontiguousarray(every[:, 5:]), frequency_hz=self.frequency_hz,
                    phases=self.frequency_hz * period / NS_PER_S, given=np.zeros((ticks, self.channels)),
                    total=np.zeros(self.channels))
        return SafetyState(np.ascontiguousarray(every[:, :5]), dose, np.zeros(self.channels),
                           np.zeros((self.channels, 2)), WatchState())

    def next_trial(self, state: SafetyState, context: Context) -> SafetyState:
        """Initial state, with the charge given so far and the emergency stop."""
        fresh = self.init(context)
        fresh.dose.total[:] = state.dose.total
        fresh.stopped = state.stopped
        return fresh

    def step(self, state: SafetyState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Pulses within the limits."""
        stimulation, posture, sd, stop, aligned = inputs
        state.stopped = state.stopped or not cast(float, stop.value) <= 0.5
        state.latch.put(tick, "emergency_stop", state.stopped, "no more stimulation in this run")
        if state.stopped:
            return (np.zeros((self.channels, 2)),)
        state.dose.book_repeated(state.charges, tick.time_ns)
        trouble = self._trouble(state, stimulation, posture, sd, aligned, tick.time_ns)
        if trouble != SOUND:
            state.latch.put(tick, trouble[0], True, trouble[1])
            hit, pulses = 0, self._ramp(state, tick.time_ns)
        else:
            if state.ramp_from_ns >= 0:
                state.ramp_from_ns = NEVER
                state.latch.holding.clear()
            hit, pulses = limit_pulses(cast(Array, stimulation.value), state.limits, state.charges)
        hit |= state.dose.limit(pulses, state.charges, tick.index)
        if trouble == SOUND:
            state.accepted = pulses
        if hit != state.hit:
            self._report(state, hit, tick)
        return (pulses,)

    def _trouble(self, state: SafetyState, stimulation: Sample, posture: Sample, sd: Sample,
                 aligned: Sample, now_ns: int) -> tuple[str, str]:
        """Status and detail of the fault that blocks stimulation, or `SOUND`."""
        tracker = SOUND
        if self.joints:
            tracker = self.watchdog.look(state.watch, posture, sd, now_ns, self.max_age_ms,
                                         bool(state.charges.any()))
        if not stimulation.present:
            return "no_input", "nothing has arrived: no stimulation"
        if now_ns - stimulation.oldest_ns > self.max_age_ms * NS_PER_MS:
            age_ms = (now_ns - stimulation.oldest_ns) / NS_PER_MS
            return "stale_input", (f"the oldest capture behind `stimulation` is {age_ms:.4g} ms old, "
                                   f"older than {self.max_age_ms:g} ms: ramp to zero")
        if not is_finite(stimulation.value):
            return "non_finite", "input is not finite: ramp to zero"
        if self.trackers and not (aligned.present and (cast(Array, aligned.value) > 0.5).all()):
            state.aligned_ns = NEVER
            return "not_aligned", "a tracker's initial pose has not been taken: no stimulation"
        if self.trackers and state.aligned_ns < 0:
            state.aligned_ns = now_ns
        if self.trackers and now_ns - state.aligned_ns < self.wait_s * NS_PER_S:
            return "waiting", f"no stimulation for {self.wait_s:g} s after the initial pose: the hand relaxes"
        return tracker

    def _ramp(self, state: SafetyState, now_ns: int) -> Array:
        """Last sound pulses, shortened linearly to zero."""
        if state.ramp_from_ns < 0:
            state.ramp_from_ns = now_ns
        elapsed_ms = (now_ns - state.ramp_from_ns) / NS_PER_MS
        share = 1.0 - elapsed_ms / self.ramp_ms if elapsed_ms < self.ramp_ms else 0.0
        pulses: Array = state.accepted * (1.0, share) if share > 0.0 else np.zeros((self.channels, 2))
        fall(pulses, state.charges)
        return pulses

    def _report(self, state: SafetyState, hit: int, tick: Tick) -> None:
        """Report the limits that begin to act at this tick."""
        for bit, status, detail in LIMITED:
            if hit & ~state.hit & bit:
                tick.report(status, detail)
        state.hit = hit
