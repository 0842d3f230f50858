"""PID gains from a patient's model by a stated rule.

Each output has a dominant pattern of drives in each direction: the non-negative drives of least norm that
bring it to 1 rad once the hand is at rest. (A pattern that moves no other output may co-contract antagonists,
which hides the speed of the muscles.) The step response to a pattern is fitted by a delay and one lag; a
rule computes gains from those and the loop's delay. Of both directions, the tuning with the lower gain is
used.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S
from fesloop.models.linear_model import AT_REST_S, LinearModel, zero_order_hold

Array = NDArray[np.float64]
RuleName = Literal["simc", "amigo"]
_STEP_S = 1e-3
"""Step of the step responses (chosen)."""
_EARLY, _LATE = 1.0 - math.exp(-1.0 / 3.0), 1.0 - math.exp(-1.0)
"""Shares of the final value that a single lag reaches after a third of it and after all of it."""
_MOVED_RAD = 0.05
"""Least effect of a channel on an output at full drive for it to be used (chosen: 3 deg)."""


class Lag(NamedTuple):
    """First-order lag with delay: gain exp(-delay_s s) / (lag_s s + 1)."""

    gain: float
    lag_s: float
    delay_s: float


class Gains(NamedTuple):
    """PID gains: kp (1 + 1 / (integral_s s) + derivative_s s) on the error."""

    kp: float
    integral_s: float
    derivative_s: float


class Tuning(NamedTuple):
    """Gains, and the lag that they are computed from, with the loop's delay."""

    gains: Gains
    lag: Lag


def gain_at_rest(model: LinearModel) -> Array:
    """Gain at rest of a model, (outputs, muscles), rad per unit of drive; InputError for an unstable one."""
    growth = float(np.linalg.eigvals(model.a).real.max())
    if not growth < 0.0:
        raise InputError("model", f"a pole with real part {growth:.3g} 1/s: it is not stable",
                         "poles with a real part below 0", "identify it with another method or again")
    return model.gain_at_rest()


def dominant_drives(gain: Array, sense: float) -> Array:
    """Drives (muscles,), none below 0, of least sum of squares that move an output by `sense` rad at rest.

    `gain` (muscles,) is that output's. All are 0 where no drive moves it in this direction.
    """
    pulls = np.maximum(sense * gain, 0.0)
    return pulls / max(float(pulls @ pulls), 1e-300) if pulls.max() >= _MOVED_RAD else 0.0 * pulls


def fitted_lag(model: LinearModel, drives: Array, output: int, sense: float) -> Lag:
    """One lag with delay fitted to the step response of an output to `drives` (muscles,), times `sense`.

    The fit uses the instants at which the response first passes 28.3 % and 63.2 % of its final value (Smith
    1972, Digital Computer Process Control, as in Seborg, Edgar and Mellichamp, Process Dynamics and Control,
    section 7.2): it is exact for a lag with delay that is at rest after 2 s.
    """
    final = float(sense * (gain_at_rest(model) @ drives)[output])
    a, b = zero_order_hold(model.a, model.b, _STEP_S)
    pushed, row = b @ drives, sense * model.c[output]
    x, risen = np.zeros(a.shape[0]), 0.0
    passed: list[float] = []
    for step in range(1, round(AT_REST_S / _STEP_S) + 1):
        x = a @ x + pushed
        before, risen = risen, float(row @ x) / final
        passed += [_STEP_S * (step - (risen - share) / (risen - before))
                   for share in (_EARLY, _LATE)[len(passed):] if risen >= share]
        if len(passed) == 2:
            break
    lag_s = 1.5 * (passed[1] - passed[0])
    return Lag(final, lag_s, max(passed[1] - lag_s, 0.0) + model.delay_ns / NS_PER_S)


def simc(lag: Lag, closed_loop_s: float) -> Gains:
    """PI by Skogestad's rule (2003, doi 10.1016/S0959-1524(02)00062-8, equations 23 and 24).

    `closed_loop_s`: time constant of the closed loop; the delay itself is his choice for fast and
    robust control (gain margin about 3, phase margin 47 to 61 deg).
    """
    slowed = closed_loop_s + lag.delay_s
    return Gains(lag.lag_s / (lag.gain * slowed), min(lag.lag_s, 4.0 * slowed), 0.0)


def amigo(lag: Lag) -> Gains:
    """PID by Astrom and Hagglund's rule (2004, doi 10.1016/j.jprocont.2004.01.002, equation 7)."""
    delay_s, lag_s = lag.delay_s, lag.lag_s
    return Gains((0.2 + 0.45 * lag_s / delay_s) / lag.gain,
                 delay_s * (0.4 * delay_s + 0.8 * lag_s) / (delay_s + 0.1 * lag_s),
                 0.5 * delay_s * lag_s / (0.3 * delay_s + lag_s))


def tuned(model: LinearModel, rule: RuleName, *, extra_delay_s: float, closed_loop_s: float) -> list[Tuning]:
    """Gains of each output; commands are in rad and become drives by the inverse gain at rest.

    Parameters
    ----------
    extra_delay_s: delay of the loop beyond the model's own: age of the samples, half a period of the hold.
    closed_loop_s: time constant for `simc`; 0: as long as the whole delay.

    Raises InputError for an output that no drive moves.
    """
    gain = gain_at_rest(model)

    def judged(lag: Lag) -> Gains:
        return amigo(lag) if rule == "amigo" else simc(lag, closed_loop_s or lag.delay_s)

    return [_of_output(model, gain, output, extra_delay_s, judged) for output in range(model.outputs)]


def _of_output(model: LinearModel, gain: Array, output: int, extra_delay_s: float,
               judged: Callable[[Lag], Gains]) -> Tuning:
    """Gains of an output: the lower of its two directions'."""
    found = []
    for sense in (1.0, -1.0):
        drives = dominant_drives(gain[output], sense)
        if drives.any():
            lag = fitted_lag(model, drives, output, sense)
            lag = lag._replace(delay_s=lag.delay_s + extra_delay_s)
            found.append(Tuning(judged(lag), lag))
    if not found:
        raise InputError("model", f"no drive moves output {output} by {_MOVED_RAD:g} rad",
                         "outputs that can be controlled", "leave it out of the outputs, or add a channel")
    return min(found, key=lambda tuning: tuning.gains.kp)
