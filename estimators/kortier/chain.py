"""Error-state filters of chains of segments: prediction, gates on measurements, correction."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.body.body import UNSEEN_SD
from estimators.kortier.error_state import (
    absorb,
    add_outer,
    fill_matrix,
    fill_right_jacobian,
    from_rotation_vector,
    turn,
)
from estimators.kortier.samples import Moment, repeats
from estimators.kortier.tree import Chains
from estimators.kortier.work import (
    Work,
    add_accelerations,
    add_constraints,
    add_field,
    error_size,
    fill_rotations,
    new_work,
)
from fesloop.compiled import compiled
from fesloop.hand.quaternion_kernels import conjugate

UNTURNED = (1.0, 0.0, 0.0, 0.0)


@compiled
def predict(
    q: Any, bias: Any, covariance: Any, rates: Any, gyr_variance: Any, walk_variance: float, dt: float,
    work: Work,
) -> None:
    """Predict the state and covariance of a chain over `dt` s.

    Parameters
    ----------
    q: (n, 4), rotation of each joint, child to parent; bias: (n + 1, 3), rad/s.
    covariance: of the error state.
    rates: (n + 1, 3), rad/s, mean readings of the gyroscopes over the step.
    gyr_variance: (n + 1,), variances of these readings, (rad/s)^2.
    walk_variance: variance that a bias gains in this step, (rad/s)^2.
    """
    joints = q.shape[0]
    before = UNTURNED
    for s in range(joints + 1):
        x, y = dt * (rates[s, 0] - bias[s, 0]), dt * (rates[s, 1] - bias[s, 1])
        z = dt * (rates[s, 2] - bias[s, 2])
        after = from_rotation_vector(x, y, z)
        fill_matrix(conjugate(after), work.step[s])
        fill_right_jacobian(x, y, z, work.jacobian[s])
        if s > 0:
            turn(q[s - 1], conjugate(before), after)
        before = after
    fill_rotations(q, work)
    for k in range(joints):
        for i in range(3):
            for j in range(3):
                work.of_child[k, i, j] = -dt * work.jacobian[k + 1, i, j]
                work.of_parent[k, i, j] = dt * (
                    work.rotation[k, 0, i] * work.jacobian[k, 0, j]
                    + work.rotation[k, 1, i] * work.jacobian[k, 1, j]
                    + work.rotation[k, 2, i] * work.jacobian[k, 2, j])
    _transform(covariance, joints, work)
    for s in range(joints + 1):
        variance = gyr_variance[s]
        if s > 0:
            add_outer(covariance, 3 * s - 3, work.of_child[s - 1], 3 * s - 3, work.of_child[s - 1], variance)
        if s < joints:
            add_outer(covariance, 3 * s, work.of_parent[s], 3 * s, work.of_parent[s], variance)
        if 0 < s < joints:
            add_outer(covariance, 3 * s - 3, work.of_child[s - 1], 3 * s, work.of_parent[s], variance)
            add_outer(covariance, 3 * s, work.of_parent[s], 3 * s - 3, work.of_child[s - 1], variance)
    for i in range(3 * joints, covariance.shape[0]):
        covariance[i, i] += walk_variance


@compiled
def _transform(covariance: Any, joints: int, work: Work) -> None:
    """Compute F P F': biases are constant, each dth depends on itself and the biases of its two segments."""
    size, turns = covariance.shape[0], 3 * joints
    for k in range(joints):
        at, parent, child = 3 * k, turns + 3 * k, turns + 3 * k + 3
        for i in range(3):
            row = work.rows[i]
            for j in range(size):
                row[j] = 0.0
            for m in range(3):
                a, b, c = work.step[k + 1, i, m], work.of_parent[k, i, m], work.of_child[k, i, m]
                for j in range(size):
                    row[j] += (a * covariance[at + m, j] + b * covariance[parent + m, j]
                               + c * covariance[child + m, j])
        for i in range(3):
            for j in range(size):
                covariance[at + i, j] = work.rows[i, j]
    for j in range(turns):
        row = covariance[j]
        # Compute the lower triangle only; the upper one and the biases' rows are its mirror image.
        for k in range(j // 3 + 1):
            at, parent, child = 3 * k, turns + 3 * k, turns + 3 * k + 3
            for i in range(3):
                total = 0.0
                for m in range(3):
                    total += (work.step[k + 1, i, m] * row[at + m] + work.of_parent[k, i, m] * row[parent + m]
                              + work.of_child[k, i, m] * row[child + m])
                work.image[i] = total
            for i in range(3):
                row[at + i] = work.image[i]
        for k in range(j):
            covariance[k, j] = row[k]
        for b in range(turns, size):
            covariance[b, j] = row[b]


@compiled
def correct(q: Any, bias: Any, covariance: Any, count: int, work: Work) -> float:
    """Update the filter with the first `count` measurement rows and correct the state (eq. 12-15).

    Returns the normalised innovation squared, chi-squared with `count` degrees of freedom.
    """
    joints = q.shape[0]
    work.error[:] = 0.0
    nis = 0.0
    for m in range(count):
        nis += absorb(covariance, work.error, work.design[m], work.span[m, 0], work.span[m, 1],
                      work.residual[m], work.variance[m], work.image, work.gain)
    error = work.error
    for k in range(joints):
        turn(q[k], UNTURNED, from_rotation_vector(error[3 * k], error[3 * k + 1], error[3 * k + 2]))
    for s in range(joints + 1):
        for i in range(3):
            bias[s, i] += error[3 * joints + 3 * s + i]
    return nis


Array = NDArray[np.float64]
BALL = 3
"""Number of freedoms of an unconstrained joint."""


class Gates(NamedTuple):
    """Gates on measurements, and assumed errors of joints and biases.

    Attributes
    ----------
    acc_difference, mag_difference: greatest difference of the magnitudes of a pair, m/s^2 and T (eq. 27).
    rate: greatest rate of either segment of a pair of accelerometers, rad/s (eq. 28).
    constraint_sd, error_time_s: sd of the changes of a joint's forbidden angles, rad, and their correlation
        time, s.
    offset_sd: sd of the constant part of a forbidden angle, rad.
    walk: random walk of a bias, rad/s after a second.
    gap_s, unknown_s: time without a sound gyroscope sample after which a segment is unseen, and after which
        its joints are unknown.
    """

    acc_difference: float
    mag_difference: float
    rate: float
    constraint_sd: float
    offset_sd: float
    error_time_s: float
    walk: float
    gap_s: float
    unknown_s: float


class Filters(NamedTuple):
    """State of the filters of all chains, in the layout of `Chains`.

    Attributes
    ----------
    q: (joints, 4), child to parent; bias: (places, 3), rad/s.
    covariance: (entries,), of the error state of each chain (joints, then biases), row by row.
    offset, offset_variance: (joints, 3), constant part of each forbidden angle, rad, and its variance.
    seen: (joints,), whether both segments of a joint are seen; begun: (joints,), whether they ever were.
    """

    q: Array
    bias: Array
    covariance: Array
    offset: Array
    offset_variance: Array
    seen: NDArray[np.bool_]
    begun: NDArray[np.bool_]


class Chain(NamedTuple):
    """One chain of n joints: its part of `Chains` and `Filters`, and the samples of its n + 1 sensors."""

    sensors: Any
    freedoms: Any
    axes: Any
    q: Any
    bias: Any
    covariance: Any
    offset: Any
    offset_variance: Any
    seen: Any
    rates: Any
    gyr_variance: Any
    acc: Any
    steady: Any
    acc_variance: Any


def new_filters(
    chains: Chains, q: Array, angle_sd: float, bias_sd: float, offset_sd: float
) -> Filters:
    """Create filters with the initial rotations q (joints, 4)."""
    covariances = []
    for joints in np.diff(chains.first):
        sds = np.full(error_size(joints), bias_sd)
        sds[:3 * joints] = angle_sd
        covariances.append(np.diag(sds ** 2).ravel())
    return Filters(
        q=q.copy(), bias=np.zeros((chains.sensors.size, 3)),
        covariance=np.concatenate([np.empty(0), *covariances]),
        offset=np.zeros((len(q), 3)), offset_variance=np.full((len(q), 3), offset_sd ** 2),
        seen=np.zeros(len(q), dtype=np.bool_), begun=np.zeros(len(q), dtype=np.bool_))


@compiled
def covariance_of(chain: int, chains: Chains, filters: Filters) -> Any:
    """Return a view of the covariance of one chain's error state."""
    size = error_size(chains.first[chain + 1] - chains.first[chain])
    return filters.covariance[chains.first_entry[chain]:chains.first_entry[chain + 1]].reshape((size, size))


@compiled
def track_chains(
    chains: Chains, filters: Filters, moment: Moment, elapsed: Any, gates: Gates
) -> bool:
    """Advance every chain by a tick; return whether any joint was lost or found again.

    `elapsed` is what Arrivals.note returns.
    """
    longest = 0
    for c in range(chains.first.size - 1):
        longest = max(longest, chains.first[c + 1] - chains.first[c])
    work = new_work(longest)
    at = chains.sensors
    rates, gyr_variance, acc = moment.rates[at], moment.gyr_variance[at], moment.acc[at]
    steady, acc_variance = moment.steady[at], moment.acc_variance[at]
    changed = False
    for c in range(chains.first.size - 1):
        joints = slice(chains.first[c], chains.first[c + 1])
        places = slice(chains.first[c] + c, chains.first[c + 1] + c + 1)
        chain = Chain(
            at[places], chains.freedoms[joints], chains.axes[joints], filters.q[joints], filters.bias[places],
            covariance_of(c, chains, filters), filters.offset[joints], filters.offset_variance[joints],
            filters.seen[joints], rates[places], gyr_variance[places],
            acc[places], steady[places], acc_variance[places])
        changed |= _look(chain, moment, gates, filters.begun[joints])
        _track(chain, moment, elapsed, gates, work)
    return changed


@compiled
def _look(chain: Chain, moment: Moment, gates: Gates, begun: Any) -> bool:
    """Update the mask of seen joints, and return whether it changed."""
    changed = False
    silent = moment.gaps.silent
    for k in range(chain.seen.size):
        seen = max(silent[chain.sensors[k], 0], silent[chain.sensors[k + 1], 0]) <= gates.gap_s
        changed |= seen != chain.seen[k]
        chain.seen[k] = seen
        begun[k] |= seen
    return changed


def begin_again(chains: Chains, filters: Filters, angle_sd: float, bias_sd: float, offset_sd: float) -> None:
    """Give filters the covariance, the biases and the offsets of the beginning; their rotations stay."""
    fresh = new_filters(chains, filters.q, angle_sd, bias_sd, offset_sd)
    for name in ("bias", "covariance", "offset", "offset_variance"):
        getattr(filters, name)[:] = getattr(fresh, name)


@compiled
def _track(chain: Chain, moment: Moment, elapsed: Any, gates: Gates, work: Work) -> None:
    if elapsed[0] > 0.0:
        predict(chain.q, chain.bias, chain.covariance, chain.rates, chain.gyr_variance,
                gates.walk ** 2 * elapsed[0], elapsed[0], work)
        silent = moment.gaps.silent
        for k in range(chain.seen.size):
            if max(silent[chain.sensors[k], 0], silent[chain.sensors[k + 1], 0]) > gates.unknown_s:
                _forget(chain.covariance, 3 * k)
    if elapsed[1] > 0.0 or elapsed[2] > 0.0:
        fill_rotations(chain.q, work)
        count = _measure(chain, moment, elapsed, gates, work)
        if count:
            correct(chain.q, chain.bias, chain.covariance, count, work)


@compiled
def _forget(covariance: Any, at: int) -> None:
    """Reset the covariance of the joint whose error begins at `at` to that of an unknown rotation."""
    for i in range(at, at + 3):
        covariance[i, :] = 0.0
        covariance[:, i] = 0.0
        covariance[i, i] = UNSEEN_SD ** 2 / 3.0


@compiled
def _measure(chain: Chain, moment: Moment, elapsed: Any, gates: Gates, work: Work) -> int:
    """Add rows of new measurements that pass the gates; return their number."""
    joints = chain.seen.size
    count = 0
    if elapsed[1] > 0.0:
        used, freedoms = np.zeros(joints, dtype=np.bool_), chain.freedoms.copy()
        for k in range(joints):
            used[k] = chain.seen[k] and comparable(
                chain.acc[k], chain.acc[k + 1], chain.acc_variance[k] + chain.acc_variance[k + 1],
                chain.rates[k], chain.rates[k + 1], gates)
            if not chain.seen[k]:
                freedoms[k] = BALL
        count = add_accelerations(chain.acc, chain.steady, chain.acc_variance, used, count, work)
        variance = repeats(gates.error_time_s, elapsed[1]) * gates.constraint_sd ** 2
        count = _constrain(chain, freedoms, variance, count, work)
    if elapsed[2] > 0.0 and chain.seen.all():
        base, tip = chain.sensors[0], chain.sensors[joints]
        variance = moment.mag_variance[base] + moment.mag_variance[tip]
        difference = abs(length(moment.mag[base]) - length(moment.mag[tip]))
        if variance < math.inf and difference < gates.mag_difference:
            count = add_field(moment.mag[base], moment.mag[tip], joints, variance, count, work)
    return count


@compiled(inline="always")
def comparable(acc: Any, other: Any, variance: float, rate: Any, other_rate: Any, gates: Gates) -> bool:
    """Return whether the accelerations of two segments pass the gates (eq. 27, 28); `variance` is of both."""
    return bool(variance < math.inf and abs(length(acc) - length(other)) < gates.acc_difference
                and length(rate) < gates.rate and length(other_rate) < gates.rate)


@compiled
def _constrain(chain: Chain, freedoms: Any, variance: float, count: int, work: Work) -> int:
    """Add rows of joint constraints less their offsets, update the offsets; return the number of rows.

    Mounting and tilted axes make a forbidden angle constant, not zero. Each row's innovation is shared
    between the joint's rotation, with variance h P h', and its offset; their correlation is neglected.
    """
    stop = add_constraints(freedoms, chain.axes, variance, count, work)
    for k in range(freedoms.size):
        for forbidden in range(3 - freedoms[k]):
            known, row, at = 0.0, work.design[count], 3 * k
            for i in range(at, at + 3):
                for j in range(at, at + 3):
                    known += row[i] * chain.covariance[i, j] * row[j]
            own = chain.offset_variance[k, forbidden]
            share = own / (known + own + variance)
            work.residual[count] -= chain.offset[k, forbidden]
            work.variance[count] += own
            chain.offset[k, forbidden] += share * work.residual[count]
            chain.offset_variance[k, forbidden] -= share * own
            count += 1
    return stop


@compiled
def length(v: Any) -> float:
    """Length of a vector."""
    return math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
