"""`error_replay`: true joint angles with error, age and loss like a recorded tracker's."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.noise import NoiseStream
from fesloop.loop.signals import NEVER, Port, Sample, Value
from fesloop.loop.wire import Losses
from fesloop.models.correlation import root_of
from fesloop.models.error_process import ErrorProcess
from fesloop.models.error_steps import DRAWS, PARTS, SDS, errors_now, rows_of, sizes

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class ErrorReplayState:
    """State of an ErrorReplay.

    Attributes
    ----------
    noise: random numbers of the error, DRAWS a joint and tick.
    fate: random numbers of loss and age of each tick.
    losses: losses by these.
    rows: (joints, columns), error processes of the joints.
    root: (joints, joints), root of their correlation.
    offsets: (joints,), rad, difference of this trial's constant parts from their means.
    drawn: what this trial has drawn of a process of several recordings; empty: nothing, or reported.
    parts: (joints, PARTS), present random parts.
    centre: (joints,), rad, origin of the angles; None before the first truth.
    past: (capture, truth) of the messages within the age, oldest first.
    captured_ns: capture of the last estimate; NEVER before the first.
    truth, angles: (joints,), truth of the last estimate, and the estimate.
    missing: whether a missing truth has been reported.
    """

    noise: NoiseStream
    fate: NoiseStream
    losses: Losses
    rows: Array
    root: Array
    offsets: Array
    drawn: str
    parts: Array
    centre: Array | None
    truth: Array
    angles: Array
    past: list[tuple[int, Array]] = field(default_factory=list)
    captured_ns: int = NEVER
    missing: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ErrorReplay:
    """True joint angles with an error, an age and a loss like those of a recorded tracker.

    Input and output `angles` (joints,), rad. The process is fitted by `fesloop fit-error`, whose file is
    named as `process = { file = "error.toml" }`. Nothing of the recording is played back: each trial and seed
    has an error of its own, with the recorded one's distribution, its correlation in time and across joints
    and its dependence on angle and rate, and, where the process was fitted to several recordings, with
    another constant part and size. Estimates carry the instant of their truth; a lost one is replaced by the
    last one, with its stamp. Before the first truth there is no output, with the status `no_sample`. What a
    trial has drawn of a process of several recordings is reported as `one_draw`.

    Attributes
    ----------
    process: process of the error.
    like: name of the series for the error of each joint; empty: those of hinges, or of all moved axes, in
        turn. A repeated series has independent errors.
    joints: number of joints; 0 takes it from the wire.
    centre_deg: origin of the process's angle, one a joint; empty: the angles at the first tick.
    size: factor on the error, for sweeps.
    """

    process: ErrorProcess
    like: tuple[str, ...] = ()
    joints: int = 0
    centre_deg: tuple[float, ...] = ()
    size: float = 1.0

    def __post_init__(self) -> None:
        if self.joints < 0:
            raise InputError("joints", f"{self.joints}", "1 or more, or 0 to take it from the wire")
        for name in self.like:
            self.process.number(name)
        if not (math.isfinite(self.size) and self.size >= 0.0):
            raise InputError("size", f"{self.size}", "0 or more")
        if not all(math.isfinite(angle) for angle in self.centre_deg):
            raise InputError("centre_deg", f"{self.centre_deg}", "finite angles")
        for key, given in (("like", self.like), ("centre_deg", self.centre_deg)):
            if self.joints and given and len(given) != self.joints:
                raise InputError(key, f"has {len(given)} values", f"{self.joints}, one a joint, or none")

    @property
    def inputs(self) -> tuple[Port, ...]:
        """angles."""
        return (Port("angles", (self.joints or None,), "rad"),)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """angles."""
        return (Port("angles", (self.joints or None,), "rad"),)

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> ErrorReplay:
        """The block for the number of wired joints."""
        return replace(self, joints=shapes["angles"][0])

    def numbers(self) -> list[int]:
        """Index of the series of each joint."""
        names = self.like or self.process.usual()
        return [self.process.number(names[joint % len(names)]) for joint in range(self.joints)]

    def init(self, context: Context) -> ErrorReplayState:
        """State without an error: the random parts begin with the first truth."""
        process, numbers = self.process, self.numbers()
        series = [process.series[number] for number in numbers]
        bias, size = context.noise(2 * self.joints, "normal", "recording").row(0).reshape(2, self.joints)
        rows = rows_of(series)
        spread_deg, size_sd = np.array([(each.bias_sd_deg, each.size_sd) for each in series]).T
        factors = sizes(size_sd, size)
        rows[:, SDS] *= factors[:, np.newaxis]
        constant_deg = self.size * (np.array([each.bias_deg for each in series]) + spread_deg * bias)
        drawn = ("of a process of several recordings: constant parts "
                 + ", ".join(f"{each:.1f}" for each in constant_deg) + " deg, random parts times "
                 + ", ".join(f"{each:.1f}" for each in factors)
                 + "; other seeds and trials have others: compare over several")
        fate = context.noise(2, "uniform", "fate")
        first = [numbers.index(number) == joint for joint, number in enumerate(numbers)]
        together = np.outer(first, first) | np.eye(self.joints, dtype=bool)
        correlation = np.where(together, process.matrix()[np.ix_(numbers, numbers)], 0.0)
        return ErrorReplayState(
            noise=context.noise(DRAWS * self.joints), fate=fate,
            losses=Losses(process.loss, process.burst_messages, fate),
            rows=rows, root=root_of(correlation),
            offsets=np.radians(spread_deg) * bias,
            drawn=drawn if spread_deg.any() or size_sd.any() else "",
            parts=np.zeros((self.joints, PARTS)),
            centre=np.radians(self.centre_deg) if self.centre_deg else None,
            truth=np.zeros(self.joints), angles=np.zeros(self.joints))

    def step(self, state: ErrorReplayState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """The present estimate; before the first truth nothing, and a report."""
        sample = inputs[0]
        if not sample.present:
            if not state.missing:
                tick.report("no_sample", "no angles have arrived yet: no output")
                state.missing = True
            return ()
        if state.drawn:
            tick.report("one_draw", state.drawn)
            state.drawn = ""
        state.past.append((sample.newest_ns, cast(Array, sample.value)))
        chance, shape = (float(number) for number in state.fate.row(tick.index))
        lost = state.losses.lost(tick.index, chance) and state.captured_ns >= 0
        captured_ns, truth = self._seen(state, tick.time_ns, shape)
        if not lost and captured_ns > state.captured_ns:
            self._estimate(state, captured_ns, truth, tick.index)
        tick.captured_ns = state.captured_ns
        return (state.angles,)

    def _seen(self, state: ErrorReplayState, now_ns: int, shape: float) -> tuple[int, Array]:
        """Newest truth that is old enough, or the oldest one, with its capture."""
        age_ns = round(self.process.age_ms * NS_PER_MS) + self.process.jitter.draw_ns(shape)
        least_ns = now_ns - round(self.process.age_ms * NS_PER_MS) - (self.process.jitter.most_ns or 0)
        past = state.past
        while len(past) > 1 and past[1][0] <= least_ns:
            del past[0]
        return next((each for each in reversed(past) if each[0] <= now_ns - age_ns), past[0])

    def _estimate(self, state: ErrorReplayState, captured_ns: int, truth: Array, index: int) -> None:
        """Estimate a truth; the error advances by the time since the last capture."""
        first = state.captured_ns < 0
        if state.centre is None:
            state.centre = truth.copy()
        elapsed_s = 0.0 if first else (captured_ns - state.captured_ns) / NS_PER_S
        rates = np.zeros(self.joints) if first else (truth - state.truth) / elapsed_s
        draws = state.noise.row(index).reshape(DRAWS, self.joints) @ state.root
        errors = errors_now(state.rows, state.parts, truth - state.centre, rates, elapsed_s, first, draws)
        state.angles = truth + self.size * (state.offsets + errors)
        state.captured_ns, state.truth = captured_ns, truth
