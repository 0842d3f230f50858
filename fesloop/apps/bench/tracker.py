"""`fesloop bench tracker`: a tick of a tracker, compared with the bare `vqf` updates that it needs.

Sixteen sensors at 100 Hz, as many as on a hand, in lively motion; trackers and reference alternate within
each tick, so that other load affects both.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from time import perf_counter_ns
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment import registry
from fesloop.loop.block import Block, Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import Sample

Array = NDArray[np.float64]
SENSORS, RATE, TICKS = 16, 100, 3000
STILL, WARM_UP = 320, 400
"""Ticks at rest, long enough for an initial pose of 3 s, and those at the start that are not counted."""
CASES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("vqf", {}), ("vqf9", {}), ("salchow_m2", {}), ("salchow_m2", {"front_end": "seel_ruppin"}),
    ("salchow_m1", {}), ("salchow_b", {}), ("constrained", {}), ("kortier", {}))
"""Tracker kinds and their parameters apart from the number of sensors."""


def moving_samples(ticks: int, sensors: int, still: int = 0) -> dict[str, Array]:
    """Samples gyr (rad/s), acc (m/s^2) and mag (T), (ticks, sensors, 3), of a fixed lively movement.

    The sensors are at rest for the first `still` ticks.
    """
    rng = np.random.default_rng(0)
    motion = rng.normal(size=(3, ticks, sensors, 3))
    motion[:, :still] = 0.0
    gyr, acc, mag = motion
    return {"gyr": gyr, "acc": acc + np.array([0.0, 0.0, 9.81]),
            "mag": 1e-6 * (mag + np.array([0.0, 20.0, -40.0]))}


def tick_times_us(tracker: Block, samples: Sequence[Array], rate: int | float | str) -> Array:
    """Wall time of each tick of a tracker without the loop, (ticks,), us.

    Parameters
    ----------
    tracker: its inputs resolved.
    samples: (ticks, sensors, 3) for each input, in the order of its ports, all read.
    rate: of the samples, Hz.
    """
    step = _Stepper(tracker, samples, RateClock.from_rate(rate))
    return np.array([step(k) for k in range(len(samples[0]))]) / 1e3


class _Stepper:
    """Steps a tracker and returns the time of each step, ns."""

    def __init__(self, tracker: Block, samples: Sequence[Array], clock: RateClock) -> None:
        self.tracker, self.samples, self.clock, self.tick = tracker, samples, clock, Tick()
        self.state = tracker.init(Context("tracker", clock=clock))

    def __call__(self, k: int) -> int:
        now = self.clock.tick(k)
        inputs = [Sample(kind[k], now, now, now) for kind in self.samples]
        self.tick.index, self.tick.time_ns = k, now
        started = perf_counter_ns()
        self.tracker.step(self.state, inputs, self.tick)
        return perf_counter_ns() - started


def _bare(samples: Sequence[Array]) -> list[Any]:
    """For each sensor, the update of a vqf filter and its rows of samples."""
    from vqf import VQF

    sensors = range(samples[0].shape[1])
    return [(VQF(1.0 / RATE).update, [np.ascontiguousarray(kind[:, i]) for kind in samples]) for i in sensors]


def _bare_ns(filters: list[Any], k: int) -> int:
    """Time of one update of every filter, without the selection of samples."""
    calls = [(update, *(kind[k] for kind in kinds)) for update, kinds in filters]
    started = perf_counter_ns()
    for update, *sample in calls:
        update(*sample)
    return perf_counter_ns() - started


def run(progress: Callable[[float], None] | None = None) -> dict[str, Any]:
    """Make a row for each tracker, with sixteen sensors."""
    samples = moving_samples(TICKS, SENSORS, STILL)
    rows = []
    for number, (kind, parameters) in enumerate(CASES):
        if progress:
            progress(number / len(CASES))
        tracker = registry.find(kind)(sensors=SENSORS, **parameters)
        fed = [samples[port.name] for port in tracker.inputs]
        step, filters = _Stepper(tracker, fed, RateClock.from_rate(RATE)), _bare(fed)
        times = np.array([(step(k), _bare_ns(filters, k)) for k in range(TICKS)])[WARM_UP:] / 1e3
        ours, bare = times[:, 0], float(np.median(times[:, 1]))
        case = ", ".join([kind, *(str(value) for value in parameters.values()), f"{SENSORS} sensors"])
        rows.append({
            "case": case, "us_median": float(np.median(ours)),
            "us_p99": float(np.percentile(ours, 99)), "us_worst": float(ours.max()),
            "reference": f"{SENSORS} bare vqf updates", "reference_us_median": bare,
            "ratio": float(np.median(ours)) / bare})
    return {"bench": "tracker", "rows": rows}
