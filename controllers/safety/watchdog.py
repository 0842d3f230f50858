"""Whether a tracker can be believed: it may fall silent, freeze, jump, return NaN, or be unsure of itself."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.guard import is_finite
from fesloop.loop.signals import NEVER, Sample

Array = NDArray[np.float64]
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
            return "posture_unsure", f"sd of posture is not from 0 to {self.sd_max_deg:g} deg: ramp to zero"
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
