"""Rotation of sensors through gaps in their samples: predicted within a gap, made good at its end.

The angle of a segment counts as a stationary random process of second order, critically damped, whose rate
has standard deviation s about each axis: cov(w(0), w(t)) = s^2 (1 - k t) exp(-k t). From the last rate a
before a gap and the first one b after it, D later, the turn in between has (Gaussian conditioning: Rasmussen
and Williams 2006, eq. 2.19)

    within the gap, from a alone:  mean a D e,                variance V - s^2 D^2 e^2
    after it, from a and b:        mean (a + b) D e / (1 + r), variance V - 2 s^2 D^2 e^2 / (1 + r)

with e = exp(-k D), r = (1 - k D) e and V = 2 s^2 / k^2 (1 - (1 + k D) e). In a short gap these are the last
rate held, and a straight line between both; in a long one the segment is about where it was. The second
variance is below the first: it is added for good as the gap lasts, the rest is there until the gap ends.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.arrivals import LOST
from fesloop.compiled import assign, compiled

Array = NDArray[np.float64]
_DAMPING = 2.0
"""k, 1/s (chosen: rates of people's arms and hands, and of a jointed chain moved by hand, are uncorrelated
after .3 to 1 s)."""
_OVER_S = 1.0
"""Silence after which the predicted rate is that of a sensor at rest, s (chosen: twice 1 / k)."""


class Gaps(NamedTuple):
    """Rotation of n sensors over the newest step, and the state of their gaps.

    Attributes
    ----------
    rates: (n, 3), rad/s, of the step as single samples tell it: the newest sample, within a gap the predicted
        rate, and at its end what also brings the turn since its start to its mean.
    means: (n, 3), rad/s, of the step between the samples at its ends, likewise.
    spread: (n,), rad^2/s, variance that each second of the step adds to the turn about each axis for good.
    pending: (n,), rad^2, variance about each axis that the gap's end removes; 0 outside of gaps.
    last: (n, 3), rad/s, newest sound sample.
    silent: (n, 2), s, since that sample: by the steps of the filter, and by the samples' stamps; infinite
        before the first.
    predicted: (n, 3), rad, turn since that sample that has been predicted.
    """

    rates: Array
    means: Array
    spread: Array
    pending: Array
    last: Array
    silent: Array
    predicted: Array

    @classmethod
    def none(cls, sensors: int) -> Gaps:
        """Create the state before the first sample."""
        vectors = [np.zeros((sensors, 3)) for _ in range(4)]
        return cls(vectors[0], vectors[1], np.zeros(sensors), np.zeros(sensors), vectors[2],
                   np.full((sensors, 2), np.inf), vectors[3])


@compiled
def turn_within(gap_s: float, rate_sd: float) -> tuple[float, float]:
    """Turn in a gap that lasts: its mean per rad/s of the last rate, s, and its variance, rad^2, an axis."""
    x = _DAMPING * gap_s
    fading = math.exp(-x)
    share = gap_s * fading
    any_turn = 2.0 * (1.0 - (1.0 + x) * fading) / _DAMPING ** 2
    return share, rate_sd ** 2 * (any_turn - share ** 2)


@compiled
def turn_after(gap_s: float, rate_sd: float) -> tuple[float, float]:
    """Turn in a gap that has ended: its mean per rad/s of both rates, s, and its variance, rad^2, an axis."""
    x = _DAMPING * gap_s
    fading = math.exp(-x)
    share = gap_s * fading / (1.0 + (1.0 - x) * fading)
    any_turn = 2.0 * (1.0 - (1.0 + x) * fading) / _DAMPING ** 2
    return share, rate_sd ** 2 * (any_turn - 2.0 * share * gap_s * fading)


@compiled
def bridge(
    gyr: Any, codes: Any, step_s: float, captured_s: float, period_s: float, rate_sd: float, gaps: Gaps
) -> bool:
    """Update `gaps` by a step of a filter; return whether any sensor is in a gap, or at its end.

    Parameters
    ----------
    gyr: (n, 3), rad/s, samples.
    codes: (n,), fault codes of the gyroscopes (`estimators.arrivals`).
    step_s: time by which the filter advances, s, above 0.
    captured_s: time between the stamps of these samples and of those before, s; 0 if there is no newer
        sample: all sensors are in a gap.
    period_s: of the gyroscopes. Stamps that differ from the number of samples by less count as jitter.
    rate_sd: s, rad/s.
    """
    found = False
    for i in range(gyr.shape[0]):
        silent, sound = gaps.silent[i], captured_s > 0.0 and codes[i] & LOST == 0
        passed = silent[0]
        silent[0] += step_s
        silent[1] += captured_s
        if passed == math.inf:
            if sound:
                assign(gaps.last[i], gyr[i])
                silent[:] = 0.0
                assign(gaps.means[i], gyr[i])
                assign(gaps.rates[i], gyr[i])
            continue
        if not sound:
            found = True
            _predict(gaps, i, passed, step_s, rate_sd)
            continue
        lasted = silent[1] if abs(silent[0] - silent[1]) > (1.0 - 1e-6) * period_s else silent[0]
        if passed == 0.0 and lasted < 1.5 * period_s:
            gaps.spread[i] = 0.0
            for a in range(3):
                gaps.means[i, a] = 0.5 * (gaps.last[i, a] + gyr[i, a])
                gaps.rates[i, a] = gaps.last[i, a] = gyr[i, a]
        else:
            found = True
            _make_good(gaps, i, gyr[i], passed, lasted, step_s, period_s, rate_sd)
        silent[:] = 0.0
    return found


@compiled
def _predict(gaps: Gaps, i: int, passed: float, step_s: float, rate_sd: float) -> None:
    """Advance sensor i by a step within a gap."""
    lasted = passed + step_s
    share, variance = turn_within(lasted, rate_sd)
    after = turn_after(lasted, rate_sd)[1]
    share -= turn_within(passed, rate_sd)[0]
    for a in range(3):
        turn = gaps.last[i, a] * share
        gaps.means[i, a] = gaps.rates[i, a] = turn / step_s
        gaps.predicted[i, a] += turn
    gaps.spread[i] = max(0.0, after - turn_after(passed, rate_sd)[1]) / step_s
    gaps.pending[i] = variance - after


@compiled
def _make_good(
    gaps: Gaps, i: int, rate: Any, passed: float, lasted: float, step_s: float, period_s: float,
    rate_sd: float
) -> None:
    """Advance sensor i by the step that ends its gap, with the turn that the prediction has missed."""
    share, variance = turn_after(lasted, rate_sd)
    for a in range(3):
        # A filter that takes a sample as the rate of its whole step is half a period ahead of the sample.
        ahead = 0.5 * period_s * (rate[a] - gaps.last[i, a])
        turn = share * (gaps.last[i, a] + rate[a]) - gaps.predicted[i, a]
        gaps.means[i, a], gaps.rates[i, a] = turn / step_s, (turn + ahead) / step_s
        gaps.last[i, a], gaps.predicted[i, a] = rate[a], 0.0
    gaps.spread[i] = max(0.0, variance - turn_after(passed, rate_sd)[1]) / step_s
    gaps.pending[i] = 0.0


def lost_samples(codes: NDArray[np.uint8], repeated: bool, gaps: Gaps) -> NDArray[np.bool_]:
    """Mask (3, n) of gyr, acc and mag that a filter of single sensors has to do without.

    Rates are there within a gap, until their prediction has faded: zeros would be learnt as a bias.

    Parameters
    ----------
    codes: (3, n), as in `estimators.arrivals`.
    repeated: whether no sample is new.
    """
    lost = np.asarray((codes & LOST) != 0) | repeated
    lost[0] = gaps.silent[:, 0] > _OVER_S
    return lost
