"""Run of an experiment: trial after trial, in stretches, into a recording."""

from __future__ import annotations

import gc
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import FrameType
from typing import Any

from fesloop.errors import FesloopError, InputError, RunError
from fesloop.experiment.metrics.scoring import metrics_of
from fesloop.experiment.recording.reading import Event, Recording
from fesloop.experiment.recording.writing import RecordingWriter, TimedBlock, require_folder_name, timed
from fesloop.experiment.specification import ExperimentSpecification
from fesloop.loop.abilities import Closes, HasStandIn, Seeks, offers
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, waits_for_arrivals
from fesloop.loop.machine import InStep, in_step_with_wall, one_blas_thread, threads_now
from fesloop.loop.nodes import Node
from fesloop.loop.realtime import Pacing, is_live
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.wiring import Wiring

_MOMENT_NS = NS_PER_S // 10
_LONGEST_NS = 2 * NS_PER_S
"""Simulated time of a rehearsal, besides wires (chosen: a loop that keeps pace takes no longer)."""
_LONGEST_WALL_S = 1.0
"""Latest start, s of wall time, of a stretch of the rehearsal outside real time, however dense ticks are."""


class Rehearsals:
    """Rehearsals of runs in this process.

    They remember the kinds of parts of each loop, whose kernels are loaded.
    """

    def __init__(self) -> None:
        self._rehearsed: set[frozenset[type[Any]]] = set()

    def rehearse(self, experiment: ExperimentSpecification, realtime: bool) -> None:
        """Load the kernels of a run, where that has yet to be done.

        A loop of the same kinds of parts needs it once in a process. Where the wall clock decides what comes
        of the run (in real time, or where steps are measured) it is done each time, for another parameter may
        lead to another kernel; elsewhere such a kernel costs some wall time and changes nothing. There it
        lasts until a message has been all the way round, two simulated seconds at most: blocks may call other
        kernels once they have received one. It is left out where a device would notice, unless the device has
        a stand-in. Faults are ignored here: they happen again in the run, which reports them.
        """
        if without_stand_in(experiment.wiring):
            return
        wiring = with_stand_ins(experiment.wiring)
        parts = frozenset(type(node.part) for node in wiring.nodes)
        measured = any(node.execution.kind == "measured" for node in wiring.nodes)
        wall_counts = bool(realtime or measured or experiment.record.timed)
        if parts in self._rehearsed and not wall_counts:
            return
        self._rehearsed.add(parts)
        until = min(_MOMENT_NS + (_way_round_ns(wiring) if wall_counts else 0), _LONGEST_NS)
        began, done = time.perf_counter(), 0
        with suppress(Exception):
            loop = Loop(wiring, recorder=Recorder(experiment.record.plant_rate))
            while done < until and (wall_counts or time.perf_counter() - began < _LONGEST_WALL_S):
                done = max(1, 4 * done)
                loop.run_until(min(done, until))


def without_stand_in(wiring: Wiring) -> list[str]:
    """Names of the nodes that a rehearsal would affect; with any of them there is none."""
    return [node.name for node in wiring.nodes
            if offers(node.part, Closes) and not offers(node.part, HasStandIn)]


def _way_round_ns(wiring: Wiring) -> int:
    """Upper bound of the time that a message takes through all wires and blocks, each passed once."""
    wires = [connection.wire for connection in wiring.connections]
    return (sum(wire.latency_ns + (wire.jitter.most_ns or 0) for wire in wires)
            + sum(node.execution.most_ns or 0 for node in wiring.nodes))


def with_stand_ins(wiring: Wiring) -> Wiring:
    """The wiring with a stand-in for each block that has one, and no clock that waits for messages."""
    if not any(offers(node.part, HasStandIn) or waits_for_arrivals(node.clock) for node in wiring.nodes):
        return wiring
    nodes = [_plain(node) for node in wiring.nodes]
    return Wiring(nodes, [connection.wire for connection in wiring.connections], wiring.seed)


def _plain(node: Node) -> Node:
    """The node with its stand-in, on a clock that ticks by itself."""
    if offers(node.part, HasStandIn):
        node = replace(node, part=node.part.stand_in())
    given = node.given_clock
    return replace(node, rate=replace(given, arrivals="")) if waits_for_arrivals(given) else node


class Interrupt:
    """A request to stop the run."""

    def __init__(self) -> None:
        self.asked = False

    def ask(self, number: int, frame: FrameType | None) -> None:
        """Stop at the end of a stretch; at once on a second request."""
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True


@contextmanager
def interruptible() -> Iterator[Interrupt]:
    """Delay Ctrl-C, and SIGTERM of schedulers, to the end of a stretch, when the recording is whole."""
    interrupt = Interrupt()
    if threading.current_thread() is not threading.main_thread():
        yield interrupt
        return
    before = {number: signal.signal(number, interrupt.ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield interrupt
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


_FIRST_STRETCH_NS = NS_PER_MS
_LONGEST_STRETCH_NS = 100 * NS_PER_S
_STRETCH_WALL_S = 0.05
_FLUSH_WALL_S = 0.4
"""Stretch and flush together stay below the second that a killed run may lose."""
_LEISURE_NS = 3 * NS_PER_MS
"""In step with the wall clock, a piece of a flush is written where nothing is due for so long (chosen: one
takes up to a ms on a slow machine)."""

_OVER = object()
Progress = Callable[[float], None]


class UnderWay:
    """One run.

    Attributes
    ----------
    simulated_ns: of all trials together, up to now.
    worst_write_ns: longest pause of the loop for a write, except at the end of trials.
    """

    def __init__(self, experiment: ExperimentSpecification, loop: Loop,
                 timed_blocks: Mapping[str, TimedBlock], writer: RecordingWriter, in_step: InStep | None,
                 progress: Progress | None) -> None:
        self.experiment, self.loop, self.writer = experiment, loop, writer
        self.timed = timed_blocks
        self.in_step, self.progress = in_step, progress
        self.simulated_ns = self.worst_write_ns = 0
        self.trial = 0
        self._flushed = time.perf_counter()
        self._pieces: Iterator[None] | None = None
        self._stretch_ns = _FIRST_STRETCH_NS

    def trials(self, interrupt: Interrupt) -> None:
        """Run every trial, until a stop is requested."""
        for trial in range(self.experiment.trials):
            self.trial = trial
            if trial:
                self.loop.next_trial()
            self._one_trial(interrupt)
            if interrupt.asked:
                return
            self.flush()
            self.writer.write_messages(self.loop)

    def _one_trial(self, interrupt: Interrupt) -> None:
        """Run [0, duration) in stretches, or in step with the wall clock."""
        if self.in_step is not None:
            self.in_step.pacer.begin_trial()
            self.writer.write_wall(self.in_step.pacer, self.trial)  # t = 0, even if the run fails
        duration, done = self.experiment.duration_ns, 0
        while done < duration and not interrupt.asked:
            stop = self._stretch(done, duration) if self.in_step is None else self.in_step.advance(duration)
            self.simulated_ns += stop - done
            done = stop
            if self._written() and self.progress is not None:
                self.progress((self.trial + done / duration) / self.experiment.trials)

    def _stretch(self, done: int, duration: int) -> int:
        """Run a stretch of some tens of ms of wall time; return its end."""
        stop = min(duration, done + self._stretch_ns)
        began = time.perf_counter()
        self.loop.run_until(stop - 1)
        factor = min(2.0, max(0.25, _STRETCH_WALL_S / max(time.perf_counter() - began, 1e-6)))
        self._stretch_ns = min(_LONGEST_STRETCH_NS, max(1, int(self._stretch_ns * factor)))
        return stop

    def _written(self) -> bool:
        """Write if it is time; return whether everything is written.

        In step with the wall clock a piece is written where there is leisure, or else after every instant.
        """
        began = time.perf_counter()
        since = began - self._flushed
        if since < _FLUSH_WALL_S:
            return False
        if self.in_step is None or since >= 2 * _FLUSH_WALL_S:
            self.flush()
            over = True
        elif since >= 1.5 * _FLUSH_WALL_S or self.in_step.pacer.slack_ns() > _LEISURE_NS:
            self._pieces = self._pieces or self._in_pieces()
            over = next(self._pieces, _OVER) is _OVER
            self._pieces = None if over else self._pieces
        else:
            return False
        self.worst_write_ns = max(self.worst_write_ns, round((time.perf_counter() - began) * NS_PER_S))
        return over

    def _in_pieces(self) -> Iterator[None]:
        """Write the recorded rows, one stream after the other."""
        assert self.loop.recorder is not None
        began = time.perf_counter()
        yield from self.writer.write_in_pieces(self.loop.recorder, self.trial)
        self.writer.write_step_times(self.timed)
        if self.in_step is not None:
            self.writer.write_wall(self.in_step.pacer, self.trial)
        self._flushed = began

    @property
    def outcome(self) -> dict[str, int | float] | None:
        """Statistics of a run in real time for its recording; None for other runs."""
        if self.in_step is None:
            return None
        return {**self.in_step.outcome, "worst_write_ms": self.worst_write_ns / NS_PER_MS}

    def flush(self) -> None:
        """Write all recorded rows, after finishing pieces that are under way."""
        assert self.loop.recorder is not None
        for _ in self._pieces or ():
            pass
        self._pieces = None
        self.writer.write(self.loop.recorder, self.trial)
        self.writer.write_step_times(self.timed)
        if self.in_step is not None:
            self.writer.write_wall(self.in_step.pacer, self.trial)
        self._flushed = time.perf_counter()


_COLLECT_AFTER = 100_000

@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """Result of a run.

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

    @property
    def events(self) -> Sequence[Event]:
        """All events of the recording, in order of time; none where its file has gone."""
        if not self.recording.is_file():
            return ()
        with Recording(self.recording) as recording:
            return tuple(recording.events)

    @property
    def troubles(self) -> Sequence[str]:
        """Troubles of the run, the gravest first, as `fesloop run` says; none without the recording."""
        from fesloop.experiment.trouble import troubles  # most runs are of studies, which do without

        if not self.recording.is_file():
            return ()
        with Recording(self.recording) as recording:
            return tuple(each.text for each in troubles(recording, self.metrics, self.cause))

    def as_table(self) -> dict[str, Any]:
        """Tables that `fesloop run --json` prints; `realtime` only of real time, `cause` of a failure."""
        facts = {"experiment": self.experiment, "seed": self.seed, "status": self.status,
                 "recording": str(self.recording), "metrics": self.metrics, "wall_s": self.wall_s,
                 "realtime_factor": self.realtime_factor}
        more = {"realtime": self.realtime, "cause": self.cause}
        return facts | {name: value for name, value in more.items() if value}

    def __str__(self) -> str:
        from fesloop.experiment.shown import result_tables
        from fesloop.tables import as_text

        return as_text(result_tables(self))

    def _repr_html_(self) -> str:
        from fesloop.experiment.shown import result_tables
        from fesloop.tables import as_html

        return as_html(result_tables(self))


@one_blas_thread()
def run(experiment: ExperimentSpecification, out: Path, *, realtime: bool | Pacing = False,
        progress: Progress | None = None, rehearsals: Rehearsals | None = None) -> Result:
    """Run every trial, record into a new file in the folder `out`, and score the file.

    `realtime` keeps it in step with the wall clock, as a `Pacing` says or as that is by default. Whoever runs
    many gives all the same `rehearsals`, so that a loop is rehearsed once. A failure or Ctrl-C ends the run
    with that status; what was recorded until then is kept. Raises InputError, and leaves nothing behind,
    where the run cannot start.
    """
    require_folder_name(out)
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
        metrics, kept_time = _scored(recording, status), _kept_time(recording) if pacing else {}
    return Result(experiment=experiment.name, seed=experiment.seed, status=status, recording=writer.path,
                  metrics=metrics, wall_s=wall_s, realtime_factor=this.simulated_ns / NS_PER_S / wall_s,
                  cause=cause, deadlines=kept_time.get("deadlines", 0),
                  missed_deadlines=kept_time.get("missed", 0), realtime=kept_time)


def _refuse_live(experiment: ExperimentSpecification) -> None:
    """Raise InputError for a live stream in a run that is not in real time."""
    for node in experiment.wiring.nodes:
        if is_live(node):
            raise InputError(f"blocks.{node.name}", "is live: it runs in step with the wall clock only",
                             "fesloop run --realtime")


def _seek(experiment: ExperimentSpecification) -> None:
    """Let parts search for what they need, such as a stream, so that a mistyped name is reported at once."""
    for node in experiment.wiring.nodes:
        if offers(node.part, Seeks):
            node.part.seek()


@contextmanager
def _collecting_rarely() -> Iterator[None]:
    """Collect garbage rarely: recorded rows are many small tuples without cycles."""
    before = gc.get_threshold()
    gc.set_threshold(_COLLECT_AFTER, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


def _outcome(this: UnderWay) -> tuple[str, str]:
    """Run, and close every device at once after it; return status and cause of the end."""
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


def _kept_time(recording: Recording) -> dict[str, Any]:
    """How a run kept in step with the wall clock."""
    from fesloop.experiment.metrics.lateness import realtime_summary  # other runs do without

    return realtime_summary(recording)


def _scored(recording: Recording, status: str) -> dict[str, Any]:
    """Metrics of a recording; of a run that broke off, those that it still gives."""
    try:
        return metrics_of(recording)
    except FesloopError:
        if status == "done":
            raise
        return {}


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Experiment(ExperimentSpecification):
    """An experiment, specified as `ExperimentSpecification` says, and its run."""

    def run(self, out: str | Path = "runs", *, realtime: bool | Pacing = False,
            progress: Callable[[float], None] | None = None) -> Result:
        """Run every trial and leave one recording in the folder `out`.

        `realtime` keeps simulated time in step with the wall clock; a `Pacing` also sets, for
        example, how late ticks are treated. `progress` receives the fraction done.
        Raises RunError if the run fails and KeyboardInterrupt if it is interrupted; what was recorded
        until then is kept.
        """
        result = run(self, Path(out), realtime=realtime, progress=progress)
        if result.status == "failed":
            raise RunError(f"{result.cause}; recorded until then: {result.recording}")
        if result.status == "interrupted":
            raise KeyboardInterrupt
        return result
