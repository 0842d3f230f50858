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
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from estimators.constrained.filter import SOUND
from estimators.constrained.measurements import change_of, mean_of, spin_matrix
from estimators.constrained.rates import SLOWEST, Rates
from estimators.constrained.vectors import components, rotated, store, turn_by
from fesloop.compiled import compiled
from fesloop.hand.quaternion_kernels import conjugate, multiply
from fesloop.loop.signals import Sample

Array = NDArray[np.float64]
_REACH_S = 0.1
"""Greatest difference of two neighbours that is found, s (chosen: a radio's buffer)."""
_SPACING_S = 0.02
"""Time between two samples of a correlation, s (chosen: hands do not move faster)."""
_FADES_S = 30.0
"""Time constant of the correlation, s (chosen: clocks drift by less than a millisecond in it)."""
_LOWEST = 2.0 * math.pi
"""Angular frequency below which accelerations do not count, rad/s (chosen: above gravity in motion)."""
_HIGHEST = 2.0 * math.pi * 5.0
"""Angular frequency above which they do not where the movement below it suffices, rad/s (chosen: sensors on
soft tissue ring at some 11 Hz after each quick turn, later than their bones; slow movements share vibration
alone)."""
WHOLE, LOW = range(2)
"""Bands that are correlated: above `_LOWEST`, and between it and `_HIGHEST`."""
_LEAST = 0.2, 0.1
"""Least shared acceleration in each, rms, m/s^2 (chosen: errors of gravity and of lever arms look like
less)."""
_FIRST_S = 8.0
"""Least duration of a correlation that is believed, s (chosen: some movements)."""
_MOST = 2.5
"""Greatest acceleration that counts whole, in rms of those before (chosen: nearly all of a movement's)."""
_SHARED, _SHARED_SDS = 0.1, 5.0
"""Least correlation, and in sds of that of noise, for a signal that both sides share (chosen: sensors on foam
reach .2; noise of a hand at rest must not pass)."""
_LEAST_KNOWN = 0.1
"""Least weight of the products of a lag, relative to lag 0, for a correlation there (chosen)."""
_SURE = 3.0
"""Sds beyond which a difference is one (chosen: looked at every second, for hours)."""
_KNOWN_S = 0.01
"""Sd of a difference above which events say that it is not known, s (chosen: three of it are 30 ms)."""
_LEAST_S, _FIRST_LEAST_S = 4e-3, 10e-3
"""Least difference that is made good, s (chosen: below it joints lose less than by interpolation), and least
one while all sensors seem simultaneous (chosen: soft tissue alone looks like up to 8 ms)."""
VALUE, SLOW, FIRST, SECOND = range(4)
"""Rows of an acceleration in `Lateness.band`."""


@dataclass(slots=True, eq=False)
class Lateness:
    """Estimate of the sensors' clock offsets.

    Attributes
    ----------
    period_s: of the samples; spacing: ticks between two samples of a correlation.
    late_s: (n,), by how much each sensor's samples are later than those of the earliest; 0 until found.
    rates: how often each sensor is sampled.
    told: (joints,), whether a difference, or none, has been found.
    known: whether any is late or slow; watched: whether any was when last looked at: samples are kept.
    past: (rows, 2, n, 3), newest rates and accelerations, a ring; NaN before the first.
    newest: row of the newest; newest_ns: its capture.
    frame: (joints, 4), child's sensor to a frame that does not rotate.
    passed: (joints, 2, 4, 3), of the acceleration from parent and child, m/s^2: newest value, slow part, and
        the low pass's two states.
    kept: (bands, joints, 2, lags + 1, 3), m/s^2, newest values in each band, the newest first.
    product: (bands, joints, 2 lags + 1), sum of products by lag of the child; energy: (bands, joints, 2),
        sums of squares.
    usable: (joints, lags + 1), whether these are known, the newest first.
    lasted: (joints, lags + 1), s, weight of the products by their lag either way. A lost sample is missing in
        two products of each lag but 0, where it is missing in one: sums alone would peak there.
    """

    period_s: float
    spacing: int
    late_s: Array
    rates: Rates
    past: Array
    frame: Array
    passed: Array
    kept: Array
    product: Array
    energy: Array
    usable: NDArray[np.bool_]
    lasted: Array
    told: NDArray[np.bool_]
    known: bool = False
    watched: bool = False
    newest: int = 0
    newest_ns: int = -1

    @classmethod
    def unknown(cls, sensors: int, joints: int, period_s: float) -> Lateness:
        """Nothing known."""
        spacing = max(1, round(_SPACING_S / period_s))
        lags = max(2, math.ceil(_REACH_S / (spacing * period_s)))
        rows = 2 * math.ceil(_REACH_S / period_s) + 2 + SLOWEST
        frame = np.zeros((joints, 4))
        frame[:, 0] = 1.0
        return cls(period_s, spacing, np.zeros(sensors), Rates.unknown(sensors),
                   np.full((rows, 2, sensors, 3), np.nan), frame, np.zeros((joints, 2, 4, 3)),
                   np.zeros((2, joints, 2, lags + 1, 3)), np.zeros((2, joints, 2 * lags + 1)),
                   np.zeros((2, joints, 2)), np.zeros((joints, lags + 1), dtype=np.bool_),
                   np.zeros((joints, lags + 1)), np.zeros(joints, dtype=np.bool_))

    def align(self, inputs: Sequence[Sample], ticks: int) -> Sequence[Sample]:
        """The samples of rates and accelerations, (n, 3) each, at the instant of the latest sensor's.

        Those of slow sensors are interpolated, so that the instant is one of their samples or before it.
        `ticks` is the number of ticks since the last call; what came between is unknown.
        """
        gyr, acc = cast(Array, inputs[0].value), cast(Array, inputs[1].value)
        rates = self.rates
        if inputs[0].newest_ns > self.newest_ns:
            self.newest_ns = inputs[0].newest_ns
            rates.note(gyr, acc, ticks)
        else:
            rates.ended[:] = 0
        if not self.watched:
            return inputs
        self.newest = remember(self.past, self.newest, gyr, acc, ticks, rates.every, rates.since, rates.ended)
        if not self.known:
            return inputs
        values = np.empty_like(gyr), np.empty_like(acc)
        simultaneous(self.past, self.newest, self._waits(), *values)
        return [sample._replace(value=value) for sample, value in zip(inputs, values, strict=True)]

    def differences(self) -> tuple[Array, Array]:
        """By how much each joint's child is later than its parent, s, and the sd; (joints,), inf if unknown.

        Movement tells it where there is enough of it, else all that both sides share.
        """
        late_s, sd_s = np.zeros((2, 2, len(self.lasted)))
        for band in (WHOLE, LOW):
            differences(self.product[band], self.energy[band], self.lasted, self.spacing * self.period_s,
                        band, late_s[band], sd_s[band])
        moved = sd_s[LOW] <= _KNOWN_S
        return np.where(moved, late_s[LOW], late_s[WHOLE]), np.where(moved, sd_s[LOW], sd_s[WHOLE])

    def turns(self) -> Array:
        """Rotation of each sensor since that instant, (n, 3), rad: by what came, then by its newest rate."""
        turns = np.zeros((len(self.late_s), 3))
        if self.known:
            turned_since(self.past, self.newest, self.late_s / self.period_s, self._waits(), turns)
            turns *= self.period_s
        return turns

    def _waits(self) -> Array:
        """Periods for which each sensor's samples wait, (n,)."""
        waits: Array = (self.late_s.max() - self.late_s) / self.period_s + (self.rates.every.max() - 1)
        return waits

    def look(
        self, q: Array, ends: NDArray[np.int64], names: Sequence[str] = ()
    ) -> list[tuple[str, str]]:
        """Make new differences good, in relative orientations q (h, joints, 4) too.

        names: of the sensors, for messages; empty: their numbers. Returns statuses and details: how late each
        sensor is against most of them, and which are slow; none where nothing changed. Correlations of what
        has been made good begin anew.
        """
        late_s, sd_s = self.differences()
        self.told |= sd_s <= _KNOWN_S
        least_s = _LEAST_S if self.late_s.any() else _FIRST_LEAST_S
        new = np.abs(late_s) > np.maximum(least_s, _SURE * sd_s)
        every = self.rates.found()
        changed = every != self.rates.every
        slow = bool(changed.any())
        watched, self.watched = self.watched, bool(self.known or new.any() or slow)
        if not (watched and (new.any() or slow)):
            return []
        turns = self.turns()
        self.rates.every[:] = every
        for j in np.flatnonzero(new):
            # All sensors beyond the joint are later by as much.
            beyond = {int(ends[j, 1])}
            beyond.update(c for p, c in ends.tolist() if p in beyond)
            self.late_s[sorted(beyond)] += late_s[j]
        # Held samples are late by half their interval, which is gone once they are interpolated.
        for j in np.flatnonzero(new | changed[ends].any(axis=1)):
            self.product[:, j], self.energy[:, j], self.usable[j], self.lasted[j] = 0.0, 0.0, False, 0.0
        self.late_s -= self.late_s.min()
        np.minimum(self.late_s, (len(self.past) - 2 - SLOWEST) * self.period_s, out=self.late_s)
        self.known = bool(self.late_s.any() or every.max() > 1)
        turns -= self.turns()
        for hypothesis in q:
            hypothesis[:] = ahead(hypothesis, ends, turns)
        told, names = [], names or [str(i) for i in range(len(every))]
        if slow:
            told.append(("slow_sensor", "samples come at different rates: " + (", ".join(
                f"sensor {name} each {ticks}. tick"
                for name, ticks in zip(names, every.tolist(), strict=True) if ticks > 1)
                or "none any more")))
        if new.any():
            against = 1e3 * (self.late_s - np.sort(self.late_s)[(len(self.late_s) - 1) // 2])
            told.append(("late_sensor", "samples come at different times: " + (", ".join(
                f"sensor {name} {abs(each):.0f} ms {'late' if each > 0.0 else 'early'}"
                for name, each in zip(names, against, strict=True) if abs(each) >= 1.0) or "none any more")
                + ("" if self.told.all() else "; not known yet between " + ", ".join(
                    f"{names[p]} and {names[c]}" for p, c in ends[~self.told].tolist()))))
        return told


@compiled
def remember(
    past: Any, newest: int, gyr: Any, acc: Any, ticks: int, every: Any, since: Any, ended: Any
) -> int:
    """Add the newest samples (n, 3) of `ticks` ticks, but for the last unknown; return the newest row.

    A slow sensor's samples are held until the next one, then interpolated; every, since, ended: as in Rates.
    """
    rows = past.shape[0]
    for _ in range(min(ticks, rows) - 1):
        newest = (newest + 1) % rows
        past[newest, :, :, :] = math.nan
    newest = (newest + 1) % rows
    for i in range(gyr.shape[0]):
        for a in range(3):
            past[newest, 0, i, a], past[newest, 1, i, a] = gyr[i, a], acc[i, a]
        for kind in range(2):
            for a in range(3):
                if 0 < since[i] < every[i]:
                    past[newest, kind, i, a] = past[(newest - 1) % rows, kind, i, a]
                elif since[i] == every[i] and math.isnan(past[newest, kind, i, a]):
                    # The next one is lost: nothing is known of what lies between.
                    for k in range(1, every[i]):
                        past[(newest - k) % rows, kind, i, a] = math.nan
                if 1 < ended[i] <= every[i]:
                    before = past[(newest - ended[i]) % rows, kind, i, a]
                    for k in range(1, ended[i]):
                        share = k / ended[i]
                        past[(newest - ended[i] + k) % rows, kind, i, a] = (
                            before + share * (past[newest, kind, i, a] - before))
    return newest


@compiled
def simultaneous(past: Any, newest: int, waits: Any, gyr: Any, acc: Any) -> None:
    """Write the samples (n, 3) of one instant, interpolated; each sensor's are `waits` (n,) periods old."""
    rows = past.shape[0]
    for i in range(waits.size):
        # A wait of whole periods, but for rounding, needs one sample only.
        wait = waits[i]
        share = wait - int(wait + 1e-6)
        k = (newest - int(wait + 1e-6)) % rows
        before = (k - 1) % rows
        for a in range(3):
            gyr[i, a], acc[i, a] = past[k, 0, i, a], past[k, 1, i, a]
            if share > 1e-6:
                gyr[i, a] += share * (past[before, 0, i, a] - gyr[i, a])
                acc[i, a] += share * (past[before, 1, i, a] - acc[i, a])


@compiled
def turned_since(past: Any, newest: int, late: Any, waits: Any, turns: Any) -> None:
    """Write the rotation of each sensor since that instant, `turns` (n, 3), rad/s periods.

    late: (n,), periods by which the newest sample of each is late.
    """
    rows = past.shape[0]
    for i in range(waits.size):
        wait = waits[i]
        for a in range(3):
            total, k = late[i] * past[newest, 0, i, a], 0
            while k < wait:
                share, later = min(1.0, wait - k), past[(newest - k) % rows, 0, i, a]
                before = later + share * (past[(newest - k - 1) % rows, 0, i, a] - later)
                total += 0.5 * share * (later + before)
                k += 1
            turns[i, a] = total if total * 0.0 == 0.0 else 0.0


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
    q: Any, rest: Any, ends: Any, gyr: Any, acc: Any, seen: Any, period: float, spacing: int, frame: Any,
    passed: Any, kept: Any, product: Any, energy: Any, usable: Any, lasted: Any
) -> None:
    """Add the newest two samples to the correlations of all joints.

    Parameters
    ----------
    q: (joints, 4); rest: (joints, ...), with the lever arms l_p and l_c from 3 on, m.
    gyr, acc: (2, n, 3), sample before and this one; seen: (2, n), LOST, EXCEEDED, DOUBTED or SOUND.
    period: of the samples, s; spacing: number of samples since the last call.
    Others: as in Lateness; updated.
    """
    elapsed = spacing * period
    left, share = math.exp(-elapsed / _FADES_S), 1.0 - math.exp(-elapsed * _LOWEST)
    lags, matrix = kept.shape[3] - 1, np.empty((3, 3))
    # Butterworth low pass of second order, by the bilinear transform.
    warped = math.tan(0.5 * elapsed * _HIGHEST)
    square, damping = warped * warped, math.sqrt(2.0) * warped
    scale = 1.0 / (1.0 + damping + square)
    gain, feed_1, feed_2 = scale * square, 2.0 * scale * (square - 1.0), scale * (1.0 - damping + square)
    for j in range(ends.shape[0]):
        p, c = ends[j, 0], ends[j, 1]
        # Both sides are turned alike, so that a small error of this turn changes nothing.
        turn = turn_by(elapsed * gyr[1, c, 0], elapsed * gyr[1, c, 1], elapsed * gyr[1, c, 2])
        store(frame[j], multiply(components(frame[j]), turn))
        for k in range(lags, 0, -1):
            usable[j, k] = usable[j, k - 1]
        usable[j, 0] = q[j, 0] * 0.0 == 0.0 and (
            min(seen[0, p], seen[1, p], seen[0, c], seen[1, c]) == SOUND)
        gap = 1
        while gap < lags and not usable[j, gap]:
            gap += 1
        if not usable[j, gap]:
            gap = 1
        for side in range(2):
            for band in range(2):
                values = kept[band, j, side]
                for a in range(3):
                    for k in range(lags, 0, -1):
                        values[k, a] = values[k - 1, a]
                    if not usable[j, 0]:
                        values[0, a] = 0.0
                if not usable[j, 0]:
                    energy[band, j, side] *= left
            if not usable[j, 0]:
                continue
            i, arm = ends[j, side], 3 + 3 * side
            spin_matrix(mean_of(gyr, i), change_of(gyr, i, period), matrix)
            f = mean_of(acc, i)
            v = (f[0] - _row(matrix, 0, rest, j, arm), f[1] - _row(matrix, 1, rest, j, arm),
                 f[2] - _row(matrix, 2, rest, j, arm))
            if side == 0:
                v = rotated(conjugate(components(q[j])), v)
            v = rotated(components(frame[j]), v)
            state = passed[j, side]
            for a in range(3):
                if lasted[j, 0] == 0.0:
                    state[VALUE, a], state[SLOW, a], state[FIRST, a], state[SECOND, a] = v[a], v[a], 0.0, 0.0
                # Through lost samples it follows a line: left behind, its slow part would be one more signal
                # that both sides share, at one time.
                before = state[VALUE, a]
                for k in range(1, gap + 1):
                    value = before + k / gap * (v[a] - before)
                    state[SLOW, a] += share * (value - state[SLOW, a])
                    value -= state[SLOW, a]
                    low = gain * value + state[FIRST, a]
                    state[FIRST, a] = 2.0 * gain * value - feed_1 * low + state[SECOND, a]
                    state[SECOND, a] = gain * value - feed_2 * low
                    kept[WHOLE, j, side, 0, a], kept[LOW, j, side, 0, a] = value, low
                state[VALUE, a] = v[a]
            for band in range(2):
                newest = kept[band, j, side, 0]
                square = newest[0] ** 2 + newest[1] ** 2 + newest[2] ** 2
                # One blow must not outweigh all movement before it: its shape is that of errors.
                most = (_MOST ** 2 * energy[band, j, side] * elapsed / lasted[j, 0] if lasted[j, 0] > 1.0
                        else square)
                if square > most:
                    for a in range(3):
                        newest[a] *= math.sqrt(most / square)
                    square = most
                energy[band, j, side] = left * energy[band, j, side] + square
        for k in range(lags + 1):
            for band in range(2):
                later, earlier, each = 0.0, 0.0, kept[band, j]
                for a in range(3):
                    later += each[0, k, a] * each[1, 0, a]
                    earlier += each[0, 0, a] * each[1, k, a]
                product[band, j, lags + k] = left * product[band, j, lags + k] + later
                if k > 0:
                    product[band, j, lags - k] = left * product[band, j, lags - k] + earlier
            lasted[j, k] = left * lasted[j, k] + (elapsed if usable[j, 0] and usable[j, k] else 0.0)


@compiled
def _row(matrix: Any, i: int, rest: Any, j: int, arm: int) -> Any:
    return matrix[i, 0] * rest[j, arm] + matrix[i, 1] * rest[j, arm + 1] + matrix[i, 2] * rest[j, arm + 2]


@compiled
def differences(
    product: Any, energy: Any, lasted: Any, spacing_s: float, band: int, late_s: Any, sd_s: Any
) -> None:
    """Write what one band, WHOLE or LOW, tells of the differences, and its sd, s; (joints,), inf if unknown.

    product, energy: of this band.
    """
    apart_s = max(spacing_s, math.pi / _HIGHEST) if band == LOW else spacing_s
    middle = product.shape[1] // 2
    whole = np.empty(product.shape[1])
    for j in range(lasted.shape[0]):
        lasting = lasted[j, 0]
        for k in range(whole.size):
            known = lasted[j, abs(k - middle)]
            whole[k] = product[j, k] * lasting / known if known > _LEAST_KNOWN * lasting else 0.0
        late_s[j], sd_s[j], k = 0.0, math.inf, int(np.argmax(whole))
        peak = whole[k]
        if lasting < _FIRST_S or not 0 < k < 2 * middle or not peak > 0.0:
            continue
        before, after = whole[k - 1], whole[k + 1]
        bend = 2.0 * peak - before - after
        rho = min(0.99, peak / math.sqrt(energy[j, 0] * energy[j, 1]))
        of_noise = _SHARED_SDS * math.sqrt(apart_s / (3.0 * lasting))
        if bend > 0.0 and peak * spacing_s > _LEAST[band] ** 2 * lasting and rho > max(_SHARED, of_noise):
            omega = math.sqrt(bend / peak) / spacing_s
            late_s[j] = (k - middle + 0.5 * (after - before) / bend) * spacing_s
            sd_s[j] = math.sqrt((1.0 - rho ** 2) * math.pi / (rho ** 2 * lasting * omega ** 3))
