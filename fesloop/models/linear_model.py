"""Model of a plant for a controller: linear dynamics behind recruitment and a pure delay."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.special import ndtri

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.forms.schema import matrix
from fesloop.loop.clock import NS_PER_S, RateClock

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]


@compiled
def recruit(
    stimulation: Array, threshold_ma: Array, spread: Array, chronaxie_us: float, fraction: Array
) -> None:
    """Fill `fraction` (muscles,) under `stimulation` (muscles, 2): current in A, pulse width in s."""
    for i in range(threshold_ma.size):
        current, width = stimulation[i, 0], stimulation[i, 1]
        if current > 0.0 and width > 0.0:
            effective_ma = 1e3 * current / (1.0 + 1e-6 * chronaxie_us / width)
            z = math.log(effective_ma / threshold_ma[i]) / spread[i]
            fraction[i] = 0.5 * math.erfc(-z * math.sqrt(0.5))
        else:
            fraction[i] = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Recruitment:
    """Recruitment curves of several muscles.

    Attributes
    ----------
    threshold_ma: effective current that recruits half of each muscle, mA.
    spread: standard deviation of the logarithm of the thresholds (lower is steeper).
    chronaxie_us: of the strength-duration curve, us.
    """

    threshold_ma: tuple[float, ...]
    spread: tuple[float, ...]
    chronaxie_us: float = 200.0
    _threshold_ma: Array = field(init=False, repr=False, compare=False)
    _spread: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if len(self.threshold_ma) != len(self.spread):
            raise InputError("recruitment.spread", f"{len(self.spread)} values",
                             f"{len(self.threshold_ma)}, one a muscle as in threshold_ma")
        for key, values in (("threshold_ma", self.threshold_ma), ("spread", self.spread),
                            ("chronaxie_us", (self.chronaxie_us,))):
            if not all(math.isfinite(v) and v > 0 for v in values):
                raise InputError(f"recruitment.{key}", f"{values} holds a value that is not positive",
                                 "finite values above 0")
        object.__setattr__(self, "_threshold_ma", np.array(self.threshold_ma, dtype=np.float64))
        object.__setattr__(self, "_spread", np.array(self.spread, dtype=np.float64))

    @property
    def muscles(self) -> int:
        """Number of muscles."""
        return len(self.threshold_ma)

    def fraction(self, stimulation: Array) -> Array:
        """Recruited fraction of each muscle, (muscles,) in [0, 1].

        `stimulation` is (muscles, 2): current in A and pulse width in s. Zero where either is zero or
        less. Raises InputError for another shape.
        """
        if stimulation.shape != (self.muscles, 2):
            raise InputError("stimulation", f"shape {stimulation.shape}", f"({self.muscles}, 2)")
        fraction = np.empty(self.muscles)
        recruit(stimulation, self._threshold_ma, self._spread, self.chronaxie_us, fraction)
        return fraction

    def pulse_width_s(self, fraction: Array, current_a: Array) -> Array:
        """Pulse width in s that recruits `fraction` of each muscle at the given current, (muscles,).

        Zero where the fraction is zero or less; infinite where no width at this current reaches it.
        """
        effective_ma = self._threshold_ma * np.exp(self._spread * ndtri(np.clip(fraction, 0.0, 1.0)))
        room = 1e3 * np.asarray(current_a) - effective_ma
        active = np.asarray(fraction) > 0.0
        width = np.full(self.muscles, np.inf)
        reachable = room > 0.0
        width[reachable] = 1e-6 * self.chronaxie_us * effective_ma[reachable] / room[reachable]
        return np.where(active, width, 0.0)


Matrix = NDArray[np.float64]

_MOST_STORED = 2000
"""Periods of a delay, each a state for every input (chosen: 2 s at 1 kHz)."""


@dataclass(frozen=True, slots=True, eq=False)
class SampledModel:
    """x[k+1] = a x[k] + b v[k], y[k] = c x[k] + offset: exact at the samples, delay included."""

    a: Matrix
    b: Matrix
    c: Matrix
    offset: NDArray[np.float64]
    delay_steps: int
    """Whole steps before v[k] first shows in y."""

    def lifted(self, samples: int) -> Matrix:
        """Lower block-triangular G with y[0..samples-1] = G v[0..samples-1] from rest."""
        outputs, inputs = self.c.shape[0], self.b.shape[1]
        lifted = np.zeros((samples * outputs, samples * inputs))
        power = self.b
        for lag in range(1, samples):
            markov = self.c @ power
            power = self.a @ power
            for k in range(lag, samples):
                lifted[k * outputs:(k + 1) * outputs, (k - lag) * inputs:(k - lag + 1) * inputs] = markov
        return lifted


AT_REST_S = 2.0
"""Time after which a hand is at rest under constant drives (chosen). What an identified model lets change
later is drift of the recording that it was identified on, by muscles that tire among others."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearModel:
    """x' = a x + b v(t - delay), y = c x + offset, v the recruited fractions.

    Attributes
    ----------
    a, b, c: (n, n), (n, muscles), (outputs, n); time in s.
    offset: (outputs,), y at rest, rad.
    delay_ns: electromechanical delay.
    recruitment: from stimulation to v; None where v itself is the plant's input.

    Raises InputError for matrices that do not fit each other or are not finite, and for a delay below 0.
    """

    FILE_KEYS: ClassVar[Mapping[str, type]] = MappingProxyType(
        dict.fromkeys(("any_patient", "any_fit", "channels"), bool))
    OFFERED_BY: ClassVar[str] = "linear_model"

    a: Matrix
    b: Matrix
    c: Matrix
    offset: NDArray[np.float64]
    delay_ns: int = 0
    recruitment: Recruitment | None = None

    def __post_init__(self) -> None:
        for key in ("a", "b", "c", "offset"):
            object.__setattr__(self, key, matrix(key, getattr(self, key)))
        states, inputs, outputs = self.a.shape[0], self.b.shape[-1], self.c.shape[0]
        for key, shape, meaning in (("a", (states, states), "states by states"),
                                    ("b", (states, inputs), "states (rows of a) by muscles"),
                                    ("c", (outputs, states), "outputs by states (rows of a)"),
                                    ("offset", (outputs,), "one an output (row of c)")):
            found = getattr(self, key)
            if found.shape != shape or 0 in shape:
                raise InputError(key, f"shape {found.shape}",
                                 f"shape {shape}: {meaning}, one or more of each")
            if not np.isfinite(found).all():
                raise InputError(key, "numbers that are not finite", "finite numbers")
        if self.delay_ns < 0:
            raise InputError("delay_ns", f"{self.delay_ns}", "0 or more ns")
        if self.recruitment is not None and self.recruitment.muscles != inputs:
            raise InputError("recruitment", f"{self.recruitment.muscles} muscles",
                             f"{inputs}, as b has columns")

    @property
    def inputs(self) -> int:
        """Number of muscles."""
        return int(self.b.shape[1])

    @property
    def outputs(self) -> int:
        """Number of outputs."""
        return int(self.c.shape[0])

    def digest(self) -> str:
        """SHA-256 of the model's numbers, as 64 hexadecimal digits: the same for the same model."""
        found = hashlib.sha256()
        curve = self.recruitment
        curves = () if curve is None else (curve.threshold_ma, curve.spread, curve.chronaxie_us)
        for each in (self.a, self.b, self.c, self.offset, self.delay_ns, *curves):
            numbers = np.asarray(each, dtype="<f8") + 0.0  # -0.0 is 0.0
            found.update(f"{numbers.shape}".encode() + numbers.tobytes())
        return found.hexdigest()

    def gain_at_rest(self) -> Matrix:
        """Effect of drives that have acted for `AT_REST_S`, (outputs, muscles), rad per unit of drive."""
        return self.c @ zero_order_hold(self.a, self.b, AT_REST_S)[1]

    def to_control(self, rate: str | int | float | None = None, pade_order: int = 0) -> control.StateSpace:
        """The dynamics as a `control.StateSpace`, from recruited fractions to outputs less their offset.

        Parameters
        ----------
        rate: in hertz, for an exact discrete-time system with the delay as states; None: continuous time.
        pade_order: order of the Pade approximation of the delay in continuous time.

        Raises InputError for a delay in continuous time without an order: it has no exact form there.
        """
        import control

        feedthrough = np.zeros((self.outputs, self.inputs))
        if rate is not None:
            clock = RateClock.from_rate(rate)
            sampled = self.sampled(round(clock.period_s * NS_PER_S))
            return control.ss(sampled.a, sampled.b, sampled.c, feedthrough, clock.period_s)
        system = control.ss(self.a, self.b, self.c, feedthrough)
        if self.delay_ns == 0:
            return system
        if pade_order < 1:
            raise InputError("delay_ns", f"{self.delay_ns} ns have no form in continuous time", "no delay",
                             "give rate for an exact discrete-time system, or pade_order")
        delay = control.ss(control.tf(*control.pade(self.delay_ns / NS_PER_S, pade_order)))
        return system * control.append(*[delay] * self.inputs)

    @classmethod
    def from_control(cls, system: control.StateSpace, **parameters: Any) -> Self:
        """The model with the dynamics of a continuous-time `control.StateSpace` without feedthrough.

        `parameters` are the other attributes; `offset` is zero unless it is given. Raises InputError for
        another system.
        """
        a, b, c, d = continuous_matrices("system", system)
        if d.any():
            raise InputError("system", "has a direct feedthrough", "D = 0")
        return cls(a=a, b=b, c=c, **{"offset": np.zeros(len(c)), **parameters})

    def sampled(self, period_ns: int, extra_delay_ns: int = 0) -> SampledModel:
        """Exact zero-order-hold model at a period, with any (fractional) input delay.

        A delay of d whole periods and a rest is carried by past inputs as states, newest first
        (Franklin, Powell, Workman 1998, section 4.3.4). Raises InputError for a period of 0 or less, a
        delay of more than 2000 periods, and dynamics that grow beyond floats within one.
        """
        if period_ns <= 0:
            raise InputError("period_ns", f"{period_ns}", "above 0")
        delay = self.delay_ns + extra_delay_ns
        whole, rest = divmod(delay, period_ns)
        states, inputs = self.b.shape
        a_full, b_late = zero_order_hold(self.a, self.b, (period_ns - rest) / NS_PER_S)
        if rest:
            a_rest, b_rest = zero_order_hold(self.a, self.b, rest / NS_PER_S)
            b_early = a_full @ b_rest
            a_step = a_full @ a_rest
        else:
            b_early, a_step = np.zeros_like(b_late), a_full
        stored = whole + (1 if rest else 0)
        if stored > _MOST_STORED:
            raise InputError("delay_ns", f"{delay} ns are {stored} periods", f"at most {_MOST_STORED}")
        if stored == 0:
            return SampledModel(a_step, b_late, self.c, self.offset, 0)
        size = states + stored * inputs
        a = np.zeros((size, size))
        b = np.zeros((size, inputs))
        a[:states, :states] = a_step

        def past(lag: int) -> slice:
            return slice(states + (lag - 1) * inputs, states + lag * inputs)

        if rest:
            a[:states, past(whole + 1)] = b_early
        if whole:
            a[:states, past(whole)] = b_late
        else:
            b[:states] = b_late
        b[past(1)] = np.eye(inputs)
        for lag in range(2, stored + 1):
            a[past(lag), past(lag - 1)] = np.eye(inputs)
        c = np.hstack([self.c, np.zeros((self.outputs, stored * inputs))])
        return SampledModel(a, b, c, self.offset, whole)


def continuous_matrices(where: str, system: Any) -> tuple[Matrix, Matrix, Matrix, Matrix]:
    """A, B, C and D of a continuous-time `control.StateSpace`. Raises InputError for any other system."""
    if not all(hasattr(system, key) for key in "ABCD"):
        raise InputError(where, f"a {type(system).__name__}", "a control.StateSpace",
                         "convert it with control.ss")
    if system.dt:
        raise InputError(where, f"a discrete-time system, dt = {system.dt}", "continuous time (dt = 0)",
                         "convert it, or give the continuous system")
    a, b, c, d = (np.asarray(getattr(system, key), dtype=np.float64) for key in "ABCD")
    return a, b, c, d


def zero_order_hold(a: Matrix, b: Matrix, duration_s: float) -> tuple[Matrix, Matrix]:
    """(Phi, Gamma) = (exp(a T), integral from 0 to T of exp(a s) ds b): x after T is Phi x + Gamma u, u held.

    One exponential of the stacked matrix (Van Loan 1978, doi 10.1109/TAC.1978.1101743). Raises InputError
    where that is not finite.
    """
    states, inputs = b.shape
    stacked = np.zeros((states + inputs, states + inputs))
    stacked[:states, :states], stacked[:states, states:] = a, b
    with np.errstate(over="ignore", invalid="ignore"):
        exponential = expm(stacked * duration_s)
    if not np.isfinite(exponential).all():
        raise InputError("a", f"grows beyond the range of floats within {duration_s:g} s",
                         "eigenvalues of a size that occurs")
    return exponential[:states, :states], exponential[:states, states:]
