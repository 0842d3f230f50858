"""Learning from trial to trial in predictive control: the disturbance that trials have in common.

Where a task is repeated, much of what a model misses comes back in each trial at the same instant: posture
changes the muscles' strength, an object is put into the hand, the gain is wrong. After trial k the outputs
less the response of the model to the drives of that trial,

    e_k(t) = y_k(t) - G v_k(t) - offset,

are taken over in part, with a zero-phase low-pass Q and a share s:

    m_{k+1} = m_k + s Q (e_k - m_k),        m_0 = 0

In trial k + 1 the controller expects m_{k+1}: it corrects the estimate by y - m and plans for r - m, so that
only what differs from trial to trial is left to the observer's walking disturbance. Feedback is as before, in
one programme with the feedforward (Lee, Lee and Kim 2000, doi 10.1016/S0005-1098(99)00194-6). With exact
tracking and a plant P, m contracts below the cut-off if |1 - s P G^-1| < 1: with s = .5, for a plant up to
four times as strong as the model.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from controllers.trajectories import posture_at, response
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.signals import NEVER, is_finite
from fesloop.models.linear_model import SampledModel

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class Course:
    """Disturbance that a trial is expected to have, and the record of that trial.

    Attributes
    ----------
    expected: (samples, outputs), rad, at the ticks; without rows in the first trial.
    indices: of the ticks; drives: (muscles,) issued then. captured_ns, measured: newest capture of the sample
        read then, and its value (outputs,), rad.
    touched: index of the first tick in contact; -1 before.
    """

    expected: Array
    indices: list[int] = field(default_factory=list)
    drives: list[Array] = field(default_factory=list)
    captured_ns: list[int] = field(default_factory=list)
    measured: list[Array] = field(default_factory=list)
    touched: int = -1

    def note(self, index: int, drive: Array, captured_ns: int, measured: Array, touching: bool) -> None:
        """Record a tick; a measurement that is not finite counts as none."""
        self.indices.append(index)
        self.drives.append(drive)
        self.captured_ns.append(captured_ns if is_finite(measured) else NEVER)
        self.measured.append(measured)
        if touching and self.touched < 0:
            self.touched = index

    def expected_at(self, at_ns: int, period_ns: int) -> Array:
        """Expected disturbance (outputs,), rad, at an instant of the trial."""
        at: Array = self._between(np.array([at_ns / period_ns]))[0]
        return at

    def expected_ahead(self, index: int, horizon: int) -> Array:
        """Expected disturbance (horizon, outputs), rad, from the tick after `index` on."""
        return self._between(np.arange(horizon, dtype=np.float64) + (index + 1))

    def _between(self, ticks: Array) -> Array:
        """Expected disturbance (n, outputs) at fractional ticks (n,); beyond the trial, that of its end."""
        samples = self.expected.shape[0]
        if samples == 0:
            return np.zeros((ticks.size, self.expected.shape[1]))
        ticks = np.minimum(np.maximum(ticks, 0.0), samples - 1.0)
        low = ticks.astype(np.int64)
        high, share = np.minimum(low + 1, samples - 1), (ticks - low)[:, np.newaxis]
        between: Array = (1.0 - share) * self.expected[low] + share * self.expected[high]
        return between


@dataclass(frozen=True, slots=True, kw_only=True)
class Memory:
    """Parameters of the learning.

    Attributes
    ----------
    share: of the difference between a trial's disturbance and the expected one that is taken over; above 0,
        at most 1 (chosen: halves what varies from trial to trial, and tolerates a wrong gain).
    cutoff_hz: of the low-pass, twice of second order (chosen: faster than a grasp, slower than noise).
    max_gap_ms: longest distance of two captures between which the posture is interpolated.
    """

    share: float = 0.5
    cutoff_hz: float = 2.0
    max_gap_ms: float = 150.0

    def __post_init__(self) -> None:
        if not 0.0 < self.share <= 1.0:
            raise InputError("memory.share", f"{self.share}", "above 0, at most 1")
        for key in ("cutoff_hz", "max_gap_ms"):
            if not (math.isfinite(getattr(self, key)) and getattr(self, key) > 0.0):
                raise InputError(f"memory.{key}", f"{getattr(self, key)}", "a finite value above 0")

    def learnt(self, course: Course, model: SampledModel, period_ns: int, blocked: Sequence[int]) -> Array:
        """Disturbance (samples, outputs), rad, to expect in the trial after `course`.

        Parameters
        ----------
        model: at the period, with the actuation delay.
        blocked: outputs that an object blocks, all if empty: from the first contact on they keep the
            difference that they had before.
        """
        if not course.indices:
            return course.expected
        samples, outputs = course.indices[-1] + 1, model.c.shape[0]
        before = course.expected_ahead(-1, samples)
        captured_ns = np.full(samples, NEVER, dtype=np.int64)
        captured_ns[course.indices] = course.captured_ns
        measured = np.zeros((samples, outputs))
        measured[course.indices] = np.nan_to_num(course.measured)
        posture, covered = posture_at(np.arange(samples) * period_ns, captured_ns, measured,
                                      max(round(self.max_gap_ms * NS_PER_MS), 2 * period_ns))
        # Between two ticks that a busy controller missed, the drive is held.
        latest = np.searchsorted(course.indices, np.arange(samples), side="right") - 1
        drives = np.where(latest[:, np.newaxis] >= 0, np.array(course.drives)[np.maximum(latest, 0)], 0.0)
        new = posture - response(model, drives) - model.offset - before
        after = before.copy()
        for j in range(outputs):
            known = covered.copy()
            if course.touched >= 0 and (not blocked or j in blocked):
                known[course.touched:] = False
            if known.any():
                at = np.flatnonzero(known)
                after[:, j] += self.share * self._smoothed(
                    np.interp(np.arange(samples), at, new[at, j]), period_ns)
        return after

    def _smoothed(self, values: Array, period_ns: int) -> Array:
        """Values (samples,) without what is faster than the cut-off, if the period shows that at all."""
        share = 2.0 * self.cutoff_hz * period_ns / NS_PER_S
        if share >= 1.0 or values.size < 2:
            return values
        from scipy.signal import butter, sosfiltfilt  # 0.5 s to import

        smooth: Array = sosfiltfilt(butter(2, share, output="sos"), values, padtype="odd",
                                    padlen=min(values.size - 1, math.ceil(3.0 / share)))
        return smooth
