"""What a period does to the loop's state: linear flows, and draws between them that pick what a port gets.

    flow    z' = matrix z + noise w
    draw    z'[i] = z[take[i]], where `take` is drawn: independently, or as the next state of a Markov chain

so that between draws everything is one matrix, and a loop without random wires is a single flow.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rows = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class Flow:
    """From one draw to the next.

    Attributes
    ----------
    matrix: (after, before).
    covariance: (after, after), of the noise of these ticks.
    readings: (readings, outputs, before), what the recorder sees on the way.
    reading_variance: (readings, outputs), by the noise of these ticks.
    """

    matrix: Array
    covariance: Array
    readings: Array
    reading_variance: Array


@dataclass(frozen=True, slots=True, eq=False)
class Draw:
    """Rows of the state before that the rows after are taken from, by chance.

    Attributes
    ----------
    chances: (before, after), of the states of the chain; of an independent draw (choices,).
    takes: (states or choices, rows after).
    """

    chances: Array
    takes: Rows

    @property
    def independent(self) -> bool:
        """Whether the draw knows nothing of those before it."""
        return self.chances.ndim == 1


Step = Flow | Draw


def pruned(steps: list[Step], kept: slice) -> list[Step]:
    """The same steps without rows that make no difference to any reading, nor to the rows to be kept."""
    live = np.zeros(_width(steps[0]), dtype=bool)
    live[kept] = True
    while True:
        alive = [live]
        for step in reversed(steps):
            alive.append(_live_before(step, alive[-1]))
        if not (alive[-1] & ~live).any():
            break
        live = live | alive[-1]
    alive.reverse()
    alive[0] = live
    return [_restricted(step, np.flatnonzero(before), np.flatnonzero(after))
            for step, before, after in zip(steps, alive[:-1], alive[1:], strict=True)]


def _width(step: Step) -> int:
    return len(step.matrix[0]) if isinstance(step, Flow) else len(step.takes[0])


def _live_before(step: Step, after: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Rows before a step that make a difference to live rows after it."""
    if isinstance(step, Flow):
        return np.asarray((step.matrix[after] != 0.0).any(axis=0) | (step.readings != 0.0).any(axis=(0, 1)))
    before = np.zeros(after.size, dtype=bool)
    before[np.unique(step.takes[:, after])] = True
    return before


def _restricted(step: Step, before: Rows, after: Rows) -> Step:
    """A step between the rows that are left."""
    if isinstance(step, Flow):
        return replace(step, matrix=step.matrix[np.ix_(after, before)], readings=step.readings[..., before],
                       covariance=step.covariance[np.ix_(after, after)])
    return replace(step, takes=np.searchsorted(before, step.takes[:, after]))
