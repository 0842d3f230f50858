"""The posture at the controller's ticks, from samples that were captured earlier than they were read."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]
Mask = NDArray[np.bool_]


def posture_at(
    ticks_ns: Stamps, captured_ns: Stamps, measured: Array, max_gap_ns: int
) -> tuple[Array, Mask]:
    """(posture (ticks, outputs), covered (ticks,)): what was captured, brought to the instants of the ticks.

    A cubic spline through the captures (its error is of fourth order in their distance; linear with fewer
    than four) undoes the age of each sample. A tick is covered if it lies between two captures that are at
    most `max_gap_ns` apart, or on one; elsewhere the posture is 0.

    Parameters
    ----------
    ticks_ns: (ticks,), increasing.
    captured_ns: (ticks,), newest capture behind the sample read at each tick; negative for none.
    measured: (ticks, outputs), the samples.
    """
    stamps, first = np.unique(captured_ns[captured_ns >= 0], return_index=True)
    values = measured[captured_ns >= 0][first]
    posture = np.zeros((ticks_ns.size, measured.shape[1]))
    if stamps.size == 0:
        return posture, np.zeros(ticks_ns.size, dtype=bool)
    after = np.searchsorted(stamps, ticks_ns, side="left")
    inside = (ticks_ns >= stamps[0]) & (ticks_ns <= stamps[-1])
    later = np.minimum(after, stamps.size - 1)
    gaps = stamps[later] - stamps[np.maximum(later - 1, 0)]
    covered = inside & ((stamps[later] == ticks_ns) | (gaps <= max_gap_ns))
    if stamps.size == 1:
        posture[covered] = values
        return posture, covered
    spline = make_interp_spline(stamps.astype(np.float64), values, k=3 if stamps.size >= 4 else 1)
    posture[covered] = spline(ticks_ns[covered].astype(np.float64))
    return posture, covered
