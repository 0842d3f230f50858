"""Clock offsets of sensors, from the acceleration that both segments of a joint share.

The acceleration of a joint's centre, measured from both sides and turned into frames that do not rotate, is
one signal at two times where a sensor's samples are late, by a radio or its clock. The peak of their
correlation gives the difference; its sd is the bound for a delay in noise of the signal's own bandwidth
(Knapp and Carter 1976, doi 10.1109/TASSP.1976.1162830). Along the tree, differences add up to the lateness of
each sensor. The others then wait for the latest one, and the posture is predicted from there to now: by the
rates that have come, and by the newest rate of a late sensor.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.constrained.measurements import change_of, mean_of, spin_matrix
from estimators.constrained.vectors import components, dot, rotated, store, turn_by
from fesloop.compiled import compiled
from fesloop.hand.quaternion_kernels import conjugate, multiply
from fesloop.loop.signals import Sample

Array = NDArray[np.float64]
_REACH_S = 0.1
"""Greatest difference of two neighbours that is found, s (chosen: a radio's buffer)."""
_FADES_S = 30.0
"""Time constant of the correlation, s (chosen: clocks drift by less than a millisecond in it)."""
_LOWEST = 2.0 * math.pi
"""Angular frequency below which accelerations do not count, rad/s (chosen: above gravity in motion)."""
_FIRST_S = 8.0
"""Least duration of a correlation that is believed, s (chosen: some movements)."""
_SHARED, _SHARED_SDS = 0.1, 5.0
"""Least correlation, and in sds of that of noise, for a signal that both sides share (chosen: sensors on foam
reach .2; noise of a hand at rest must not pass)."""
_SURE = 3.0
"""Sds beyond which a difference is one (chosen: looked at every second, for hours)."""
_LEAST_S = 4e-3
"""Least difference that is made good, s (chosen: below it joints lose less than by interpolation)."""


@dataclass(slots=True, eq=False)
class Lateness:
    """What is known of the sensors' clocks.

    Attributes
    ----------
    late_s: (n,), by how much each sensor's samples are later than those of the earliest; 0 until found.
    past: (rows, 2, n, 3), newest rates and accelerations, the newest first; NaN before the first.
    frame: (joints, 4), child's sensor to a frame that does not rotate.
    mean: (joints, 2, 3), m/s^2, slow part of the acceleration from parent and child.
    kept: (joints, 2, lags + 1, 3), m/s^2, newest fast parts, the newest first.
    product: (joints, 2 lags + 1), sum of products by lag of the child; energy: (joints, 2), sums of squares.
    lasted: (joints,), s, weight of these sums.
    """

    late_s: Array
    past: Array
    frame: Array
    mean: Array
    kept: Array
    product: Array
    energy: Array
    lasted: Array

    @classmethod
    def unknown(cls, sensors: int, joints: int, period_s: float) -> Lateness:
        """Nothing known."""
        lags = max(2, math.ceil(_REACH_S / period_s))
        frame = np.zeros((joints, 4))
        frame[:, 0] = 1.0
        return cls(np.zeros(sensors), np.full((2 * lags + 2, 2, sensors, 3), np.nan), frame,
                   np.zeros((joints, 2, 3)), np.zeros((joints, 2, lags + 1, 3)),
                   np.zeros((joints, 2 * lags + 1)), np.zeros((joints, 2)), np.zeros(joints))

    @property
    def known(self) -> bool:
        """Whether any sensor is late."""
        return bool(self.late_s.any())

    def align(self, inputs: Sequence[Sample], ticks: int, period_s: float) -> Sequence[Sample]:
        """The samples of rates and accelerations, (n, 3) each, at the instant of the latest sensor's.

        `ticks` is the number of ticks since the last call.
        """
        values = inputs[0].value, inputs[1].value
        remember(self.past, *values, ticks)
        if not self.known:
            return inputs
        values = np.empty_like(values[0]), np.empty_like(values[1])
        simultaneous(self.past, self.late_s, period_s, *values)
        return [sample._replace(value=value) for sample, value in zip(inputs, values, strict=True)]

    def turns(self, period_s: float) -> Array:
        """Rotation of each sensor since that instant, (n, 3), rad: by what came, then by its newest rate."""
        turns = np.zeros((len(self.late_s), 3))
        if self.known:
            turned_since(self.past, self.late_s, period_s, turns)
        return turns

    def look(self, q: Array, ends: NDArray[np.int64], period_s: float) -> str:
        """Make new differences good, in relative orientations q (h, joints, 4) too.

        Tells how late each sensor is against most of them; empty where nothing changed. Correlations of what
        has been made good begin anew.
        """
        late_s, sd_s = differences(self, period_s)
        new = np.abs(late_s) > np.maximum(_LEAST_S, _SURE * sd_s)
        if not new.any():
            return ""
        turns = self.turns(period_s)
        for j in np.flatnonzero(new):
            # All sensors beyond the joint are later by as much.
            beyond = {int(ends[j, 1])}
            beyond.update(c for p, c in ends.tolist() if p in beyond)
            self.late_s[sorted(beyond)] += late_s[j]
            self.product[j], self.energy[j], self.lasted[j] = 0.0, 0.0, 0.0
        self.late_s -= self.late_s.min()
        turns -= self.turns(period_s)
        for hypothesis in q:
            hypothesis[:] = ahead(hypothesis, ends, turns)
        against = 1e3 * (self.late_s - np.sort(self.late_s)[(len(self.late_s) - 1) // 2])
        return "samples come at different times: " + (", ".join(
            f"sensor {i} {abs(each):.0f} ms {'late' if each > 0.0 else 'early'}"
            for i, each in enumerate(against) if abs(each) >= 1.0) or "none any more")


@compiled
def remember(past: Any, gyr: Any, acc: Any, ticks: int) -> None:
    """Add the newest samples (n, 3); those of ticks between the last call and this one are unknown."""
    for _ in range(min(ticks, past.shape[0])):
        for k in range(past.shape[0] - 1, 0, -1):
            past[k] = past[k - 1]
        past[0] = math.nan
    past[0, 0], past[0, 1] = gyr, acc


@compiled
def simultaneous(past: Any, late_s: Any, period: float, gyr: Any, acc: Any) -> None:
    """Write the samples (n, 3) of the instant at which the latest sensor was sampled, interpolated."""
    latest = late_s.max()
    for i in range(late_s.size):
        wait = (latest - late_s[i]) / period
        # A wait of whole periods, but for rounding, needs one sample only.
        k = min(int(wait + 1e-6), past.shape[0] - 2)
        share = wait - k
        for a in range(3):
            gyr[i, a], acc[i, a] = past[k, 0, i, a], past[k, 1, i, a]
            if share > 1e-6:
                gyr[i, a] += share * (past[k + 1, 0, i, a] - gyr[i, a])
                acc[i, a] += share * (past[k + 1, 1, i, a] - acc[i, a])


@compiled
def turned_since(past: Any, late_s: Any, period: float, turns: Any) -> None:
    """Write the rotation of each sensor since that instant, `turns` (n, 3), rad."""
    latest = late_s.max()
    for i in range(late_s.size):
        wait = (latest - late_s[i]) / period
        for a in range(3):
            newest = past[0, 0, i, a]
            total, k = late_s[i] / period * newest, 0
            while k < wait:
                share = min(1.0, wait - k)
                before = past[k, 0, i, a] + share * (past[k + 1, 0, i, a] - past[k, 0, i, a])
                total += 0.5 * share * (past[k, 0, i, a] + before)
                k += 1
            turns[i, a] = period * total if total * 0.0 == 0.0 else 0.0


@compiled
def ahead(q: Any, ends: Any, turns: Any) -> Any:
    """Relative orientations (joints, 4) after the sensors' rotations `turns` (n, 3), rad."""
    moved = np.empty_like(q)
    for j in range(q.shape[0]):
        p, c = ends[j, 0], ends[j, 1]
        before = turn_by(-turns[p, 0], -turns[p, 1], -turns[p, 2])
        after = turn_by(turns[c, 0], turns[c, 1], turns[c, 2])
        store(moved[j], multiply(multiply(before, components(q[j])), after))
    return moved


@compiled
def advanced(q: Any, turns: Any) -> Any:
    """Orientations (n, 4) after the sensors' rotations `turns` (n, 3), rad."""
    moved = np.empty_like(q)
    for i in range(q.shape[0]):
        turn = turn_by(turns[i, 0], turns[i, 1], turns[i, 2])
        store(moved[i], multiply(components(q[i]), turn))
    return moved


@compiled
def correlate(
    q: Any, rest: Any, ends: Any, gyr: Any, acc: Any, sound: Any, rates: Any, period: float, frame: Any,
    mean: Any, kept: Any, product: Any, energy: Any, lasted: Any
) -> None:
    """Add the newest two samples to the correlations of all joints.

    Parameters
    ----------
    q: (joints, 4); rest: (joints, ...), with the lever arms l_p and l_c from 3 on, m.
    gyr, acc: (2, n, 3), sample before and this one; sound: (n,), whether both of a sensor are.
    rates: (n, 3), mean over the period, rad/s.
    Others: as in Lateness; updated.
    """
    left, share = math.exp(-period / _FADES_S), 1.0 - math.exp(-period * _LOWEST)
    lags, matrix = kept.shape[2] - 1, np.empty((3, 3))
    for j in range(ends.shape[0]):
        p, c = ends[j, 0], ends[j, 1]
        turn = turn_by(period * rates[c, 0], period * rates[c, 1], period * rates[c, 2])
        store(frame[j], multiply(components(frame[j]), turn))
        for side in range(2):
            for k in range(lags, 0, -1):
                for a in range(3):
                    kept[j, side, k, a] = kept[j, side, k - 1, a]
        usable = sound[p] and sound[c] and q[j, 0] * 0.0 == 0.0
        for side in range(2):
            i = ends[j, side]
            if usable:
                spin_matrix(mean_of(gyr, i), change_of(gyr, i, period), matrix)
                f, arm = mean_of(acc, i), 3 + 3 * side
                for a in range(3):
                    kept[j, side, 0, a] = f[a] - (
                        matrix[a, 0] * rest[j, arm] + matrix[a, 1] * rest[j, arm + 1]
                        + matrix[a, 2] * rest[j, arm + 2])
                v = (kept[j, side, 0, 0], kept[j, side, 0, 1], kept[j, side, 0, 2])
                if side == 0:
                    v = rotated(conjugate(components(q[j])), v)
                v = rotated(components(frame[j]), v)
                for a in range(3):
                    mean[j, side, a] += share * (v[a] - mean[j, side, a])
                    kept[j, side, 0, a] = v[a] - mean[j, side, a]
            else:
                kept[j, side, 0, :] = 0.0
        for side in range(2):
            now = kept[j, side, 0]
            energy[j, side] = left * energy[j, side] + dot(now, now)
        for k in range(lags + 1):
            product[j, lags + k] = left * product[j, lags + k] + dot(kept[j, 0, k], kept[j, 1, 0])
            if k > 0:
                product[j, lags - k] = left * product[j, lags - k] + dot(kept[j, 0, 0], kept[j, 1, k])
        lasted[j] = left * lasted[j] + period


def differences(found: Lateness, period_s: float) -> tuple[Array, Array]:
    """By how much each child is later than its parent, and its sd, s, (joints,); NaN where unknown."""
    lags = found.kept.shape[2] - 1
    late, sd = np.full(len(found.lasted), np.nan), np.full(len(found.lasted), np.nan)
    for j, product in enumerate(found.product):
        k = int(np.argmax(product))
        if found.lasted[j] < _FIRST_S or not 0 < k < 2 * lags or product[k] <= 0.0:
            continue
        before, peak, after = product[k - 1:k + 2]
        bend = 2.0 * peak - before - after
        if bend <= 0.0:
            continue
        late[j] = (k - lags + 0.5 * (after - before) / bend) * period_s
        rho = min(0.99, float(peak / math.sqrt(found.energy[j].prod())))
        if rho < max(_SHARED, _SHARED_SDS * math.sqrt(period_s / (3.0 * found.lasted[j]))):
            continue
        omega = math.sqrt(bend / peak) / period_s
        sd[j] = math.sqrt((1.0 - rho ** 2) * math.pi / (rho ** 2 * found.lasted[j] * omega ** 3))
    return late, sd
