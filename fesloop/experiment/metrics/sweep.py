"""Elements of the arrays that a sweep found to move the hand, and the strongest for each angle."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.metrics.joints import Trace
from fesloop.experiment.metrics.missing import put
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
_BEFORE_NS, _LAST_NS = NS_PER_S * 15 // 100, NS_PER_S * 8 // 100
"""Spans before a turn and at the end of a current, over which angles are averaged (chosen)."""
RESPONDS_DEG = 6.0
"""Change of an angle from which an element counts (chosen: more than noise and drift in a turn)."""


def sweep_metrics(recording: Recording, sweep: str, traces: Sequence[Trace], names: Sequence[str]
                  ) -> dict[str, Any]:
    """Compute the metrics of a block `element_sweep`.

    swept_elements and responding_elements: number of elements that had a current after a rest, and of those
    that moved an angle by 6 deg or more; one a trial. Under joints, by angle, the strongest element of each
    direction: raised_deg and raised_by, lowered_deg and lowered_by; none where no element moved it so.

    Parameters
    ----------
    traces: true angles of each trial, rad.
    names: of the angles; empty: numbers under joints are left out.
    """
    metrics: dict[str, Any] = {}
    for trial, trace in enumerate(traces):
        elements, moved = _responses(recording, sweep, trial, trace)
        put(metrics, ("swept_elements",), len(elements))
        put(metrics, ("responding_elements",),
            sum(bool(np.abs(each).max() >= np.radians(RESPONDS_DEG)) for each in moved))
        for row, name in enumerate(names):
            for word, sense in (("raised", 1.0), ("lowered", -1.0)):
                most = [float(np.degrees((sense * each[:, row]).max())) for each in moved]
                best = int(np.argmax(most)) if most else None
                found = best if best is not None and most[best] > 0.0 else None
                put(metrics, ("joints", name, f"{word}_deg"), np.nan if found is None else most[found])
                put(metrics, ("joints", name, f"{word}_by"), None if found is None else elements[found])
    return metrics


def _responses(recording: Recording, sweep: str, trial: int, trace: Trace) -> tuple[list[int], list[Array]]:
    """Swept elements, and for each the changes (currents, angles), rad, of the angles by the end of each.

    They are against the angles before the element's first current, so that an element at the trial's start
    has none; 0 for a current that was left out, or that the trial's end cut off.
    """
    stairs = len(recording.experiment["blocks"][sweep]["current_ma"])
    element, stair = (recording.signal(f"{sweep}.{port}", trial) for port in ("element", "stair"))
    times_ns, angles = trace[0], np.asarray(trace[1][:], dtype=np.float64)

    def mean(from_ns: int, until_ns: int) -> Array:
        first, stop = np.searchsorted(times_ns, [from_ns, until_ns])
        mean: Array = angles[max(min(first, stop - 1), 0):max(stop, 1)].mean(axis=0)  # of one row or more
        return mean

    def turns() -> Iterator[tuple[int, Array]]:
        for number in dict.fromkeys(element.values[element.values >= 0].astype(int).tolist()):
            given = np.flatnonzero((element.values == number) & (stair.values >= 0))
            if not given.size or (begun := int(element.times_ns[given[0]])) < _BEFORE_NS:
                continue
            before, moved = mean(begun - _BEFORE_NS, begun), np.zeros((stairs, *angles.shape[1:]))
            for current in range(stairs):
                ticks = given[stair.values[given] == current]
                if ticks.size and ticks[-1] + 1 < element.times_ns.size:
                    ends = int(element.times_ns[ticks[-1] + 1])
                    moved[current] = mean(ends - _LAST_NS, ends) - before
            yield number, moved

    found = list(turns())
    return [number for number, _ in found], [moved for _, moved in found]
