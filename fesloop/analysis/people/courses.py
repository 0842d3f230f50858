"""Courses of torque under steps, trains and ramps of pulse width: plain figures, and a person's response.

`step_responses` reduces a course to delays and rise times. `fit_course` finds delay, natural frequency,
recruitment and the device's friction that explain all of it, at greatest posterior density.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.signal import lfilter
from scipy.special import ndtr

from fesloop.errors import InputError
from fesloop.hand.muscle_paths import JOINTS
from fesloop.models.arm_responses import (
    CHAIN_S,
    FRICTION_NM,
    ArmResponses,
    Estimate,
    Response,
    Widths,
    chronaxie_s,
    effective_a,
)
from fesloop.models.dry_friction import play
from fesloop.models.evoked_torque import REFERENCE_RAD, Postures
from fesloop.streams.stimulation import StimulationRecording, TorqueCourse

Array = NDArray[np.float64]
LEAST_NM = np.array([0.2, 0.05, 0.05, 0.05])
"""Least torque of a step by joint of `JOINTS`, and below the times the noise before it that a torque must
exceed, as in the recordings' baselines."""
_CLEAR = 8.0
_TO_FIT_NM = np.array([0.4, 0.08, 0.08, 0.08])
"""Least range of torque within a window for a joint to take part in a fit (chosen)."""
_REST_S, _AFTER_S, _APART_S = 0.3, 0.9, 0.3
"""Time before and after a stretch of stimulation that counts as its own, and pause between two (chosen)."""
_STEP_S = 0.01
_MISFIT, _MEMORY_S = 0.1, 0.2
"""Error of the model, as a share of the torque's range, and time over which it is one error (chosen)."""
_LEAST_ARM_M = 1e-3
_GOOD = 0.8
"""Share of the variance that a fit must explain."""


class StepResponse(NamedTuple):
    """Response of one joint to one step or train of pulse width.

    Attributes
    ----------
    joint: number. step: True for a step of more than .5 s, False for a train.
    delay_s: from the command to 5 % of the torque. rise_s: from 10 to 90 %; NaN for a train.
    fall_delay_s, fall_s: from the end to 5 % of what goes, and from 90 to 10 %; NaN for a train.
    left: torque 1.5 s after a step over the torque before its end; NaN for a train.
    """

    joint: int
    step: bool
    delay_s: float
    rise_s: float
    fall_delay_s: float
    fall_s: float
    left: float


def step_responses(course: TorqueCourse) -> list[StepResponse]:
    """Responses to the steps and trains of a course, of the joint that answers most clearly; ramps have none.

    A step begins at rest, lasts .1 to 1.2 s and rises by more than .6 of the range of widths. Responses below
    `LEAST_NM`, or below eight times the noise before, are left out.
    """
    period, width, torque = course.period_s, course.pulse_width_s, course.device_torque_nm

    def samples(seconds: float) -> int:
        return round(seconds / period)

    low, span = width.min(), np.ptp(width)
    high = width > low + 0.9 * span
    change = np.diff(high.astype(int))
    downs = np.flatnonzero(change == -1) + 1
    found = []
    for up in np.flatnonzero(change == 1) + 1 if span > 0.0 else ():
        after = downs[downs > up]
        if not after.size or width[up - 2] > low + 0.3 * span or up < samples(0.5):
            continue
        down = int(after[0])
        lasts = (down - up) * period
        if not 0.1 <= lasts <= 1.2 or down + samples(2.5) > len(width):
            continue
        evoked = torque[up - samples(0.3):up].mean(axis=0) - torque
        until = down + samples(0.15)
        size = np.abs(evoked[up:until + 1]).max(axis=0)
        joint = int(np.argmax(np.where(size > LEAST_NM, size / LEAST_NM, 0.0)))
        if not (size[joint] >= LEAST_NM[joint]
                and size[joint] >= _CLEAR * evoked[up - samples(0.5):up, joint].std()):
            continue
        peak = evoked[up:until + 1, joint]
        course_nm = evoked[:, joint] * np.sign(peak[np.argmax(np.abs(peak))])
        found.append(_response(course_nm, int(up), down, joint, period))
    return found


def _response(course: Array, up: int, down: int, joint: int, period: float) -> StepResponse:
    """Times of one positive response (samples,) to a step from `up` to `down`."""
    until, second = down + round(0.15 / period), round(1.0 / period)
    step = (down - up) * period > 0.5
    top = course[until - round(0.2 / period):until].mean() if step else course[up:until].max()
    rising = course[up:until + 1] / top
    delay = _first_beyond(rising, 0.05) * period
    if not step:
        return StepResponse(joint, False, delay, *(np.nan,) * 4)
    rise = (_first_beyond(rising, 0.9) - _first_beyond(rising, 0.1)) * period
    left = course[down + 3 * second // 2:down + 2 * second].mean()
    fall_delay = fall = np.nan
    if top - left > 0.4 * top:
        falling = (top - course[down:down + 3 * second // 2]) / (top - left)
        fall = (_first_beyond(falling, 0.9) - _first_beyond(falling, 0.1)) * period
        fall_delay = _first_beyond(falling, 0.05) * period
    return StepResponse(joint, True, delay, rise, fall_delay, fall, left / top)


def _first_beyond(values: Array, level: float) -> float:
    """Place, with a fraction, at which values first cross a level upwards; NaN where they never do."""
    k = int(np.argmax(values >= level))
    if k == 0:
        return 0.0 if values[0] >= level else np.nan
    return float(k - 1 + (level - values[k - 1]) / (values[k] - values[k - 1]))


class CourseFit(NamedTuple):
    """Response of a muscle in one course at one joint, and what the device adds.

    Attributes
    ----------
    response: of the muscle. joint: number in `JOINTS`. size_nm: greatest range of torque in a stretch.
    explained: share of the torque's variance.
    gain_nm: torque of the whole muscle. friction_nm: of the device.
    sd: standard deviations of delay, s, of the logarithm of natural frequency, of the probit at the highest
        width, and of the logarithm of spread, by the curvature at the greatest density.
    places: (stretches, n), sample numbers. seen_nm, fitted_nm: torque there, NaN after a stretch's end.
    """

    response: Response
    joint: int
    size_nm: float
    explained: float
    gain_nm: float
    friction_nm: float
    sd: Array
    places: NDArray[np.int64]
    seen_nm: Array
    fitted_nm: Array


class Prior(NamedTuple):
    """Means and standard deviations of normal priors (chosen).

    Attributes
    ----------
    delay_s: beyond the chain. log_frequency: of the natural frequency, rad/s (20 to 25 in grip-force data).
    highest: probit of the share recruited at the highest width. log_spread: of recruitment.
    log_friction: of friction over `FRICTION_NM`. log_gain: of a stretch's torque over that of all.
    """

    delay_s: tuple[float, float] = (0.04, 0.03)
    log_frequency: tuple[float, float] = (float(np.log(22.0)), 0.5)
    highest: tuple[float, float] = (0.7, 0.8)
    log_spread: tuple[float, float] = (float(np.log(0.25)), 0.7)
    log_friction: tuple[float, float] = (0.0, 0.4)
    log_gain: tuple[float, float] = (0.0, 0.2)


PRIOR = Prior()
_CHOSEN = np.array([PRIOR.delay_s, PRIOR.log_frequency, PRIOR.highest, PRIOR.log_spread, PRIOR.log_friction])
_LOW = np.array([-0.03, np.log(4.0), -2.0, np.log(0.02), -2.0, np.log(0.3)])
_HIGH = np.array([0.25, np.log(120.0), 4.0, np.log(1.5), 2.0, np.log(10.0)])


def fit_course(course: TorqueCourse, joint: int, person: str, electrode: str) -> CourseFit | None:
    """Response of greatest posterior density; None for a course without a clear torque at a joint.

    The model: lognormal recruitment by effective current, the mean delay of the laboratory's chain
    (`CHAIN_S`) and the muscle's, a critically damped second order, and dry friction of the device. Each
    stretch of stimulation has a factor on its torque and begins at a place of its own within friction. Errors
    are normal, `_MISFIT` of the range, and count once every `_MEMORY_S`; priors are `PRIOR`.
    """
    starts, ends = _stretches(course)
    if not len(starts):
        return None
    every = max(1, round(_STEP_S / course.period_s))
    ahead = starts[:, np.newaxis] + np.arange(0, (ends - starts).max(), every)
    places, inside = np.minimum(ahead, ends[:, np.newaxis]), ahead <= ends[:, np.newaxis]
    seen = -course.device_torque_nm[places, joint]
    size = float(np.ptp(seen, axis=1).max())
    if not (size >= _TO_FIT_NM[joint] and np.isfinite(seen).all()):
        return None
    with np.errstate(divide="ignore"):
        logs = np.log(effective_a(course.current_a, course.pulse_width_s, chronaxie_s(electrode)))
    highest, count = logs.max(), len(starts)
    sign = float(np.sign(np.median(_furthest(seen - seen[:, :1]))))
    scale = _MISFIT * size * np.sqrt(_MEMORY_S / (every * course.period_s))

    def model(q: Array) -> Array:
        recruited = ndtr((logs - highest) / np.exp(q[3]) + q[2])
        activation = _activated(recruited, (q[0] + CHAIN_S) / course.period_s, np.exp(q[1]), course.period_s)
        gains = sign * size * np.exp(q[5] + q[6:6 + count])
        friction = np.full(count, FRICTION_NM[joint] * np.exp(q[4]))
        drive = (activation[places] * gains[:, np.newaxis]).T
        begin = drive[0] + q[6 + count:] * friction
        return np.asarray((play(drive, friction, begin) - begin).T + seen[:, :1])

    def residuals(q: Array) -> Array:
        return np.concatenate([
            np.where(inside, (model(q) - seen) / scale, 0.0).ravel(),
            (q[:5] - _CHOSEN[:, 0]) / _CHOSEN[:, 1],
            (q[6:6 + count] - PRIOR.log_gain[0]) / PRIOR.log_gain[1]])

    low = np.concatenate([_LOW, np.full(count, -1.0), np.full(count, -1.0)])
    high = np.concatenate([_HIGH, np.full(count, 1.0), np.full(count, 1.0)])
    tried = [least_squares(residuals, np.concatenate([
        [0.05, np.log(20.0), 0.6, np.log(spread), friction, np.log(1.5)], np.zeros(2 * count)]),
        bounds=(low, high), diff_step=np.full(len(low), 1e-3), x_scale="jac", max_nfev=80)
        for spread, friction in ((0.2, 0.0), (0.1, -0.5), (0.3, 0.3))]
    best = min(tried, key=lambda each: float(each.cost))
    q, fitted = best.x, model(best.x)
    left = (fitted - seen)[inside]
    mean = np.where(inside, seen, 0.0).sum(axis=1, keepdims=True) / inside.sum(axis=1, keepdims=True)
    spread, slopes = float(np.exp(q[3])), np.asarray(best.jac, float)
    return CourseFit(
        response=Response(person, electrode, float(q[0]), float(np.exp(q[1])), float(q[2]), spread,
                          1e3 * float(np.exp(highest - spread * q[2]))),
        joint=joint, size_nm=size, explained=float(1.0 - (left**2).sum() / ((seen - mean)[inside]**2).sum()),
        gain_nm=float(sign * size * np.exp(q[5])), friction_nm=float(FRICTION_NM[joint] * np.exp(q[4])),
        sd=np.sqrt(np.diag(np.linalg.pinv(slopes.T @ slopes))[:4]), places=places,
        seen_nm=np.where(inside, seen, np.nan), fitted_nm=np.where(inside, fitted, np.nan))


def _stretches(course: TorqueCourse) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First and last sample of each stretch of stimulation, with rest before and after."""
    width, period = course.pulse_width_s, course.period_s
    above = np.flatnonzero(width > width.min() + 0.05 * np.ptp(width))
    if not above.size or np.ptp(width) <= 0.0:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    breaks = np.flatnonzero(np.diff(above) * period > _APART_S)
    starts = above[np.append(0, breaks + 1)] - round(_REST_S / period)
    ends = above[np.append(breaks, -1)] + round(_AFTER_S / period)
    whole = (starts >= 0) & (ends < len(width))
    return starts[whole], ends[whole]


def _furthest(values: Array) -> Array:
    """Value (windows,) of greatest size over time of values (windows, samples)."""
    return np.asarray(values[np.arange(len(values)), np.abs(values).argmax(axis=1)])


def _activated(recruited: Array, delay: float, frequency: float, period: float) -> Array:
    """Activation (samples,) behind a delay, in samples, and two equal lags; at rest before the first."""
    whole = np.arange(len(recruited)) - delay
    late = np.interp(whole, np.arange(len(recruited)), recruited)
    pole = np.exp(-frequency * period)
    for _ in range(2):
        late = lfilter([1.0 - pole], [1.0, -pole], late, zi=[pole * late[0]])[0]
    return np.asarray(late)


def crossed_by(electrode: str) -> list[int]:
    """Numbers of the joints that the muscle crosses after which an electrode is named."""
    arms = np.abs(Postures.of(electrode, REFERENCE_RAD[np.newaxis]).arms[0, 0])
    return [int(joint) for joint in np.flatnonzero(arms > _LEAST_ARM_M)]


def fits_of(recording: StimulationRecording) -> list[CourseFit]:
    """Fits of all courses of a recording, each at the joint of the largest torque that it explains.

    Joints are those of the recording that the electrode's muscle crosses: what others show, they show through
    the device. Torques are compared over `LEAST_NM`.

    Raises InputError for a recording of other joints.
    """
    if not {*recording.joints} <= {*JOINTS}:
        raise InputError(f"{recording.source}: joints", ", ".join(recording.joints),
                         f"of {', '.join(JOINTS)}")
    columns, found = [JOINTS.index(name) for name in recording.joints], []
    for recorded in recording.courses:
        torque = np.full((len(recorded.device_torque_nm), len(JOINTS)), np.nan)
        torque[:, columns] = recorded.device_torque_nm
        course = replace(recorded, device_torque_nm=torque)
        electrode = recording.muscles[course.muscle]
        fits = [fit_course(course, joint, recording.person, electrode) for joint in crossed_by(electrode)]
        explained = [each for each in fits if each is not None and each.explained > _GOOD]
        found += sorted(explained, key=lambda each: each.size_nm / LEAST_NM[each.joint])[-1:]
    return found


def widths_of(recording: StimulationRecording) -> list[Widths]:
    """Usable pulse widths of a recording's muscles, as far as they are known."""
    found = []
    for electrode, current, low, high in zip(
            recording.muscles, recording.width_current_a, recording.lowest_width_s,
            recording.highest_width_s, strict=True):
        if np.isfinite([current, low, high]).all():
            ends = np.log(1e3 * effective_a(current, np.array([low, high]), chronaxie_s(electrode)))
            found.append(Widths(recording.person, electrode, float(ends[1]), float(ends[1] - ends[0])))
    return found


def responses_of(recordings: Sequence[StimulationRecording]) -> ArmResponses:
    """Population of the responses of people with courses."""
    return ArmResponses(
        [Estimate(fit.response, tuple(fit.sd.tolist())) for each in recordings for fit in fits_of(each)],
        [widths for each in recordings for widths in widths_of(each)])
