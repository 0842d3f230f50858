"""Measurements of a trial: recorded tick by tick, then interpolated at the instants of the ticks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from fesloop.loop.signals import NEVER

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]
Mask = NDArray[np.bool_]


def posture_at(
    ticks_ns: Stamps, captured_ns: Stamps, measured: Array, max_gap_ns: int
) -> tuple[Array, Mask]:
    """Posture (ticks, outputs) at the instants of the ticks, and whether each tick is covered, (ticks,).

    A cubic spline through the captures (its error is of fourth order in their distance; linear with fewer
    than four) removes the age of each sample. A tick is covered if it lies between two captures that are at
    most `max_gap_ns` apart, or on one; elsewhere the posture is 0.

    Parameters
    ----------
    ticks_ns: (ticks,), increasing.
    captured_ns: (ticks,), newest capture of the sample that is read at each tick; negative for none.
    measured: (ticks, outputs), samples.
    """
    stamps, first = np.unique(captured_ns[captured_ns >= 0], return_index=True)
    values = measured[captured_ns >= 0][first]
    posture = np.zeros((ticks_ns.size, measured.shape[1]))
    if stamps.size == 0:
        return posture, np.zeros(ticks_ns.size, dtype=bool)
    after = np.searchsorted(stamps, ticks_ns, side="left")
    inside = (ticks_ns >= stamps[0]) & (ticks_ns <= stamps[-1])
    later = np.minimum(after, stamps.size - 1)
    gaps = stamps[later] - stamps[np.maximum(later - 1, 0)]
    covered = inside & ((stamps[later] == ticks_ns) | (gaps <= max_gap_ns))
    if stamps.size == 1:
        posture[covered] = values
        return posture, covered
    spline = make_interp_spline(stamps.astype(np.float64), values, k=3 if stamps.size >= 4 else 1)
    posture[covered] = spline(ticks_ns[covered].astype(np.float64))
    return posture, covered


@dataclass(slots=True, eq=False)
class SeenTrial:
    """Measurements of a trial.

    Attributes
    ----------
    ticks_ns: (samples,), instants of the steps with a reference; NEVER for others.
    captured_ns: (samples,), newest capture of the sample that was read then; NEVER for none.
    measured, reference: (samples, outputs), rad.
    doubtful: (samples, outputs), samples that arrived but are excluded from learning.
    touched: tick of the first contact; the number of samples before it.
    """

    ticks_ns: Stamps
    captured_ns: Stamps
    measured: Array
    reference: Array
    doubtful: Mask
    touched: int

    @classmethod
    def empty(cls, samples: int, outputs: int) -> SeenTrial:
        """Empty record of a trial."""
        return cls(np.full(samples, NEVER, dtype=np.int64), np.full(samples, NEVER, dtype=np.int64),
                   np.zeros((samples, outputs)), np.zeros((samples, outputs)),
                   np.zeros((samples, outputs), dtype=bool), samples)

    @property
    def free(self) -> bool:
        """Whether there has been no contact."""
        return self.touched == self.ticks_ns.size

    def touch(self, k: int) -> None:
        """Record a contact at tick k."""
        self.touched = k

    def note(self, k: int, captured_ns: int, measured: Array, doubtful: Mask) -> None:
        """Record the sample of tick k without its doubtful outputs (outputs,)."""
        self.captured_ns[k] = captured_ns
        self.doubtful[k] = doubtful
        self.measured[k] = np.where(doubtful, 0.0, measured)

    def doubtful_share(self) -> float:
        """Share of the samples that is doubtful, 0 to 1; 0 without samples."""
        came = self.captured_ns >= 0
        return float(self.doubtful[came].mean()) if came.any() else 0.0

    def touching(self, numbers: Sequence[int], count: int) -> Mask:
        """Mask (samples, count): true from the first contact on in the columns `numbers`, all if empty."""
        columns = np.zeros(count, dtype=bool)
        columns[list(numbers) or slice(None)] = True
        return (np.arange(self.ticks_ns.size) >= self.touched)[:, None] & columns

    def posture(self, align: bool, max_gap_ns: int) -> tuple[Array, Mask]:
        """Posture and coverage, (samples, outputs), at the instants of the ticks if `align`, else as read.

        Doubtful samples are left out, output by output. `max_gap_ns` as in `posture_at`.
        """
        posture, covered = np.zeros_like(self.measured), np.zeros_like(self.doubtful)
        for j in range(posture.shape[1]):
            stamps = np.where(self.doubtful[:, j], NEVER, self.captured_ns)
            column = self.measured[:, j:j + 1]
            if align:
                column, covered[:, j] = posture_at(self.ticks_ns, stamps, column, max_gap_ns)
            else:
                covered[:, j] = stamps >= 0
            posture[:, j] = column[:, 0]
        return posture, covered & (self.ticks_ns >= 0)[:, None]
