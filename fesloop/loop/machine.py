"""Requests to the operating system for a run in real time: locked memory, priority, deferred collection.

Memory is locked (`mlockall(2)`), so that no page of the run is swapped out; pages are locked as they come
into use, not before. Where the limit on locked memory (RLIMIT_MEMLOCK) is not lifted, what comes later is
left out: the allocations of a run would fail at the limit. The scheduling class is SCHED_FIFO (`sched(7)`)
only if a priority is requested: such a thread that never rests keeps everything else of its core waiting. It
is requested for the run's own thread and for Python threads that its blocks have started in `init`, such as
readers of live streams: one in the common class that is preempted while it holds the global interpreter lock
keeps the run waiting, whatever the run's priority. Native threads, such as those of liblsl, never hold that
lock and stay in the common class. Processes and threads that are started later do not inherit it.
"""

from __future__ import annotations

import gc
import sys
import threading
import time
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from types import TracebackType
from typing import Self

from threadpoolctl import ThreadpoolController

from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.realtime import Pacer, Pacing
from fesloop.loop.run import Loop

_NOT_LOCKED, _COMMON = "not locked: not requested", "as any other program"


@dataclass(frozen=True, slots=True)
class Granted:
    """Answers of the operating system to a run's requests.

    Attributes
    ----------
    memory, scheduling: in words, with the reason for a refusal.
    """

    memory: str
    scheduling: str


@contextmanager
def realtime_privileges(lock_memory: bool, priority: int, beside: Collection[int] = ()) -> Iterator[Granted]:
    """Request locked memory and SCHED_FIFO of a priority (0: none); release all of it at the end.

    The priority holds for the calling thread and for those `beside` it (see `threads_now`).
    """
    from fesloop import posix  # other runs do without

    before = posix.scheduling_of([0, *beside]) if priority else {}
    scheduling = posix.raise_priority(priority, before) if priority else _COMMON
    memory = posix.lock_memory() if lock_memory else _NOT_LOCKED
    try:
        yield Granted(memory, scheduling)
    finally:
        if memory.startswith("locked"):
            posix.unlock_memory()
        posix.set_back(before, threads_now())


def threads_now() -> frozenset[int]:
    """Threads of this process that take Python's lock, by the numbers that the kernel has for them."""
    return frozenset(thread.native_id for thread in threading.enumerate() if thread.native_id is not None)


_OFTEN_NS = NS_PER_S
_AT_LAST_NS = 30 * NS_PER_S
"""Interval between collections where there is leisure, and where there is none (chosen): only cycles wait
for them, as all else is freed at once, and the loop makes no cycles."""
_AT_FIRST_NS = 2 * NS_PER_MS
"""Expected time of a collection before one has been timed."""


class Garbage:
    """The collector during a run in real time: a context.

    What exists when the run begins is collected once, then frozen: no later collection visits it. The
    collector is off from then on, and runs where nothing is due for twice as long as it has ever
    worked (not counting what else the machine did meanwhile), or else every half minute. All of it is undone
    at the end.

    Attributes
    ----------
    collections, worst_ns: how many there were during the run, and how long the longest took.
    """

    def __init__(self) -> None:
        self.collections = self.worst_ns = 0
        self._last_ns = 0
        self._expected_ns = _AT_FIRST_NS
        self._enabled = self._frozen = False

    def __enter__(self) -> Self:
        self._enabled, self._frozen = gc.isenabled(), gc.get_freeze_count() == 0
        gc.collect()
        if self._frozen:
            gc.freeze()
        gc.disable()
        self._last_ns = time.monotonic_ns()
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None,
                 trace: TracebackType | None) -> None:
        if self._frozen:
            gc.unfreeze()
        if self._enabled:
            gc.enable()

    def collect_in(self, leisure_ns: int) -> None:
        """Collect if it is time, and nothing is due for so long."""
        began = time.monotonic_ns()
        since = began - self._last_ns
        if since < _OFTEN_NS or (leisure_ns < 2 * self._expected_ns and since < _AT_LAST_NS):
            return
        worked_ns = time.thread_time_ns()
        gc.collect()
        self._expected_ns = max(self._expected_ns, time.thread_time_ns() - worked_ns)
        self._last_ns = time.monotonic_ns()
        self.collections += 1
        self.worst_ns = max(self.worst_ns, self._last_ns - began)


@dataclass(frozen=True, slots=True)
class InStep:
    """Everything that keeps a run in step with the wall clock.

    Attributes
    ----------
    pacing, pacer: the settings, and what carries them out.
    garbage: Python's collector, deferred.
    granted: answers of the operating system.
    """

    pacing: Pacing
    pacer: Pacer
    garbage: Garbage
    granted: Granted

    def advance(self, stop_ns: int) -> int:
        """Advance the pacer, then collect garbage if there is time."""
        done = self.pacer.advance(stop_ns)
        self.garbage.collect_in(self.pacer.slack_ns())
        return done

    @property
    def facts(self) -> dict[str, str | float]:
        """Facts that a recording states from the start."""
        return {"policy": self.pacing.late, "period_ms": self.pacer.period_ns / NS_PER_MS,
                "memory": self.granted.memory, "scheduling": self.granted.scheduling}

    @property
    def outcome(self) -> dict[str, int | float]:
        """Facts that a recording states at the end."""
        return {"deadlines": self.pacer.deadlines, "missed_deadlines": self.pacer.missed,
                "worst_late_s": self.pacer.worst_late_ns / NS_PER_S,
                "collections": self.garbage.collections,
                "worst_collection_ms": self.garbage.worst_ns / NS_PER_MS}


@contextmanager
def in_step_with_wall(loop: Loop, pacing: Pacing | None, beside: Collection[int]) -> Iterator[InStep | None]:
    """Yield what keeps a run of the loop in step, with the threads beside it; None without pacing."""
    if pacing is None:
        yield None
        return
    with realtime_privileges(pacing.lock_memory, pacing.priority, beside) as granted:
        yield InStep(pacing, Pacer(loop, pacing), Garbage(), granted)


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Leave BLAS one thread, of all of this process, until the context is left."""
    with _libraries(len(sys.modules)).limit(limits=1, user_api="blas"):
        yield


@lru_cache(maxsize=1)
def _libraries(modules: int) -> ThreadpoolController:
    """BLAS libraries that are loaded; a search takes a ms, so it is repeated only for more `modules`."""
    return ThreadpoolController()
