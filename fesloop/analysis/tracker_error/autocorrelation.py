"""Autocorrelation of what has gaps, and how many independent values a record is worth."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled

Array = NDArray[np.float64]


@compiled
def autocorrelation(errors: Any, known: Any, lags: Any) -> Any:
    """Of what is left when each row's mean is taken off, (runs, lags); errors (runs, n), known (n,).

    At each lag by the pairs of instants that are both known; 0 where there is none.
    """
    runs, samples = errors.shape
    found = np.zeros((runs, lags.size))
    for r in range(runs):
        total, count = 0.0, 0
        for k in range(samples):
            if known[k]:
                total += errors[r, k]
                count += 1
        mean, power = total / count, 0.0
        for k in range(samples):
            if known[k]:
                power += (errors[r, k] - mean) ** 2
        power /= count
        for i in range(lags.size):
            product, pairs = 0.0, 0
            for k in range(samples - lags[i]):
                if known[k] and known[k + lags[i]]:
                    product += (errors[r, k] - mean) * (errors[r, k + lags[i]] - mean)
                    pairs += 1
            if pairs and power > 0.0:
                found[r, i] = product / pairs / power
    return found


def independent_values(values: Array, known: NDArray[np.bool_]) -> float:
    """How many independent values tell as much of the mean as values (n,) do where they are `known`.

    Their number over one and twice the sum of the autocorrelation up to its first zero (Priestley 1981,
    Spectral Analysis and Time Series, section 5.3.2).
    """
    lags = np.arange(1, values.size // 2)
    found = autocorrelation(values[np.newaxis], known, lags)[0]
    negative = np.flatnonzero(found <= 0.0)
    total = float(found[:negative[0] if negative.size else found.size].sum())
    return float(known.sum()) / (1.0 + 2.0 * total)
