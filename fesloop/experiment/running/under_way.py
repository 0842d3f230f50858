"""A run under way: trial after trial, in stretches or in step with the wall clock, and written down."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping

from fesloop.experiment.experiment import Experiment
from fesloop.experiment.recording.writing import RecordingWriter
from fesloop.experiment.running.interrupts import Interrupt
from fesloop.experiment.running.timing import TimedBlock
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.in_step import InStep
from fesloop.loop.run import Loop

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
    worst_write_ns: the longest that the loop stood still for a write, at the end of trials apart.
    """

    def __init__(self, experiment: Experiment, loop: Loop, timed_blocks: Mapping[str, TimedBlock],
                 writer: RecordingWriter, in_step: InStep | None, progress: Progress | None) -> None:
        self.experiment, self.loop, self.writer = experiment, loop, writer
        self.timed = timed_blocks
        self.in_step, self.progress = in_step, progress
        self.simulated_ns = self.worst_write_ns = 0
        self.trial = 0
        self._flushed = time.perf_counter()
        self._pieces: Iterator[None] | None = None
        self._stretch_ns = _FIRST_STRETCH_NS

    def trials(self, interrupt: Interrupt) -> None:
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

    def _one_trial(self, interrupt: Interrupt) -> None:
        """[0, duration) in stretches, or in step with the wall clock."""
        if self.in_step is not None:
            self.in_step.pacer.begin_trial()
            self.writer.write_wall(self.in_step.pacer, self.trial)  # when t = 0 was, whatever befalls the run
        duration, done = self.experiment.duration_ns, 0
        while done < duration and not interrupt.asked:
            stop = self._stretch(done, duration) if self.in_step is None else self.in_step.advance(duration)
            self.simulated_ns += stop - done
            done = stop
            if self._written() and self.progress is not None:
                self.progress((self.trial + done / duration) / self.experiment.trials)

    def _stretch(self, done: int, duration: int) -> int:
        """Run a stretch of some tens of ms of wall time; where it ends."""
        stop = min(duration, done + self._stretch_ns)
        began = time.perf_counter()
        self.loop.run_until(stop - 1)
        factor = min(2.0, max(0.25, _STRETCH_WALL_S / max(time.perf_counter() - began, 1e-6)))
        self._stretch_ns = min(_LONGEST_STRETCH_NS, max(1, int(self._stretch_ns * factor)))
        return stop

    def _written(self) -> bool:
        """Write if it is time; whether all has been.

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
        """Write what is held now, one stream after the other."""
        assert self.loop.recorder is not None
        began = time.perf_counter()
        yield from self.writer.write_in_pieces(self.loop.recorder, self.trial)
        self.writer.write_step_times(self.timed)
        if self.in_step is not None:
            self.writer.write_wall(self.in_step.pacer, self.trial)
        self._flushed = began

    @property
    def outcome(self) -> dict[str, int | float] | None:
        """What a recording says in the end of how a run kept in step; None of one that need not."""
        if self.in_step is None:
            return None
        return {**self.in_step.outcome, "worst_write_ms": self.worst_write_ns / NS_PER_MS}

    def flush(self) -> None:
        """Write all that is held, and what of it was begun to be written."""
        assert self.loop.recorder is not None
        for _ in self._pieces or ():
            pass
        self._pieces = None
        self.writer.write(self.loop.recorder, self.trial)
        self.writer.write_step_times(self.timed)
        if self.in_step is not None:
            self.writer.write_wall(self.in_step.pacer, self.trial)
        self._flushed = time.perf_counter()
