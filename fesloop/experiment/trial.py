"""Running an experiment: trial after trial, in stretches, into a recording."""

from __future__ import annotations

import gc
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import Any

from fesloop.errors import FesloopError, InputError, RunError
from fesloop.experiment.blas import one_blas_thread
from fesloop.experiment.experiment import Experiment
from fesloop.experiment.reading import Recording
from fesloop.experiment.recording import RecordingWriter
from fesloop.experiment.rehearsal import rehearse
from fesloop.experiment.scoring import metrics_of
from fesloop.experiment.timing import TimedBlock, timed
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.pacer import Pacer
from fesloop.loop.realtime import Pacing, is_live
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop

_FIRST_STRETCH_NS = NS_PER_MS
_LONGEST_STRETCH_NS = 100 * NS_PER_S
_STRETCH_WALL_S = 0.05
_FLUSH_WALL_S = 0.4
"""Stretch and flush together stay below the second that a killed run may lose."""
_LEISURE_NS = 5 * NS_PER_MS
"""A flush takes some ms."""

_COLLECT_AFTER = 100_000

Progress = Callable[[float], None]


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

    def as_table(self) -> dict[str, Any]:
        """What `fesloop run --json` prints; `cause` only of a run that failed."""
        told = {"experiment": self.experiment, "seed": self.seed, "status": self.status,
                "recording": str(self.recording), "metrics": self.metrics, "wall_s": self.wall_s,
                "realtime_factor": self.realtime_factor}
        return {**told, "cause": self.cause} if self.cause else told


class _Interrupt:
    """Whether somebody has asked the run to stop."""

    def __init__(self) -> None:
        self.asked = False

    def ask(self, number: int, frame: FrameType | None) -> None:
        """Stop at the next chance; at once when asked a second time."""
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True


@contextmanager
def _interruptible() -> Iterator[_Interrupt]:
    """Ctrl-C, and SIGTERM as schedulers send it, are heard between two stretches, the recording whole."""
    interrupt = _Interrupt()
    if threading.current_thread() is not threading.main_thread():
        yield interrupt
        return
    before = {number: signal.signal(number, interrupt.ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield interrupt
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class _Run:
    """One run under way."""

    def __init__(self, experiment: Experiment, loop: Loop, timed_blocks: Mapping[str, TimedBlock],
                 writer: RecordingWriter, pacer: Pacer | None, progress: Progress | None) -> None:
        self.experiment, self.loop, self.writer = experiment, loop, writer
        self.timed = timed_blocks
        self.pacer, self.progress = pacer, progress
        self.simulated_ns = 0
        self.trial = 0
        self._flushed = time.perf_counter()
        self._stretch_ns = _FIRST_STRETCH_NS

    def trials(self, interrupt: _Interrupt) -> None:
        """Every trial, until asked to stop."""
        for trial in range(self.experiment.trials):
            self.trial = trial
            if trial:
                self.loop.next_trial()
            self._one_trial(interrupt)
            if interrupt.asked:
                return
            self.flush()
            self.writer.write_messages(self.loop)

    def _one_trial(self, interrupt: _Interrupt) -> None:
        """[0, duration) in stretches, or in step with the wall clock."""
        if self.pacer is not None:
            self.pacer.begin_trial()
        duration, done = self.experiment.duration_ns, 0
        while done < duration and not interrupt.asked:
            stop = self._stretch(done, duration) if self.pacer is None else self.pacer.advance(duration)
            self.simulated_ns += stop - done
            done = stop
            if self._flush_is_due():
                self.flush()
                if self.progress is not None:
                    self.progress((self.trial + done / duration) / self.experiment.trials)

    def _stretch(self, done: int, duration: int) -> int:
        """Run a stretch of some tens of ms of wall time; where it ends."""
        stop = min(duration, done + self._stretch_ns)
        began = time.perf_counter()
        self.loop.run_until(stop - 1)
        factor = min(2.0, max(0.25, _STRETCH_WALL_S / max(time.perf_counter() - began, 1e-6)))
        self._stretch_ns = min(_LONGEST_STRETCH_NS, max(1, int(self._stretch_ns * factor)))
        return stop

    def _flush_is_due(self) -> bool:
        """Whether to write now; in step with the wall clock that waits a little for a moment of leisure."""
        since = time.perf_counter() - self._flushed
        if self.pacer is None or since < _FLUSH_WALL_S:
            return since >= _FLUSH_WALL_S
        return since >= 2 * _FLUSH_WALL_S or self.pacer.slack_ns() > _LEISURE_NS

    def flush(self) -> None:
        """Write what the recorder holds."""
        assert self.loop.recorder is not None
        self.writer.write(self.loop.recorder, self.trial)
        self.writer.write_step_times(self.timed)
        if self.pacer is not None:
            self.writer.write_instants(self.pacer.rows, self.trial)
        self._flushed = time.perf_counter()


@one_blas_thread()
def run(experiment: Experiment, out: Path, *, realtime: bool | Pacing = False,
        progress: Progress | None = None) -> Result:
    """Run every trial, record into a new file in the folder `out`, and score the file.

    `realtime` keeps it in step with the wall clock, as a `Pacing` says or as that is by default. A failure
    or Ctrl-C ends the run with that status; what was recorded until then is kept. Raises InputError, and
    leaves nothing behind, where the run cannot start.
    """
    pacing = Pacing() if realtime is True else realtime or None
    if pacing is None:
        _refuse_live(experiment)
    wiring, timed_blocks = timed(experiment.wiring, experiment.record.timed)
    rehearse(experiment, pacing is not None)
    loop = Loop(wiring, recorder=Recorder(experiment.record.plant_rate))
    with closing(loop):
        writer = RecordingWriter(out, experiment, paced=pacing is not None)
        pacer = Pacer(loop, pacing) if pacing is not None else None
        this = _Run(experiment, loop, timed_blocks, writer, pacer, progress)
        status, cause = "failed", ""
        began = time.perf_counter()
        try:
            status, cause = _outcome(this)
        finally:
            with suppress(RunError):
                this.flush()
            wall_s = time.perf_counter() - began
            late = (pacer.deadlines, pacer.missed, pacer.worst_late_ns / NS_PER_S) if pacer else (0, 0, 0.0)
            writer.close(status, wall_s, late)
    return Result(experiment=experiment.name, seed=experiment.seed, status=status, recording=writer.path,
                  metrics=_scored(writer.path, status), wall_s=wall_s,
                  realtime_factor=this.simulated_ns / NS_PER_S / wall_s, cause=cause,
                  deadlines=late[0], missed_deadlines=late[1])


def _refuse_live(experiment: Experiment) -> None:
    """A live stream cannot be heard faster or slower than it comes. Raises InputError naming the first."""
    for node in experiment.wiring.nodes:
        if is_live(node):
            raise InputError(f"blocks.{node.name}", "is live: it runs in step with the wall clock only",
                             "fesloop run --realtime")


@contextmanager
def _collecting_rarely() -> Iterator[None]:
    """Recorded rows are many small tuples and no cycles: Python's collector would visit them in vain."""
    before = gc.get_threshold()
    gc.set_threshold(_COLLECT_AFTER, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


def _outcome(this: _Run) -> tuple[str, str]:
    """Run, and say how it ended: status and cause."""
    try:
        with _interruptible() as interrupt, _collecting_rarely():
            this.trials(interrupt)
            return ("interrupted" if interrupt.asked else "done"), ""
    except KeyboardInterrupt:
        return "interrupted", ""
    except RunError as fault:
        return "failed", " ".join(str(fault).split())


def _scored(path: Path, status: str) -> dict[str, Any]:
    """Metrics of a recording; of a run that broke off, those that it still gives."""
    with Recording(path) as recording:
        try:
            return metrics_of(recording)
        except FesloopError:
            if status == "done":
                raise
            return {}
