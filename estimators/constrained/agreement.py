"""Agreement of a joint's filter with what it measures: whether the joint is one of its kind at all.

Where the model of a joint holds, the corrections of its filter are uncorrelated, so that the variance of
their sum is what the covariance lost by them. Where it does not (a span over two joints taken for one, a
hinge about another axis, a heading that was decided wrongly), corrections pull one way for as long as a
movement lasts, and their sum exceeds that variance. The sums fade, so that they are those of the last
seconds.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.body.joint_constraints import HINGE
from estimators.constrained.vectors import rotated, turn_by
from fesloop.compiled import compiled

LEVERS, TILTS = 6, 12
"""First column of the lever arms in the error state, and the one behind them."""
TURNED, MOVED, BENT, COLUMNS = 17, 21, 28, 29
"""Columns of a joint's `rest`: the sum of its corrections in rotation, rad, in the child's frame (3), then
its expected variance; that of its lever arms, m (6), then its variance; the mean square by which its axes are
apart, rad^2; and the number of all columns."""
_FADES = 5.0
"""Time constant of sums and means, s (chosen: some movements)."""
_TURNED_LIMIT, _MOVED_LIMIT = 2.0, 2.7
"""Sds of a sum above which corrections disagree (chosen: joints of a real chain and a robot's wrist stay
below 1.0 and 2.3, spans over two of them reach 3.7 and 5.3)."""
_FITS_AGAIN = 0.7
"""Share of these below which a joint fits again: hysteresis of the reports (chosen)."""
_BENT_LIMIT = 1.7
"""The same for axes, in sds of soft tissue (chosen: real hinges stay below .7, wrong ones reach 2.3)."""

_WRONG_LEVERS = 0.3
"""Share of their first sd by which lever arms that were learnt from samples of two instants may be wrong
(chosen: 3 cm; more lets the heading of a ball joint on foam be decided wrongly)."""


@compiled
def variances(cov: Any) -> Any:
    """Sums of the variances of rotation and lever arms."""
    moved = 0.0
    for i in range(6, 12):
        moved += cov[i, i]
    return cov[0, 0] + cov[1, 1] + cov[2, 2], moved


@compiled
def note(s: Any, cov: Any, x: Any, before: Any, wc: Any, elapsed: float) -> None:
    """Add the correction `x` (16,) of one instant to the sums in `s`.

    `before` are the `variances` before it, `wc` the rate of the child's sensor, rad/s, and `elapsed` the time
    since the correction before, s.
    """
    left = math.exp(-elapsed / _FADES)
    back = turn_by(-elapsed * wc[0], -elapsed * wc[1], -elapsed * wc[2])
    turned = rotated(back, (s[TURNED], s[TURNED + 1], s[TURNED + 2]))
    now = variances(cov)
    for i in range(3):
        s[TURNED + i] = left * turned[i] + x[i]
    for i in range(6):
        s[MOVED + i] = left * s[MOVED + i] + x[6 + i]
    s[TURNED + 3] = left * left * s[TURNED + 3] + max(0.0, before[0] - now[0])
    s[MOVED + 6] = left * left * s[MOVED + 6] + max(0.0, before[1] - now[1])


@compiled
def note_axes(s: Any, apart: float, elapsed: float) -> None:
    """Add the mean square by which the axes are apart at one instant, rad^2."""
    s[BENT] += (1.0 - math.exp(-elapsed / _FADES)) * (apart - s[BENT])


@compiled
def contradicted(s: Any) -> bool:
    """Whether corrections of the rotation disagree, as after a heading that was decided wrongly."""
    return bool(_square(s, TURNED, 3) > _TURNED_LIMIT ** 2 * max(s[TURNED + 3], 1e-9))


@compiled
def forget_contradicted(q: Any, rest: Any, doubt: Any, kinds: Any) -> bool:
    """Make joints of several possible headings unknown whose decided heading is contradicted.

    Returns whether there are any.

    q: (hypotheses, joints, 4); rest: (joints, COLUMNS), of the likeliest; doubt: (joints,), above 0 for an
    undecided heading; kinds: (joints,).
    """
    found = False
    for j in range(kinds.size):
        if kinds[j] != HINGE and doubt[j] == 0.0 and contradicted(rest[j]):
            q[:, j] = math.nan
            found = True
    return found


@compiled
def disagreement(s: Any, tissue_sd: float) -> float:
    """Ratio of corrections and axes to what is possible; above 1 the joint is none of its kind."""
    turned, moved = _square(s, TURNED, 3), _square(s, MOVED, 6)
    return max(math.sqrt(turned / max(s[TURNED + 3], 1e-9)) / _TURNED_LIMIT,
               math.sqrt(moved / max(s[MOVED + 6], 1e-9)) / _MOVED_LIMIT,
               math.sqrt(s[BENT]) / (_BENT_LIMIT * tissue_sd))


@compiled
def judge(rest: Any, doubt: Any, tissue_sd: float, misfit: Any, doubted: Any) -> bool:
    """Update which joints do not fit their kind; return whether any changed.

    Parameters
    ----------
    rest: (joints, COLUMNS); doubt: (joints,), sd of headings that are undecided, rad.
    tissue_sd: sd of the rotation of a sensor on soft tissue, rad.
    misfit: (joints,), updated; a joint fits again once it is well below the limit.
    doubted: (joints,), rad, written: `doubt` with what corrections and axes leave unexplained.
    """
    changed = False
    for j in range(doubt.size):
        s, doubted[j] = rest[j], doubt[j]
        if doubt[j] > 0.0:
            continue
        wrong = disagreement(s, tissue_sd) > (_FITS_AGAIN if misfit[j] else 1.0)
        changed |= wrong != misfit[j]
        misfit[j] = wrong
        beyond = max(0.0, _square(s, TURNED, 3) - s[TURNED + 3])
        if s[BENT] > (_BENT_LIMIT * tissue_sd) ** 2:
            beyond += s[BENT]
        doubted[j] = math.sqrt(beyond)
    return changed


def learn_levers_anew(
    rest: NDArray[np.float64], covariance: NDArray[np.float64], lever_sd: NDArray[np.float64]
) -> None:
    """Forget lever arms, and all disagreement, of joints whose sensors get other clocks.

    Lever arms that were learnt from samples of two instants are wrong and certain; as they are put right, all
    corrections pull one way, though the joint is of its kind.

    Parameters
    ----------
    rest: (hypotheses, joints, COLUMNS); covariance: (hypotheses, joints, N, N); both updated.
    lever_sd: (joints, 6), their first sds, m.
    """
    rest[..., TURNED:] = 0.0
    levers = np.arange(LEVERS, TILTS)
    covariance[..., levers, levers] += (_WRONG_LEVERS * lever_sd) ** 2


@compiled
def _square(s: Any, first: int, count: int) -> float:
    total = 0.0
    for i in range(first, first + count):
        total += s[i] * s[i]
    return total
