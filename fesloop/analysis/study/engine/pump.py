"""Tasks to a Dask cluster and outcomes back, a window of them under way at any time.

However many tasks there are, only those of the window are held by client and scheduler, so memory does not
grow with them. Outcomes come in the order in which they are done.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Any, NamedTuple, Protocol
from uuid import uuid4

from fesloop.analysis.study.engine.cluster import renew, threads
from fesloop.errors import RunError

_AHEAD = 10
"""Tasks under way for each thread of the cluster: one that runs, one that waits there, others at the
scheduler while outcomes are fetched (chosen: runs of 20 ms do not wait for that)."""
_LEAST_AHEAD = 4
_LOOK_S = 0.5
_TOGETHER_S = 0.1
"""Outcomes that come within so long of each other are fetched, and noted, together."""
_RENEW_S = 2.0
_GONE = "the scheduler is gone; what was done is kept; start the study again to go on"
_PATIENCE_S = 15.0
"""For a scheduler that does not answer; a network's hiccup is shorter (chosen)."""


class Task(NamedTuple):
    """A function of a module, its arguments, and the name by which its outcome, never None, is told."""

    id: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]


class Done(NamedTuple):
    """The outcome of a task, or the error that its worker, not it itself, came to."""

    id: str
    outcome: Any
    fault: BaseException | None


def pumped(client: Any, tasks: Iterator[Task], waiting: Callable[[], object] = lambda: None
           ) -> Iterator[list[Done]]:
    """Outcomes of all tasks, some at a time.

    `waiting` is called while nothing comes, twice a second. Raises RunError when the scheduler is gone.
    """
    finished: SimpleQueue[Any] = SimpleQueue()
    under_way: dict[str, Any] = {}
    exhausted, silent_since, renewed_at, window = False, time.monotonic(), 0.0, 0
    # A key of two clients is one task to a scheduler, whatever each of them asks of it.
    own = f"fesloop-{uuid4().hex[:8]}"
    try:
        while True:
            if time.monotonic() - renewed_at > _RENEW_S or client.status != "running":
                renew(client)
                window, renewed_at = _window(client), time.monotonic()
            while not exhausted and len(under_way) < window:
                task = next(tasks, None)
                if task is None:
                    exhausted = True
                    break
                under_way[task.id] = client.submit(task.function, *task.arguments, key=f"{own}-{task.id}",
                                                   pure=False)
                under_way[task.id].add_done_callback(lambda _, id=task.id: finished.put(id))
            if exhausted and not under_way:
                return
            # What was lost with its worker is told of once only; it is looked for while nothing else comes.
            ids = _arrived(finished) or [id for id, future in under_way.items() if future.done()]
            now = time.monotonic()
            if client.status == "running":
                silent_since = now
            elif now - silent_since > _PATIENCE_S or client.status == "closed":
                raise RunError(_GONE)
            done = _outcomes(client, {id: under_way[id] for id in ids if id in under_way})
            for each in done:
                del under_way[each.id]
            if done:
                yield done
            else:
                waiting()
    finally:
        for future in under_way.values():
            future.release()


def _window(client: Any) -> int:
    """How many tasks may be under way; none more while the scheduler is silent."""
    return max(_LEAST_AHEAD, _AHEAD * threads(client)) if client.status == "running" else 0


def _arrived(finished: SimpleQueue[Any]) -> list[str]:
    """Ids of tasks that are done, waiting for a moment if there is none."""
    ids, until = [], time.monotonic() + _LOOK_S
    with suppress(Empty):
        while True:
            ids.append(finished.get(timeout=max(0.0, until - time.monotonic())))
            until = min(until, time.monotonic() + _TOGETHER_S)
    return list(dict.fromkeys(ids))


def _outcomes(client: Any, futures: dict[str, Any]) -> list[Done]:
    """What finished tasks gave; nothing of one whose worker ended with its outcome, which is done again.

    Raises RunError where tasks were called off: the scheduler was restarted.
    """
    whole = {id: future for id, future in futures.items() if future.status == "finished"}
    try:
        values = client.gather(whole, errors="skip") if whole else {}
    except (OSError, CancelledError) as fault:
        raise RunError(f"{_GONE} ({fault})") from None
    if any(future.status == "cancelled" for future in futures.values()):
        raise RunError(_GONE)
    done = [Done(id, value, None) for id, value in values.items() if value is not None]
    return done + [Done(id, None, future.exception()) for id, future in futures.items()
                   if future.status == "error"]


def each_of(several: Iterator[list[Done]]) -> Iterator[Done]:
    """What `pumped` gives, one by one."""
    return (each for some in several for each in some)


class Watch(Protocol):
    """Who is told how far a study is."""

    def stage(self, text: str, fraction: float | None = None) -> None:
        """What is being done before the runs."""

    def runs(self, done: int, failed: Mapping[str, int], total: int) -> None:
        """Runs that are done, that failed by cause, and all; told also while nothing comes."""


class Nobody:
    """Who is told and says nothing."""

    def stage(self, text: str, fraction: float | None = None) -> None:
        """As of `Watch`."""

    def runs(self, done: int, failed: Mapping[str, int], total: int) -> None:
        """As of `Watch`."""
