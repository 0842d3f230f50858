"""Convergence of a tracker on a recorded motion: its error against the time since it began.

A tracker is restarted at many instants of one recording. The result is the spread, over all starts, of the
error of each relative orientation at each time since the start.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.experiment.metrics.orientation import orientation_error, relative_orientation_error
from fesloop.hand import quaternion
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from fesloop.streams.blocks.replay import Replay
from fesloop.streams.recording import MotionRecording, Reference

Array = NDArray[np.float64]
QUANTILES = (0.5, 0.9, 1.0)
"""Median, nine of ten, worst."""


class Convergence(NamedTuple):
    """Errors of a tracker against the time since its start.

    times_s: (m,), the middle of each interval since the beginning.
    starts_s: (starts,), instants of the recording at which the tracker began.
    error_deg: "parent-child" to (starts, m), the mean total error in each interval; NaN where the reference
        does not reach or is not known.
    """

    times_s: Array
    starts_s: Array
    error_deg: dict[str, Array]

    def table(self) -> list[dict[str, Any]]:
        """A row a pair: {"pair", "times_s", "median_deg", "nine_of_ten_deg", "worst_deg"}."""
        rows = []
        for pair, errors in self.error_deg.items():
            known = np.isfinite(errors).any(axis=0)
            median, most, worst = np.nanquantile(errors[:, known], QUANTILES, axis=0)
            rows.append({"pair": pair, "times_s": self.times_s[known].tolist(), "median_deg": median.tolist(),
                         "nine_of_ten_deg": most.tolist(), "worst_deg": worst.tolist()})
        return rows


def convergence(
    path: str, tracker: Any, starts_s: Sequence[float], duration_s: float = 15.0, step_s: float = 0.5,
    sensor_set: str | None = None,
) -> Convergence:
    """Start a tracker at each of `starts_s` and measure it for `duration_s`, in intervals of `step_s`.

    Parameters
    ----------
    path, sensor_set: of the recording (see `fesloop.streams.files.open_recording`).
    tracker: a block with an output `orientation` (n, 4), sensor to earth; its inputs are those that the
        recording has.

    Raises InputError for a recording without reference orientations, or without pairs.
    """
    edges = np.arange(0.0, duration_s + 0.5 * step_s, step_s)
    rows: dict[str, list[Array]] = {}
    for start in starts_s:
        replay = Replay(recording=path, sensor_set=sensor_set, start_s=start, duration_s=duration_s)
        source, reference = replay.source, _referenced(replay.source)
        since, found = _followed(replay, tracker)
        inside = (reference.stamps_ns >= since[0]) & (reference.stamps_ns <= since[-1])
        at = reference.stamps_ns[inside]
        error = orientation_error(quaternion.interpolate(since, found, at), reference.orientation[inside])
        interval = np.digitize((at - since[0]) / NS_PER_S, edges) - 1
        for p, c in source.pairs:
            angle = quaternion.rotation_angle(relative_orientation_error(error[:, p], error[:, c]))
            means = [_mean_deg(angle[interval == i]) for i in range(len(edges) - 1)]
            rows.setdefault(source.pair_name((p, c)), []).append(np.array(means))
    return Convergence(edges[:-1] + 0.5 * step_s, np.array(starts_s, dtype=np.float64),
                       {pair: np.stack(errors) for pair, errors in rows.items()})


def _referenced(recording: MotionRecording) -> Reference:
    if recording.reference is None or not recording.reference.sensor_frames or not recording.pairs:
        raise InputError("recording", f"{recording.path} has no orientations of jointed segments to score",
                         "one with a reference in the sensors' frames and pairs, such as chain5")
    return recording.reference


def _followed(replay: Replay, tracker: Any) -> tuple[NDArray[np.int64], Array]:
    """Instants of the recording, (m,), ns, and orientations, (m, n, 4)."""
    played = {port.name for port in replay.outputs}
    wires = [Wire(source=f"recording.{port.name}", target=f"tracker.{port.name}")
             for port in tracker.inputs if port.name in played]
    recorder = Recorder()
    nodes = [Node("recording", replay), Node("tracker", tracker, rate=replay.clock)]
    Loop(Wiring(nodes, wires), recorder=recorder).run_until(int(replay.clock.stamps_ns[-1]) + 1)
    port = [port.name for port in tracker.outputs].index("orientation")
    rows = recorder.blocks["tracker"]
    orientation = np.array([row[5][port] for row in rows])
    return np.array([row[4] for row in rows], dtype=np.int64) + replay.start_ns, orientation


def _mean_deg(angles: Array) -> float:
    known = angles[np.isfinite(angles)]
    return float(np.degrees(known.mean())) if known.size else float("nan")
