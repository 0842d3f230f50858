"""Error-state Kalman filter of one joint: relative orientation, gyroscope bias and lever arms.

State: q, child to parent; b (3), rad/s, bias of the child's gyroscope relative to the parent's, in the
child's frame; l_p, l_c (3 each), m, from the joint's centre to each sensor, in that sensor's
frame; d, c (2 each), rad, the tilts of the joint's axes in the parent and in the child, two components across
each. Error state (16): rotation t in the child's frame (R = Rh (I + [t]x)), then b, l_p, l_c, d, c. With M(w)
= [dw/dt]x + [w]x [w]x,

    dt/dt = -[w_c - b]x t - db + noise
    shared acceleration of the joint's centre:  0 = R' (f_p - M(w_p) l_p) - (f_c - M(w_c) l_c) + noise
    hinge: a_c + c = R' (a_p + d) + noise, its two components across a_c
    saddle: 0 = (a_c + c) . R' (a_p + d) + noise
    range: angle - limit = 0 + noise, while the angle is beyond its limit

(f specific force, w angular velocity, a axis; R' = R transposed). The vector pair is that of Kortier et
al. 2014 (doi 10.1186/1743-0003-11-70); the lever arms and the hinge's two rows on three axes are derived
here. All measurements are taken midway between two samples, so that rates, their derivative and forces
belong to one instant. Arrays carry one joint a row.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from estimators.arrivals import CLIPPED
from estimators.arrivals import LOST as MISSING
from estimators.constrained.agreement import TURNED, note, variances
from estimators.constrained.measurements import (
    BIAS,
    BIAS_WALK,
    EXCESS,
    PERIOD,
    RANGE,
    SPACING,
    TISSUE_TIME,
    TURN,
    UNSEEN,
    N,
    axes_agree,
    correct,
    measure,
    shared_acceleration,
)
from estimators.constrained.posture import joint_angles
from estimators.constrained.vectors import components, dot, rotated, store, turn_by
from fesloop.compiled import compiled
from fesloop.hand.quaternion_kernels import conjugate, multiply


@compiled
def keep_in_range(
    q: Any, s: Any, kind: int, axes: Any, zero: Any, ranges: Any, cov: Any, settings: Any,
    x: Any, h: Any, gain: Any, decided: bool
) -> float:
    """Truncate each angle beyond its limit, if its variance exceeds the limit's tolerance.

    The angle then has the mean and variance of its distribution inside the range (Simon 2010, doi
    10.1049/iet-cta.2009.0032, section 2.4), plus the tolerance. There is no truncation while several
    hypotheses are open, as it would hide a wrong one. The error of a limit is constant (it is mostly the
    sensors' mounting), so that repeated measurements add no information; as noise, it would make an angle at
    its limit far too certain.
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
            # The measurement that results in this mean and variance.
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


LOST, EXCEEDED, DOUBTED, SOUND = range(4)
"""Quality of a sample: no rate, a clipped one, a rate without a sound acceleration, sound."""
_COHERENT = 0.25
"""Angle over which a joint's rotation does not reverse, rad, shared by two sensors (chosen)."""


@compiled
def advance(
    q: Any, rest: Any, covariance: Any, surprise: Any, doubt: Any, ends: Any, kinds: Any, axes: Any,
    zero: Any, ranges: Any, gyr: Any, acc: Any, seen: Any, rates: Any, spread: Any, silent: Any,
    settings: Any, number: int, several: bool
) -> bool:
    """Advance all joints by one period; return whether every joint has begun.

    Joints are measured in turns, every few periods: measurements closer than the correlation times of their
    errors add no information.

    Parameters
    ----------
    q: (hypotheses, joints, 4), updated; NaN for a joint that has not begun, which is skipped, and for one
        whose samples have been missing until it is unknown.
    rest: (hypotheses, joints, COLUMNS), b, l_p, l_c, the force's mean in the child's frame, m/s^2,
        duration of clipped rates, s, then d, c, and from TURNED on as in `constrained.agreement`; updated.
    covariance: (hypotheses, joints, 16, 16), updated.
    surprise: (hypotheses, joints), increased by minus twice the log likelihood of the measurements.
    doubt: (joints,), above 0 with several hypotheses.
    ends, kinds, axes, zero, ranges: as in JointTable.
    gyr, acc: (2, n, 3), sample before and this one.
    seen: (2, n), LOST, EXCEEDED, DOUBTED or SOUND. Accelerations are measured between two sound samples
        alone.
    rates: (n, 3), rad/s, mean over the period, spread: (n,), rad^2/s, and silent: (n, 2), s: as in Gaps.
    settings: (13,), see PERIOD and the following; number: of this sample.
    several: whether any joint has more than the first hypothesis.
    """
    x, h, gain, levers = np.empty(N), np.zeros(N), np.empty(N), np.empty((2, 3, 3))
    period = settings[PERIOD]
    every, begun = max(1, round(settings[SPACING] / period)), True
    joints = q.shape[1]
    for each in range(q.shape[0] * joints if several else joints):
        rank, j = each // joints, each % joints
        if np.isnan(q[rank, j, 0]):
            begun &= rank > 0
            continue
        p, c = ends[j, 0], ends[j, 1]
        worst = min(seen[1, p], seen[1, c])
        at, s, cov = q[rank, j], rest[rank, j], covariance[rank, j]
        wp, wc = (rates[p, 0], rates[p, 1], rates[p, 2]), (rates[c, 0], rates[c, 1], rates[c, 2])
        if (number + j) % every > 0:
            _turn(at, s, wp, wc, period)
        else:
            x[:] = 0.0
            _turn(at, s, wp, wc, 0.5 * period)
            before = variances(cov)
            if min(worst, seen[0, p], seen[0, c]) == SOUND:
                surprise[rank, j] += shared_acceleration(
                    at, s, cov, gyr, acc, p, c, settings, x, h, gain, levers)
            surprise[rank, j] += axes_agree(at, s, kinds[j], axes[j], zero[j], cov, settings, x, h, gain)
            note(s, cov, x, before, wc, settings[SPACING])
            correct(at, s, x)
            surprise[rank, j] += keep_in_range(
                at, s, kinds[j], axes[j], zero[j], ranges[j], cov, settings, x, h, gain, doubt[j] == 0.0)
            _turn(at, s, wp, wc, 0.5 * period)
        walked = settings[BIAS_WALK] ** 2 + _turned_bias(at, wp, wc, settings[BIAS])
        turned = settings[TURN] ** 2 + 0.5 * (spread[p] + spread[c])
        _spread(cov, s, wc, period, turned * period, walked * period)
        if worst == EXCEEDED:
            # The excess of a clipped rate is constant: its sd grows with time, not with its square root.
            clipped = s[12]
            s[12] += period
            for i in range(3):
                cov[i, i] += settings[EXCESS] ** 2 * (s[12] ** 2 - clipped ** 2)
            # It may also be a spike, and wrong by as much as itself: that is no misfit of the joint.
            s[TURNED + 3] += period ** 2 * max(dot(wp, wp), dot(wc, wc))
        elif worst > EXCEEDED:
            s[12] = 0.0
        if max(silent[p, 0], silent[c, 0]) * settings[UNSEEN] > math.pi:
            at[:] = np.nan
        begun &= rank > 0 or not np.isnan(at[0])
    return begun


@compiled
def admit(samples: Any, codes: Any, repeated: bool, gyr: Any, acc: Any, seen: Any) -> None:
    """Shift the newest sample to before and store the new one; a lost one as zero.

    `samples` (3, n, 3) and `codes` (3, n) are those of `estimators.arrivals`; if they are `repeated`, all
    count as lost. `gyr`, `acc`, `seen` are as in `advance`.
    """
    for i in range(codes.shape[1]):
        seen[0, i] = seen[1, i]
        if repeated or codes[0, i] & MISSING:
            seen[1, i] = LOST
        elif codes[0, i] & CLIPPED:
            seen[1, i] = EXCEEDED
        else:
            seen[1, i] = SOUND if codes[1, i] == 0 else DOUBTED
        for k in range(3):
            gyr[0, i, k], acc[0, i, k] = gyr[1, i, k], acc[1, i, k]
            gyr[1, i, k] = 0.0 if seen[1, i] == LOST else samples[0, i, k]
            acc[1, i, k] = 0.0 if codes[1, i] & MISSING else samples[1, i, k]


@compiled
def _turn(q: Any, s: Any, wp: Any, wc: Any, dt: float) -> None:
    """Relative rotation after `dt` with constant rates."""
    before = turn_by(-dt * wp[0], -dt * wp[1], -dt * wp[2])
    after = turn_by(dt * (wc[0] - s[0]), dt * (wc[1] - s[1]), dt * (wc[2] - s[2]))
    store(q, multiply(multiply(before, components(q)), after))


@compiled
def _turned_bias(q: Any, wp: Any, wc: Any, bias_sd: float) -> float:
    """Variance that b gains a second, rad^2/s^3, as the parent's share turns in the child's frame."""
    v = rotated(conjugate(components(q)), wp)
    d = (wc[0] - v[0], wc[1] - v[1], wc[2] - v[2])
    return _COHERENT * bias_sd ** 2 * math.sqrt(dot(d, d))


@compiled
def _spread(cov: Any, s: Any, wc: Any, dt: float, turned: float, walked: float) -> None:
    """Covariance after `dt`; `turned` and `walked` are the variances that one sensor adds."""
    w, i, j, k = turn_by(-dt * (wc[0] - s[0]), -dt * (wc[1] - s[1]), -dt * (wc[2] - s[2]))
    r00, r11, r22 = 1.0 - 2.0 * (j * j + k * k), 1.0 - 2.0 * (i * i + k * k), 1.0 - 2.0 * (i * i + j * j)
    r01, r02, r12 = 2.0 * (i * j - w * k), 2.0 * (i * k + w * j), 2.0 * (j * k - w * i)
    r10, r20, r21 = 2.0 * (i * j + w * k), 2.0 * (i * k - w * j), 2.0 * (j * k + w * i)
    for b in range(N):
        x, y, z = cov[0, b], cov[1, b], cov[2, b]
        cov[0, b] = r00 * x + r01 * y + r02 * z - dt * cov[3, b]
        cov[1, b] = r10 * x + r11 * y + r12 * z - dt * cov[4, b]
        cov[2, b] = r20 * x + r21 * y + r22 * z - dt * cov[5, b]
    for a in range(3):
        x, y, z = cov[a, 0], cov[a, 1], cov[a, 2]
        cov[a, 0] = r00 * x + r01 * y + r02 * z - dt * cov[a, 3]
        cov[a, 1] = r10 * x + r11 * y + r12 * z - dt * cov[a, 4]
        cov[a, 2] = r20 * x + r21 * y + r22 * z - dt * cov[a, 5]
        for b in range(3, N):
            cov[b, a] = cov[a, b]
    # Prevents asymmetry by rounding.
    cov[1, 0], cov[2, 0], cov[2, 1] = cov[0, 1], cov[0, 2], cov[1, 2]
    for a in range(3):
        cov[a, a] += 2.0 * turned
        cov[3 + a, 3 + a] += 2.0 * walked
