"""A tracker that errs like one that was recorded: error, age and loss as a process, on any simulated hand."""

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
from fesloop.models.error_steps import DRAWS, PARTS, errors_now, rows_of

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class ErrorReplayState:
    """Memory of an ErrorReplay.

    Attributes
    ----------
    noise: DRAWS numbers a joint and tick. fate: what decides loss and age of each tick. losses: by these.
    rows: (joints, columns), the joints' error processes. root: (joints, joints), of their correlation.
    parts: (joints, PARTS), the random parts now.
    centre: (joints,), rad, from which angles count; None before the first truth.
    past: (capture, truth) of the messages that the age still needs, oldest first.
    captured_ns: of the estimate that was put out last; NEVER before any.
    truth, angles: (joints,), what that was made of, and it.
    missing: whether it has been reported that no truth has arrived.
    """

    noise: NoiseStream
    fate: NoiseStream
    losses: Losses
    rows: Array
    root: Array
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
    and its dependence on angle and rate. Estimates carry the instant of the truth that they were made of; in
    place of a lost one the last one stands, with its stamp. Before any truth has arrived nothing is put out,
    and the status `no_sample` says so.

    Attributes
    ----------
    process: of the error.
    like: for each joint the name of the series whose error it has; empty: those of hinges, or of all axes
        that were moved about, in turn. A series that stands there again has an error of its own, independent
        of the first.
    joints: how many; 0 takes it from what is wired to `angles`.
    centre_deg: angles from which the process's angle counts, one a joint; empty: those at the first tick.
    size: factor of the error, for sweeps.
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
        """The same for the number of joints wired to it."""
        return replace(self, joints=shapes["angles"][0])

    def numbers(self) -> list[int]:
        """Of the series that each joint's error is like."""
        names = self.like or self.process.usual()
        return [self.process.number(names[joint % len(names)]) for joint in range(self.joints)]

    def init(self, context: Context) -> ErrorReplayState:
        """No error yet: the random parts begin with the first truth."""
        process, numbers = self.process, self.numbers()
        fate = context.noise(2, "uniform", "fate")
        first = [numbers.index(number) == joint for joint, number in enumerate(numbers)]
        together = np.outer(first, first) | np.eye(self.joints, dtype=bool)
        correlation = np.where(together, process.matrix()[np.ix_(numbers, numbers)], 0.0)
        return ErrorReplayState(
            noise=context.noise(DRAWS * self.joints), fate=fate,
            losses=Losses(process.loss, process.burst_messages, fate),
            rows=rows_of(process.series)[numbers], root=root_of(correlation),
            parts=np.zeros((self.joints, PARTS)),
            centre=np.radians(self.centre_deg) if self.centre_deg else None,
            truth=np.zeros(self.joints), angles=np.zeros(self.joints))

    def step(self, state: ErrorReplayState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """The estimate of now; before any truth has arrived nothing, and a report."""
        sample = inputs[0]
        if not sample.present:
            if not state.missing:
                tick.report("no_sample", "no angles have arrived yet: nothing is put out")
                state.missing = True
            return ()
        state.past.append((sample.newest_ns, cast(Array, sample.value)))
        chance, shape = (float(number) for number in state.fate.row(tick.index))
        lost = state.losses.lost(tick.index, chance) and state.captured_ns >= 0
        captured_ns, truth = self._seen(state, tick.time_ns, shape)
        if not lost and captured_ns > state.captured_ns:
            self._estimate(state, captured_ns, truth, tick.index)
        tick.captured_ns = state.captured_ns
        return (state.angles,)

    def _seen(self, state: ErrorReplayState, now_ns: int, shape: float) -> tuple[int, Array]:
        """The newest truth that is old enough, with its capture; the oldest there is until one is."""
        age_ns = round(self.process.age_ms * NS_PER_MS) + self.process.jitter.draw_ns(shape)
        least_ns = now_ns - round(self.process.age_ms * NS_PER_MS) - (self.process.jitter.most_ns or 0)
        past = state.past
        while len(past) > 1 and past[1][0] <= least_ns:
            del past[0]
        return next((each for each in reversed(past) if each[0] <= now_ns - age_ns), past[0])

    def _estimate(self, state: ErrorReplayState, captured_ns: int, truth: Array, index: int) -> None:
        """A new estimate of a truth; the error moves on by the time since the capture before."""
        first = state.captured_ns < 0
        if state.centre is None:
            state.centre = truth.copy()
        elapsed_s = 0.0 if first else (captured_ns - state.captured_ns) / NS_PER_S
        rates = np.zeros(self.joints) if first else (truth - state.truth) / elapsed_s
        draws = state.noise.row(index).reshape(DRAWS, self.joints) @ state.root
        errors = errors_now(state.rows, state.parts, truth - state.centre, rates, elapsed_s, first, draws)
        state.angles = truth + self.size * errors
        state.captured_ns, state.truth = captured_ns, truth
