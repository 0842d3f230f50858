"""`fesloop reproduce linear_theory`: the simulated loop compared with the exact theory of linear loops.

Cost: many independent runs of the shipped experiment `linear_loop` at each of 20 points of latency, jitter
and loss are compared with `fesloop.analysis.theory.stationary_cost`. The mean square of the joint angles
about rest is averaged over joints and over each run; since runs are independent, the confidence interval of
the mean needs no model of the correlation within a run. Its level is 99 % for all points together
(Bonferroni).

Critical latency: at each of 20 gains, the latency at which the noiseless loop changes from decay to growth,
found by bisection, is compared with `fesloop.analysis.theory.critical_latency_ms`. Takes 9 minutes of
processor time, shared by the workers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from fesloop.analysis.theory import critical_latency_ms, stationary_cost
from fesloop.apps.reproduce.cohort import Kept, Key, Progress, run_jobs
from fesloop.apps.reproduce.comparison import Row
from fesloop.apps.reproduce.result import Reproduction
from fesloop.errors import InputError, RunError
from fesloop.experiment.files.parse import load
from fesloop.experiment.running import Experiment
from fesloop.forms.schema import plain
from fesloop.forms.toml import toml_value
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.duration import ZERO, Duration
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop

Array = NDArray[np.float64]
EXPERIMENT = "linear_loop"
SUBJECTS = 40
CONFIDENCE, WIDEST = 0.99, 0.02
"""Confidence of all intervals of the cost together; largest half interval relative to the exact value."""
NEAR_MS = 0.1
SENSED, STIMULATED = "tracker.angles->controller.measured", "controller.stimulation->finger.stimulation"
_WAYS = {SENSED: "to the controller", STIMULATED: "to the finger"}
_SETTLED_S, _STRETCH_S = 5, 50
_RUNS_AT_ONCE = 4
_BRACKET_MS, _RESOLUTION_MS = 8.0, 0.02
_GROWTH_S = (40, 80, 120)
"""Spans of time; growth is measured between the second and the third, when faster modes have decayed."""


@dataclass(frozen=True, slots=True)
class Point:
    """Conditions of the cost.

    Attributes
    ----------
    seconds: length of each of `SUBJECTS` runs, for an interval below `WIDEST` (measured, with a margin).
    latency_ms, jitter, loss, burst_messages: of the wire from tracker to controller.
    actuation_ms, actuation_loss: of the wire from controller to finger.
    """

    seconds: int
    latency_ms: float = 0.0
    jitter: Duration = ZERO
    loss: float = 0.0
    burst_messages: float = 0.0
    actuation_ms: float = 5.0
    actuation_loss: float = 0.0

    @property
    def settings(self) -> tuple[str, ...]:
        """Settings as in `fesloop run --set`."""
        sensed = f'wires."{SENSED}"'
        jitter = ", ".join(f"{key} = {toml_value(value)}" for key, value in plain(self.jitter).items()
                           if value is not None)
        return (f"{sensed}.jitter={{{jitter}}}", f"latency_ms={self.latency_ms}", f"loss={self.loss}",
                f"{sensed}.burst_messages={self.burst_messages}", f"actuation_ms={self.actuation_ms}",
                f"actuation_loss={self.actuation_loss}")

    @property
    def name(self) -> str:
        """Name in messages."""
        parts = [f"{self.latency_ms:g} ms"]
        if self.jitter.random:
            parts.append(f"{self.jitter.kind} jitter to {self.jitter.high_ms:g} ms")
        if self.loss:
            bursts = f" in bursts of {self.burst_messages:g}" if self.burst_messages else ""
            parts.append(f"{100 * self.loss:g} % lost{bursts}")
        if self.actuation_loss:
            parts.append(f"to the finger {self.actuation_ms:g} ms and {100 * self.actuation_loss:g} % lost")
        return ", ".join(parts)


def _uniform(high_ms: float) -> Duration:
    return Duration(kind="uniform", low_ms=0.0, high_ms=high_ms)


_TAILED = Duration(kind="exponential", mean_ms=8.0, high_ms=40.0)
_BELL = Duration(kind="normal", mean_ms=5.0, sd_ms=8.0, low_ms=-10.0, high_ms=30.0)
POINTS = (
    Point(120), Point(140, 10), Point(180, 30), Point(310, 60),
    Point(140, loss=0.1), Point(140, loss=0.3), Point(190, 30, loss=0.2), Point(230, 20, loss=0.5),
    Point(400, 10, loss=0.2, burst_messages=4.0),
    Point(150, 0, _uniform(20)), Point(180, 0, _uniform(40)), Point(250, 15, _uniform(35)),
    Point(240, 30, _uniform(30)), Point(210, 30, _uniform(20), 0.05), Point(200, 10, _uniform(40), 0.2),
    Point(230, 0, _uniform(60), 0.3), Point(220, 20, _TAILED, 0.1), Point(190, 20, _BELL),
    Point(350, actuation_ms=13.7, actuation_loss=0.3),
    Point(300, 5, _uniform(25), 0.1, actuation_ms=21.3, actuation_loss=0.1))
GAINS = tuple(round(0.6 * 1.06**k, 3) for k in range(20))


@dataclass(frozen=True, slots=True)
class Cost:
    """Some runs at a point: mean squares about rest, rad^2, (runs,)."""

    point: int
    seeds: tuple[int, ...]

    @property
    def key(self) -> Key:
        """Key of the result."""
        return ("cost", self.point, *self.seeds)

    def kept(self) -> Kept:
        """Run the experiments of the point."""
        point = POINTS[self.point]
        return {"squares": np.array([
            mean_square(load(EXPERIMENT, point.settings, seed), point.seconds) for seed in self.seeds])}


@dataclass(frozen=True, slots=True)
class Crossing:
    """The latency at which the simulated loop becomes unstable, for one gain and one wire."""

    gain: float
    wire: str

    @property
    def key(self) -> Key:
        """Key of the result."""
        return ("crossing", self.wire, str(self.gain))

    def at(self, latency_ms: float) -> Experiment:
        """Settings for a run without noise from a step off rest, with all gains scaled."""
        scaled = tuple(f"blocks.controller.{name}={[self.gain * value] * 3}"
                       for name, value in (("kp", 1.0), ("ki", 8.0), ("kd", 0.02)))
        return load(EXPERIMENT, (*scaled, "noise_deg=0", "latency_ms=0", "actuation_ms=0",
                                 f'wires."{self.wire}".latency_ms={latency_ms}',
                                 "blocks.reference.angles_deg=[[22, 26, 16]]"))

    def kept(self) -> Kept:
        """Critical latency by theory and by bisection, ms; NaN where the bracket contains none."""
        theory = critical_latency_ms(self.at(1.0), self.wire)
        if theory is None:
            return {"theory": math.nan, "simulated": math.nan}
        low, high = max(0.0, theory - _BRACKET_MS), theory + _BRACKET_MS
        if growth(self.at(low)) >= 0.0 or growth(self.at(high)) <= 0.0:
            return {"theory": theory, "simulated": math.nan}
        while high - low > _RESOLUTION_MS:
            middle = round(0.5 * (low + high), 6)
            low, high = (low, middle) if growth(self.at(middle)) > 0.0 else (middle, high)
        return {"theory": theory, "simulated": 0.5 * (low + high)}


def mean_square(experiment: Experiment, seconds: float) -> float:
    """Mean square of the finger's angles about rest, over time and joints of one run, rad^2."""
    recorder = Recorder(experiment.record.plant_rate)
    loop = Loop(experiment.wiring, recorder=recorder)
    rest = np.array(experiment.wiring.node("finger").part.outputs[0].initial)
    total, count, done, end = 0.0, 0, float(_SETTLED_S), _SETTLED_S + seconds
    loop.run_until(_SETTLED_S * NS_PER_S - 1)
    recorder.drain()
    while done < end:
        done = min(done + _STRETCH_S, end)
        loop.run_until(round(done * NS_PER_S) - 1)
        for _, _, outputs in recorder.drain()[1]["finger"]:
            total += float(np.square(outputs[0] - rest).sum())
            count += outputs[0].size
    return total / count


def growth(experiment: Experiment) -> float:
    """Logarithm of the growth of the joints' rates from one span to the next."""
    recorder = Recorder(experiment.record.plant_rate)
    loop = Loop(experiment.wiring, recorder=recorder)
    sizes = []
    for until_s in _GROWTH_S:
        loop.run_until(until_s * NS_PER_S - 1)
        rows = recorder.drain()[1]["finger"]
        sizes.append(math.sqrt(sum(float(np.square(outputs[1]).sum()) for _, _, outputs in rows)))
    return math.log(sizes[2] / sizes[1])


def run(subjects: int = SUBJECTS, workers: int = 1, progress: Progress | None = None) -> Reproduction:
    """Run every point `subjects` times, and every gain. Raises InputError for a single subject."""
    if subjects < 2:
        raise InputError("--subjects", f"{subjects}", "2 or more: one run has no interval")
    # Each point has its own seeds, so that their errors are independent.
    costs = [Cost(point, tuple(range(first, first + subjects))[start:start + _RUNS_AT_ONCE])
             for start in range(0, subjects, _RUNS_AT_ONCE)
             for point, first in enumerate(range(1, 1 + subjects * len(POINTS), subjects))]
    crossings = [Crossing(gain, (SENSED, STIMULATED)[number % 2]) for number, gain in enumerate(GAINS)]
    kept = run_jobs([*crossings, *costs], workers, progress)
    squares = [np.concatenate([kept[task.key]["squares"] for task in costs if task.point == number])
               for number in range(len(POINTS))]
    return compare(subjects, squares, [(task, kept[task.key]) for task in crossings])


def compare(
    subjects: int, squares: Sequence[Array], crossings: Sequence[tuple[Crossing, Kept]]
) -> Reproduction:
    """Make rows and curves of the results at each point and each gain."""
    intervals = np.array([interval(each, len(POINTS)) for each in squares])
    exact = np.radians([stationary_cost(load(EXPERIMENT, point.settings)).joint_rms_deg
                        for point in POINTS]) ** 2
    rows = [_cost_row(*each) for each in zip(POINTS, exact, *intervals.T, strict=True)]
    rows += [_crossing_row(*each) for each in crossings]
    curves = {
        "cost": {"names": [point.name for point in POINTS], "exact": exact, "mean": intervals[:, 0],
                 "half": intervals[:, 1]},
        "crossing": {"wires": [_WAYS[task.wire] for task, _ in crossings],
                     "theory_ms": np.array([found["theory"] for _, found in crossings]),
                     "simulated_ms": np.array([found["simulated"] for _, found in crossings])}}
    return Reproduction("linear_theory", subjects, rows, curves=curves)


def interval(squares: Array, comparisons: int) -> tuple[float, float]:
    """Mean of independent runs, and half its confidence interval (Bonferroni over `points`)."""
    runs = squares.size
    if runs < 2:
        raise RunError("one run has no interval: more subjects")
    quantile = float(student.ppf(1.0 - 0.5 * (1.0 - CONFIDENCE) / comparisons, runs - 1))
    return float(squares.mean()), quantile * float(squares.std(ddof=1)) / math.sqrt(runs)


def _cost_row(point: Point, exact: float, mean: float, half: float) -> Row:
    found = f"{_deg(mean):.4f} rms, square {100 * (mean / exact - 1):+.2f} % +- {100 * half / exact:.2f} %"
    return Row("cost", point.name, f"{_deg(exact):.4f} rms", found,
               bool(half <= WIDEST * exact and abs(mean - exact) <= half), "deg")


def _deg(square: float) -> float:
    return math.degrees(math.sqrt(square))


def _crossing_row(task: Crossing, kept: Kept) -> Row:
    theory, simulated = kept["theory"], kept["simulated"]
    return Row("critical latency", f"gains times {task.gain:g}, {_WAYS[task.wire]}", f"{theory:.3f}",
               f"{simulated:.3f}", abs(simulated - theory) <= NEAR_MS, "ms")
