"""One tick of one chain: what is new and passes the gates goes into its filter; its angles come out."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from estimators.kortier_finger import correct, predict
from estimators.kortier_rows import add_accelerations, add_constraints, add_field
from estimators.kortier_samples import Moment, repeats
from estimators.kortier_work import Work, error_size, fill_rotations, new_work
from fesloop.hand.quaternion_kernels import euler_x_of_zxy, euler_y_of_zxy, euler_z_of_zxy, multiply

Array = NDArray[np.float64]
UNSEEN_SD = math.pi
"""Of a joint that is not seen, rad: of an angle it says nothing."""


class Gates(NamedTuple):
    """When measurements are taken, and how sure joints are.

    Attributes
    ----------
    acc_difference, mag_difference: of the magnitudes of a pair at most, m/s^2 and T (eq. 27).
    rate: of both segments of a pair of accelerometers at most, rad/s (eq. 28).
    constraint_sd, error_time_s: of a joint's forbidden angles, rad, and how long such an error lasts.
    walk: of a bias, rad/s after a second.
    gap_s: after which a segment without a sound sample of the gyroscope is not seen.
    """

    acc_difference: float
    mag_difference: float
    rate: float
    constraint_sd: float
    error_time_s: float
    walk: float
    gap_s: float


class ChainFilter(NamedTuple):
    """Filter of a chain of n joints.

    Attributes
    ----------
    sensors: (n + 1,), numbers; kinds: (n,), BALL, SADDLE or HINGE.
    q, bias, covariance: as of `kortier_finger`. seen: (n,), whether both segments of a joint are seen.
    rates, gyr_variance, acc, steady, acc_variance, kept, used, held_kinds: scratch, as is `work`.
    """

    sensors: NDArray[np.int64]
    kinds: NDArray[np.int64]
    q: Array
    bias: Array
    covariance: Array
    seen: NDArray[np.bool_]
    rates: Array
    gyr_variance: Array
    acc: Array
    steady: Array
    acc_variance: Array
    kept: Array
    used: NDArray[np.bool_]
    held_kinds: NDArray[np.int64]
    work: Work


def new_chain(
    sensors: tuple[int, ...], kinds: tuple[int, ...], q: Array, angle_sd: float, bias_sd: float
) -> ChainFilter:
    """A filter that starts at q (n, 4)."""
    n = len(kinds)
    sds = np.full(error_size(n), bias_sd)
    sds[:3 * n] = angle_sd
    return ChainFilter(
        sensors=np.array(sensors), kinds=np.array(kinds), q=q.copy(), bias=np.zeros((n + 1, 3)),
        covariance=np.diag(sds ** 2), seen=np.zeros(n, dtype=np.bool_), rates=np.zeros((n + 1, 3)),
        gyr_variance=np.zeros(n + 1), acc=np.zeros((n + 1, 3)), steady=np.zeros((n + 1, 3)),
        acc_variance=np.zeros(n + 1), kept=np.zeros((n, 4)), used=np.zeros(n, dtype=np.bool_),
        held_kinds=np.zeros(n, dtype=np.int64), work=new_work(n))


@numba.njit(cache=True)
def track_chain(
    chain: ChainFilter, moment: Moment, elapsed: Any, gates: Gates, orientation: Any, first: int, angles: Any,
    sds: Any,
) -> int:
    """One tick, put out; the entry after the last angle.

    Parameters
    ----------
    elapsed: (3,), as of `kortier_samples.take`.
    orientation: (n, 4), to which that of the chain's segments is added, its base's being there.
    angles, sds: where angles and their sd go from entry `first` on.
    """
    joints = chain.kinds.size
    for k in range(joints + 1):
        s = chain.sensors[k]
        gone = moment.missing[s] > gates.gap_s
        chain.rates[k] = chain.bias[k] if gone else moment.rates[s]
        chain.gyr_variance[k] = 0.0 if gone else moment.gyr_variance[s]
        chain.acc[k] = moment.acc[s]
        chain.steady[k] = moment.steady[s]
        chain.acc_variance[k] = moment.acc_variance[s]
        if k < joints:
            child = chain.sensors[k + 1]
            chain.seen[k] = not gone and moment.missing[child] <= gates.gap_s
            chain.held_kinds[k] = chain.kinds[k] if chain.seen[k] else 0
    if elapsed[0] > 0.0:
        chain.kept[:] = chain.q
        predict(chain.q, chain.bias, chain.covariance, chain.rates, chain.gyr_variance,
                gates.walk ** 2 * elapsed[0], elapsed[0], chain.work)
        for k in range(joints):
            if not chain.seen[k]:
                chain.q[k] = chain.kept[k]
                _forget(chain.covariance, 3 * k)
    if elapsed[1] > 0.0 or elapsed[2] > 0.0:
        fill_rotations(chain.q, chain.work)
        count = _measure(chain, moment, elapsed, gates)
        if count:
            correct(chain.q, chain.bias, chain.covariance, count, chain.work)
    return put_out(chain, orientation, first, angles, sds)


@numba.njit(cache=True)
def _forget(covariance: Any, at: int) -> None:
    """Nothing is known of the joint whose error begins at `at`."""
    for i in range(at, at + 3):
        covariance[i, :] = 0.0
        covariance[:, i] = 0.0
        covariance[i, i] = UNSEEN_SD ** 2 / 3.0


@numba.njit(cache=True)
def _measure(chain: ChainFilter, moment: Moment, elapsed: Any, gates: Gates) -> int:
    """Rows of all that is new and passes; how many."""
    joints = chain.kinds.size
    count = 0
    if elapsed[1] > 0.0:
        for k in range(joints):
            a, b = chain.acc[k], chain.acc[k + 1]
            difference = abs(length(a) - length(b))
            chain.used[k] = (
                chain.seen[k] and chain.acc_variance[k] < math.inf and chain.acc_variance[k + 1] < math.inf
                and difference < gates.acc_difference and length(chain.rates[k]) < gates.rate
                and length(chain.rates[k + 1]) < gates.rate)
        count = add_accelerations(chain.acc, chain.steady, chain.acc_variance, chain.used, count, chain.work)
        variance = repeats(gates.error_time_s, elapsed[1]) * gates.constraint_sd ** 2
        count = add_constraints(chain.held_kinds, variance, count, chain.work)
    if elapsed[2] > 0.0:
        base, tip = chain.sensors[0], chain.sensors[joints]
        variance = moment.mag_variance[base] + moment.mag_variance[tip]
        difference = abs(length(moment.mag[base]) - length(moment.mag[tip]))
        if variance < math.inf and difference < gates.mag_difference and chain.seen.all():
            count = add_field(moment.mag[base], moment.mag[tip], variance, count, chain.work)
    return count


@numba.njit(cache=True)
def length(v: Any) -> float:
    """Length of a vector."""
    return math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])


@numba.njit(cache=True)
def put_out(chain: ChainFilter, orientation: Any, first: int, angles: Any, sds: Any) -> int:
    """Write a chain's orientations, angles and their sd, from entry `first` on; the entry after the last.

    With R = Rz(f) Rx(a) Ry(p), dth = R'z df + Ry(p)'x da + y dp, which is solved for the angles' errors.
    """
    for k in range(chain.kinds.size):
        q = (chain.q[k, 0], chain.q[k, 1], chain.q[k, 2], chain.q[k, 3])
        before = orientation[chain.sensors[k]]
        w, x, y, z = multiply((before[0], before[1], before[2], before[3]), q)
        after = orientation[chain.sensors[k + 1]]
        after[0], after[1], after[2], after[3] = w, x, y, z
        a, p = euler_x_of_zxy(q), euler_y_of_zxy(q)
        sine, cosine, upright = math.sin(p), math.cos(p), max(math.cos(a), 1e-6)
        cov = chain.covariance[3 * k:3 * k + 3, 3 * k:3 * k + 3]
        rows = ((-sine / upright, 0.0, cosine / upright), (cosine, 0.0, sine),
                (sine * math.sin(a) / upright, 1.0, -cosine * math.sin(a) / upright))
        values = (euler_z_of_zxy(q), a, p)
        for i in range(3 - chain.kinds[k]):
            variance = 0.0
            for m in range(3):
                for j in range(3):
                    variance += rows[i][m] * cov[m, j] * rows[i][j]
            angles[first] = values[i]
            sds[first] = min(math.sqrt(variance), UNSEEN_SD) if chain.seen[k] else UNSEEN_SD
            first += 1
    return first
