"""Decline of a contraction that repeats."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording, Signal, reached_ns
from fesloop.hand.movements import MUSCLES, muscle
from fesloop.loop.clock import NS_PER_S, duration_ns


@dataclass(frozen=True, slots=True, kw_only=True)
class CycleScore:
    """A signal whose peak in each cycle is compared with its peak in the first.

    Attributes
    ----------
    signal: forces or activations; of several values their sum counts, or `muscle` alone.
    muscle: of a signal that has one value a muscle (`fesloop.hand.movements`); empty: all.
    cycle_s: length of a cycle; the first begins with the trial.
    count: cycles that are compared, the last of them with the first; later ones are ignored.
    """

    signal: str
    cycle_s: float
    count: int
    muscle: str = ""

    def __post_init__(self) -> None:
        if duration_ns(self.cycle_s, NS_PER_S, "cycle_s") == 0:
            raise InputError("cycle_s", f"{self.cycle_s}", "above 0")
        if self.count < 2:
            raise InputError("count", f"{self.count}", "2 or more cycles")
        if self.muscle:
            muscle(self.muscle)

    def faults(self, shapes: Mapping[str, tuple[int | None, ...]]) -> Iterator[InputError]:
        """Faults: a signal that does not exist; `shapes` are those of all outputs."""
        if self.signal not in shapes:
            yield InputError("score.cycles.signal", f"there is no signal {self.signal!r}",
                             ", ".join(sorted(shapes)))
        elif self.muscle and shapes[self.signal] != (len(MUSCLES),):
            yield InputError("score.cycles.muscle", f"{self.signal!r} has shape {shapes[self.signal]}",
                             f"{(len(MUSCLES),)}, one value a muscle", "take it out")


def cycle_metrics(recording: Recording, score: CycleScore) -> dict[str, Any]:
    """`decline_pct` of each trial: decline from the first cycle's peak to the last's, per cent."""
    declines = []
    for trial in range(recording.trials):
        peaks = cycle_peaks(recording.signal(score.signal, trial), score)
        declines.append(float(100.0 * (1.0 - peaks[-1] / peaks[0])))
    return {"decline_pct": declines}


def cycle_peaks(signal: Signal, score: CycleScore) -> np.ndarray:
    """Peak of every cycle, (count,); NaN for a cycle that the trial did not reach the end of."""
    values = signal.values.reshape(len(signal.values), -1)
    total = values[:, muscle(score.muscle)] if score.muscle else values.sum(axis=1)
    edges = np.arange(score.count + 1) * duration_ns(score.cycle_s, NS_PER_S, "cycle_s")
    rows = np.searchsorted(signal.times_ns, edges)
    reached = reached_ns(signal.times_ns)
    return np.array([total[first:stop].max() if stop > first and edge <= reached else np.nan
                     for first, stop, edge in zip(rows, rows[1:], edges[1:], strict=False)])
