"""Chosen instants of a trial, and the outputs that matter there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """An instant at which the reference is to be met.

    Attributes
    ----------
    at_s: since the start of the trial.
    outputs: which of them matter then, from 0; empty for all.
    """

    at_s: float
    outputs: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if not (math.isfinite(self.at_s) and self.at_s >= 0.0):
            raise InputError("points.at_s", f"{self.at_s}", "0 or more seconds")


def heeded(points: Sequence[Point], samples: int, outputs: int, period_ns: int) -> Mask:
    """(samples, outputs), true at the tick nearest to each point; everywhere if there are no points.

    Raises InputError for a point after the trial and for an output that does not exist.
    """
    if not points:
        return np.ones((samples, outputs), dtype=bool)
    mask = np.zeros((samples, outputs), dtype=bool)
    for i, point in enumerate(points):
        tick = round(point.at_s * NS_PER_S / period_ns)
        if tick >= samples:
            raise InputError(f"points[{i}].at_s", f"{point.at_s:g} s",
                             f"at most {(samples - 1) * period_ns / NS_PER_S:g} s, the end of the trial")
        if not all(0 <= output < outputs for output in point.outputs):
            raise InputError(f"points[{i}].outputs", f"{list(point.outputs)}", f"0 to {outputs - 1}")
        mask[tick, list(point.outputs) or slice(None)] = True
    return mask
