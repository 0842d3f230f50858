"""Which instants of a recording are drawn: as asked for, or those whose postures differ most."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_MS, NS_PER_S

Array = NDArray[np.float64]
Instants = NDArray[np.int64]
CANDIDATES, SHOWN = 240, 4
"""Instants looked at, evenly spaced, and drawn at most, where none is asked for (chosen: a strip of four)."""
BETWEEN = 20
"""Part of the recording, one in so many, that lies between two drawn instants at least (chosen: else a hand
that springs to rest at the start is drawn twice, and what it does later once)."""
APART_M, APART_SHARE = 0.005, 0.05
"""Postures nearer to each other than this, root mean square of what is compared, are one (chosen); and
shares of muscles."""


def asked_for(at_s: Sequence[float], last_ns: int, trial: int) -> Instants:
    """The instants of the command line, ns; raises InputError for one outside of what is recorded."""
    for second in at_s:
        if not 0.0 <= second <= last_ns / NS_PER_S:
            raise InputError(f"--at {second:g}", f"is not in what is recorded of trial {trial}",
                             f"0 to {last_ns / NS_PER_S:g} s")
    return np.array(list(dict.fromkeys(round(second * NS_PER_S) for second in at_s)), dtype=np.int64)


def candidates(first_ns: int, last_ns: int) -> Instants:
    """Instants to choose among, in whole milliseconds."""
    return np.unique(np.linspace(first_ns, last_ns, CANDIDATES).astype(np.int64) // NS_PER_MS * NS_PER_MS)


def most_different(values: Array, apart_by: float, shown: int = SHOWN) -> list[int]:
    """Rows of values (t, n, k) that differ most: the first, and again and again what is farthest.

    Rows that are not finite are passed over, and those next to a chosen one (`BETWEEN`). In order of time;
    fewer where the rest are much the same, nearer than `apart_by`, root mean square over the n.
    """
    rows = np.flatnonzero(np.isfinite(values).all(axis=(1, 2)))
    if not rows.size:
        return []
    flat = values[rows].reshape(len(rows), -1)
    chosen: list[int] = []
    apart = np.full(len(rows), np.inf)
    while len(chosen) < shown and apart.max() > apart_by:
        chosen.append(int(apart.argmax()))
        near = np.abs(rows - rows[chosen[-1]]) < len(values) / BETWEEN
        distance = _distance(flat, flat[chosen[-1]], values.shape[1])
        apart = np.minimum(apart, np.where(near, 0.0, distance))
    return [int(rows[each]) for each in sorted(chosen)]


def spread_out(first_ns: int, last_ns: int) -> Instants:
    """Start, middle and end."""
    return np.unique(np.array([first_ns, (first_ns + last_ns) // 2, last_ns], dtype=np.int64))


def _distance(flat: Array, row: Array, count: int) -> Array:
    """Root mean square distance of `count` points from where they are in one row."""
    return np.asarray(np.sqrt(np.square(flat - row).sum(axis=1) / count))
