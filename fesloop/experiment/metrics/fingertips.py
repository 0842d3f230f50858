"""Metrics of fingertips: where a tracker says they are against where they were."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.metrics.joints import Trace, held

Array = NDArray[np.float64]
TWO_SIDED_95 = 1.959963984540054


def fingertip_error(estimate: Trace, truth: Trace) -> Array:
    """Vectors (n, tips, 3), m, from the truth to the estimate, at the estimate's instants.

    The truth is held between its instants; what comes before the first is left out. Estimates are to be
    stamped with the capture of the samples behind them (doi 10.3390/s19010208, eq. 30).
    """
    times, values = estimate
    error = np.asarray(values[:]) - held(truth, times)
    return np.asarray(error[np.isfinite(error).all(axis=(1, 2))])


def fingertip_rmse_mm(error: Array) -> Array:
    """RMS distance of each fingertip from the truth, (tips,), mm (doi 10.3390/s19010208, eq. 31)."""
    squared = np.square(error).sum(axis=2)
    return np.asarray(1e3 * np.sqrt(squared.mean(axis=0))) if len(error) else np.full(error.shape[1], np.nan)


def coverage(error: Array, sd: Array) -> Array:
    """Share of each fingertip's coordinates, (tips,), within the 95 % interval of their sd (n, tips, 3)."""
    if not len(error):
        return np.full(error.shape[1], np.nan)
    inside = np.abs(error) <= TWO_SIDED_95 * sd
    return np.asarray(inside.mean(axis=(0, 2)))


def by_tip(trials: Sequence[Array], names: Sequence[str]) -> dict[str, list[float]]:
    """One value a trial, under each fingertip's name."""
    return {name: [float(trial[i]) for trial in trials] for i, name in enumerate(names)}
