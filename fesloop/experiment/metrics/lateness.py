"""Lateness of a run in real time, from its recording."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.realtime import KEPT

EDGES_MS = (0.0, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
"""Edges of the histogram, ms; the last class is open."""
_WORDS = ("policy", "memory", "scheduling")
_NUMBERS = ("period_ms", "collections", "worst_collection_ms", "worst_write_ms")
"""Attributes of the recording of a run in real time; older recordings lack those of writing."""


def realtime_summary(recording: Recording) -> dict[str, Any]:
    """Statistics that `fesloop run --realtime --json` prints under "realtime"; empty for other runs.

    `late_ms` is how late work began, `took_ms` how long it took, both over all instants: `p50`, `p99`,
    `worst`; `histogram` counts the instants by `late_ms`, in classes that begin at `from_ms`; `done` counts
    them by what was done: kept, run late, skipped, stopped. `worst_collection_ms` and `worst_write_ms` are
    the longest pauses of the loop for the collector and for writing the recording.
    """
    rows = recording.instants
    if not rows.size:
        return {}
    late, took = rows["late_ns"] / NS_PER_MS, rows["took_ns"] / NS_PER_MS
    actions, counts = np.unique(rows["action"], return_counts=True)
    wall = recording.wall
    return {
        "deadlines": len(rows), "missed": int((rows["action"] != KEPT.encode()).sum()),
        "late_ms": quantiles(late), "took_ms": quantiles(took),
        "histogram": {"from_ms": list(EDGES_MS), "instants": histogram(late).tolist()},
        "done": {action.decode(): int(count) for action, count in zip(actions, counts, strict=True)},
        **{name: str(wall[name]) for name in _WORDS},
        **{name: float(wall[name]) for name in _NUMBERS if name in wall},
    }


def quantiles(values: NDArray[np.float64]) -> dict[str, float]:
    """Median, 99th percentile and maximum."""
    p50, p99 = np.percentile(values, (50, 99))
    return {"p50": float(p50), "p99": float(p99), "worst": float(values.max())}


def class_names(from_ms: Sequence[float]) -> list[str]:
    """Labels of the classes of the histogram, each from its edge to below the next; the last is open."""
    return [*(f"{low:g} to {high:g} ms" for low, high in pairwise(from_ms)), f"{from_ms[-1]:g} ms or more"]


def histogram(late_ms: NDArray[np.float64], edges_ms: Sequence[float] = EDGES_MS) -> NDArray[np.int64]:
    """Number of values in each class, from its edge to the next."""
    return np.histogram(late_ms, [*edges_ms, np.inf])[0].astype(np.int64)
