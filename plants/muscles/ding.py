"""Force models of Ding and co-workers: calcium binds to troponin pulse by pulse, and force follows.

The values of 2003 come with their own fatigue. Those of 2007 have none and can be given none of 2003: with
tau2 of 1 ms the growth of tau1 would outweigh the fall of A, and force would grow as the muscle tires.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.hand.muscles import MUSCLES
from plants.checks import require_not_negative, require_positive
from plants.muscles.ding_kernels import (
    LAST,
    SCALING,
    Constants,
    advance_nodes,
    change_trains,
    look_ahead,
    reach,
)

Array = NDArray[np.float64]


class PulsedState:
    """Muscles (n, 6) and their pulse trains (n, 4) as the kernels take them, and what drives them."""

    __slots__ = ("frequency", "muscles", "recruited", "trains")

    def __init__(self, fatigued: Array) -> None:
        count = len(MUSCLES)
        self.muscles = np.zeros((count, 6))
        self.muscles[:, SCALING:] = fatigued
        self.trains = np.zeros((count, 4), dtype=np.int64)
        self.trains[:, LAST] = -1
        self.recruited, self.frequency = np.zeros(count), np.zeros(count)

    def copy(self) -> PulsedState:
        """A state that can go ahead on its own."""
        ahead = PulsedState.__new__(PulsedState)
        ahead.muscles, ahead.trains = self.muscles.copy(), self.trains.copy()
        ahead.recruited, ahead.frequency = self.recruited, self.frequency
        return ahead


@dataclass(frozen=True, slots=True)
class PulsedForce:
    """All muscles' force by pulse trains at their stimulation frequencies.

    The state stays at each muscle's last node, so looking at it splits nothing.
    """

    constants: Constants

    def start(self) -> PulsedState:
        """At rest, fresh."""
        return PulsedState(self._rest())

    def rested(self, state: PulsedState, rest_s: float) -> PulsedState:
        """At rest, `rest_s` after `state`: what fatigue did has come back in part."""
        tired = state.muscles[:, SCALING:] - self._rest()
        return PulsedState(self._rest() + tired * math.exp(-rest_s * self.constants.recovery))

    def _rest(self) -> Array:
        """A, tau1, Km of the fresh muscle."""
        return np.array([self.constants.a_rest, self.constants.tau1_rest, self.constants.km_rest])

    def advance(self, state: PulsedState, stop_ns: int) -> None:
        """To the last node before `stop_ns`."""
        advance_nodes(state.muscles, state.trains, state.recruited, state.frequency, self.constants, stop_ns)

    def change(self, state: PulsedState, time_ns: int, pulses: Array, drive: Array) -> None:
        """`pulses` (2, muscles), recruited fraction and frequency, act from `time_ns` on."""
        recruited, frequency = pulses
        self.advance(state, time_ns)
        reach(state.muscles, state.trains, state.recruited, self.constants, time_ns)
        change_trains(state.trains, state.frequency, frequency, time_ns)
        state.recruited, state.frequency = recruited, frequency

    def look(self, state: PulsedState, time_ns: int) -> tuple[Array, Array]:
        """Activation and what is left of A, (muscles,) each.

        Activation is force over that of the fresh, fully recruited muscle in fused tetanus.
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
    """A, tau1 and Km drift with force, and back (Ding 2003 eq. 5, 9, 11).

    Attributes
    ----------
    recovery_s: tfat, s (127).
    scaling_per_s2: alpha_A, 1/s^2 (-0.4).
    relaxation_per_n: alpha_tau1, 1/N (2.1e-5).
    sensitivity_per_n_s: alpha_Km, 1/(N s) (1.9e-5).
    recovers: off: what is lost stays lost.
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

    Values as cocofest (pyomeca) has them. For muscles of the forearm they stand for want of better ones:
    only the force over its full value is used.

    Attributes
    ----------
    scaling_n_s: A, N/s (3009).
    relaxation_ms: tau1, without bound cross-bridges (50.957).
    friction_ms: tau2, what bound cross-bridges add (60).
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

    Values as cocofest has them; attributes as of `Ding2003`, and the paper's own recruitment.

    Attributes
    ----------
    threshold_us: pd0, narrowest pulse that recruits (131.405).
    width_us: pdt, by which wider pulses saturate (194.138).
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
        """Recruited fraction that the paper gives to a pulse width at its fixed current."""
        wider_us = max(0.0, 1e6 * pulse_width_s - self.threshold_us)
        return -math.expm1(-wider_us / self.width_us)

    def contraction(self) -> PulsedForce:
        """The dynamics."""
        return PulsedForce(Constants(
            1e-3 * self.calcium_ms, 1e-3 * self.friction_ms, self.scaling_n_s, 1e-3 * self.relaxation_ms,
            self.sensitivity, 0.0, 0.0, 0.0, 0.0))
