"""Steps of a loop's state over a period: linear flows, and random draws of the messages that ports receive.

    flow    z' = matrix z + noise w
    draw    z'[i] = z[take[i]], where `take` is random: independent, or the next state of a Markov chain

Between draws everything is one matrix; a loop without random wires is a single flow.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rows = NDArray[np.intp]
Marks = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Flow:
    """The linear step from one draw to the next.

    Attributes
    ----------
    matrix: (after, before).
    covariance: (after, after), of the noise of these ticks.
    readings: (readings, outputs, before), the recorder's readings in between, as rows of the state.
    reading_variance: (readings, outputs), from the noise of these ticks.
    """

    matrix: Array
    covariance: Array
    readings: Array
    reading_variance: Array


@dataclass(frozen=True, slots=True, eq=False)
class Draw:
    """A random choice of the rows before it that the rows after it are copies of.

    Attributes
    ----------
    chances: (before, after), transition probabilities of the chain; (choices,) for an independent draw.
    takes: (states or choices, rows after), numbers of rows before.
    """

    chances: Array
    takes: Rows

    @property
    def independent(self) -> bool:
        """Whether the draw is independent of those before it."""
        return self.chances.ndim == 1


Step = Flow | Draw


def pruned(steps: list[Step], kept: slice) -> list[Step]:
    """The steps without rows that have no effect, and rows that always stay at 0.

    A row has an effect if it changes a reading or a kept row; a row moves if noise or a kept row moves it.
    (The integral of a controller without integral gain does neither, and would never come to rest.)
    """
    live = _settled(steps[::-1], kept, _live_before)[::-1]
    moved = _settled(steps, kept, _moved_after)
    rows = [np.flatnonzero(here & there) for here, there in zip(live, moved, strict=True)]
    return [_restricted(step, before, after)
            for step, before, after in zip(steps, rows[:-1], rows[1:], strict=True)]


def _settled(steps: list[Step], kept: slice, passed: Callable[[Step, Marks], Marks]) -> list[Marks]:
    """Marks between the steps, first to last, after as many rounds of the cycle as add marks."""
    first = steps[0]
    rows = len(first.matrix) if isinstance(first, Flow) else len(first.takes[0])
    marks: Marks = np.zeros(rows, dtype=bool)
    marks[kept] = True
    while True:
        found = [marks]
        for step in steps:
            found.append(passed(step, found[-1]))
        if not (found[-1] & ~marks).any():
            return [*found[:-1], marks]
        marks = marks | found[-1]


def _live_before(step: Step, after: Marks) -> Marks:
    """Rows before a step that have an effect on live rows after it."""
    if isinstance(step, Flow):
        return np.asarray((step.matrix[after] != 0.0).any(axis=0) | (step.readings != 0.0).any(axis=(0, 1)))
    before = np.zeros(after.size, dtype=bool)
    before[np.unique(step.takes[:, after])] = True
    return before


def _moved_after(step: Step, before: Marks) -> Marks:
    """Rows after a step that noise, or rows that move before it, move."""
    if isinstance(step, Flow):
        return np.asarray((step.matrix[:, before] != 0.0).any(axis=1) | (np.diag(step.covariance) != 0.0))
    return np.asarray(before[step.takes].any(axis=0))


def _restricted(step: Step, before: Rows, after: Rows) -> Step:
    """The step between the rows that are left."""
    if isinstance(step, Flow):
        return replace(step, matrix=step.matrix[np.ix_(after, before)], readings=step.readings[..., before],
                       covariance=step.covariance[np.ix_(after, after)])
    return replace(step, takes=np.searchsorted(before, step.takes[:, after]))
