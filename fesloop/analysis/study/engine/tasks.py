"""Tasks on a Dask cluster, a window of them at a time.

However many tasks there are, client and scheduler hold only those of the window, so that memory does not grow
with them. `distributed.as_completed` yields them in the order in which they end.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError
from typing import Any, NamedTuple, Protocol
from uuid import uuid4

from fesloop.analysis.study.engine.cluster import renew, require_dask, threads
from fesloop.errors import RunError

_AHEAD = 10
"""Submitted tasks per thread of the cluster: one runs, one waits there, others wait at the scheduler while
outcomes are fetched (chosen: runs of 20 ms do not wait for that)."""
_LEAST_AHEAD = 4
_TOGETHER_S = 0.1
"""Outcomes that come within this time are fetched, and stored, together."""
_LOOK_S = 0.5
_RENEW_S = 2.0
_GONE = "the scheduler is gone; earlier results are kept; start the study again to continue"
_FETCH_S = 30.0
"""Longest time to fetch outcomes (chosen: they are small). Dask waits without end for one that is lost with
its worker meanwhile, also where no other worker starts until `renew` is called."""
_PATIENCE_S = 15.0
"""Longest silence of a scheduler; a network's hiccup is shorter (chosen)."""


class Task(NamedTuple):
    """A function of a module, its arguments, and a name for its outcome, which is never None."""

    id: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]


class Done(NamedTuple):
    """The outcome of a task, or the error of its worker."""

    id: str
    outcome: Any
    fault: BaseException | None


def completed(client: Any, tasks: Iterator[Task], waiting: Callable[[], object] = lambda: None
              ) -> Iterator[list[Done]]:
    """Run all tasks and yield their outcomes, some at a time.

    `waiting` is called twice a second while no task ends. Raises RunError when the scheduler is gone.
    """
    ended = require_dask().as_completed(loop=client.loop)
    submitted: dict[Any, str] = {}
    exhausted, silent_since, renewed_at, window = False, time.monotonic(), 0.0, 0
    # Tasks of two clients that have the same key are one task to a scheduler, whatever their arguments.
    prefix = f"fesloop-{uuid4().hex[:8]}"
    try:
        while True:
            if time.monotonic() - renewed_at > _RENEW_S or client.status != "running":
                renew(client)
                window, renewed_at = _window(client), time.monotonic()
            while not exhausted and len(submitted) < window:
                task = next(tasks, None)
                if task is None:
                    exhausted = True
                    break
                future = client.submit(task.function, *task.arguments, key=f"{prefix}-{task.id}", pure=False)
                submitted[future] = task.id
                ended.add(future)
            if exhausted and not submitted:
                return
            batch = {submitted[future]: future for future in _batch(ended)}
            done = _outcomes(client, batch)
            if client.status == "running":
                silent_since = time.monotonic()
            elif time.monotonic() - silent_since > _PATIENCE_S or client.status == "closed":
                raise RunError(_GONE)
            for each in done:
                del submitted[batch.pop(each.id)]
            # The rest were lost with their worker before they were fetched; the scheduler runs them again.
            ended.update(batch.values())
            if done:
                yield done
            else:
                waiting()
    finally:
        for future in submitted:
            future.release()


def _window(client: Any) -> int:
    """Most tasks to submit; none while the scheduler is silent."""
    return max(_LEAST_AHEAD, _AHEAD * threads(client)) if client.status == "running" else 0


def _batch(ended: Any) -> list[Any]:
    """Futures that have ended; waits for the first of them for `_LOOK_S`."""
    until = time.monotonic() + _LOOK_S
    time.sleep(_TOGETHER_S)
    while not ended.has_ready() and time.monotonic() < until:
        time.sleep(_TOGETHER_S)
    return list(ended.next_batch(block=False))


def _outcomes(client: Any, futures: Mapping[str, Any]) -> list[Done]:
    """Outcomes of futures that have ended, except those whose worker was lost before they were fetched.

    There are none where fetching takes longer than `_FETCH_S`. Raises RunError where tasks were cancelled:
    the scheduler was restarted.
    """
    whole = {id: future for id, future in futures.items() if future.status == "finished"}
    try:
        values = client.sync(client.gather, whole, errors="skip", callback_timeout=_FETCH_S) if whole else {}
    except TimeoutError:
        values = {}
    except (OSError, CancelledError) as fault:
        raise RunError(f"{_GONE} ({fault})") from None
    if any(future.status == "cancelled" for future in futures.values()):
        raise RunError(_GONE)
    done = [Done(id, value, None) for id, value in values.items() if value is not None]
    return done + [Done(id, None, future.exception()) for id, future in futures.items()
                   if future.status == "error"]


def each_of(several: Iterator[list[Done]]) -> Iterator[Done]:
    """The outcomes of `completed` one by one."""
    return (each for some in several for each in some)


class Watch(Protocol):
    """Receives the progress of a study."""

    def stage(self, text: str, fraction: float | None = None) -> None:
        """Report a stage before the runs, and its progress."""

    def runs(self, done: int, failed: Mapping[str, int], total: int) -> None:
        """Report numbers of runs: done, failed by cause, and all; also while none ends."""


class Nobody:
    """A `Watch` that ignores what it receives."""

    def stage(self, text: str, fraction: float | None = None) -> None:
        """Ignore a stage."""

    def runs(self, done: int, failed: Mapping[str, int], total: int) -> None:
        """Ignore numbers of runs."""
