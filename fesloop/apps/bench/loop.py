"""`fesloop bench loop`: cost of a block call in the loop, compared with a bare heap loop of the same work.

Both simulate the same small closed loop (`_yardstick_loop`) with the same plant arithmetic, one numpy step of
1 ms, alternating in one process. The case `exact` uses fesloop's default for a linear plant: exact at every
time, with the recorder's 1 kHz evaluated in stacks.
"""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from fesloop.loop.block import Context, Plant, Tick
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port, Sample, Value
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

PERIOD_NS, CONTROL_NS, DELAY_NS, END_NS = 1_000_000, 20_000_000, 30_000_000, 10_000_000_000
CALLS = 30_500
KP, KI, REFERENCE, CONTROL_S = 0.6, 3.0, 1.0, 20e-3
_NATURAL, _DAMPING = 2 * np.pi * 2.5, 0.9


def continuous() -> tuple[tuple[tuple[float, ...], ...], tuple[tuple[float, ...], ...]]:
    """Continuous A (2, 2) and B (2, 1) of the plant."""
    return (((0.0, 1.0), (-_NATURAL**2, -2 * _DAMPING * _NATURAL)), ((0.0,), (_NATURAL**2,)))


def matrices() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Exact step of the plant over 1 ms, (2, 2) and (2,)."""
    stacked = np.zeros((3, 3))
    stacked[:2, :2], stacked[:2, 2:] = continuous()
    step = expm(stacked * 1e-3)
    return np.ascontiguousarray(step[:2, :2]), np.ascontiguousarray(step[:2, 2])


def exact_trajectory() -> NDArray[np.float64]:
    """Output y at the 10,001 ticks, in plain floats."""
    a, b = matrices()
    a00, a01, a10, a11 = (float(value) for value in a.ravel())
    b0, b1 = (float(value) for value in b)
    x0 = x1 = integral = u = 0.0
    y = [0.0] * 10_001
    for k in range(10_001):
        y[k] = x0
        if k % 20 == 0:
            error = REFERENCE - (y[k - 30] if k >= 30 else 0.0)
            u = KP * error + KI * integral
            integral += CONTROL_S * error
        x0, x1 = a00 * x0 + a01 * x1 + b0 * u, a10 * x0 + a11 * x1 + b1 * u
    return np.array(y)


class _Plant:
    """The plant x' = A x + b u, one numpy step a call."""

    def __init__(self) -> None:
        self.a, self.b = matrices()
        self.x: NDArray[np.float64] = np.zeros(2)
        self.y: Any = 0.0

    def output(self) -> None:
        self.y = self.x[0]

    def update(self, u: float) -> None:
        self.x = self.a.dot(self.x) + self.b * u


class _Delay:
    """A delay line."""

    def __init__(self) -> None:
        self.queue: deque[tuple[int, float]] = deque()
        self.y = 0.0

    def step(self, now: int, u: float) -> None:
        queue = self.queue
        queue.append((now + DELAY_NS, u))
        while queue and queue[0][0] <= now:
            self.y = queue.popleft()[1]


class _Controller:
    """A PI controller."""

    def __init__(self) -> None:
        self.integral = self.u = 0.0

    def step(self, measured: float) -> None:
        error = REFERENCE - measured
        self.u = KP * error + KI * self.integral
        self.integral += CONTROL_S * error


class _Log:
    """Rows of (time, y, u)."""

    def __init__(self) -> None:
        self.rows: list[tuple[int, float, float]] = []

    def step(self, now: int, y: float, u: float) -> None:
        self.rows.append((now, y, u))


def run_bare() -> NDArray[np.float64]:
    """The loop as block objects on a heap of integer ns; y at every tick."""
    plant, delay, controller, log = _Plant(), _Delay(), _Controller(), _Log()
    signals: dict[str, float] = {}

    def output(now: int) -> None:
        plant.output()
        signals["y"] = plant.y

    def transport(now: int) -> None:
        delay.step(now, signals["y"])
        signals["delayed"] = delay.y

    def control(now: int) -> None:
        controller.step(signals["delayed"])
        signals["u"] = controller.u

    def record(now: int) -> None:
        log.step(now, signals["y"], signals["u"])

    def update(now: int) -> None:
        plant.update(signals["u"])

    schedule: list[tuple[int, int, Callable[[int], None], int]] = [
        (0, 0, output, PERIOD_NS), (0, 1, transport, PERIOD_NS), (0, 2, control, CONTROL_NS),
        (0, 3, record, PERIOD_NS), (0, 4, update, PERIOD_NS)]
    heapq.heapify(schedule)
    while schedule[0][0] <= END_NS:
        now, order, call, period = schedule[0]
        call(now)
        heapq.heapreplace(schedule, (now + period, order, call, period))
    return np.array([row[1] for row in log.rows])


@dataclass(slots=True)
class _PlantState:
    x: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _SteppedPlant:
    """The yardstick's plant, with the yardstick's arithmetic, as a fixed-step plant."""

    a: NDArray[np.float64]
    b: NDArray[np.float64]
    grid: RateClock
    feedthrough: bool = False
    inputs: tuple[Port, ...] = (Port("u"),)
    outputs: tuple[Port, ...] = (Port("y"),)

    def init(self, context: Context) -> _PlantState:
        return _PlantState(np.zeros(2))

    def advance(self, state: _PlantState, inputs: Sequence[Value], start_ns: int, stop_ns: int) -> None:
        state.x = self.a.dot(state.x) + self.b * inputs[0]

    def read(self, state: _PlantState, inputs: Sequence[Value]) -> tuple[Value, ...]:
        return (state.x[0],)


@dataclass(slots=True)
class _PiState:
    integral: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Pi:
    """The yardstick's controller."""

    inputs: tuple[Port, ...] = (Port("y"),)
    outputs: tuple[Port, ...] = (Port("u"),)

    def init(self, context: Context) -> _PiState:
        return _PiState()

    def step(self, state: _PiState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        measured: Any = inputs[0].value
        error = REFERENCE - measured
        u = KP * error + KI * state.integral
        state.integral += CONTROL_S * error
        return (u,)


def _run_loop(plant: Plant) -> NDArray[np.float64]:
    """The yardstick's loop through blocks and wires; y at every tick."""
    recorder = Recorder("1000")
    nodes = [Node("plant", plant), Node("pi", _Pi(), rate="50")]
    wires = [Wire("plant.y", "pi.y", latency_ms=30, rate="1000"), Wire("pi.u", "plant.u")]
    Loop(Wiring(nodes, wires), recorder=recorder).run_until(END_NS)
    return np.concatenate([row[2][0] for row in recorder.plants["plant"]])


def _exact_plant() -> Plant:
    """The same plant as the kind `state_space`."""
    from fesloop.experiment.registry import find

    a, b = continuous()
    plant: Plant = find("state_space")(a=a, b=b, c=((1.0, 0.0),), d=((0.0,),))
    return plant


def run(
    repeats: int = 5, processes: int = 9, progress: Callable[[float], None] | None = None
) -> dict[str, Any]:
    """Time the cases in turn, in several fresh processes; returns microseconds per block call (of 30,500).

    The place of arrays in memory changes the speed of the same arithmetic by up to 2x between processes, so
    the ratio of one process says little.
    """
    walls: dict[str, list[float]] = {}
    worst_error = 0.0
    with ProcessPoolExecutor(1, mp_context=get_context("spawn"), max_tasks_per_child=1) as pool:
        for i in range(processes):
            measured, error = pool.submit(measure, repeats).result()
            for name, seconds in measured.items():
                walls.setdefault(name, []).extend(seconds)
            worst_error = max(worst_error, error)
            if progress:
                progress((i + 1) / processes)
    reference = float(np.median(walls["bare"])) * 1e6 / CALLS
    rows = [_row(name, walls[name], walls["bare"], reference) for name in ("stepped", "exact")]
    factor = END_NS / NS_PER_S / float(np.median(walls["stepped"]))
    return {"bench": "loop", "rows": rows, "max_abs_error": worst_error, "realtime_factor": factor}


def measure(repeats: int) -> tuple[dict[str, list[float]], float]:
    """Time the cases in turn in this process; returns the seconds of each and the largest error."""
    a, b = matrices()
    stepped = _SteppedPlant(a=a, b=b, grid=RateClock.from_rate("1000"))
    exact = _exact_plant()
    cases: dict[str, Callable[[], NDArray[np.float64]]] = {
        "bare": run_bare, "stepped": lambda: _run_loop(stepped), "exact": lambda: _run_loop(exact)}
    walls: dict[str, list[float]] = {name: [] for name in cases}
    truth, worst_error = exact_trajectory(), 0.0
    for i in range(repeats + 1):
        for name, case in cases.items():
            started = perf_counter()
            y = case()
            if i:  # the first round warms up
                walls[name].append(perf_counter() - started)
            worst_error = max(worst_error, float(np.abs(y - truth).max()))
    return walls, worst_error


def _row(case: str, walls: list[float], bare: list[float], reference: float) -> dict[str, Any]:
    """Row of one case; its ratio to the bare loop is the median over neighbouring runs."""
    us = np.array(walls) * 1e6 / CALLS
    return {"case": case, "us_median": float(np.median(us)), "us_p99": float(np.percentile(us, 99)),
            "us_worst": float(us.max()), "reference": "bare block objects on a heap of integer ns",
            "reference_us_median": reference, "ratio": float(np.median(np.array(walls) / np.array(bare)))}
