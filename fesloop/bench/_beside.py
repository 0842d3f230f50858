"""Processes that run beside a measured one: one that loads a core, and one that only sleeps and wakes."""

from __future__ import annotations

import gc
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.clock import NS_PER_S
from fesloop.realtime.machine import asked_of_machine

Wakings = NDArray[np.int64]
_LOOK_NS = NS_PER_S // 20
_MOST_TICKS = 2**20


class Origin:
    """An instant of `time.monotonic_ns()`, in a small file that processes share; 0 until it is told."""

    def __init__(self, path: Path) -> None:
        self._told = np.memmap(path, np.int64, "r+" if path.exists() else "w+", shape=(2,))

    def tell(self, origin_ns: int) -> None:
        """Tell the instant."""
        self._told[0] = origin_ns

    def end(self) -> None:
        """Tell that there is nothing more to do."""
        self._told[1] = 1

    @property
    def ns(self) -> int:
        """The instant."""
        return int(self._told[0])

    @property
    def over(self) -> bool:
        """Whether there is nothing more to do."""
        return bool(self._told[1])


@contextmanager
def beside(folder: Path, period_ns: int, priority: int = 0) -> Iterator[Origin]:
    """One core kept busy, and a bare sleeper on the deadlines origin + k x period, until the context is left.

    What is yielded tells the sleeper its origin, again for each trial. It asks for the priority, as a run
    does. Both processes end with this one, however that ends. What the sleeper did is then in the folder: see
    `slept`.
    """
    context = get_context("spawn")
    origin = Origin(folder / "origin")
    busy = max(os.sched_getaffinity(0))
    others = [context.Process(target=_burn, args=(busy, os.getpid()), daemon=True),
              context.Process(target=_sleep_and_wake, args=(folder, period_ns, priority, os.getpid()),
                              daemon=True)]
    for other in others:
        other.start()
    burner, sleeper = others
    try:
        yield origin
    finally:
        origin.end()
        burner.kill()
        sleeper.join(5.0)
        for other in others:
            other.kill()
            other.join()


def slept(folder: Path) -> Wakings:
    """Deadlines of the sleeper (`time.monotonic_ns()`) and by how much it woke late, (n, 2) ns."""
    rows: Wakings = np.load(folder / "slept.npy")
    return rows


def _burn(core: int, parent: int) -> None:
    """Keep a core busy as long as the parent lives."""
    os.sched_setaffinity(0, {core})
    while os.getppid() == parent:
        sum(range(100_000))


def _sleep_and_wake(folder: Path, period_ns: int, priority: int, parent: int) -> None:
    """Sleep until each deadline and note how late that was, as the loop sleeps, with nothing else to do."""
    rows = np.zeros((_MOST_TICKS, 2), np.int64)
    gc.disable()
    with asked_of_machine(True, priority):
        count = _note_wakings(rows, Origin(folder / "origin"), period_ns, parent)
    np.save(folder / "slept.npy", rows[:count])


def _note_wakings(rows: Wakings, told: Origin, period_ns: int, parent: int) -> int:
    """Fill rows until it is told that all is over; how many were."""
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
        rows[count] = deadline, -ahead
        tick, count = tick + 1, count + 1
    return count
