"""Running an experiment: trial after trial, in stretches, into a recording."""

from __future__ import annotations

import gc
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fesloop.errors import FesloopError, InputError, RunError
from fesloop.experiment.experiment import Experiment
from fesloop.experiment.metrics.lateness import realtime_summary
from fesloop.experiment.metrics.scoring import metrics_of
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.recording.writing import RecordingWriter
from fesloop.experiment.running.blas import one_blas_thread
from fesloop.experiment.running.interrupts import interruptible
from fesloop.experiment.running.rehearsal import Rehearsals
from fesloop.experiment.running.timing import timed
from fesloop.experiment.running.under_way import Progress, UnderWay
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.in_step import in_step_with_wall
from fesloop.loop.machine import threads_now
from fesloop.loop.realtime import Pacing, is_live
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop

_COLLECT_AFTER = 100_000

@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """What came of a run.

    Attributes
    ----------
    experiment, seed: what was run.
    status: done, failed or interrupted.
    recording: its file.
    metrics: from the recording alone.
    wall_s: how long it took, without loading and scoring.
    realtime_factor: simulated time over wall_s.
    cause: why it failed, in one line; empty otherwise.
    deadlines, missed_deadlines: of a run in real time.
    realtime: how it kept in step with the wall clock (`fesloop.experiment.metrics.lateness`); empty for other
    runs.
    """

    experiment: str
    seed: int
    status: str
    recording: Path
    metrics: dict[str, Any] = field(default_factory=dict)
    wall_s: float
    realtime_factor: float
    cause: str = ""
    deadlines: int = 0
    missed_deadlines: int = 0
    realtime: dict[str, Any] = field(default_factory=dict)

    def as_table(self) -> dict[str, Any]:
        """What `fesloop run --json` prints; `realtime` only of a run that was, `cause` of one that failed."""
        told = {"experiment": self.experiment, "seed": self.seed, "status": self.status,
                "recording": str(self.recording), "metrics": self.metrics, "wall_s": self.wall_s,
                "realtime_factor": self.realtime_factor}
        more = {"realtime": self.realtime, "cause": self.cause}
        return told | {name: value for name, value in more.items() if value}


@one_blas_thread()
def run(experiment: Experiment, out: Path, *, realtime: bool | Pacing = False,
        progress: Progress | None = None, rehearsals: Rehearsals | None = None) -> Result:
    """Run every trial, record into a new file in the folder `out`, and score the file.

    `realtime` keeps it in step with the wall clock, as a `Pacing` says or as that is by default. Whoever runs
    many gives all the same `rehearsals`, so that a loop is rehearsed once. A failure or Ctrl-C ends the run
    with that status; what was recorded until then is kept. Raises InputError, and leaves nothing behind,
    where the run cannot start.
    """
    pacing = Pacing() if realtime is True else realtime or None
    if pacing is None:
        _refuse_live(experiment)
    else:
        _seek(experiment)
    wiring, timed_blocks = timed(experiment.wiring, experiment.record.timed)
    (rehearsals or Rehearsals()).rehearse(experiment, pacing is not None)
    before = threads_now()
    loop = Loop(wiring, recorder=Recorder(experiment.record.plant_rate))
    with closing(loop), in_step_with_wall(loop, pacing, threads_now() - before) as in_step:
        writer = RecordingWriter(out, experiment, in_step.facts if in_step else None)
        this = UnderWay(experiment, loop, timed_blocks, writer, in_step, progress)
        status, cause = "failed", ""
        began = time.perf_counter()
        try:
            status, cause = _outcome(this)
        finally:
            try:
                with suppress(RunError):
                    this.flush()
            finally:
                wall_s = time.perf_counter() - began
                writer.close(status, wall_s, this.outcome)
    with Recording(writer.path) as recording:
        metrics, kept_time = _scored(recording, status), realtime_summary(recording)
    return Result(experiment=experiment.name, seed=experiment.seed, status=status, recording=writer.path,
                  metrics=metrics, wall_s=wall_s, realtime_factor=this.simulated_ns / NS_PER_S / wall_s,
                  cause=cause, deadlines=kept_time.get("deadlines", 0),
                  missed_deadlines=kept_time.get("missed", 0), realtime=kept_time)


def _refuse_live(experiment: Experiment) -> None:
    """A live stream cannot be heard faster or slower than it comes. Raises InputError naming the first."""
    for node in experiment.wiring.nodes:
        if is_live(node):
            raise InputError(f"blocks.{node.name}", "is live: it runs in step with the wall clock only",
                             "fesloop run --realtime")


def _seek(experiment: Experiment) -> None:
    """Let parts look for what they are to hear, so that a user who mistyped a name need not wait to know."""
    for node in experiment.wiring.nodes:
        seek = getattr(node.part, "seek", None)
        if seek is not None:
            seek()


@contextmanager
def _collecting_rarely() -> Iterator[None]:
    """Recorded rows are many small tuples and no cycles: Python's collector would visit them in vain."""
    before = gc.get_threshold()
    gc.set_threshold(_COLLECT_AFTER, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


def _outcome(this: UnderWay) -> tuple[str, str]:
    """Run, let every device go before anything else is done, and say how it ended: status and cause."""
    status, cause = "failed", ""
    try:
        status, cause = _ran(this)
    finally:
        try:
            this.loop.close()
        except RunError as fault:
            status, cause = "failed", cause or " ".join(str(fault).split())
    return status, cause


def _ran(this: UnderWay) -> tuple[str, str]:
    """Run every trial: status and cause."""
    collecting = _collecting_rarely() if this.in_step is None else this.in_step.garbage
    try:
        with interruptible() as interrupt, collecting:
            this.trials(interrupt)
            return ("interrupted" if interrupt.asked else "done"), ""
    except KeyboardInterrupt:
        return "interrupted", ""
    except RunError as fault:
        return "failed", " ".join(str(fault).split())


def _scored(recording: Recording, status: str) -> dict[str, Any]:
    """Metrics of a recording; of a run that broke off, those that it still gives."""
    try:
        return metrics_of(recording)
    except FesloopError:
        if status == "done":
            raise
        return {}
