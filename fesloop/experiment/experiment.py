"""Experiments that run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fesloop.errors import RunError
from fesloop.experiment.specification import ExperimentSpecification

if TYPE_CHECKING:
    from fesloop.experiment.running.trial import Result
    from fesloop.loop.realtime import Pacing


@dataclass(frozen=True, kw_only=True, eq=False)
class Experiment(ExperimentSpecification):
    """An experiment, specified as `ExperimentSpecification` says, and its run."""

    def run(self, out: str | Path = "runs", *, realtime: bool | Pacing = False,
            progress: Callable[[float], None] | None = None) -> Result:
        """Run every trial and leave one recording in the folder `out`.

        `realtime` keeps simulated time in step with the wall clock; a `Pacing` also sets, for
        example, how late ticks are treated. `progress` receives the fraction done.
        Raises RunError if the run fails and KeyboardInterrupt if it is interrupted; what was recorded
        until then is kept.
        """
        from fesloop.experiment.running.trial import run

        result = run(self, Path(out), realtime=realtime, progress=progress)
        if result.status == "failed":
            raise RunError(f"{result.cause}; recorded until then: {result.recording}")
        if result.status == "interrupted":
            raise KeyboardInterrupt
        return result
