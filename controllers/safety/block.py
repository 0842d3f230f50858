"""`safety`: limits between a controller and a stimulator."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, cast

import numpy as np
from numpy.typing import NDArray

from controllers.safety import kernel
from controllers.safety.kernel import SOUND, Dose, Watchdog, WatchState
from controllers.timing import period_ns
from fesloop.errors import InputError
from fesloop.loop.abilities import AgeLimit
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import NEVER, Port, Sample, Value, is_finite
from fesloop.models.linear_form import BlockToControl, SampledForm, memoryless

Array = NDArray[np.float64]
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
    """

    limits: Array
    dose: Dose
    charges: Array
    accepted: Array
    watch: WatchState
    ramp_from_ns: int = NEVER
    stopped: bool = False
    hit: int = 0
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
       counts;
    5. from the first tick that reads `stop` above 0.5, or not finite, i = w = 0, in all later trials too;
    6. `ramp_ms` after stimulation ceases to be sound, i = w = 0 for as long as it is not, and no q rises
       meanwhile. It is sound while `stimulation` is finite and not older than `max_age_ms`, counted from its
       oldest capture, if `aligned` is wired, all of it is 1, and, if `posture` is wired, the tracker has not
       failed (`Watchdog`).

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
            hit, pulses = kernel.limit_pulses(cast(Array, stimulation.value), state.limits, state.charges)
        hit |= state.dose.limit(pulses, state.charges, tick.index)
        if trouble == SOUND:
            state.accepted = pulses
        if hit != state.hit:
            self._report(state, hit, tick)
        return (pulses,)

    def _trouble(self, state: SafetyState, stimulation: Sample, posture: Sample, sd: Sample,
                 aligned: Sample, now_ns: int) -> tuple[str, str]:
        """Status and detail of the reason against stimulation; `SOUND` without one."""
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
            return "not_aligned", "a tracker's initial pose has not been taken: no stimulation"
        return tracker

    def _ramp(self, state: SafetyState, now_ns: int) -> Array:
        """Last sound pulses, shortened linearly to zero."""
        if state.ramp_from_ns < 0:
            state.ramp_from_ns = now_ns
        elapsed_ms = (now_ns - state.ramp_from_ns) / NS_PER_MS
        share = 1.0 - elapsed_ms / self.ramp_ms if elapsed_ms < self.ramp_ms else 0.0
        pulses: Array = state.accepted * (1.0, share) if share > 0.0 else np.zeros((self.channels, 2))
        kernel.fall(pulses, state.charges)
        return pulses

    def _report(self, state: SafetyState, hit: int, tick: Tick) -> None:
        """Report the limits that begin to act at this tick."""
        for bit, status, detail in kernel.LIMITED:
            if hit & ~state.hit & bit:
                tick.report(status, detail)
        state.hit = hit
