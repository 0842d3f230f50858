"""Errors of trials in learning control, and the end of learning that makes them worse."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Report = tuple[str, str]
WORSE, FAR_WORSE = 1.5, 2.0
"""Ratio to the least error above which a trial counts as worse if the error has grown, and in any case
(chosen)."""


@dataclass(slots=True, eq=False)
class Progress:
    """Errors of the trials so far.

    Attributes
    ----------
    errors: RMS error of each trial, rad, outputs weighted as by the controller.
    best: what was learnt before the trial of least error, (samples, ...); None before the first trial.
    worse: number of successive trials, the last among them, that are worse than the best.
    stopped: whether learning has stopped.
    """

    errors: list[float] = field(default_factory=list)
    best: Array | None = None
    worse: int = 0
    stopped: bool = False

    def note(self, error: float, learnt: Array, stop_after: int, what: str) -> tuple[Report, ...]:
        """Add a trial before which `learnt` was; return the report that learning has stopped, if it has.

        Parameters
        ----------
        stop_after: number of successive worse trials after which it stops; 0: never.
        what: name of what is learnt, for the report.
        """
        least, before = min(self.errors, default=math.inf), self.errors[-1] if self.errors else math.inf
        self.errors.append(error)
        if error < least:
            self.best = learnt
        worse = error > FAR_WORSE * least or error > max(WORSE * least, before)
        self.worse = self.worse + 1 if worse else 0
        self.stopped = 0 < stop_after <= self.worse
        if not self.stopped:
            return ()
        told = ", ".join(f"{math.degrees(each):.2g}" for each in self.errors)
        return (("learning_stopped", f"trials became worse (errors {told} deg): from now on {what} of "
                 f"the one with {math.degrees(min(self.errors)):.2g} deg are used"),)
