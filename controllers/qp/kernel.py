"""What the wrapper of quadratic programmes checks and computes around a solve."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled

Array = NDArray[np.float64]
SOUND, NOT_FINITE, CROSSED, MISSHAPEN = 0, 1, 2, 3
"""Faults of the vectors of a programme."""


@compiled
def check_vectors(q: Array, lower: Array, upper: Array) -> int:
    """SOUND, NOT_FINITE (or infinity as a bound's wrong side), or CROSSED bounds."""
    for i in range(q.size):
        if not math.isfinite(q[i]):
            return NOT_FINITE
    fault = SOUND
    for i in range(lower.size):
        if math.isnan(lower[i]) or math.isnan(upper[i]) or lower[i] == math.inf or upper[i] == -math.inf:
            return NOT_FINITE
        if lower[i] > upper[i]:
            fault = CROSSED
    return fault


@compiled
def minus_product(matrix: Array, vector: Array) -> Array:
    """Minus a symmetric matrix times a vector, fresh, summed in a fixed order."""
    product = np.zeros(vector.size)
    for j in range(vector.size):
        for i in range(vector.size):
            product[i] -= matrix[j, i] * vector[j]
    return product


@compiled
def around(
    centre: Array, lower: Array, upper: Array, below: Array, above: Array, indptr: NDArray[np.int64],
    indices: NDArray[np.int64], values: Array,
) -> int:
    """Fill `below` and `above` with the bounds less the constrained quantities at the centre; the fault.

    `indptr`, `indices`, `values` are the rows, compressed.
    """
    size = centre.size
    if size != below.size - indptr.size + 1 or lower.size != below.size or upper.size != below.size:
        return MISSHAPEN
    fault: int = check_vectors(centre, lower, upper)
    for i in range(size):
        below[i], above[i] = lower[i] - centre[i], upper[i] - centre[i]
    for row in range(indptr.size - 1):
        total = 0.0
        for k in range(indptr[row], indptr[row + 1]):
            total += values[k] * centre[indices[k]]
        below[size + row], above[size + row] = lower[size + row] - total, upper[size + row] - total
    return fault


@compiled
def settle(
    x: Array, lower: Array, upper: Array, indptr: NDArray[np.int64], indices: NDArray[np.int64], values: Array
) -> tuple[bool, float]:
    """Clip x into its boxes, in place; (whether x is finite, worst violation relative to 1 + |bound|)."""
    worst = 0.0
    for i in range(x.size):
        if not math.isfinite(x[i]):
            return False, 0.0
        bound = min(max(x[i], lower[i]), upper[i])
        worst = max(worst, abs(x[i] - bound) / (1.0 + abs(bound)))
        x[i] = bound
    for row in range(indptr.size - 1):
        total = 0.0
        for k in range(indptr[row], indptr[row + 1]):
            total += values[k] * x[indices[k]]
        bound = min(max(total, lower[x.size + row]), upper[x.size + row])
        worst = max(worst, abs(total - bound) / (1.0 + abs(bound)))
    return True, worst
