"""Features of recordings of stimulated muscle: recruitment in ramps, change over repeats and visits."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fesloop.streams.stimulation.recording import Array, SteadyTrials, StimulationRecording, TorqueCourse

_LEVELS = 20
"""Most pulse widths of a recruitment curve (chosen)."""
_LONGEST_STEP, _LEAST_RISE, _REST_S = 0.3, 0.8, 0.3
"""Limits of a ramp: greatest step and least rise, as shares of the range of pulse widths, and time before it
that counts as rest (chosen)."""
CLEAR = 3.0
"""Standard errors beyond which a muscle's mean torque counts as different from 0 (chosen)."""
_HELD_S = 0.5
"""Time for which a ramp may keep one pulse width, s (chosen)."""


def principal_joint(trials: SteadyTrials, muscle: int) -> int:
    """Number of the joint at which a muscle's mean torque stands out most from the scatter of a repeat.

    Where nothing was repeated, that of the largest mean torque.
    """
    evoked, sd = trials.evoked_nm, trials.repeatability().sd_nm
    cells = [evoked[rows].mean(axis=0) for (m, _), rows in trials.cells().items() if m == muscle]
    size = np.abs(np.mean(cells, axis=0))
    return int(np.argmax(size / sd if (sd > 0.0).all() else size))


def shown_joint(recording: StimulationRecording, course: TorqueCourse, curve: RecruitmentCurve) -> int:
    """Number of the joint at which a ramp is shown: that of the muscle's isometric trials, if there are any.

    Otherwise that of the largest torque in the ramps, where friction of the device may hide the muscle's own
    joint.
    """
    trials = recording.steady
    if trials is None or not (trials.muscle == course.muscle).any():
        return curve.principal_joint
    return principal_joint(trials, course.muscle)


class ByRepeat(NamedTuple):
    """A muscle's torque at its principal joint in each visit of the same postures, by the same pulses.

    Attributes
    ----------
    joint: its number. mean_nm: (repeats,), mean over the postures that have every repeat.
    clear: whether the mean over repeats is beyond `CLEAR` of its standard errors.
    """

    joint: int
    mean_nm: Array
    clear: bool


def by_repeat(trials: SteadyTrials, muscle: int) -> ByRepeat:
    """Torque of a muscle by repeat, up to the repeat that half of its postures and pulses have."""
    joint, evoked = principal_joint(trials, muscle), trials.evoked_nm
    cells = [evoked[rows[np.argsort(trials.repeat[rows], kind="stable")], joint]
             for rows in trials.repeats() if trials.muscle[rows[0]] == muscle]
    repeats = int(np.median([len(each) for each in cells]))
    whole = np.array([each[:repeats] for each in cells if len(each) >= repeats])
    error = trials.repeatability().sd_nm[joint] / np.sqrt(whole.size)
    return ByRepeat(joint, whole.mean(axis=0), bool(abs(whole.mean()) > CLEAR * error))


class Baselines(NamedTuple):
    """Device torque of each visit less the mean of its posture's visits.

    Attributes
    ----------
    visit: (visits,), their numbers, in the order of the session. time_s: (visits,), NaN where unknown.
    change_nm: (visits, joints); NaN in a posture that was visited once.
    """

    visit: Array
    time_s: Array
    change_nm: Array


def baselines(trials: SteadyTrials) -> Baselines:
    """Change of the visits' median device torque over the session."""
    _, first = np.unique(trials.visit, return_index=True)
    visits = trials.visit[np.sort(first)]
    median = np.array([np.median(trials.device_torque_nm[trials.visit == v], axis=0) for v in visits])
    posture = np.array([trials.posture[trials.visit == v][0] for v in visits])
    time = np.array([trials.time_s[trials.visit == v].mean() for v in visits])
    change = np.full(median.shape, np.nan)
    for code in np.unique(posture):
        here = posture == code
        if np.count_nonzero(here) > 1:
            change[here] = median[here] - median[here].mean(axis=0)
    return Baselines(visits.astype(float), time, change)


class RecruitmentCurve(NamedTuple):
    """Torque against pulse width in the ramps of a course.

    Attributes
    ----------
    width_s: (k,), rising. up_nm, down_nm: (k, joints), mean over ramps of rising and of falling width, less
        the torque before each pair of ramps; NaN at a width that no ramp has.
    ramps: number of rising ramps.
    """

    width_s: Array
    up_nm: Array
    down_nm: Array
    ramps: int

    @property
    def principal_joint(self) -> int:
        """Number of the joint of the largest torque."""
        size = np.abs(np.concatenate([self.up_nm, self.down_nm]))
        return int(np.argmax(np.where(np.isfinite(size), size, 0.0).max(axis=0)))


def recruitment_curve(course: TorqueCourse) -> RecruitmentCurve | None:
    """Recruitment in the ramps of a course; None for a course without any.

    Torque is taken at the instant of its width as commanded. It lags by the delay of chain and muscle, so
    that curves of rising and falling width differ without any hysteresis of recruitment.
    """
    width, period = course.pulse_width_s, course.period_s
    rising, falling = (_ramps(width, period, sign) for sign in (1.0, -1.0))
    if not rising:
        return None
    levels = np.unique(np.round(width[np.concatenate([np.arange(*each) for each in rising])], 9))
    if len(levels) > _LEVELS:
        levels = np.linspace(levels[0], levels[-1], _LEVELS)
    up: list[Array] = []
    down: list[Array] = []
    for begin, end in rising:
        rest = course.device_torque_nm[max(0, begin - max(1, round(_REST_S / period))):begin + 1]
        evoked = rest.mean(axis=0) - course.device_torque_nm
        up.append(_by_level(width[begin:end], evoked[begin:end], levels))
        after = next((each for each in falling if each[0] >= end - 1), None)
        later = next((each for each in rising if each[0] >= end), None)
        if after is not None and (later is None or after[0] < later[0]):
            down.append(_by_level(width[slice(*after)], evoked[slice(*after)], levels))
    missing = np.full((len(levels), course.device_torque_nm.shape[1]), np.nan)
    return RecruitmentCurve(levels, _mean(up, missing), _mean(down, missing), len(rising))


def _ramps(width: Array, period: float, sign: float) -> list[tuple[int, int]]:
    """First and last + 1 sample of each stretch in which the width rises (sign 1) or falls gradually."""
    span = float(np.ptp(width))
    if span <= 0.0:
        return []
    change = sign * np.diff(width)
    moves = np.flatnonzero(change != 0.0)
    gradual = (change[moves] > 0.0) & (change[moves] <= _LONGEST_STEP * span)
    follows = np.diff(moves, prepend=-len(width)) * period <= _HELD_S
    breaks = ~(gradual & follows & np.append(False, gradual[:-1]))
    stretches = np.split(moves, np.flatnonzero(breaks)[1:]) if moves.size else []
    return [(int(each[0]), int(each[-1]) + 2) for each in stretches
            if sign * (width[each[-1] + 1] - width[each[0]]) >= _LEAST_RISE * span
            and 0.0 < change[each[0]] <= _LONGEST_STEP * span]


def _by_level(width: Array, torque: Array, levels: Array) -> Array:
    """Mean torque (levels, joints) of samples by their nearest level; NaN where there is none."""
    nearest = np.abs(width[:, None] - levels).argmin(axis=1)
    return np.array([torque[nearest == k].mean(axis=0) if (nearest == k).any()
                     else np.full(torque.shape[1], np.nan) for k in range(len(levels))])


def _mean(curves: list[Array], missing: Array) -> Array:
    """Mean of curves over those that have a number at the place."""
    if not curves:
        return missing
    known = np.isfinite(curves)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(known, curves, 0.0).sum(axis=0) / known.sum(axis=0))
