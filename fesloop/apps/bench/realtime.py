"""`fesloop bench realtime`: sixteen streams at 100 Hz in step with the wall clock, on a busy machine.

The recording `body16` (in the folder FESLOOP_RECORDINGS) plays through a tracker and a controller as in the
experiment `replay`, for ten minutes in trials of its length, recorded as in every run. A process keeps the
last core busy; the loop is pinned to the first. On each core another process, the sleeper, does nothing but
sleep in the same way until the same deadlines and nine between each two: a deadline that it misses could not
    be kept by any process
that sleeps on that core. (The loop has to be pinned for this comparison: otherwise its timer is that of the
core where it fell asleep, while it may wake on the other.)

`us_*` of the first row is the delay of the start of each tick's work, with the sleepers' delay in
`reference_us_*`; of the second row the duration of the work. `missed` counts deadlines: of the loop, where
work ended more than a period of 10 ms late; of the sleepers, where one woke later than that, at 100 deadlines
a second; and `alone`, those missed by the loop that the sleeper on its core would have kept with the loop's
work to do: it woke less than a period minus the median work late, at all its deadlines from a period before
the tick to the end of the loop's work. (For this it has a deadline every ms: a stall of 15 ms that begins
during the loop's work lasts 15 ms for the loop, but 5 ms for a sleeper whose next deadline is 10 ms away.)
`alone_ms` lists the worst of these, with their times and the sleeper's worst delay around them.

`stood_still_ms` is the longest pause of the loop for Python's garbage collector and for writing the
recording.

`memory_mb` is the resident memory of the loop's process from a tenth of the run on: at the start, at the end,
and the slope of a line through all samples, one a second.
"""

from __future__ import annotations

import gc
import math
import os
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from multiprocessing import get_context
from multiprocessing.context import SpawnProcess
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, RunError
from fesloop.experiment.files.parse import load
from fesloop.experiment.recording.reading import Recording
from fesloop.loop.abilities import Present
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.machine import realtime_privileges
from fesloop.loop.nodes import Node
from fesloop.loop.realtime import Pacing
from fesloop.loop.signals import Port, Sample, Value

Wakings = NDArray[np.int64]
_LOOK_NS = NS_PER_S // 20
_MOST_TICKS = 2**20


class Origin:
    """A time of `time.monotonic_ns()` in a small file shared by processes; 0 until it is set."""

    def __init__(self, path: Path) -> None:
        self._told = np.memmap(path, np.int64, "r+" if path.exists() else "w+", shape=(2,))

    def tell(self, origin_ns: int) -> None:
        """Set the time."""
        self._told[0] = origin_ns

    def end(self) -> None:
        """Signal the end."""
        self._told[1] = 1

    @property
    def ns(self) -> int:
        """Return the time, ns."""
        return int(self._told[0])

    @property
    def over(self) -> bool:
        """Whether the end is signalled."""
        return bool(self._told[1])


@contextmanager
def beside(folder: Path, period_ns: int, priority: int = 0) -> Iterator[Origin]:
    """Context in which one core is kept busy, and a sleeper runs on each core.

    Sleepers wake at the deadlines origin + k x period. The context's value sets the origin, for each trial.
    They take the same priority as the run. All processes end with this one. The sleepers' records are then in
    the folder: see `slept`.
    """
    context = get_context("spawn")
    origin = Origin(folder / "origin")
    cores = sorted(os.sched_getaffinity(0))
    burner = context.Process(target=_burn, args=(cores[-1], os.getpid()), daemon=True)
    sleepers = [context.Process(target=_sleep_and_wake, args=(folder, core, period_ns, priority, os.getpid()),
                                daemon=True) for core in cores]
    for other in (burner, *sleepers):
        other.start()
    try:
        yield origin
    finally:
        origin.end()
        burner.kill()
        for sleeper in sleepers:
            sleeper.join(5.0)
        for other in (burner, *sleepers):
            other.kill()
            other.join()


def slept(folder: Path) -> Wakings:
    """Core, deadline (`time.monotonic_ns()`) and delay of the sleepers' wakings, ns, (n, 3), by deadline."""
    rows = np.concatenate([np.load(each) for each in sorted(folder.glob("slept-*.npy"))])
    return rows[np.argsort(rows[:, 1], kind="stable")]


def _burn(core: int, parent: int) -> None:
    """Keep a core busy while the parent lives."""
    os.sched_setaffinity(0, {core})
    while os.getppid() == parent:
        sum(range(100_000))


def _sleep_and_wake(folder: Path, core: int, period_ns: int, priority: int, parent: int) -> None:
    """Sleep until each deadline in the same way as the loop, and record the delay."""
    rows = np.full((_MOST_TICKS, 3), core, np.int64)
    gc.disable()
    os.sched_setaffinity(0, {core})
    with realtime_privileges(True, priority):
        count = _note_wakings(rows, Origin(folder / "origin"), period_ns, parent)
    np.save(folder / f"slept-{core}.npy", rows[:count])


def _note_wakings(rows: Wakings, told: Origin, period_ns: int, parent: int) -> int:
    """Fill rows until the end is signalled, and return their number."""
    origin_ns = tick = count = 0
    while not told.over and os.getppid() == parent and count < _MOST_TICKS:
        if told.ns != origin_ns:
            origin_ns, tick = told.ns, 0
        if origin_ns == 0:
            time.sleep(_LOOK_NS / NS_PER_S)
            continue
        deadline = origin_ns + tick * period_ns
        while (ahead := deadline - time.monotonic_ns()) > 0:
            time.sleep(ahead / NS_PER_S)
        rows[count, 1:] = deadline, -ahead
        tick, count = tick + 1, count + 1
    return count


Array = NDArray[np.float64]
Stamps = NDArray[np.int64]
_FULL_S, _SHORT_S, _TRIAL_S = 600.0, 20.0, 99.0
_PERIOD_NS = 10 * NS_PER_MS
_WAKINGS_A_PERIOD = 10
_SHOWN = 10


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Teller:
    """Signals t = 0 to the other processes, and ends a run whose bench has ended."""

    path: str
    bench: int
    inputs: tuple[Port, ...] = ()
    outputs: tuple[Port, ...] = ()

    def init(self, context: Context) -> None:
        """No state."""

    def attach(self, state: Any, present: Present) -> None:
        """Signal t = 0."""
        Origin(Path(self.path)).tell(present.origin_ns)

    def step(self, state: Any, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """End the run if the bench has ended."""
        if os.getppid() != self.bench:
            raise RunError("the bench that this run is of has ended")
        return ()


def run(seconds: float = _FULL_S, short: bool = False, priority: int = 0,
        progress: Callable[[float], None] | None = None) -> dict[str, Any]:
    """Run the bench for some seconds, or its short form, with a scheduling priority (0: none).

    Raises InputError without the recording `body16`, and RunError if the run fails.
    """
    Pacing(priority=priority)  # refuses one that is none
    source, seconds, core = _recording(), _SHORT_S if short else seconds, min(os.sched_getaffinity(0))
    with TemporaryDirectory() as made:
        folder = Path(made)
        with beside(folder, _PERIOD_NS // _WAKINGS_A_PERIOD, priority) as origin:
            loop = get_context("spawn").Process(
                target=_paced, args=(str(source), str(folder), seconds, priority, core), daemon=True)
            memory = _watched(loop, seconds, origin, progress)
        with Recording(next(folder.glob("*.h5"))) as recording:
            late, took, instants = _instants(recording)
            wall = recording.wall
        sleepers = slept(folder)
    ends = late + took
    missed, own = ends > _PERIOD_NS, sleepers[sleepers[:, 0] == core]
    alone = missed & ~_slept_through(instants, ends, own, _PERIOD_NS - int(np.median(took)))
    rows = [_row(f"body16: 16 streams at 100 Hz, {seconds:g} s: begun late", late, sleepers[:, 2]),
            _row("the work of an instant", took, None)]
    return {"bench": "realtime", "rows": rows,
            "missed": {"deadlines": len(ends), "loop": int(missed.sum()),
                       "sleeper": _missed_by_core(sleepers), "alone": int(alone.sum())},
            "alone_ms": _worst(instants, ends, alone, own), "memory_mb": _memory(memory),
            "stood_still_ms": {what: float(wall[f"worst_{what}_ms"]) for what in ("collection", "write")},
            "asked_for": {name: str(wall[name]) for name in ("policy", "memory", "scheduling")}}


def _recording() -> Path:
    folder = Path(os.environ.get("FESLOOP_RECORDINGS", ""), "body16")
    found = sorted(folder.glob("*.mat"))
    if not found:
        raise InputError("FESLOOP_RECORDINGS", f"there is no recording in {folder}",
                         "a folder with body16/qmt_full_body_example_data.mat, of the qmt toolbox")
    return found[0].absolute()


def _watched(process: SpawnProcess, seconds: float, origin: Origin,
             progress: Callable[[float], None] | None) -> list[tuple[float, float]]:
    """Run the loop in its process; returns its resident memory as (time, s; MB), one row a second."""
    process.start()
    began, samples = 0.0, []
    try:
        while process.is_alive():
            process.join(1.0)
            began = began or (time.monotonic() if origin.ns else 0.0)
            elapsed = time.monotonic() - began if began else 0.0
            if 0.0 < elapsed < seconds - 1.0:
                samples.append((elapsed, _resident_mb(process.pid or 0)))
            if progress:
                progress(min(1.0, elapsed / seconds))
    finally:
        process.kill()
        process.join()
    if process.exitcode:
        raise RunError("bench realtime: the run failed; what it said is above")
    return samples


def _paced(source: str, folder: str, seconds: float, priority: int, core: int) -> None:
    """Run the loop on its core, in trials as long as the recording, or in one shorter trial."""
    os.sched_setaffinity(0, {core})
    trials = math.ceil(seconds / _TRIAL_S)
    experiment = load("replay", [f"recording={source}", f"experiment.trials={trials}",
                                 f"experiment.duration_s={seconds / trials}"])
    teller = Node("teller", _Teller(path=str(Path(folder, "origin")), bench=os.getppid()), "100")
    replace(experiment, nodes=(*experiment.nodes, teller)).run(folder, realtime=Pacing(priority=priority))


def _resident_mb(process: int) -> float:
    pages = int(Path(f"/proc/{process}/statm").read_text(encoding="utf-8").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def _instants(recording: Recording) -> tuple[Stamps, Stamps, Stamps]:
    """Delay, duration and time (monotonic clock) of each tick's work, ns."""
    rows, origins = recording.instants, recording.origins
    return rows["late_ns"], rows["took_ns"], origins["monotonic_ns"][rows["trial"]] + rows["time_ns"]


def _missed_by_core(sleepers: Stamps) -> dict[str, int]:
    """Number of deadlines, one a period, missed by the sleeper of each core."""
    missed = {}
    for core in np.unique(sleepers[:, 0]):
        late = sleepers[sleepers[:, 0] == core, 2][::_WAKINGS_A_PERIOD]
        missed[str(core)] = int((late > _PERIOD_NS).sum())
    return missed


def _slept_through(instants: Stamps, ends: Stamps, sleeper: Stamps, slept_ns: int) -> NDArray[np.bool_]:
    """Whether a sleeper woke that late between a period before each tick and the end of its work."""
    late = sleeper[sleeper[:, 2] > slept_ns, 1]
    first = np.searchsorted(late, instants - _PERIOD_NS)
    last = np.searchsorted(late, instants + ends, side="right")
    excused: NDArray[np.bool_] = last > first
    return excused


def _worst(instants: Stamps, ends: Stamps, alone: NDArray[np.bool_],
           sleeper: Stamps) -> list[dict[str, float]]:
    """Worst deadlines missed by the loop alone."""
    found = np.flatnonzero(alone)
    found = found[np.argsort(-ends[found])][:_SHOWN]
    told = []
    for i in found:
        since = sleeper[:, 1] - instants[i]
        near = (since >= -_PERIOD_NS) & (since <= ends[i])
        told.append({"at_s": float(instants[i] - instants[0]) / NS_PER_S, "ended_after": ends[i] / NS_PER_MS,
                     "sleeper": float(sleeper[near, 2].max(initial=0)) / NS_PER_MS})
    return told


def _memory(samples: Sequence[tuple[float, float]]) -> dict[str, float]:
    """Memory at the start and end, MB, and its slope, MB a minute, without the first tenth."""
    times, sizes = np.array(samples[len(samples) // 10:]).T
    slope = float(np.polyfit(times, sizes, 1)[0]) * 60.0 if len(times) > 1 else 0.0
    return {"start": float(sizes[0]), "end": float(sizes[-1]), "slope_per_minute": slope}


def _row(case: str, times_ns: Stamps, reference_ns: Stamps | None) -> dict[str, Any]:
    ours = _quantiles(times_ns)
    row: dict[str, Any] = {"case": case, **{f"us_{name}": value for name, value in ours.items()}}
    if reference_ns is None:
        return row | {"reference": None, "reference_us_median": None, "ratio": None}
    bare = _quantiles(reference_ns)
    return row | {"reference": "bare sleepers with the same deadlines, one a core",
                  "reference_us_median": bare["median"], "ratio": ours["median"] / bare["median"],
                  "reference_us_p99": bare["p99"], "reference_us_worst": bare["worst"]}


def _quantiles(times_ns: Stamps) -> dict[str, float]:
    times: Array = times_ns / 1e3
    return {"median": float(np.median(times)), "p99": float(np.percentile(times, 99)),
            "worst": float(times.max())}
