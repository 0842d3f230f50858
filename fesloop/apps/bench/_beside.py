"""Processes that run beside a measured one: one loads a core, and on each core one only sleeps and wakes."""

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
from fesloop.loop.machine import asked_of_machine

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
    """One core kept busy, and on each a bare sleeper, until the context is left.

    Sleepers wake at the deadlines origin + k x period. What is yielded tells them the origin, again for each
    trial. They ask for the priority, as a run does. All processes end with this one, however that ends. What
    sleepers did is then in the folder: see `slept`.
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
    """Each sleeper's core, its deadlines (`time.monotonic_ns()`) and by how much it woke late, ns: (n, 3).

    In the order of deadlines.
    """
    rows = np.concatenate([np.load(each) for each in sorted(folder.glob("slept-*.npy"))])
    return rows[np.argsort(rows[:, 1], kind="stable")]


def _burn(core: int, parent: int) -> None:
    """Keep a core busy as long as the parent lives."""
    os.sched_setaffinity(0, {core})
    while os.getppid() == parent:
        sum(range(100_000))


def _sleep_and_wake(folder: Path, core: int, period_ns: int, priority: int, parent: int) -> None:
    """Sleep until each deadline and note how late that was, as the loop sleeps, with nothing else to do."""
    rows = np.full((_MOST_TICKS, 3), core, np.int64)
    gc.disable()
    os.sched_setaffinity(0, {core})
    with asked_of_machine(True, priority):
        count = _note_wakings(rows, Origin(folder / "origin"), period_ns, parent)
    np.save(folder / f"slept-{core}.npy", rows[:count])


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
        rows[count, 1:] = deadline, -ahead
        tick, count = tick + 1, count + 1
    return count
