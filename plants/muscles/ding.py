"""Force models of Ding and co-workers: calcium binds to troponin pulse by pulse, and force follows.

The 2003 values include fatigue. The 2007 values have none, and that of 2003 does not fit them: with tau2 of
1 ms the growth of tau1 would outweigh the fall of A, and force would grow as the muscle tires.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.forms.schema import require_not_negative, require_positive
from fesloop.hand.movements import MUSCLES
from fesloop.loop.clock import FOREVER, NS_PER_S

Array = NDArray[np.float64]
Instants = NDArray[np.int64]
STEP_NS = 500_000
"""Longest step (chosen: activation is right within 1e-6)."""
NEGLIGIBLE = 1e-100
"""Values below this become zero, as denormal numbers are slow."""
SLOWEST_HZ = 1e-3
"""Frequency below which there are no pulses."""
CALCIUM, TROPONIN, FORCE, SCALING, RELAXATION, SENSITIVITY = range(6)
"""Columns of `muscles`: S, CN, F (N), A (N/s), tau1 (s), Km."""
NODE, START, COUNT, LAST = range(4)
"""Columns of `trains`: instant of the muscle's state; first pulse of the train, number of the next pulse,
newest pulse that recruited fibres (-1: none yet)."""


class Constants(NamedTuple):
    """Coefficients of the model, in s and N. `recovery` is 1 / tfat, 0 for a muscle that does not recover."""

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
    """Derivatives (F', A', tau1', Km')."""
    bound = troponin / (sensitivity + troponin)
    rest = constants.recovery
    return (
        recruited * scaling * bound - force / (relaxation + constants.tau2 * bound),
        rest * (constants.a_rest - scaling) + constants.alpha_a * force,
        rest * (constants.tau1_rest - relaxation) + constants.alpha_tau1 * force,
        rest * (constants.km_rest - sensitivity) + constants.alpha_km * force)


@compiled
def go(muscle: Array, recruited: float, elapsed_s: float, constants: Constants) -> None:
    """Advance one muscle, (6,), by `elapsed_s` without a pulse, in place."""
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
    """Apply the pulse due at the muscle's node; a pulse that recruits nothing has no effect."""
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
    """Advance every muscle, (n, 6) and (n, 4), to its last node before `stop_ns`, in place.

    A pulse at `stop_ns` itself waits for the drive that acts from then on.
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
    """Advance every muscle from its last node to `time_ns`, which becomes a node; none lies in between."""
    for i in range(recruited.size):
        if time_ns > trains[i, NODE]:
            go(muscles[i], recruited[i], (time_ns - trains[i, NODE]) / NS_PER_S, constants)
            trains[i, NODE] = time_ns


@compiled
def change_trains(trains: Instants, before: Array, after: Array, time_ns: int) -> None:
    """Start a new train an interval after the newest pulse where the frequency (n,) changes at `time_ns`."""
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
    """Fill `seen` (2, n), F and A, at `time_ns`, before any further node; the muscles are not changed."""
    for i in range(recruited.size):
        muscle = muscles[i].copy()
        if time_ns > trains[i, NODE]:
            go(muscle, recruited[i], (time_ns - trains[i, NODE]) / NS_PER_S, constants)
        seen[0, i], seen[1, i] = muscle[FORCE], muscle[SCALING]


class PulsedState:
    """Muscles (n, 6), their pulse trains (n, 4), recruited fractions and frequencies."""

    __slots__ = ("frequency", "muscles", "recruited", "trains")

    def __init__(self, fatigued: Array) -> None:
        count = len(MUSCLES)
        self.muscles = np.zeros((count, 6))
        self.muscles[:, SCALING:] = fatigued
        self.trains = np.zeros((count, 4), dtype=np.int64)
        self.trains[:, LAST] = -1
        self.recruited, self.frequency = np.zeros(count), np.zeros(count)

    def copy(self) -> PulsedState:
        """An independent copy."""
        ahead = PulsedState.__new__(PulsedState)
        ahead.muscles, ahead.trains = self.muscles.copy(), self.trains.copy()
        ahead.recruited, ahead.frequency = self.recruited, self.frequency
        return ahead


@dataclass(frozen=True, slots=True)
class PulsedForce:
    """Force of all muscles by pulse trains at their stimulation frequencies.

    The state stays at each muscle's last node, so observations do not split it.
    """

    constants: Constants

    def start(self) -> PulsedState:
        """State at rest, without fatigue."""
        return PulsedState(self._rest())

    def rested(self, state: PulsedState, rest_s: float) -> PulsedState:
        """State at rest, `rest_s` after `state`, partly recovered."""
        tired = state.muscles[:, SCALING:] - self._rest()
        return PulsedState(self._rest() + tired * math.exp(-rest_s * self.constants.recovery))

    def _rest(self) -> Array:
        """A, tau1, Km of the muscle without fatigue."""
        return np.array([self.constants.a_rest, self.constants.tau1_rest, self.constants.km_rest])

    def advance(self, state: PulsedState, stop_ns: int) -> None:
        """Advance to the last node before `stop_ns`."""
        advance_nodes(state.muscles, state.trains, state.recruited, state.frequency, self.constants, stop_ns)

    def change(self, state: PulsedState, time_ns: int, pulses: Array, drive: Array) -> None:
        """Let `pulses` (2, muscles), recruited fraction and frequency, act from `time_ns` on."""
        recruited, frequency = pulses
        self.advance(state, time_ns)
        reach(state.muscles, state.trains, state.recruited, self.constants, time_ns)
        change_trains(state.trains, state.frequency, frequency, time_ns)
        state.recruited, state.frequency = recruited, frequency

    def look(self, state: PulsedState, time_ns: int) -> tuple[Array, Array]:
        """Activation, and A relative to its value at rest, (muscles,) each.

        Activation is force relative to that of the fresh, fully recruited muscle in fused tetanus.
        """
        seen = np.empty((2, len(MUSCLES)))
        look_ahead(state.muscles, state.trains, state.recruited, self.constants, time_ns, seen)
        return seen[0] / self.full_n, seen[1] / self.constants.a_rest

    @property
    def full_n(self) -> float:
        """Force of the fresh, fully recruited muscle in the limit of high frequencies, N."""
        return self.constants.a_rest * (self.constants.tau1_rest + self.constants.tau2)


@dataclass(frozen=True, slots=True, kw_only=True)
class Ding2003Fatigue:
    """Drift of A, tau1 and Km with force, and recovery (Ding 2003 eq. 5, 9, 11).

    Attributes
    ----------
    recovery_s: tfat, s (127).
    scaling_per_s2: alpha_A, 1/s^2 (-0.4).
    relaxation_per_n: alpha_tau1, 1/N (2.1e-5).
    sensitivity_per_n_s: alpha_Km, 1/(N s) (1.9e-5).
    recovers: whether A, tau1 and Km recover.
    """

    recovery_s: float = 127.0
    scaling_per_s2: float = -0.4
    relaxation_per_n: float = 2.1e-5
    sensitivity_per_n_s: float = 1.9e-5
    recovers: bool = True

    def __post_init__(self) -> None:
        require_positive("fatigue", self, "recovery_s")
        require_not_negative("fatigue", self, "relaxation_per_n", "sensitivity_per_n_s")
        if not -math.inf < self.scaling_per_s2 <= 0.0:
            raise InputError("fatigue.scaling_per_s2", f"{self.scaling_per_s2}", "finite numbers, 0 or less")


@dataclass(frozen=True, slots=True, kw_only=True)
class Ding2003:
    """Quadriceps of able-bodied people (Ding 2003, doi 10.1016/S1050-6411(03)00102-0).

    Values are those of cocofest (pyomeca). They serve for muscles of the forearm in the absence of better
    ones: only the force relative to its full value is used.

    Attributes
    ----------
    scaling_n_s: A, N/s (3009).
    relaxation_ms: tau1, without bound cross-bridges (50.957).
    friction_ms: tau2, added by bound cross-bridges (60).
    sensitivity: Km (0.103).
    calcium_ms: tauc (20).
    fatigue: None for muscles that do not tire.
    """

    scaling_n_s: float = 3009.0
    relaxation_ms: float = 50.957
    friction_ms: float = 60.0
    sensitivity: float = 0.103
    calcium_ms: float = 20.0
    fatigue: Ding2003Fatigue | None = None

    def __post_init__(self) -> None:
        require_positive("ding2003", self, "scaling_n_s", "relaxation_ms", "friction_ms", "sensitivity",
                         "calcium_ms")

    def contraction(self) -> PulsedForce:
        """The dynamics."""
        tiring = self.fatigue
        return PulsedForce(Constants(
            1e-3 * self.calcium_ms, 1e-3 * self.friction_ms, self.scaling_n_s, 1e-3 * self.relaxation_ms,
            self.sensitivity, tiring.scaling_per_s2 if tiring else 0.0,
            tiring.relaxation_per_n if tiring else 0.0, tiring.sensitivity_per_n_s if tiring else 0.0,
            1.0 / tiring.recovery_s if tiring and tiring.recovers else 0.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class Ding2007:
    """Quadriceps after spinal cord injury (Ding and co-workers 2007, doi 10.1002/mus.20806).

    Values are those of cocofest; attributes as in `Ding2003`, and the paper's own recruitment.

    Attributes
    ----------
    threshold_us: pd0, narrowest pulse that recruits (131.405).
    width_us: pdt, scale of saturation with wider pulses (194.138).
    """

    scaling_n_s: float = 4920.0
    relaxation_ms: float = 60.601
    friction_ms: float = 1.0
    sensitivity: float = 0.137
    calcium_ms: float = 11.0
    threshold_us: float = 131.405
    width_us: float = 194.138

    def __post_init__(self) -> None:
        require_positive("ding2007", self, "scaling_n_s", "relaxation_ms", "friction_ms", "sensitivity",
                         "calcium_ms", "threshold_us", "width_us")

    def recruitment(self, pulse_width_s: float) -> float:
        """Recruited fraction by pulse width, at the paper's fixed current."""
        wider_us = max(0.0, 1e6 * pulse_width_s - self.threshold_us)
        return -math.expm1(-wider_us / self.width_us)

    def contraction(self) -> PulsedForce:
        """The dynamics."""
        return PulsedForce(Constants(
            1e-3 * self.calcium_ms, 1e-3 * self.friction_ms, self.scaling_n_s, 1e-3 * self.relaxation_ms,
            self.sensitivity, 0.0, 0.0, 0.0, 0.0))
