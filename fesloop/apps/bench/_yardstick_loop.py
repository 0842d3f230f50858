"""The yardstick of `fesloop bench loop`: one small multi-rate loop, bare, with nothing around it.

A second-order plant at 1 kHz (2.5 Hz, damping 0.9, exact zero-order hold), its output delayed by 30 ms, a
PI controller at 50 Hz, a log at 1 kHz; 10 s. That makes 30,500 block calls: plant 10,000, delay 10,000,
log 10,000, controller 500.
"""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

PERIOD_NS, CONTROL_NS, DELAY_NS, END_NS = 1_000_000, 20_000_000, 30_000_000, 10_000_000_000
CALLS = 30_500
KP, KI, REFERENCE, CONTROL_S = 0.6, 3.0, 1.0, 20e-3
_NATURAL, _DAMPING = 2 * np.pi * 2.5, 0.9


def continuous() -> tuple[tuple[tuple[float, ...], ...], tuple[tuple[float, ...], ...]]:
    """(2, 2) and (2, 1): the plant's continuous A and B."""
    return (((0.0, 1.0), (-_NATURAL**2, -2 * _DAMPING * _NATURAL)), ((0.0,), (_NATURAL**2,)))


def matrices() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(2, 2) and (2,): the plant's exact step of 1 ms."""
    stacked = np.zeros((3, 3))
    stacked[:2, :2], stacked[:2, 2:] = continuous()
    step = expm(stacked * 1e-3)
    return np.ascontiguousarray(step[:2, :2]), np.ascontiguousarray(step[:2, 2])


def exact_trajectory() -> NDArray[np.float64]:
    """y at the 10,001 ticks, in plain floats."""
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
    """x' = A x + b u by one numpy step a call."""

    def __init__(self) -> None:
        self.a, self.b = matrices()
        self.x: NDArray[np.float64] = np.zeros(2)
        self.y: Any = 0.0

    def output(self) -> None:
        self.y = self.x[0]

    def update(self, u: float) -> None:
        self.x = self.a.dot(self.x) + self.b * u


class _Delay:
    """A queue of values under way."""

    def __init__(self) -> None:
        self.queue: deque[tuple[int, float]] = deque()
        self.y = 0.0

    def step(self, now: int, u: float) -> None:
        queue = self.queue
        queue.append((now + DELAY_NS, u))
        while queue and queue[0][0] <= now:
            self.y = queue.popleft()[1]


class _Controller:
    """PI."""

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
