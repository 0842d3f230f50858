"""Tasks on a Dask cluster, a window of them at a time.

However many tasks there are, client and scheduler hold only those of the window, so that memory does not grow
with them. A worker is given several short ones at once, as Dask takes some milliseconds for whatever it is
given. `distributed.as_completed` yields these batches in the order in which they end.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from typing import Any, NamedTuple, Protocol
from uuid import uuid4

from fesloop.analysis.study.engine.cluster import renew, require_dask, threads
from fesloop.errors import RunError

_AHEAD = 10
"""Submitted batches per thread of the cluster: one runs, one waits there, others wait at the scheduler while
outcomes are fetched (chosen: single runs of 20 ms, with which a study begins, do not wait for that)."""
_LEAST_AHEAD = 4
_BATCH_S = 0.2
"""Time after which a worker begins no other task of a batch (chosen: many times what Dask takes for one)."""
_LARGEST = 32
"""Most tasks of a batch: those that are lost with a worker are tried one by one."""
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
    submitted: dict[Any, list[Task]] = {}
    left = deque[Task]()
    exhausted, silent_since, renewed_at, window, size = False, time.monotonic(), 0.0, 0, 1
    # Tasks of two clients that have the same key are one task to a scheduler, whatever their arguments.
    prefix = f"fesloop-{uuid4().hex[:8]}"
    try:
        while True:
            if time.monotonic() - renewed_at > _RENEW_S or client.status != "running":
                renew(client)
                window, renewed_at = _window(client), time.monotonic()
            while not exhausted and len(submitted) < window:
                batch = [task for _ in range(size) if (task := left.popleft() if left else next(tasks, None))]
                if not batch:
                    exhausted = True
                    break
                future = client.submit(_in_turn, [each.function for each in batch],
                                       [each.arguments for each in batch],
                                       key=f"{prefix}-{batch[0].id}-{len(batch)}", pure=False)
                submitted[future] = batch
                ended.add(future)
            if exhausted and not submitted:
                return
            futures = _ended(ended)
            results = _results(client, futures)
            if client.status == "running":
                silent_since = time.monotonic()
            elif time.monotonic() - silent_since > _PATIENCE_S or client.status == "closed":
                raise RunError(_GONE)
            done = list[Done]()
            for future, result in results.items():
                batch = submitted.pop(future)
                if isinstance(result, BaseException):
                    done += [Done(each.id, None, result) for each in batch]
                    continue
                outcomes, took_s = result
                done += [Done(each.id, outcome, None) for each, outcome in zip(batch, outcomes, strict=False)]
                left.extend(batch[len(outcomes):])
                size = max(1, min(_LARGEST, int(_BATCH_S / took_s * len(outcomes))))
            exhausted = exhausted and not left
            # The rest were lost with their worker before they were fetched; the scheduler runs them again.
            ended.update(future for future in futures if future not in results)
            if done:
                yield done
            else:
                waiting()
    finally:
        for future in submitted:
            future.release()


def _in_turn(functions: Sequence[Callable[..., Any]], arguments: Sequence[tuple[Any, ...]]
             ) -> tuple[list[Any], float]:
    """Outcomes of the first tasks of a batch, begun within `_BATCH_S`, and the seconds that they took."""
    began, outcomes, took_s = time.perf_counter(), [], 0.0
    for function, each in zip(functions, arguments, strict=True):
        outcomes.append(function(*each))
        took_s = time.perf_counter() - began
        if took_s > _BATCH_S:
            break
    return outcomes, took_s


def _window(client: Any) -> int:
    """Most batches to submit; none while the scheduler is silent."""
    return max(_LEAST_AHEAD, _AHEAD * threads(client)) if client.status == "running" else 0


def _ended(ended: Any) -> list[Any]:
    """Futures that have ended; waits for the first of them for `_LOOK_S`."""
    until = time.monotonic() + _LOOK_S
    time.sleep(_TOGETHER_S)
    while not ended.has_ready() and time.monotonic() < until:
        time.sleep(_TOGETHER_S)
    return list(ended.next_batch(block=False))


def _results(client: Any, futures: Sequence[Any]) -> dict[Any, Any]:
    """Results, or errors, of futures that have ended, but not of those whose worker was lost meanwhile.

    There are none where fetching takes longer than `_FETCH_S`. Raises RunError where tasks were cancelled:
    the scheduler was restarted.
    """
    whole = {future.key: future for future in futures if future.status == "finished"}
    try:
        values = client.sync(client.gather, whole, errors="skip", callback_timeout=_FETCH_S) if whole else {}
    except TimeoutError:
        values = {}
    except (OSError, CancelledError) as fault:
        raise RunError(f"{_GONE} ({fault})") from None
    if any(future.status == "cancelled" for future in futures):
        raise RunError(_GONE)
    found = {whole[key]: value for key, value in values.items() if value is not None}
    return found | {future: future.exception() for future in futures if future.status == "error"}


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
