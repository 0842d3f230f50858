"""`fesloop bench view`: effect of a viewer on a loop at 100 Hz in step with the wall clock.

A whole hand with sixteen inertial sensors moves, and a tracker follows at 100 Hz (the experiment
`tracker_hour`), recorded as in every run. Turns with and without a viewer alternate within this run: `fesloop
view` follows the recording, and a client takes every frame; a turn with it includes its start and end. The
loop is pinned to the first core; the viewer runs on any.

`us_*` is the delay of the start of each tick's work: in the first row with a viewer, with the turns without
(`reference_us_*`), which are the second row. `p99_ratio` is the ratio of the 99th percentiles, `low` and
`high` its 95 % bootstrap interval over turns. Since one stall of the machine in thirty turns can decide it,
`turn_p99_ratio` is the ratio of the medians over turns of each turn's 99th percentile, which
`us_p99_of_turns` lists. `frames_per_s` is the rate of frames in the turns with a viewer, from the first frame
on.
"""

from __future__ import annotations

import http.client
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import urlsplit

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import RunError
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.running import run as run_experiment
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.realtime import Pacing
from fesloop.show.view.followed import GrowingRecording

Stamps = NDArray[np.int64]
_FULL, _SHORT = (30, 20.0), (4, 8.0)
"""Number of turns, and length of one, s."""
_WARM_UP_NS = 2 * NS_PER_S
"""Time of the run before the first turn."""
_STARTING_S, _TIMES = 120.0, 5.0
"""Longest time for the start, s, and longest run as a multiple of the turns; it ends with the last turn."""
_EXPERIMENT = "tracker_hour"
_STARTS_S, _LOOK_S = 120.0, 0.05
_DRAWS = 1000
_SEED = 1


@dataclass(slots=True)
class _Turn:
    """A part of the run, by the monotonic clock; with a viewer, the number of frames and their time."""

    watched: bool
    began_ns: int
    ended_ns: int = 0
    frames: int = 0
    seconds: float = 0.0


def run(count: int | None = None, turn_s: float | None = None, short: bool = False, priority: int = 0,
        progress: Callable[[float], None] | None = None, experiment: str = _EXPERIMENT) -> dict[str, Any]:
    """Run the bench for some turns of some seconds, or its short form, with a scheduling priority.

    Raises RunError if the run or a viewer fails.
    """
    usual = _SHORT if short else _FULL
    count, turn_s = count or usual[0], turn_s or usual[1]
    core = min(os.sched_getaffinity(0))
    with TemporaryDirectory(prefix="fesloop-bench-") as made:
        folder = Path(made)
        loop = get_context("spawn").Process(target=_paced, args=(
            experiment, made, _STARTING_S + _TIMES * count * turn_s, priority, core), daemon=True)
        loop.start()
        try:
            _begun(loop, folder)
            turns = _take_turns(loop, _recording(folder), count, turn_s, progress or (lambda share: None))
        finally:
            loop.kill()
            loop.join()
        with Recording(_recording(folder)) as recording:
            rows, origins = recording.instants, recording.origins
    instants = origins["monotonic_ns"][rows["trial"]] + rows["time_ns"]
    return _result(turns, [_late(rows["late_ns"], instants, turn) for turn in turns])


def _paced(experiment: str, folder: str, seconds: float, priority: int, core: int) -> None:
    """Run the loop on its core."""
    os.sched_setaffinity(0, {core})
    loaded = load(experiment, [f"experiment.duration_s={seconds}"])
    run_experiment(loaded, Path(folder), realtime=Pacing(priority=priority))


def _recording(folder: Path) -> Path:
    return next(iter(sorted(folder.glob("[!.]*.h5"))))


def _begun(loop: Any, folder: Path) -> None:
    """Wait until the run has started."""
    until = time.monotonic() + _STARTS_S
    rows: GrowingRecording | None = None
    origin_ns: int | None = None
    while origin_ns is None or time.monotonic_ns() < origin_ns + _WARM_UP_NS:
        if not loop.is_alive() or time.monotonic() > until:
            raise RunError("bench view: the run did not begin; what it said is above")
        time.sleep(_LOOK_S)
        if rows is None and any(folder.glob("[!.]*.h5")):
            rows = GrowingRecording(_recording(folder), [])
        origin_ns = rows.origin_ns(0) if rows is not None else None
    if rows is not None:
        rows.close()


def _take_turns(loop: Any, recording: Path, count: int, turn_s: float,
                progress: Callable[[float], None]) -> list[_Turn]:
    """Watch in every other turn."""
    turns: list[_Turn] = []
    while len(turns) < count:
        turn = _Turn(bool(len(turns) % 2), time.monotonic_ns())
        if turn.watched:
            _watch(turn, recording, turn_s)
        else:
            loop.join(turn_s)
        if not loop.is_alive():
            raise RunError("bench view: the run ended; what it said is above")
        turn.ended_ns = time.monotonic_ns()
        turns.append(turn)
        progress(len(turns) / count)
    return turns


def _watch(turn: _Turn, recording: Path, turn_s: float) -> None:
    """Run a viewer and a client that takes its frames for one turn."""
    with subprocess.Popen([sys.executable, "-m", "fesloop", "view", str(recording)],
                          stderr=subprocess.PIPE, text=True) as viewer:
        assert viewer.stderr is not None
        try:
            said = viewer.stderr.readline()
            if "http://" not in said:
                raise RunError(f"bench view: the viewer did not begin: {said.strip()}")
            address = urlsplit(said[said.index("http://"):].strip())
            _take_frames(turn, str(address.hostname), int(address.port or 0), turn_s)
        finally:
            viewer.terminate()


def _take_frames(turn: _Turn, host: str, port: int, turn_s: float) -> None:
    connection = http.client.HTTPConnection(host, port, timeout=_STARTS_S)
    connection.request("GET", "/frames")
    answer = connection.getresponse()
    first, end = 0.0, time.monotonic() + turn_s
    while time.monotonic() < end:
        line = answer.readline()
        if not line:
            break
        if line.startswith(b"event: frame"):
            first = first or time.monotonic()
            turn.frames += 1
            turn.seconds = time.monotonic() - first
    connection.close()


def _late(late_ns: Stamps, instants_ns: Stamps, turn: _Turn) -> Stamps:
    """Delays of the work of a turn's ticks, ns."""
    return late_ns[(instants_ns >= turn.began_ns) & (instants_ns < turn.ended_ns)]


def _result(turns: Sequence[_Turn], late: Sequence[Stamps]) -> dict[str, Any]:
    with_viewer = [each for turn, each in zip(turns, late, strict=True) if turn.watched and len(each)]
    without = [each for turn, each in zip(turns, late, strict=True) if not turn.watched and len(each)]
    if not with_viewer or not without:
        raise RunError("bench view: no instant in one kind of turn")
    watched, alone = np.concatenate(with_viewer), np.concatenate(without)
    by_turn = {"watched": [_p99(each) for each in with_viewer],
               "not watched": [_p99(each) for each in without]}
    told = sum(turn.seconds for turn in turns)
    rows = [_row(f"tracker at 100 Hz, {len(turns)} turns: begun late, watched", watched, alone),
            _row("begun late, not watched", alone, None)]
    return {"bench": "view", "rows": rows,
            "p99_ratio": _ratio(with_viewer, without, lambda turns: _p99(np.concatenate(turns))),
            "turn_p99_ratio": _ratio(by_turn["watched"], by_turn["not watched"], np.median),
            "us_p99_of_turns": by_turn,
            "turns": {"watched": len(with_viewer), "not watched": len(without)},
            "frames_per_s": sum(turn.frames for turn in turns) / told if told > 0.0 else 0.0}


def _ratio(watched: Sequence[Any], alone: Sequence[Any], of: Callable[[list[Any]], Any]) -> dict[str, float]:
    """Ratio of a statistic with and without a viewer, and its 95 % bootstrap interval over turns."""
    chances = np.random.default_rng(_SEED)
    ratios = [of(_drawn(watched, chances)) / of(_drawn(alone, chances)) for _ in range(_DRAWS)]
    low, high = np.percentile(ratios, [2.5, 97.5])
    return {"ratio": float(of(list(watched)) / of(list(alone))), "low": float(low), "high": float(high)}


def _drawn(turns: Sequence[Any], chances: np.random.Generator) -> list[Any]:
    """Sample as many turns with replacement."""
    return [turns[i] for i in chances.integers(0, len(turns), len(turns))]


def _p99(late_ns: Stamps) -> float:
    return float(np.percentile(late_ns, 99)) / 1e3


def _row(case: str, late_ns: Stamps, reference_ns: Stamps | None) -> dict[str, Any]:
    ours = _quantiles(late_ns)
    row: dict[str, Any] = {"case": case, **{f"us_{name}": value for name, value in ours.items()}}
    if reference_ns is None:
        return row | {"reference": None, "reference_us_median": None, "ratio": None}
    bare = _quantiles(reference_ns)
    return row | {"reference": "turns of the same run in which nobody watches",
                  "reference_us_median": bare["median"], "ratio": ours["median"] / bare["median"],
                  "reference_us_p99": bare["p99"], "reference_us_worst": bare["worst"]}


def _quantiles(late_ns: Stamps) -> dict[str, float]:
    return {"median": float(np.median(late_ns)) / 1e3, "p99": _p99(late_ns),
            "worst": float(late_ns.max()) / 1e3}
