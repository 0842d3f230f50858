"""State of a ConstrainedTracker, and its update by a sample of every sensor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.arrivals import Arrivals, Overrun
from estimators.body.body import ImplausibleAngles
from estimators.body.joint_constraints import JointTable
from estimators.calibration.pose_evidence import ReleaseWatch
from estimators.constrained.agreement import forget_contradicted
from estimators.constrained.beginning import Hypotheses, Unknown, begin_missing, weigh
from estimators.constrained.filter import SOUND, admit, advance
from estimators.constrained.lateness import Lateness, correlate
from estimators.constrained.learning import AxisSearch
from estimators.fusion.front_end import VqfBank
from estimators.gaps import Gaps, lost_samples

Array = NDArray[np.float64]
LOOK = 10
"""Samples after which headings and mounting are looked at anew (chosen: they show over seconds)."""


@dataclass(slots=True, eq=False)
class ConstrainedState:
    """State of a ConstrainedTracker.

    Attributes
    ----------
    table: joints, with the axes that have been learnt so far.
    searches: of the axes that have not.
    roots: filters of the sensors that are no joint's child.
    arrivals: monitor of new, lost and clipped samples.
    overrun: what clipped rates have missed since the initial pose.
    settings: settings of the joint filters, for `constrained.filter`.
    unknown: initial uncertainty of a joint.
    found: joint filters.
    gaps: rotation through gaps in the samples.
    lateness: clock offsets of the sensors.
    gyr, acc: (2, n, 3), sample before and newest sample.
    seen: (2, n), LOST, EXCEEDED, DOUBTED or SOUND for each of these.
    status: (joints,), SURE, UNSURE or UNSEEN, as last reported.
    misfit: (joints,), mask of those that do not move as their kind does, as last reported.
    doubted: (joints,), rad, sd of headings that are undecided, with what the filters leave unexplained.
    plausible: check of implausible angles.
    pose_samples: number of samples of the initial pose.
    pose_acc: (n, 3), m/s^2, sum of the sound accelerations in it; pose_counts: (n,), their number.
    watch: comparison of the posture after the pose with the pose; None without a pose.
    scale: of the variance of mounting and axes, as motion shows.
    aligned_ns: instant of the first sample after the pose; None before.
    contradicted: whether evidence contradicts the pose.
    ticks: number of the next tick.
    taken: number of the next sample.
    """

    table: JointTable
    searches: tuple[AxisSearch, ...]
    roots: VqfBank
    arrivals: Arrivals
    overrun: Overrun
    settings: Array
    unknown: Unknown
    found: Hypotheses
    gaps: Gaps
    lateness: Lateness
    gyr: Array
    acc: Array
    seen: NDArray[np.int64]
    status: NDArray[np.int64]
    misfit: NDArray[np.bool_]
    doubted: Array
    plausible: ImplausibleAngles
    pose_acc: Array
    pose_counts: Array
    watch: ReleaseWatch | None
    scale: float = 1.0
    aligned_ns: int | None = None
    contradicted: bool = False
    pose_samples: int = 0
    ticks: int = 0
    taken: int = 0


def take(state: ConstrainedState, repeated: bool, gap: bool) -> None:
    """Advance by one period.

    Parameters
    ----------
    repeated: whether no sample is new.
    gap: whether any sensor is in a gap, or at its end.
    """
    table, found, gaps, arrivals = state.table, state.found, state.gaps, state.arrivals
    admit(arrivals.samples, arrivals.codes, repeated, state.gyr, state.acc, state.seen)
    roots, newest = table.roots.tolist(), state.acc[1]
    gyr, acc = [gaps.rates[root] for root in roots], [newest[root] for root in roots]
    if arrivals.sound and not gap:
        state.roots.update(gyr, acc, None)
    else:
        lost = lost_samples(arrivals.codes, repeated, gaps)
        state.roots.update_sound(gyr, acc, None, lost[:, roots])
    begun = advance(
        found.q, found.rest, found.covariance, found.surprise, found.doubt, table.ends, table.kinds,
        table.axes, table.zero, table.ranges, state.gyr, state.acc, state.seen, gaps.means, gaps.spread,
        gaps.silent, state.settings, state.taken, found.open)
    if state.taken < state.pose_samples:
        sound = state.seen[1] == SOUND
        state.pose_acc[sound] += state.acc[1, sound]
        state.pose_counts += sound
    clocks = state.lateness
    if state.taken % clocks.spacing == 0:
        correlate(found.q[0], found.rest[0], table.ends, state.gyr, state.acc, state.seen, clocks.period_s,
                  clocks.spacing, clocks.frame, clocks.passed, clocks.kept, clocks.product, clocks.energy,
                  clocks.usable, clocks.lasted)
    state.taken += 1
    if state.taken % LOOK == 0:
        begun &= not forget_contradicted(found.q, found.rest[0], found.doubt, table.kinds)
    if not begun:
        begin_missing(found, table, state.acc[1], state.seen[1] == SOUND, state.unknown,
                      state.taken <= state.pose_samples)
    if found.open:
        found.open = weigh(found.q, found.rest, found.covariance, found.surprise, found.doubt)
