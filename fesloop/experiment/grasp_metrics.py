"""Whether an object was held, how far it moved meanwhile, and with which forces."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fesloop.errors import InputError
from fesloop.experiment.reading import Recording, Signal
from fesloop.loop.clock import NS_PER_S

Shape = tuple[int | None, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspScore:
    """What is a grasp: an object that stays where it is for a while, without its table.

    Attributes
    ----------
    object: its position, (3,), m.
    from_s, until_s: the while, seconds of each trial.
    within_mm: how far the object may be at any instant of it from where it was at its start (chosen).
    forces: contact forces of the fingertips, N, of which the mean over the while is told; None: not told.
    """

    object: str
    from_s: float
    until_s: float
    within_mm: float = 20.0
    forces: str | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.until_s) and 0.0 <= self.from_s < self.until_s):
            raise InputError("until_s", f"{self.from_s:g} to {self.until_s:g} s", "0 <= from_s < until_s")
        if not (math.isfinite(self.within_mm) and self.within_mm > 0.0):
            raise InputError("within_mm", f"{self.within_mm:g}", "a finite distance above 0")

    def faults(self, shapes: Mapping[str, Shape]) -> Iterator[InputError]:
        """Signals that do not exist or do not fit; `shapes` are those of all outputs."""
        for key, name, shape in (("object", self.object, (3,)), ("forces", self.forces, None)):
            if name is not None and name not in shapes:
                yield InputError(f"score.grasp.{key}", f"there is no signal {name!r}",
                                 ", ".join(sorted(shapes)))
            elif name is not None and shape not in (None, shapes[name]):
                yield InputError(f"score.grasp.{key}", f"{name!r} has shape {shapes[name]}", f"{shape}")


def grasp_metrics(recording: Recording, score: GraspScore) -> dict[str, Any]:
    """`held`, whether, and `object_moved_mm`, how far at most, one a trial; `grip_force_n` by fingertip.

    Of a trial that ended before the while was over, `held` is None and the others are NaN.
    """
    moved = [_moved_mm(_between(recording.signal(score.object, trial), score))
             for trial in range(recording.trials)]
    held = [None if math.isnan(way) else way <= score.within_mm for way in moved]
    metrics: dict[str, Any] = {"held": held, "object_moved_mm": moved}
    if score.forces is not None:
        forces = np.array([_between(recording.signal(score.forces, trial), score).mean(axis=0)
                           for trial in range(recording.trials)])
        metrics["grip_force_n"] = {f"F{i + 1}": column.tolist() for i, column in enumerate(forces.T)}
    return metrics


def _between(signal: Signal, score: GraspScore) -> np.ndarray:
    """Values (n, ...) of the while; one row of NaN where the trial ended before it was over."""
    seconds = signal.times_ns / NS_PER_S
    inside = (seconds >= score.from_s) & (seconds <= score.until_s)
    complete = seconds.size > 1 and seconds[-1] >= score.until_s - (seconds[-1] - seconds[-2])
    return signal.values[inside] if complete and inside.any() else np.full_like(signal.values[:1], np.nan)


def _moved_mm(places: np.ndarray) -> float:
    return float(1e3 * np.linalg.norm(places - places[0], axis=1).max()) if len(places) else math.nan
