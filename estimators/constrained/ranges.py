"""A joint's ranges, as measurements on `constrained.filter`'s error state."""

from __future__ import annotations

import math
from typing import Any

from estimators.constrained.measurements import RANGE, SPACING, TISSUE_TIME, correct, measure
from estimators.constrained.posture import joint_angles
from fesloop.compiled import compiled


@compiled
def keep_in_range(
    q: Any, s: Any, kind: int, axes: Any, zero: Any, ranges: Any, cov: Any, settings: Any,
    x: Any, h: Any, gain: Any, decided: bool
) -> float:
    """Each angle beyond its limit is drawn back, as far as it is known worse than the limit's tolerance.

    It then has mean and variance of its distribution inside the range (Simon 2010, doi
    10.1049/iet-cta.2009.0032, section 2.4), the tolerance added. It is not drawn while hypotheses are not
    decided between: a wrong one is to be seen, not to be hidden. The error of a limit lasts (it is mostly the
    sensors' mounting): seen again, it tells nothing new. Were it taken for noise, an angle at its limit would
    soon be believed blindly.
    """
    surprise, tolerance = 0.0, settings[RANGE] ** 2
    angles, rows = joint_angles(q, kind, axes, zero)
    for i in range(kind + 1):
        angle, low, high = angles[i], ranges[i, 0], ranges[i, 1]
        beyond = max(angle - high, 0.0) + min(angle - low, 0.0)
        if beyond == 0.0:
            continue
        h[0], h[1], h[2] = rows[i]
        known = 0.0
        for a in range(3):
            known += h[a] * (cov[a, 0] * h[0] + cov[a, 1] * h[1] + cov[a, 2] * h[2])
        surprise += beyond ** 2 / (known + tolerance) * settings[SPACING] / settings[TISSUE_TIME]
        mean, left = truncated(angle, known, low, high)
        left += tolerance
        if decided and known > left:
            # The measurement after which these are mean and variance.
            measure(cov, h, (mean - angle) * known / (known - left), known * left / (known - left), x, gain,
                     0, 0)
            correct(q, s, x)
            angles, rows = joint_angles(q, kind, axes, zero)
    return surprise


@compiled
def truncated(mean: float, variance: float, low: float, high: float) -> Any:
    """Mean and variance of a normal distribution inside [low, high]."""
    sd = math.sqrt(variance)
    a, b = (low - mean) / sd, (high - mean) / sd
    inside = 0.5 * (math.erf(b / math.sqrt(2.0)) - math.erf(a / math.sqrt(2.0)))
    if inside < 1e-9:
        return min(max(mean, low), high), 0.0
    scale = 1.0 / (math.sqrt(2.0 * math.pi) * inside)
    at_a, at_b = scale * math.exp(-0.5 * a * a), scale * math.exp(-0.5 * b * b)
    shift = at_a - at_b
    wide = (a * at_a if a > -40.0 else 0.0) - (b * at_b if b < 40.0 else 0.0)
    return mean + sd * shift, variance * max(0.0, 1.0 + wide - shift * shift)
