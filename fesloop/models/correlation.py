"""Correlation between the errors of several angles, from what each one's fit could not foresee."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_FEWEST = 30
"""Instants known of both, below which two count as independent (chosen)."""


def correlation_of(innovations: Sequence[Array]) -> Array:
    """Correlation matrix (series, series) of standardised innovations, (n,) each, NaN where unknown.

    Of each pair by the instants that both have; the nearest matrix without negative eigenvalues, as far as
    clipping them gives it.
    """
    rows = np.array(innovations)
    known = np.isfinite(rows)
    rows = np.where(known, rows, 0.0)
    counts = known.astype(np.float64) @ known.T
    power = (rows * rows) @ known.T
    scale = np.sqrt(power * power.T)
    known = (scale > 0.0) & (counts >= _FEWEST)
    matrix = np.divide(rows @ rows.T, scale, out=np.zeros_like(scale), where=known)
    np.fill_diagonal(matrix, 1.0)
    return without_negative(matrix)


def without_negative(matrix: Array) -> Array:
    """A correlation matrix with negative eigenvalues clipped, and ones on the diagonal again."""
    values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
    clipped = (vectors * np.maximum(values, 0.0)) @ vectors.T
    sd = np.sqrt(np.diag(clipped))
    made = clipped / np.outer(sd, sd)
    np.fill_diagonal(made, 1.0)
    return np.asarray(0.5 * (made + made.T))


def root_of(matrix: Array) -> Array:
    """The symmetric root of a correlation matrix: it correlates independent normal numbers."""
    values, vectors = np.linalg.eigh(matrix)
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T)
