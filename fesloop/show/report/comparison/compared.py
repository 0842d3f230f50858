"""Runs that are compared, with their names and colours."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fesloop.experiment.recording.reading import Recording
from fesloop.show.report.run.known import Known, known_of

ROLES = 8


@dataclass(frozen=True, slots=True, eq=False)
class Compared:
    """One of the runs.

    Attributes
    ----------
    name: that distinguishes it from the others. role: of its colour. known: facts about the run.
    """

    name: str
    role: str
    known: Known

    @property
    def recording(self) -> Recording:
        """Its file."""
        return self.known.recording

    def last_error(self, metric: str) -> float:
        """A metric of the last trial; NaN where it has none."""
        values = self.known.per_trial(metric)
        return values[-1] if values else float("nan")


def compared(recordings: Sequence[Recording]) -> list[Compared]:
    """The runs in the order given, each under the shortest name that is its own."""
    names = _names(recordings)
    return [Compared(name, f"series-{number % ROLES}", known_of(recording))
            for number, (name, recording) in enumerate(zip(names, recordings, strict=True))]


def _names(recordings: Sequence[Recording]) -> list[str]:
    """File names without ending; where these are alike, with folders; where those are, numbered."""
    paths = [recording.path.resolve().with_suffix("") for recording in recordings]
    deepest = max(len(path.parts) for path in paths)
    for depth in range(1, deepest + 1):
        names = ["/".join(path.parts[-depth:]) for path in paths]
        if len(set(names)) == len(names):
            return names
    counts: Counter[str] = Counter()
    names = []
    for path in paths:
        counts[path.name] += 1
        names.append(f"{path.name} ({counts[path.name]})" if counts[path.name] > 1 else path.name)
    return names


def finite(values: Sequence[float]) -> bool:
    """Return whether any value is finite."""
    return bool(np.isfinite(np.asarray(values, dtype=np.float64)).any())
