"""The force model of Ding, Wexler and Binder-Macleod between and at its pulses, compiled.

    S' = -S / tauc, S += R at a pulse, R = 1 + (Km + 1.04 - 1) exp(-interval / tauc)  (1 at the first pulse)
    CN' = (S - CN) / tauc                                                 calcium-troponin complex
    F' = v A B - F / (tau1 + tau2 B),  B = CN / (Km + CN)                 force, N; v the recruited fraction
    A' = (A_rest - A) / tfat + alpha_A F, and tau1 and Km likewise        fatigue

S and CN are solved in closed form, the rest by Runge-Kutta's fourth order. A muscle goes from node to node:
its pulses, the changes of its drive and the multiples of `STEP_NS`, all instants of its own. So nobody who
looks in between changes a bit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.loop.clock import FOREVER, NS_PER_S
from plants.linear.system import NEGLIGIBLE

Array = NDArray[np.float64]
Instants = NDArray[np.int64]
STEP_NS = 500_000
"""Longest step (chosen: activation is right within 1e-6)."""
SLOWEST_HZ = 1e-3
"""Below this frequency no pulse comes."""
CALCIUM, TROPONIN, FORCE, SCALING, RELAXATION, SENSITIVITY = range(6)
"""Columns of `muscles`: S, CN, F (N), A (N/s), tau1 (s), Km."""
NODE, START, COUNT, LAST = range(4)
"""Columns of `trains`: instant that the muscle is of; first pulse of the train, number of the next pulse,
newest pulse that excited anything (-1: none yet)."""


class Constants(NamedTuple):
    """Numbers of the model; seconds and newtons. `recovery` is 1 / tfat, 0 for a muscle that stays tired."""

    tauc: float
    tau2: float
    a_rest: float
    tau1_rest: float
    km_rest: float
    alpha_a: float
    alpha_tau1: float
    alpha_km: float
    recovery: float


@compiled
def slope(
    force: float, scaling: float, relaxation: float, sensitivity: float, troponin: float, recruited: float,
    constants: Constants,
) -> tuple[float, float, float, float]:
    """(F', A', tau1', Km')."""
    bound = troponin / (sensitivity + troponin)
    rest = constants.recovery
    return (
        recruited * scaling * bound - force / (relaxation + constants.tau2 * bound),
        rest * (constants.a_rest - scaling) + constants.alpha_a * force,
        rest * (constants.tau1_rest - relaxation) + constants.alpha_tau1 * force,
        rest * (constants.km_rest - sensitivity) + constants.alpha_km * force)


@compiled
def go(muscle: Array, recruited: float, elapsed_s: float, constants: Constants) -> None:
    """Take one muscle, (6,), over `elapsed_s` without a pulse, in place."""
    half = math.exp(-0.5 * elapsed_s / constants.tauc)
    grown = 0.5 * elapsed_s / constants.tauc * muscle[CALCIUM]
    middle = (muscle[TROPONIN] + grown) * half
    end = (muscle[TROPONIN] + 2.0 * grown) * half * half
    f, a, t, k = muscle[FORCE], muscle[SCALING], muscle[RELAXATION], muscle[SENSITIVITY]
    h = 0.5 * elapsed_s
    f1, a1, t1, k1 = slope(f, a, t, k, muscle[TROPONIN], recruited, constants)
    f2, a2, t2, k2 = slope(f + h * f1, a + h * a1, t + h * t1, k + h * k1, middle, recruited, constants)
    f3, a3, t3, k3 = slope(f + h * f2, a + h * a2, t + h * t2, k + h * k2, middle, recruited, constants)
    h = elapsed_s
    f4, a4, t4, k4 = slope(f + h * f3, a + h * a3, t + h * t3, k + h * k3, end, recruited, constants)
    h = elapsed_s / 6.0
    muscle[FORCE] = f + h * (f1 + 2.0 * f2 + 2.0 * f3 + f4)
    muscle[SCALING] = a + h * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    muscle[RELAXATION] = t + h * (t1 + 2.0 * t2 + 2.0 * t3 + t4)
    muscle[SENSITIVITY] = k + h * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    muscle[CALCIUM] *= half * half
    muscle[TROPONIN] = end
    for i in (CALCIUM, TROPONIN, FORCE):
        if muscle[i] < NEGLIGIBLE:
            muscle[i] = 0.0


@compiled
def next_pulse(train: Instants, frequency: float) -> int:
    """Instant of the next pulse of one train, (4,), ns."""
    if frequency < SLOWEST_HZ:
        return FOREVER
    return int(train[START]) + int(train[COUNT] * (NS_PER_S / frequency))


@compiled
def fire(muscle: Array, train: Instants, recruited: float, constants: Constants) -> None:
    """The pulse that is due at the muscle's node; one that recruits nothing leaves no trace."""
    train[COUNT] += 1
    if recruited <= 0.0:
        return
    release = 1.0
    if train[LAST] >= 0:
        interval_s = (train[NODE] - train[LAST]) / NS_PER_S
        release += (muscle[SENSITIVITY] + 0.04) * math.exp(-interval_s / constants.tauc)
    muscle[CALCIUM] += release
    train[LAST] = train[NODE]


@compiled
def advance_nodes(
    muscles: Array, trains: Instants, recruited: Array, frequency: Array, constants: Constants, stop_ns: int
) -> None:
    """Take every muscle, (n, 6) and (n, 4), to its last node before `stop_ns`, in place.

    A pulse at `stop_ns` itself waits: it takes the drive that acts from then on.
    """
    for i in range(recruited.size):
        muscle, train = muscles[i], trains[i]
        while True:
            pulse = next_pulse(train, frequency[i])
            node = min(pulse, (train[NODE] // STEP_NS + 1) * STEP_NS)
            if node >= stop_ns:
                break
            if node > train[NODE]:
                go(muscle, recruited[i], (node - train[NODE]) / NS_PER_S, constants)
                train[NODE] = node
            if pulse == node:
                fire(muscle, train, recruited[i], constants)


@compiled
def reach(muscles: Array, trains: Instants, recruited: Array, constants: Constants, time_ns: int) -> None:
    """Take every muscle from its last node to `time_ns`, which becomes a node; none lies in between."""
    for i in range(recruited.size):
        if time_ns > trains[i, NODE]:
            go(muscles[i], recruited[i], (time_ns - trains[i, NODE]) / NS_PER_S, constants)
            trains[i, NODE] = time_ns


@compiled
def change_trains(trains: Instants, before: Array, after: Array, time_ns: int) -> None:
    """Where the frequency (n,) changes at `time_ns`, start a train an interval after the newest pulse."""
    for i in range(after.size):
        if after[i] == before[i]:
            continue
        start = time_ns
        if trains[i, LAST] >= 0 and after[i] >= SLOWEST_HZ:
            start = max(time_ns, trains[i, LAST] + int(NS_PER_S / after[i]))
        trains[i, START], trains[i, COUNT] = start, 0


@compiled
def look_ahead(
    muscles: Array, trains: Instants, recruited: Array, constants: Constants, time_ns: int, seen: Array
) -> None:
    """Fill `seen` (2, n), F and A, at `time_ns`, up to which no node lies; the muscles stay as they are."""
    for i in range(recruited.size):
        muscle = muscles[i].copy()
        if time_ns > trains[i, NODE]:
            go(muscle, recruited[i], (time_ns - trains[i, NODE]) / NS_PER_S, constants)
        seen[0, i], seen[1, i] = muscle[FORCE], muscle[SCALING]
