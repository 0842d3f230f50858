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
four times as strong as the model. Beyond that, and where drives are at their limits, it may make trials
worse: then it stops, and expects from there on what it expected in the best one (`controllers.progress`).
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from controllers.progress import Progress, Report
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
    progress: errors of the trials before.
    pending: reports of the learning before this trial, for its first tick.
    indices: of the ticks; drives: (muscles,) issued then; wanted: (outputs,) reference a period later, rad,
        NaN where nothing is controlled. captured_ns, measured: newest capture of the sample read then, and
        its value (outputs,), rad.
    touched: index of the first tick in contact; -1 before.
    """

    expected: Array
    progress: Progress = field(default_factory=Progress)
    pending: tuple[Report, ...] = ()
    indices: list[int] = field(default_factory=list)
    drives: list[Array] = field(default_factory=list)
    wanted: list[Array] = field(default_factory=list)
    captured_ns: list[int] = field(default_factory=list)
    measured: list[Array] = field(default_factory=list)
    touched: int = -1

    def note(
        self, index: int, drive: Array, wanted: Array, captured_ns: int, measured: Array, touching: bool
    ) -> None:
        """Record a tick; a measurement that is not finite counts as none."""
        self.indices.append(index)
        self.drives.append(drive)
        self.wanted.append(wanted)
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

    def posture(self, period_ns: int, max_gap_ns: int) -> tuple[Array, NDArray[np.bool_]]:
        """Posture at the ticks (samples, outputs), rad, and where captures cover it (samples,)."""
        samples = self.indices[-1] + 1
        captured_ns = np.full(samples, NEVER, dtype=np.int64)
        captured_ns[self.indices] = self.captured_ns
        measured = np.zeros((samples, self.expected.shape[1]))
        measured[self.indices] = np.nan_to_num(self.measured)
        return posture_at(np.arange(samples) * period_ns, captured_ns, measured, max_gap_ns)

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
    stop_after: number of successive worse trials after which learning stops; 0: never. A trial is worse with
        half as much error again as the best one and more than the last one, or with twice the best one's.
    """

    share: float = 0.5
    cutoff_hz: float = 2.0
    max_gap_ms: float = 150.0
    stop_after: int = 2

    def __post_init__(self) -> None:
        if not 0.0 < self.share <= 1.0:
            raise InputError("memory.share", f"{self.share}", "above 0, at most 1")
        for key in ("cutoff_hz", "max_gap_ms"):
            if not (math.isfinite(getattr(self, key)) and getattr(self, key) > 0.0):
                raise InputError(f"memory.{key}", f"{getattr(self, key)}", "a finite value above 0")
        if self.stop_after < 0:
            raise InputError("memory.stop_after", f"{self.stop_after}", "0 (never) or more")

    def next_course(
        self, course: Course, model: SampledModel, period_ns: int, blocked: Sequence[int], weights: Array
    ) -> Course:
        """Course of the trial after `course`; arguments as in `learnt`, and weights of errors (outputs,)."""
        progress, reports = copy.deepcopy(course.progress), tuple[Report, ...]()
        error = None if progress.stopped else self._error(course, period_ns, blocked, weights)
        if error is not None:
            reports = progress.note(error, course.expected, self.stop_after, "the expectations")
        if progress.stopped and progress.best is not None:
            return Course(progress.best, progress, reports)
        return Course(self.learnt(course, model, period_ns, blocked), progress, reports)

    def _error(
        self, course: Course, period_ns: int, blocked: Sequence[int], weights: Array
    ) -> float | None:
        """RMS error of a trial, rad; None where nothing was measured that counts."""
        if not course.indices:
            return None
        posture, covered = course.posture(period_ns, self.gap_ns(period_ns))
        at = np.array(course.indices[:-1], dtype=np.int64) + 1
        wanted = np.array(course.wanted[:-1]).reshape(at.size, -1)
        heed = np.isfinite(wanted) & covered[at, np.newaxis]
        if course.touched >= 0:
            hidden = np.zeros(wanted.shape[1], dtype=bool)
            hidden[list(blocked) if blocked else slice(None)] = True
            heed &= ~((at >= course.touched)[:, np.newaxis] & hidden)
        total = float(np.sum(heed * weights))
        errors = np.where(heed, posture[at] - wanted, 0.0)
        return math.sqrt(float(np.sum(weights * errors**2)) / total) if total > 0.0 else None

    def gap_ns(self, period_ns: int) -> int:
        """Longest distance of two captures between which the posture is interpolated."""
        return max(round(self.max_gap_ms * NS_PER_MS), 2 * period_ns)

    def section(self, period_ns: int) -> Array:
        """Second-order section of the low-pass, (1, 6)."""
        from scipy.signal import butter  # 0.5 s to import

        section: Array = butter(2, self._cutoff(period_ns), output="sos")
        return section

    def padding(self, period_ns: int) -> int:
        """Number of samples by which a trial is extended on either side for the low-pass."""
        return math.ceil(3.0 / self._cutoff(period_ns))

    def _cutoff(self, period_ns: int) -> float:
        """Cut-off as a share of half the rate."""
        return 2.0 * self.cutoff_hz * period_ns / NS_PER_S

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
        posture, covered = course.posture(period_ns, self.gap_ns(period_ns))
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
        """Values (samples,) without what is faster than the cut-off, which is below half the rate."""
        if values.size < 2:
            return values
        from scipy.signal import sosfiltfilt  # 0.5 s to import

        smooth: Array = sosfiltfilt(self.section(period_ns), values, padtype="odd",
                                    padlen=min(values.size - 1, self.padding(period_ns)))
        return smooth
