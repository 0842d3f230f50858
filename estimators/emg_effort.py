"""`emg_effort`: effort of a muscle, estimated from its surface EMG."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample, Sensors, Value

_REST_PART_NS = 25 * NS_PER_MS
"""Parts of the rest whose means show the power of slow noise (chosen: longer than EMG is correlated)."""
_LEAST_PARTS = 8
_COLOUR = 2.0
"""Factor on the rate of noise, since rectified EMG is not white (chosen: 1.6 was found for a narrow band)."""
_STRONG_PART_NS = 250 * NS_PER_MS
"""Parts of the greatest contraction, the strongest of which counts (chosen: shorter than it is held)."""


class Parts:
    """Means of a signal over consecutive parts of a window.

    Attributes
    ----------
    means: of the parts that are over and had a sample.
    """

    __slots__ = ("_count", "_part", "_sum", "length_ns", "means", "window")

    def __init__(self, window: tuple[int, int], length_ns: int) -> None:
        self.window, self.length_ns = window, length_ns
        self.means: list[float] = []
        self._part, self._sum, self._count = 0, 0.0, 0

    def add(self, time_ns: int, value: float) -> None:
        """Add a sample; one outside the window, or NaN, does not count."""
        part = (time_ns - self.window[0]) // self.length_ns
        if part != self._part:
            if self._count:
                self.means.append(self._sum / self._count)
            self._part, self._sum, self._count = part, 0.0, 0
        if self.window[0] <= time_ns < self.window[1] and not math.isnan(value):
            self._sum += value
            self._count += 1


@dataclass(slots=True, eq=False)
class EmgEffortState:
    """State of the estimate.

    Attributes
    ----------
    gain: of the two lags at a tick.
    rest, strong: rectified EMG of the calibration.
    lags: the two lags' outputs, V.
    heard_ns: arrival of the newest message. sample_ns: instant of the newest sample that was not lost.
    base, span: rectified EMG at rest, and how much more the greatest contraction has, V; span 0: unknown.
    detection: effort below which the noise of rest stays.
    """

    gain: float
    rest: Parts
    strong: Parts
    latch: StatusLatch = field(default_factory=StatusLatch)
    lags: tuple[float, float] = (0.0, 0.0)
    heard_ns: int = -1
    sample_ns: int = -1
    calibrated: bool = False
    base: float = 0.0
    span: float = 0.0
    detection: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class EmgEffort:
    """Effort of a muscle as a fraction of its greatest contraction, from a calibration in the same trial.

        effort = clip((envelope - rest) / (greatest - rest), 0, 1)

    The envelope is the rectified EMG behind two equal lags: of a step the share 1 - (1 + w t) exp(-w t) is
    seen after t, with w = 2 pi cutoff_hz. `rest` is the mean over the window `rest_s`, `greatest` the
    largest mean of 250 ms in the window `contraction_s`, in which the person contracts as strongly as
    possible. Before the second window is over, effort is 0 and `calibrated` 0.

    `detection` is the effort that the noise of rest exceeds at most `false_alarms_per_min` times a minute, on
    average over calibrations. For Gaussian noise behind two such lags, which exceeds its mean by z sds
    cutoff_hz exp(-z^2 / 2) times a second (Rice 1945, Bell Syst Tech J 24:46-156), z is that of Student's
    t, since the sd follows from the n parts of 25 ms of a finite rest, and is enlarged by the skewness of
    a gamma variable, which rectified EMG does not exceed. That holds for noise with its power above 60 Hz.

    A lost sample does not move the envelope. Without any for `lost_ms` the effort is 0. Statuses: `no_rest`,
    `no_contraction`: the calibration failed, and the effort stays 0; `emg_lost`.

    Input: `emg` (k,), V. Outputs, a number each: `effort`, `detection`, `calibrated`.

    Attributes
    ----------
    muscle: name of the muscle among those of the input; "" for the only one.
    rest_s: window of rest, from and to.
    contraction_s: window of the greatest contraction, after that of rest.
    cutoff_hz: frequency of the two lags (chosen: a compromise of quickness and noise).
    false_alarms_per_min: rate for `detection`.
    lost_ms: time without samples after which the effort is 0.
    muscles: names of the muscles of the input, which the wire states.
    size: number of muscles of the input; 0 takes it from the wire.
    """

    muscle: str = ""
    rest_s: tuple[float, float] = (0.5, 2.0)
    contraction_s: tuple[float, float] = (2.0, 4.0)
    cutoff_hz: float = 3.0
    false_alarms_per_min: float = 0.1
    lost_ms: float = 250.0
    muscles: tuple[str, ...] = ()
    size: int = 0

    def __post_init__(self) -> None:
        for key in ("rest_s", "contraction_s"):
            window = getattr(self, key)
            if not 0.0 <= window[0] < window[1] < math.inf:
                raise InputError(key, f"{list(window)}", "from and to, the first before the second")
        if self.contraction_s[0] < self.rest_s[1]:
            raise InputError("contraction_s", f"{list(self.contraction_s)}",
                             f"from {self.rest_s[1]:g} on, when the rest is over")
        for key in ("cutoff_hz", "false_alarms_per_min", "lost_ms"):
            if not 0.0 < getattr(self, key) < math.inf:
                raise InputError(key, f"{getattr(self, key):g}", "above 0")
        if self.false_alarms_per_min >= 60.0 * self.cutoff_hz:
            raise InputError("false_alarms_per_min", f"{self.false_alarms_per_min:g}",
                             f"below {60.0 * self.cutoff_hz:g}, how often noise exceeds its own mean")
        if self.muscle and self.muscles and self.muscle not in self.muscles:
            raise InputError("muscle", f"{self.muscle!r} has no EMG", ", ".join(self.muscles),
                             did_you_mean(self.muscle, self.muscles))
        if len(self.muscles) > 1 and not self.muscle:
            raise InputError("muscle", "is not named, and EMG of several is wired", ", ".join(self.muscles))

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`emg`."""
        return (Port("emg", (self.size or None,), "V", every=True),)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`effort`, `detection`, `calibrated`."""
        return Port("effort"), Port("detection", initial=1.0), Port("calibrated")

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> EmgEffort:
        """The block for the wired number of muscles."""
        return replace(self, size=shapes["emg"][0])

    def with_sensors(self, sources: Mapping[str, Sensors]) -> EmgEffort:
        """The block that knows the muscles' names."""
        return replace(self, muscles=sources["emg"].names)

    def init(self, context: Context) -> EmgEffortState:
        """State before the calibration."""
        period_s = context.clock.period_s if context.clock is not None else 0.0
        if self.cutoff_hz * period_s >= 0.5:
            raise InputError(f"{context.name}.cutoff_hz", f"{self.cutoff_hz:g}",
                             f"below {0.5 / period_s:g}, half the block's rate")
        windows = [(duration_ns(window[0], NS_PER_S, key), duration_ns(window[1], NS_PER_S, key))
                   for key, window in (("rest_s", self.rest_s), ("contraction_s", self.contraction_s))]
        return EmgEffortState(-math.expm1(-2.0 * math.pi * self.cutoff_hz * period_s),
                              Parts(windows[0], _REST_PART_NS), Parts(windows[1], _STRONG_PART_NS))

    def step(self, state: EmgEffortState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Effort after a sample; none before the first."""
        sample, now_ns = inputs[0], tick.time_ns
        if not sample.present:
            return ()
        if sample.arrived_ns > state.heard_ns:
            state.heard_ns = sample.arrived_ns
            row = self.muscles.index(self.muscle) if self.muscle and self.muscles else 0
            self._hear(state, abs(float(cast("NDArray[np.float64]", sample.value)[row])), now_ns)
        if not state.calibrated and now_ns >= state.strong.window[1]:
            state.calibrated = True
            self._calibrate(state, tick)
        lost = now_ns - state.sample_ns > self.lost_ms * NS_PER_MS
        state.latch.put(tick, "emg_lost", lost, f"no sample for {self.lost_ms:g} ms: the effort is 0")
        if lost or state.span == 0.0:
            return 0.0, state.detection, float(state.span > 0.0)
        return min(max((state.lags[1] - state.base) / state.span, 0.0), 1.0), state.detection, 1.0

    def _hear(self, state: EmgEffortState, rectified: float, now_ns: int) -> None:
        """Take a sample, which may be lost (NaN)."""
        if not state.calibrated:
            state.rest.add(now_ns, rectified)
            state.strong.add(now_ns, rectified)
        if not math.isnan(rectified):
            state.sample_ns = now_ns
            first = state.lags[0] + state.gain * (rectified - state.lags[0])
            state.lags = first, state.lags[1] + state.gain * (first - state.lags[1])

    def _calibrate(self, state: EmgEffortState, tick: Tick) -> None:
        """Determine rest, greatest contraction and detection; report where that is not possible."""
        rest, strong = np.array(state.rest.means), state.strong.means
        if len(rest) < _LEAST_PARTS:
            tick.report("no_rest", f"{len(rest)} of at least {_LEAST_PARTS} parts of 25 ms in rest_s have a "
                        "sample: the effort stays 0")
            return
        state.base = float(rest.mean())
        above = self._above(state.base, float(rest.var(ddof=1)), len(rest))
        span = max(strong, default=0.0) - state.base
        if span <= above:
            tick.report("no_contraction", "the greatest contraction in contraction_s is "
                        f"{1e6 * max(span, 0.0):.3g} uV above rest, and noise of rest may be "
                        f"{1e6 * above:.3g} above it: the effort stays 0")
            return
        state.span, state.detection = span, above / span

    def _above(self, mean: float, variance: float, parts: int) -> float:
        """Height above the mean of rest that the envelope exceeds at the stated rate, V.

        `variance` is that of means of `_REST_PART_NS`; the power of slow noise is variance times that time.
        """
        part_s, w, freedom = _REST_PART_NS / NS_PER_S, 2.0 * math.pi * self.cutoff_hz, parts - 1
        # Of the envelope less the mean of rest: both vary.
        sd = math.sqrt(variance * part_s * (w / 4.0 + 1.0 / (parts * part_s)))
        rate = self.false_alarms_per_min / 60.0 / _COLOUR
        z = math.sqrt(freedom * ((self.cutoff_hz / rate) ** (2.0 / freedom) - 1.0))
        skewed = (z * z - 1.0) * sd / (3.0 * mean) if mean > 0.0 and z > 1.0 else 0.0
        return sd * (z + skewed)
