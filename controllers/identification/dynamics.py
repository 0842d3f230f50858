"""Identification of linear dynamics from recruited fractions to outputs, under binary widths on all channels.

Two methods give a state-space model x[k+1] = A x[k] + B v[k], y[k] = C x[k] + offset:

"fir": impulse responses by ridge regression, realised by the singular values of their Hankel matrix (Kung
1978; Juang and Pappa 1985, doi 10.2514/3.20031);
"subspace": the observability matrix from the past's instruments (PO-MOESP: Verhaegen 1994, doi
10.1016/0005-1098(94)90230-5).

Both give A and C; B, the offset and the initial state then follow by least squares, as y is linear in them.
Muscles that tire and vary drift: what is slower than `drift_s` is left out of the fit, and no lag may be
slower than a hand's, as it would take up the rest of the drift, and its gains. The input delay and the order
are those with the least Bayesian information criterion among all that are tried. A delay and fast lags have
similar effects, so that the delay is this model's, not exactly the muscle's.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, logm, schur

from fesloop.compiled import compiled
from fesloop.errors import InputError

Array = NDArray[np.float64]
_TINY_RIDGE = 1e-10
"""Ridge for states without excitation, as a share of the regressors' mean power (chosen: rounding)."""


def linear_rest(a: Array, c: Array, drive: Array, measured: Array, drift: Array
                ) -> tuple[Array, Array, Array]:
    """Least-squares b (n, channels), offset (outputs,) and errors (samples, outputs) over a record.

    Parameters
    ----------
    a, c: (n, n), (outputs, n).
    drive: (samples, channels).
    measured: (samples, outputs).
    drift: (samples, k), orthonormal courses that are no effect of the drive, such as a constant (`slow`).
    """
    (samples, channels), (outputs, order) = drive.shape, c.shape
    rows = _regressors(np.ascontiguousarray(a), np.ascontiguousarray(c), np.ascontiguousarray(drive))
    regressors = without(drift, rows.reshape(samples, -1)).reshape(rows.shape)
    gram = regressors.T @ regressors
    gram[np.diag_indices_from(gram)] += _TINY_RIDGE * np.trace(gram) / len(gram)
    target = without(drift, measured).ravel()
    found = np.linalg.solve(gram, regressors.T @ target)
    error = (target - regressors @ found).reshape(samples, outputs)
    offset = (measured.ravel() - rows @ found).reshape(samples, outputs).mean(axis=0)
    b = np.ascontiguousarray(found[:channels * order].reshape(channels, order).T)
    return np.asarray(b), np.asarray(offset), np.asarray(error)


def slow(samples: int, shortest: float) -> Array:
    """Orthonormal courses (samples, k): a constant, and cosines whose half periods fill the record, with
    periods of `shortest` samples or more."""
    k, n = np.arange(int(2 * samples / shortest) + 1), np.arange(samples)[:, np.newaxis]
    return np.asarray(np.linalg.qr(np.cos(math.pi * k * (n + 0.5) / samples))[0])


def without(courses: Array, values: Array) -> Array:
    """Values (samples, m) less their part in the span of orthonormal courses (samples, k)."""
    return np.asarray(values - courses @ (courses.T @ values))


@compiled
def _regressors(a: Array, c: Array, drive: Array) -> Array:
    """Regressors (samples outputs, channels n + n) of B's entries by channel, and of the first state.

    S_c[k+1] = A S_c[k] + v_c[k] I are the states under B = I, one column an entry."""
    samples, channels = drive.shape
    outputs, order = c.shape
    rows = np.zeros((samples * outputs, channels * order + order))
    states = np.zeros((channels, order, order))
    power = c.copy()
    for k in range(samples):
        for channel in range(channels):
            seen = c @ states[channel]
            for i in range(outputs):
                for j in range(order):
                    rows[k * outputs + i, channel * order + j] = seen[i, j]
            states[channel] = a @ states[channel]
            for j in range(order):
                states[channel, j, j] += drive[k, channel]
        for i in range(outputs):
            for j in range(order):
                rows[k * outputs + i, channels * order + j] = power[i, j]
        power = power @ a
    return rows


Method = Literal["fir", "subspace"]
_RIDGE = 1e-3
"""Ridge weight as a share of the inputs' mean power times the number of samples (chosen)."""
_TINY = 1e-9
"""Ridge for dependent rows, as a share of their mean power (chosen: far below any noise)."""
_FASTEST = 1e-3
"""Least modulus of an eigenvalue: of a response that lasts a sample (chosen)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Dynamics:
    """Dynamics x[k+1] = a x[k] + b v[k], y[k] = c x[k] + offset, v the drive after the delay (`delayed`).

    Attributes
    ----------
    a, b, c: (n, n), (n, channels), (outputs, n).
    offset: (outputs,).
    delay_s: delay of the inputs.
    period_s: period of the samples.
    """

    a: Array
    b: Array
    c: Array
    offset: Array
    delay_s: float
    period_s: float

    @property
    def order(self) -> int:
        """Number of states."""
        return int(self.a.shape[0])

    def response(self, drive: Array, start: Array | None = None) -> Array:
        """Outputs (n, outputs) at the samples, from drives (n, channels) and the first state (None: rest)."""
        moved = delayed(drive, self.delay_s / self.period_s)
        x = np.zeros(self.order) if start is None else start
        course = np.empty((len(drive), self.order))
        for k, v in enumerate(moved):
            course[k] = x
            x = self.a @ x + self.b @ v
        return np.asarray(course @ self.c.T + self.offset)

    def continuous(self) -> tuple[Array, Array]:
        """Matrices a, b of x' = a x + b v whose exact zero-order-hold model this is."""
        states, inputs = self.b.shape
        stacked = block_diag(self.a, np.eye(inputs))
        stacked[:states, states:] = self.b
        logarithm = logm(stacked).real / self.period_s
        return logarithm[:states, :states].copy(), logarithm[:states, states:].copy()


def identify_dynamics(drive: Array, measured: Array, period_s: float, *, method: Method = "subspace",
                      memory_s: float = 1.0, slowest_s: float = 2.0, drift_s: float = 20.0,
                      delay_max_s: float = 0.15, delay_step_s: float = 0.005, order_max: int = 12
                      ) -> Dynamics:
    """Identify the dynamics of a record.

    Parameters
    ----------
    drive: (n, channels), recruited fractions, held from each sample to the next.
    measured: (n, outputs), measurements at the samples.
    period_s: period of the samples.
    memory_s: length of impulse responses.
    slowest_s: greatest time constant of a lag. drift_s: shortest period of drift (chosen: in eleven
        recordings of two virtual patients, bounds of 1 to 8 s and periods of 10 and 20 s leave the fit half a
        second ahead as it is; without them drift turned over free runs, to -62 % at worst).
    delay_max_s, delay_step_s: greatest delay that is tried, and distance of delays.
    order_max: greatest number of states.

    Raises InputError for a record that is too short or gives no stable model.
    """
    memory = max(3, round(memory_s / period_s))
    if len(drive) < (drive.shape[1] + 3) * memory // 2:
        raise InputError("identification", f"{len(drive) * period_s:.3g} s of binary widths",
                         f"{(drive.shape[1] + 3) * memory * period_s / 2:.3g} s or more", "a longer prbs_s")
    scale = np.maximum(measured.std(axis=0), 1e-12)
    slowest, drift = math.exp(-period_s / slowest_s), slow(len(drive), drift_s / period_s)
    target = measured / scale
    steady = without(drift, target)
    best: tuple[float, Dynamics] | None = None
    delays = np.arange(0.0, delay_max_s + 0.5 * delay_step_s, delay_step_s)
    for stride in (4, 1):
        for delay_s in _near(delays, stride, best):
            moved = delayed(drive, delay_s / period_s)
            for a, c in _candidates(without(drift, moved), steady, memory, method, order_max, slowest):
                b, offset, error = linear_rest(a, c, moved, target, drift)
                score = _information(error, a.shape[0], drive.shape[1])
                if best is None or score < best[0]:
                    best = score, Dynamics(a=a, b=b, c=scale[:, np.newaxis] * c, offset=scale * offset,
                                           delay_s=float(delay_s), period_s=period_s)
    if best is None:
        raise InputError("identification", "no stable model of this record",
                         remedy="check in the record that the measurements follow the stimulation")
    return best[1]


def _near(delays: Array, stride: int, best: tuple[float, Dynamics] | None) -> Array:
    """Coarse grid of delays; once one is known, the delays around it."""
    if best is None:
        return delays[::stride]
    at = int(np.argmin(np.abs(delays - best[1].delay_s)))
    return np.delete(delays[max(0, at - 3):at + 4], min(at, 3))


def _information(error: Array, order: int, inputs: int) -> float:
    """Bayesian information criterion (Schwarz 1978) of a model with these errors (n, outputs)."""
    samples, outputs = error.shape
    parameters = order * (inputs + outputs)
    return float(samples * np.log((error**2).mean(axis=0)).sum() + parameters * math.log(samples * outputs))


def delayed(drive: Array, periods: float) -> Array:
    """Inputs (n, channels) after a delay, averaged over each sample's interval.

    Before the record they have their first value.
    """
    whole, rest = divmod(periods, 1.0)
    padded = np.concatenate([np.repeat(drive[:1], int(whole) + 1, axis=0), drive])
    return np.asarray((1.0 - rest) * padded[1:len(drive) + 1] + rest * padded[:len(drive)])


def impulse_responses(drive: Array, measured: Array, memory: int, ridge: float = _RIDGE) -> Array:
    """Impulse responses (memory, outputs, channels), from one sample after the pulse, by ridge regression."""
    samples, channels = drive.shape
    rows = np.arange(memory, samples)[:, np.newaxis] - 1 - np.arange(memory)
    regressors = drive[rows].reshape(len(rows), -1)
    centred, target = regressors - regressors.mean(axis=0), measured[memory:] - measured[memory:].mean(axis=0)
    weight = ridge * len(rows) * float((centred**2).mean())
    gram = centred.T @ centred + weight * np.eye(centred.shape[1])
    found = np.linalg.solve(gram, centred.T @ target)
    return np.asarray(found.reshape(memory, channels, -1).transpose(0, 2, 1))


def _candidates(drive: Array, measured: Array, memory: int, method: Method, order_max: int,
                slowest: float) -> Iterator[tuple[Array, Array]]:
    """Pairs A, C of every order, without eigenvalues of modulus `slowest` or more, and without those that no
    sampled system of lags and oscillations has, which are noise."""
    observability = (_observability_by_responses if method == "fir" else _observability_by_instruments)(
        drive, measured, memory)
    outputs = measured.shape[1]
    for order in range(1, min(order_max, observability.shape[1]) + 1):
        columns = observability[:, :order]
        a = np.linalg.lstsq(columns[:-outputs], columns[outputs:], rcond=None)[0]
        form, basis, kept = schur(a, output="real", sort=lambda real, imaginary: (
            _FASTEST < math.hypot(real, imaginary) < slowest and (real > 0.0 or imaginary != 0.0)))
        if kept:
            yield form[:kept, :kept], columns[:outputs] @ basis[:, :kept]


def _observability_by_responses(drive: Array, measured: Array, memory: int) -> Array:
    """Columns that span the extended observability matrix, strongest first, from impulse responses."""
    responses = impulse_responses(drive, measured, memory)
    half = memory // 2
    hankel = np.block([[responses[i + j] for j in range(half)] for i in range(half)])
    left, values, _ = np.linalg.svd(hankel, full_matrices=False)
    return np.asarray(left * np.sqrt(values))


def _observability_by_instruments(drive: Array, measured: Array, memory: int) -> Array:
    """Columns as above by PO-MOESP, with past inputs and outputs as instruments."""
    rows = max(8, memory // 3)
    columns = len(drive) - 2 * rows + 1
    centred_u, centred_y = drive - drive.mean(axis=0), measured - measured.mean(axis=0)

    def hankel(values: Array, first: int) -> Array:
        return np.concatenate([values[first + i:first + i + columns].T for i in range(rows)])

    future_u, future_y = hankel(centred_u, rows), hankel(centred_y, rows)
    past = np.concatenate([hankel(centred_u, 0), hankel(centred_y, 0)])
    stacked = np.concatenate([future_u, past, future_y])
    gram = stacked @ stacked.T
    gram[np.diag_indices_from(gram)] += _TINY * np.trace(gram) / len(gram)
    triangle = np.linalg.cholesky(gram)
    inputs, instruments = len(future_u), len(past)
    projected = triangle[inputs + instruments:, inputs:inputs + instruments]
    left, values, _ = np.linalg.svd(projected, full_matrices=False)
    return np.asarray(left * np.sqrt(values))
