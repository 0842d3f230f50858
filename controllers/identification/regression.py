"""What of a state-space model is linear once A and C are known: B, the offset and the state at the start."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled

Array = NDArray[np.float64]
_TINY_RIDGE = 1e-10
"""Against states that nothing excites, as a share of the mean power of the regressors (chosen: rounding)."""


def linear_rest(a: Array, c: Array, drive: Array, measured: Array) -> tuple[Array, Array, Array]:
    """(b (n, channels), offset (outputs,), errors (samples, outputs)) by least squares over a record.

    Parameters
    ----------
    a, c: (n, n), (outputs, n).
    drive: (samples, channels).
    measured: (samples, outputs).
    """
    (samples, channels), (outputs, order) = drive.shape, c.shape
    regressors = _regressors(np.ascontiguousarray(a), np.ascontiguousarray(c), np.ascontiguousarray(drive))
    gram = regressors.T @ regressors
    gram[np.diag_indices_from(gram)] += _TINY_RIDGE * np.trace(gram) / len(gram)
    found = np.linalg.solve(gram, regressors.T @ measured.ravel())
    error = (measured.ravel() - regressors @ found).reshape(samples, outputs)
    b = np.ascontiguousarray(found[:channels * order].reshape(channels, order).T)
    return np.asarray(b), np.asarray(found[-outputs:]), np.asarray(error)


@compiled
def _regressors(a: Array, c: Array, drive: Array) -> Array:
    """(samples outputs, channels n + n + outputs): of B's entries channel by channel, of the first state, of
    the offset. S_c[k+1] = A S_c[k] + v_c[k] I are the states under B = I, one column an entry."""
    samples, channels = drive.shape
    outputs, order = c.shape
    rows = np.zeros((samples * outputs, channels * order + order + outputs))
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
            rows[k * outputs + i, channels * order + order + i] = 1.0
        power = power @ a
    return rows
