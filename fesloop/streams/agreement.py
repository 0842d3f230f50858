"""Agreement of gyroscope and accelerometer: both must show the same rotation.

A window of samples is rotated by its rates into one frame. There gravity is constant if the rates are right,
and the remaining motion is acceleration, whose size follows from the length of the samples. Where gravity
moves by more than that, other explanations of the rates are tried: axes swapped or of the wrong sign, a wrong
scale, the gyroscope of another sensor. Explanations are compared by likelihood, with residuals of Student's t
distribution, whose tails allow for rough motion. By Markov's inequality a wrong one reaches a likelihood
ratio of `1 / _ALPHA` with a probability of `_ALPHA` at most, as far as windows are independent.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import permutations, product
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fesloop.hand.quaternion import multiply, normalized, rotate
from fesloop.loop.clock import NS_PER_S
from fesloop.streams.pace import pace_of
from fesloop.streams.recording import MotionRecording

Array = NDArray[np.float64]

_WINDOW_S = 4.0
"""Chosen: long enough for a turn, short enough for the drift of a gyroscope that is not calibrated."""
_STEPS = 96
"""Steps of a window."""
_MEANS = ((16, 1.5), (4, 0.5))
"""Parts of a window over which means are compared, and gravity's deviation in them, rad, for a relative
deviation of the samples' length (measured: ratios of .4 to 1.5 and of 0 to .3 in most windows of four
published sets). Short parts show quick motion, in long ones accelerations cancel."""
_ROUGH = 0.6
"""Root mean square deviation of the samples' length, relative to gravity, above which a window is not used
(chosen)."""
_LEAST_WINDOWS = 16
"""Least windows of a recording with enough samples: one that states too high a rate looks short."""
_MOST_WINDOWS, _FEW_WINDOWS = 240, 24
"""Most windows that judge the rates, and most windows that are searched for all explanations."""
_SD_RAD = np.radians(2.0)
"""Motion of gravity that drift of a gyroscope and noise leave (chosen: 1 deg/s leaves 1.1 deg)."""
_TAIL = 1.5
"""Exponent of the density of a bivariate Student's t, (degrees of freedom + dimensions) / 2 = (1 + 2) / 2."""
_ALPHA = 1e-6
"""Probability of a false alarm for each sensor (chosen)."""
_CONSISTENT = 4.0
"""Least ratio of the evidence for an explanation to that against it, over all windows (chosen)."""
_MOVES = 9.0
"""Least squared motion, in standard deviations, at which a window counts as moving."""
_LEAST_FACTOR = 1.15
"""Scale factors within this ratio of 1 count as calibration errors, not as wrong units (chosen)."""
DEGREES = 180.0 / np.pi
"""Degrees per radian."""
_GRID = np.geomspace(1.0 / 100.0, 100.0, 53)
_FACTORS = np.concatenate([[DEGREES, 1.0 / DEGREES], _GRID[np.abs(np.log(_GRID)) > np.log(_LEAST_FACTOR)]])
"""Factors that are tried, the likely ones first."""
_FINER = np.geomspace(1.0 / 1.2, 1.2, 37)
_AGREES_ALPHA = 1e-3
"""Probability of taking rates for right that are half or twice the right ones (chosen)."""
_CLEARLY_WRONG = np.array([0.5, 2.0])
"""Factors that rates which agree must exclude."""
_NO_BETTER = 2.0
"""Logarithm of a likelihood ratio below which the simpler of two explanations is taken (chosen)."""
_SAME_FACTOR = 1.12
"""Ratio within which factors count as equal (chosen: a step of those that are tried, and calibration)."""
_SAME_LIKELIER = 1.5
"""Ratio within which likelier factors, not shown, count as equal (chosen)."""
_MOST_NAMED = 4
_OWN = "{name}"
"""Placeholder of a sensor's name where several have the same fault."""
_LOST = 0.1
"""Share of a window's samples that may be lost; they are interpolated."""

Verdict = Literal["agrees", "no_information", "axes", "scale", "axes_and_scale", "exchange", "disagrees"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Agreement:
    """Agreement of a sensor's rates with the rotation of gravity in it, or another explanation.

    Attributes
    ----------
    verdict: "agrees", where half and twice the rates do clearly worse and no other factor better;
        "no_information", where rotation is too small, or too rough, to judge; "axes", "scale" or both, where
        `factor` times `axes` @ rates explains it; "exchange", where the rates of sensor `other` do;
        "disagrees", where none of these does better than no rotation.
    axes: (3, 3), signed permutation.
    factor: of the rates that explains gravity; with "no_information" a likelier one than 1, not shown.
    other: number of a sensor; its own where it is not an exchange.
    """

    verdict: Verdict
    axes: Array
    factor: float
    other: int

    @property
    def doubtful(self) -> bool:
        """True if the rates do not explain gravity."""
        return self.verdict not in ("agrees", "no_information")


@dataclass(frozen=True, slots=True, eq=False)
class _Windows:
    """Windows of one sensor.

    Attributes
    ----------
    gyr, acc: (windows, steps, 3), rad/s and multiples of gravity.
    variance: (2, windows), rad^2, of gravity's direction in short and long means, by noise and acceleration.
    sound: (windows,), whether samples are there, evenly spaced, and mostly gravity.
    """

    gyr: Array
    acc: Array
    variance: Array
    sound: NDArray[np.bool_]

    def at(self, rows: NDArray[np.intp]) -> _Windows:
        """Some of them."""
        return _Windows(self.gyr[rows], self.acc[rows], self.variance[:, rows], self.sound[rows])

    def squares(self, rates: Array, step_s: float) -> Array:
        """Squared residuals of gravity under rates (m, windows, steps, 3): (m, windows), in variances."""
        return _squares(rates, self.acc, step_s, self.variance)


def _signed_permutations() -> Array:
    """The 48 ways to name three axes, (48, 3, 3): the identity first, few changes before many."""
    every = [np.eye(3)[list(order)] * np.array(signs)[:, np.newaxis]
             for order in permutations(range(3)) for signs in product((1.0, -1.0), repeat=3)]
    return np.array(sorted(every, key=lambda axes: (-np.trace(axes != 0.0), -axes.sum())))


AXES = _signed_permutations()


def agreements(times_s: Array, gyr: Array, acc: Array) -> tuple[Agreement, ...]:
    """The agreement of each sensor.

    Parameters
    ----------
    times_s: (n,), s, increasing; windows with gaps are left out.
    gyr, acc: (n, n_sensors, 3), rad/s and m/s^2 in the sensor's frame, +g upwards at rest; NaN where lost.
    """
    period = pace_of(times_s).period_s if times_s.size > _STEPS else 0.0
    if not period > 0.0:
        return tuple(_of("no_information", number) for number in range(gyr.shape[1]))
    together = max(1, min(round(_WINDOW_S / period / _STEPS), times_s.size // (_STEPS * _LEAST_WINDOWS)))
    step_s = period * together
    cut = [_windows(times_s, gyr[:, number], acc[:, number], period, together)
           for number in range(gyr.shape[1])]
    return tuple(_agreement(number, cut, step_s) for number in range(len(cut)))


def _of(verdict: Verdict, number: int) -> Agreement:
    return Agreement(verdict=verdict, axes=np.eye(3), factor=1.0, other=number)


def _windows(times_s: Array, gyr: Array, acc: Array, period: float, together: int) -> _Windows:
    """A sensor's samples in windows, steps of `together` samples each."""
    size = _STEPS * together
    count = times_s.size // size
    times = times_s[:count * size].reshape(count, size)
    even = np.abs((times[:, -1] - times[:, 0]) / (period * (size - 1)) - 1.0) < _LOST
    there = np.asarray(np.isfinite(gyr).all(axis=1) & np.isfinite(acc).all(axis=1))
    found = there[:count * size].reshape(count, size).mean(axis=1) > 1.0 - _LOST
    if not there.any():
        nothing = np.zeros((count, _STEPS, 3))
        return _Windows(nothing, nothing, np.ones((len(_MEANS), count)), found)
    gravity = float(np.median(np.linalg.norm(acc[there], axis=1)))
    rates, force = (_filled(values, there)[:count * size].reshape(count, _STEPS, together, 3).mean(axis=2)
                    for values in (gyr, acc / gravity))
    deviation = np.mean((np.linalg.norm(force, axis=2) - 1.0)**2, axis=1)
    variance = np.array([_SD_RAD**2 + share**2 * deviation for _, share in _MEANS])
    return _Windows(rates, force, variance, even & found & (deviation < _ROUGH**2))


def _filled(values: Array, there: NDArray[np.bool_]) -> Array:
    """Values (n, 3) with lost ones on lines between their neighbours."""
    if there.all():
        return values
    row = np.arange(len(values))
    return np.column_stack([np.interp(row, row[there], column[there]) for column in values.T])


def _agreement(number: int, cut: Sequence[_Windows], step_s: float) -> Agreement:
    """The agreement of one sensor."""
    at = _judging(cut[number], step_s)
    own = cut[number].at(at)
    if not at.size:
        return _of("no_information", number)
    resting = own.squares(np.zeros((1, *own.gyr.shape)), step_s)[0]
    score = _score(own.squares(own.gyr[np.newaxis], step_s)[0])
    unrelated = _unrelated(own, step_s, score, resting)
    evidence, gain, best, likelier = np.log(1.0 / _ALPHA), 0.0, None, 1.0
    for found, choices, ahead in _explanations(number, cut, at, step_s, score, unrelated):
        if ahead.sum() - np.log(choices) > max(evidence, gain) and _consistent(ahead):
            gain, best = float(ahead.sum() - np.log(choices)), found
        if found.verdict == "scale" and ahead.sum() > _NO_BETTER:
            likelier = found.factor if abs(np.log(found.factor)) > np.log(_LEAST_FACTOR) else 1.0
    at_rest = float((score - _score(resting)).sum())
    if best is not None and (best.factor >= 1.0 or gain > at_rest + _NO_BETTER):
        return best
    if unrelated or best is not None:
        return _of("disagrees", number)
    if -at_rest > evidence and likelier == 1.0 and _excluded(own, step_s, score):
        return _of("agrees", number)
    return replace(_of("no_information", number), factor=likelier if -at_rest > evidence else 1.0)


def _excluded(own: _Windows, step_s: float, score: Array) -> bool:
    """Return whether clearly wrong rates would be distinguished from these."""
    wrong = _CLEARLY_WRONG[:, np.newaxis, np.newaxis, np.newaxis] * own.gyr
    behind = (_score(own.squares(wrong, step_s)) - score).sum(axis=1)
    return bool((behind > np.log(1.0 / _AGREES_ALPHA)).all())


def _judging(own: _Windows, step_s: float) -> NDArray[np.intp]:
    """Numbers of the windows that judge: of many, half are spread evenly, half are those with most motion.

    Motion is that of gravity alone: a choice by the rates too would prefer windows with wrong rates.
    """
    at = np.flatnonzero(own.sound)
    if at.size <= _MOST_WINDOWS:
        return at
    some = own.at(at)
    moved = some.squares(np.zeros((1, *some.gyr.shape)), step_s)[0]
    half = _MOST_WINDOWS // 2
    return np.asarray(np.union1d(at[np.argsort(-moved, kind="stable")[:half]],
                                 at[np.linspace(0, at.size - 1, half).astype(int)]))


def _unrelated(own: _Windows, step_s: float, score: Array, resting: Array) -> bool:
    """Return whether gravity moves as if the rates came from another motion that is as lively as this one."""
    mean = np.broadcast_to(own.acc.mean(axis=1, keepdims=True), own.acc.shape)
    turned = _squares(own.gyr[np.newaxis], mean, step_s, own.variance)[0]
    moving = np.maximum(resting, turned) > _MOVES
    lively, left = (resting + turned)[moving], np.expm1(score[moving] / _TAIL)
    ahead = score[moving] - _score(left / lively) - np.log(lively)
    return bool(ahead.sum() > np.log(1.0 / _ALPHA)) and _consistent(ahead)


def _score(squares: Array) -> Array:
    """Minus the logarithm of the likelihood of squared residuals, in squared standard deviations.

    The likelihood is Student's t distribution in a plane, of one degree of freedom.
    """
    return np.asarray(_TAIL * np.log1p(squares))


def _consistent(ahead: Array) -> bool:
    """Return whether the windows as a whole support an explanation, not a few of them alone."""
    return bool(ahead[ahead > 0.0].sum() > -_CONSISTENT * ahead[ahead < 0.0].sum())


def _explanations(number: int, cut: Sequence[_Windows], at: NDArray[np.intp], step_s: float,
                  score: Array, unrelated: bool) -> Iterator[tuple[Agreement, int, Array]]:
    """The likeliest explanation of each kind, how many of its kind there are, and how far it is ahead.

    The last is the logarithm of its likelihood ratio to the rates as they are, (windows,).
    """
    own = cut[number].at(at)
    others = [each for each in range(len(cut)) if each != number]
    if others:
        sources = [cut[each].at(at) for each in others]
        scores = _score(own.squares(np.array([each.gyr for each in sources]), step_s))
        ahead = np.where([each.sound for each in sources], score - scores, 0.0)
        likeliest = int(np.argmax(ahead.sum(axis=1)))
        yield replace(_of("exchange", number), other=others[likeliest]), len(others), ahead[likeliest]
    few = own.at(np.sort(np.argsort(-score, kind="stable")[:_FEW_WINDOWS]))
    # Pairs of steps are fine enough for a search.
    pairs = (len(few.gyr), _STEPS // 2, 2, 3)
    few = replace(few, gyr=few.gyr.reshape(pairs).mean(axis=2), acc=few.acc.reshape(pairs).mean(axis=2))

    def scores_of(maps: Array) -> Array:
        return np.asarray(_score(few.squares(_mapped(maps, few.gyr), 2.0 * step_s)).sum(axis=1))

    def ahead_of(found: Agreement, factors: Array) -> Array:
        maps = factors[:, np.newaxis, np.newaxis] * found.axes
        return np.asarray(score - _score(own.squares(_mapped(maps, own.gyr), step_s)))

    def refined(found: Agreement) -> tuple[Agreement, Array]:
        factors = found.factor * _FINER
        ahead = ahead_of(found, factors)
        likeliest = int(np.argmax(ahead.sum(axis=1)))
        return replace(found, factor=float(factors[likeliest])), ahead[likeliest]

    found = replace(_of("axes", number), axes=AXES[1 + _simplest(scores_of(AXES[1:]))])
    yield found, len(AXES) - 1, ahead_of(found, np.ones(1))[0]
    factors = _FACTORS[:, np.newaxis, np.newaxis]
    factor = _simplest(scores_of(factors * AXES[0]))
    found, ahead = refined(replace(_of("scale", number), factor=float(_FACTORS[factor])))
    yield found, _FACTORS.size, ahead
    if unrelated:
        both = np.array([scores_of(factors * each) for each in AXES[1:]])
        axes, factor = divmod(_simplest(both.ravel()), _FACTORS.size)
        found, ahead = refined(replace(_of("axes_and_scale", number), factor=float(_FACTORS[factor]),
                                       axes=AXES[1 + axes]))
        yield found, both.size, ahead


def _mapped(maps: Array, rates: Array) -> Array:
    """Rates (windows, steps, 3) under maps (m, 3, 3): (m, windows, steps, 3)."""
    return np.asarray(np.einsum("mij,wsj->mwsi", maps, rates))


def _simplest(scores: Array) -> int:
    """The first that is as likely as the likeliest: motion about one axis leaves the others open."""
    return int(np.flatnonzero(scores <= scores.min() + _NO_BETTER)[0])


def _squares(rates: Array, acc: Array, step_s: float, variance: Array) -> Array:
    """Mean square deviation of gravity in windows that rates turn into one frame, in variances.

    It is the greater of the deviations of short and of long means; the loss of gravity's length in a mean
    counts too.

    Parameters
    ----------
    rates, acc: (m, windows, steps, 3) and (windows, steps, 3), rad/s and multiples of gravity.
    variance: (2, windows), rad^2.

    Returns (m, windows).
    """
    turns = np.moveaxis(rates, 2, 0) * step_s
    angle = np.linalg.norm(turns, axis=-1, keepdims=True)
    steps = np.concatenate([np.cos(0.5 * angle), 0.5 * np.sinc(angle / (2.0 * np.pi)) * turns], axis=-1)
    here = np.broadcast_to([1.0, 0.0, 0.0, 0.0], steps.shape[1:])
    most = _MEANS[0][0]
    means = np.zeros((most, *turns.shape[1:]))
    each = len(steps) // most
    for number, step in enumerate(steps):
        then = multiply(here, step)
        means[number // each] += rotate(normalized(here + then), acc[:, number]) / each
        here = then
    found = []
    for (parts, _), own in zip(_MEANS, variance, strict=True):
        part = means.reshape(parts, most // parts, *means.shape[1:]).mean(axis=1)
        # Rates that are far too fast rotate gravity many times, until its mean vanishes.
        short = np.maximum(0.0, 1.0 - np.linalg.norm(part, axis=-1))
        apart = np.sum((part - part.mean(axis=0))**2, axis=-1)
        found.append(np.mean(apart + short**2, axis=0) / own)
    return np.asarray(np.maximum(*found))


def unjudged_text(recording: MotionRecording, found: Sequence[Agreement]) -> str:
    """Text on sensors whose agreement could not be judged; empty for none."""
    unjudged = [(name, each.factor) for name, each in zip(recording.sensors, found, strict=True)
                if each.verdict == "no_information"]
    if not unjudged:
        return ""
    likelier = [(name, factor) for name, factor in unjudged if factor != 1.0]
    factors, better = [factor for _, factor in likelier], ""
    if likelier and max(factors) < _SAME_LIKELIER * min(factors):
        better = (f"; {_names([name for name, _ in likelier])}: {np.median(factors):.2g} times these rates "
                  "would explain it better: check `rate`, `units.gyr` and the gyroscopes' range")
    return f"rates could not be checked against gravity in {len(unjudged)} of {len(found)} sensors " \
           f"({_names([name for name, _ in unjudged])}): too little or too rough motion; rate, units and " \
           f"axes are as stated{better}"


def agreements_in(
    recording: MotionRecording, first: int = 0, stop: int | None = None
) -> tuple[Agreement, ...]:
    """The agreement of each sensor of a recording, from samples `first` to `stop`."""
    part = slice(first, stop)
    return agreements(recording.stamps_ns[part] / NS_PER_S, recording.gyr[part], recording.acc[part])


def disagreement_text(recording: MotionRecording, found: Sequence[Agreement]) -> str:
    """Text on sensors whose rates do not explain the rotation of gravity, with remedies; empty for none."""
    scaled = [each.factor for each in found if each.verdict == "scale"]
    common = float(np.median(scaled)) if scaled and max(scaled) < _SAME_FACTOR * min(scaled) and not any(
        each.verdict == "agrees" for each in found) else None
    sensors_of: dict[str, list[str]] = {}
    for name, each in zip(recording.sensors, found, strict=True):
        if each.doubtful:
            sensors_of.setdefault(_reason(recording, each, common), []).append(name)
    return "; ".join(f"{_names(names)}: rates do not explain how gravity turns, "
                     f"{reason.replace(_OWN, names[0] if len(names) == 1 else 'NAME')}"
                     for reason, names in sensors_of.items())


def _names(names: Sequence[str]) -> str:
    more = f" and {len(names) - _MOST_NAMED} sensors more" if len(names) > _MOST_NAMED else ""
    return ", ".join(names[:_MOST_NAMED]) + more


def _reason(recording: MotionRecording, found: Agreement, common: float | None) -> str:
    """Explanation of a disagreement, and the key of a layout to change; `common`: factor of all that turn."""
    if found.verdict == "exchange":
        other = recording.sensors[found.other]
        return f"those of {other} do: exchange `sensors.{_OWN}.gyr` and `sensors.{other}.gyr` in the layout"
    if found.verdict == "disagrees":
        return (f"nor does any order, sign or scale of them: check `sensors.{_OWN}.gyr` and `.acc`, "
                "`units.gyr`, and `rate` or `time` in the layout")
    reasons = [_axes_reason(found.axes)] if "axes" in found.verdict else []
    reasons += [_scale_reason(recording, found.factor, common)] if "scale" in found.verdict else []
    return "; and ".join(reasons)


def _axes_reason(axes: Array) -> str:
    order = ", ".join("-"[:bool(row.min() < 0.0)] + "xyz"[int(np.argmax(np.abs(row)))] for row in axes)
    listed = order.replace("-", "")
    swapped = bool((axes <= 0.0).all() and np.linalg.det(axes) > 0.0)
    key = f"`sensors.{_OWN}.{'acc' if swapped else 'gyr'}`"
    says = f"({order}) in place of (x, y, z) does"
    if swapped:
        return f"{says}, as where `acc` is swapped: list the columns of {key} as {listed} in the layout"
    if (axes >= 0.0).all():
        return f"{says}: list the columns of {key} as {listed} in the layout"
    if listed == "x, y, z":
        return f"{says}: change the signs of the columns of {key} in the file"
    return f"{says}: list the columns of {key} as {listed} in the layout, and change the signs in the file"


def _scale_reason(recording: MotionRecording, factor: float, common: float | None) -> str:
    """Explanation of a factor: of all sensors it is one of units or of time, of one sensor its own."""
    every = common is not None or len(recording.sensors) == 1
    factor = factor if common is None else common
    says = f"{factor:.3g} times these rates do"
    near = [unit for unit, value in (("rad/s", DEGREES), ("deg/s", 1.0 / DEGREES))
            if abs(np.log(factor / value)) < np.log(_SAME_FACTOR)]
    if near and every:
        return f'{says}: set `units.gyr = "{near[0]}"` in the layout'
    if near:
        return f"{says}: they are in {near[0]}, and `units.gyr` in the layout says otherwise of all sensors"
    if every:
        stated = pace_of(recording.stamps_ns / NS_PER_S).rate_hz
        return (f"{says}, of all that turn: check `rate` in the layout, about {stated / factor:.3g} Hz in "
                f"place of {stated:.4g}, or `units.time`, or the gyroscopes' range")
    return f"{says}: scale its columns in the file by its gyroscope's range"
