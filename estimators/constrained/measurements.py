"""Constraints of a joint as scalar measurements of the error state of `estimators.constrained.filter`."""

from __future__ import annotations

import math
from typing import Any

from estimators.body.joint_constraints import BALL, SADDLE
from estimators.constrained.agreement import LEVERS, TILTS, note_axes
from estimators.constrained.vectors import components, cross, dot, rotated, store, turn_by, unit
from fesloop.compiled import compiled
from fesloop.hand.quaternion_kernels import conjugate, multiply

N = 16
PERIOD, TURN, BIAS_WALK, FORCE, SPIN, FORCE_TIME = range(6)
TISSUE, TISSUE_TIME, RANGE, UNSEEN, BIAS, SPACING, EXCESS = range(6, 13)
"""Index of each setting in `settings`. Units, in this order: s; rad/sqrt(s); rad/s/sqrt(s); m/s^2; m (error
of the shared acceleration per rad^2/s^2 of rotation); s; rad; s; rad; rad/s; rad/s; s (between two
measurements of a joint); rad/s (beyond a clipped rate)."""


_MEAN_TIME = 1.0
"""Time constant of a force's mean, s (chosen: longer than tremor and shorter than a posture)."""

_SKEW = 2.5e-3
"""Time by which two sensors feel one movement apart, s: clocks, filters and tissue (chosen)."""

_USUAL = 1.345
"""Sds up to which an innovation counts in full (Huber 1964, doi 10.1214/aoms/1177703732)."""


@compiled
def mean_of(samples: Any, i: int) -> Any:
    """Mean of the two samples of sensor i."""
    return (0.5 * (samples[0, i, 0] + samples[1, i, 0]), 0.5 * (samples[0, i, 1] + samples[1, i, 1]),
            0.5 * (samples[0, i, 2] + samples[1, i, 2]))


@compiled
def measure(
    cov: Any, h: Any, innovation: float, variance: float, x: Any, gain: Any, first: int, last: int
) -> float:
    """Update the error state `x` (N,) and its covariance with a scalar measurement of Jacobian row `h`.

    `x` holds the error estimated so far at this instant. The row is zero except in its first three columns
    and those from `first` to before `last`. An innovation beyond `_USUAL` of its sds gets the variance under
    which it is that many, so that its pull falls with its size. Returns minus twice the log-likelihood, up
    to a constant.
    """
    # Loops over whole rows, which the compiler turns into vector instructions.
    for b in range(N):
        gain[b] = cov[0, b] * h[0] + cov[1, b] * h[1] + cov[2, b] * h[2]
    for a in range(first, last):
        for b in range(N):
            gain[b] += cov[a, b] * h[a]
    total, left = variance, innovation
    for a in range(3):
        total += h[a] * gain[a]
        left -= h[a] * x[a]
    for a in range(first, last):
        total += h[a] * gain[a]
        left -= h[a] * x[a]
    total = max(total, (left / _USUAL) ** 2)
    scale = 1.0 / math.sqrt(total)
    for b in range(N):
        gain[b] *= scale
    left *= scale
    for a in range(N):
        share = gain[a]
        x[a] += share * left
        for b in range(N):
            cov[a, b] -= share * gain[b]
    return left * left + math.log(total)


@compiled
def change_of(samples: Any, i: int, period: float) -> Any:
    """Derivative between the two samples of sensor i."""
    return ((samples[1, i, 0] - samples[0, i, 0]) / period,
            (samples[1, i, 1] - samples[0, i, 1]) / period,
            (samples[1, i, 2] - samples[0, i, 2]) / period)


@compiled
def spin_matrix(w: Any, dw: Any, matrix: Any) -> None:
    """Write M = [dw]x + [w]x [w]x into `matrix` (3, 3)."""
    size = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    for i in range(3):
        for k in range(3):
            matrix[i, k] = w[i] * w[k] - (size if i == k else 0.0)
    matrix[0, 1] -= dw[2]
    matrix[1, 0] += dw[2]
    matrix[0, 2] += dw[1]
    matrix[2, 0] -= dw[1]
    matrix[1, 2] -= dw[0]
    matrix[2, 1] += dw[0]


@compiled
def _lasting(s: Any, v: Any, wc: Any, period: float, settings: Any) -> Any:
    """Remove from force v, in the child's frame, its differences from the mean that are within the noise.

    Only a change of the force's direction shows the heading about it. If noise counted as such a change, the
    sd of an unobservable heading would fall with every sample.
    """
    back = turn_by(-period * wc[0], -period * wc[1], -period * wc[2])
    mean = rotated(back, (s[9], s[10], s[11]))
    share = min(1.0, period / _MEAN_TIME)
    mean = (mean[0] + share * (v[0] - mean[0]), mean[1] + share * (v[1] - mean[1]),
            mean[2] + share * (v[2] - mean[2]))
    s[9], s[10], s[11] = mean
    off = (v[0] - mean[0], v[1] - mean[1], v[2] - mean[2])
    square = dot(off, off)
    kept = max(0.0, 1.0 - settings[FORCE] ** 2 / max(square, 1e-12))
    return mean[0] + kept * off[0], mean[1] + kept * off[1], mean[2] + kept * off[2]


@compiled
def shared_acceleration(
    q: Any, s: Any, cov: Any, gyr: Any, acc: Any, p: int, c: int, settings: Any, x: Any, h: Any,
    gain: Any, levers: Any
) -> float:
    """Update the error state x with the acceleration of the joint's centre, measured from both sides.

    `levers` (2, 3, 3) is filled with the matrices of the lever arms on both sides, in the child's frame.
    """
    wp, wc, period = mean_of(gyr, p), mean_of(gyr, c), settings[PERIOD]
    dp, dc = change_of(gyr, p, period), change_of(gyr, c, period)
    fp, fc = mean_of(acc, p), mean_of(acc, c)
    to_child = conjugate(components(q))
    spin_matrix(wp, dp, levers[0])
    spin_matrix(wc, dc, levers[1])
    m = levers[0]
    v = rotated(to_child, (fp[0] - (m[0, 0] * s[3] + m[0, 1] * s[4] + m[0, 2] * s[5]),
                           fp[1] - (m[1, 0] * s[3] + m[1, 1] * s[4] + m[1, 2] * s[5]),
                           fp[2] - (m[2, 0] * s[3] + m[2, 1] * s[4] + m[2, 2] * s[5])))
    for k in range(3):
        m[0, k], m[1, k], m[2, k] = rotated(to_child, (m[0, k], m[1, k], m[2, k]))
    spin = dot(wp, wp) + dot(wc, wc) + math.sqrt(dot(dp, dp) + dot(dc, dc))
    # Samples closer together than the correlation time carry no more information than one of them.
    jolt_p, jolt_c = change_of(acc, p, period), change_of(acc, c, period)
    jolt = dot(jolt_p, jolt_p) + dot(jolt_c, jolt_c)
    variance = settings[FORCE] ** 2 + (settings[SPIN] * spin) ** 2 + _SKEW ** 2 * jolt
    variance *= max(1.0, settings[FORCE_TIME] / settings[SPACING])
    u = _lasting(s, v, wc, settings[SPACING], settings)
    n = levers[1]
    surprise = 0.0
    for i in range(3):
        # Rows of -[u]x.
        h[0] = 0.0 if i == 0 else -u[2] if i == 1 else u[1]
        h[1] = u[2] if i == 0 else 0.0 if i == 1 else -u[0]
        h[2] = -u[1] if i == 0 else u[0] if i == 1 else 0.0
        for k in range(3):
            h[6 + k] = m[i, k]
            h[9 + k] = -n[i, k]
        of_child = fc[i] - (n[i, 0] * s[6] + n[i, 1] * s[7] + n[i, 2] * s[8])
        surprise += measure(cov, h, v[i] - of_child, variance, x, gain, LEVERS, TILTS)
    return surprise


@compiled
def axes_agree(
    q: Any, s: Any, kind: int, axes: Any, zero: Any, cov: Any, settings: Any, x: Any, h: Any, gain: Any
) -> float:
    """Update the error state x with the axes of a hinge or saddle, tilted as estimated so far.

    How far they are apart is noted in s.

    For a hinge, with e, f two directions perpendicular to its axis and Z the rotation at angle zero, both
    perpendicular components of (a + c_1 e + c_2 f) - R' (p + d_1 Z e + d_2 Z f) are zero. For a saddle, with
    perpendicular axes p, a and n = p x a, (a + c_1 p + c_2 n) . R' (p + d_1 a + d_2 n) = 0.
    """
    if kind == BALL:
        return 0.0
    p, a = (axes[0, 0], axes[0, 1], axes[0, 2]), (axes[1, 0], axes[1, 1], axes[1, 2])
    to_child = conjugate(components(q))
    if kind == SADDLE:
        e, g = p, a
        f = cross(p, a)
        k = f
    else:
        # Perpendicular to the axis, starting from whichever of x and y is farther from it.
        e = unit(cross(a, (1.0, 0.0, 0.0) if abs(a[0]) < abs(a[1]) else (0.0, 1.0, 0.0)))
        f = cross(a, e)
        g, k = rotated(components(zero), e), rotated(components(zero), f)
    own = (a[0] + s[15] * e[0] + s[16] * f[0], a[1] + s[15] * e[1] + s[16] * f[1],
           a[2] + s[15] * e[2] + s[16] * f[2])
    v = rotated(to_child, (p[0] + s[13] * g[0] + s[14] * k[0], p[1] + s[13] * g[1] + s[14] * k[1],
                           p[2] + s[13] * g[2] + s[14] * k[2]))
    g, k = rotated(to_child, g), rotated(to_child, k)
    # Samples closer together than the correlation time carry no more information than one of them.
    variance = settings[TISSUE] ** 2 * max(1.0, settings[TISSUE_TIME] / settings[SPACING])
    if kind == SADDLE:
        h[0], h[1], h[2] = cross(own, v)
        h[12], h[13], h[14], h[15] = dot(own, g), dot(own, k), dot(e, v), dot(f, v)
        apart = dot(own, v)
        note_axes(s, apart ** 2, settings[SPACING])
        return measure(cov, h, -apart, variance, x, gain, TILTS, N)
    surprise, apart = 0.0, 0.0
    for i in range(2):
        n = e if i == 0 else f
        h[0], h[1], h[2] = cross(n, v)
        h[12], h[13], h[14], h[15] = dot(n, g), dot(n, k), -1.0 + i, -1.0 * i
        across = dot(n, own) - dot(n, v)
        apart += 0.5 * across ** 2
        surprise += measure(cov, h, across, variance, x, gain, TILTS, N)
    note_axes(s, apart, settings[SPACING])
    return surprise


@compiled
def correct(q: Any, s: Any, x: Any) -> None:
    """Add the estimated error to the state, and reset the error to zero."""
    store(q, multiply(components(q), turn_by(x[0], x[1], x[2])))
    for i in range(9):
        s[i] += x[3 + i]
    for i in range(4):
        s[13 + i] += x[12 + i]
    x[:] = 0.0
