"""Elements of the arrays, their currents and the model of a task, from a sweep over all elements.

A sweep shows by how much each element moves the hand at each current. Responses of several elements are taken
to add up. Of all elements, those channels are chosen whose recruited fractions v, from 0 to a posture's most,
bring the hand nearest to each posture of the task,

    min over v of |W (K v - (q - q_rest))|^2 + |effort * v|^2,

added up over postures: greedily, then by exchange. K holds the gains of the recruitment curves that are
fitted to each element's responses. The dynamics of all channels are those of stimulated muscle, critically
damped, and one lag of each output, which is fitted to the course of the sweep. What contractions at one time
do to each other is not in it: a controller that learns from trial to trial makes it good.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear
from scipy.special import ndtr

from fesloop.errors import InputError
from fesloop.models.linear_model import LinearModel, Recruitment
from fesloop.models.patient_model import LEAST_FIT

Array = NDArray[np.float64]
CHRONAXIE_US = 122.0
"""Chronaxie of motor nerves (as in `controllers.identification.patient_model`)."""
_THRESHOLDS = np.geomspace(2.0, 60.0, 80)
_SPREADS = (0.3, 0.45, 0.6)
"""Effective currents that recruit half, mA, and spreads that are tried (chosen: of stimulated people)."""
_ABOVE_HALF = 1.0
"""Sds of log thresholds above half of recruitment that a pulse of 400 us recruits: 84 % (chosen on pilots:
with more current a few us decide about a posture, with less nothing is left against fatigue)."""
_WIDEST = 1.3
"""Current over the effective one at a pulse of 400 us: (400 + chronaxie) / 400."""
_NATURAL_RAD_S, _DELAY_NS = 16.0, 50_000_000
"""Natural frequency of stimulated muscle, and its delay with the loop's (chosen: of identified models)."""
LAGS_S = (0.05, 0.08, 0.12, 0.17, 0.25, 0.35, 0.5)
"""Lags of an output that are tried, s."""
_LEAST_DEG = 6.0
"""Gain below which an element is no candidate (chosen: above errors of a tracker)."""
_EFFORT_DEG = 4.0
"""Error that whole recruitment at 6 mA of threshold is worth (chosen)."""
_GAINED = 0.5
"""Least decrease of the cost, deg^2, for an exchange (chosen)."""
_TENODESIS = 0.27
"""Flexion of relaxed fingers over extension of the wrist (chosen: passive tendons)."""
_CLOSES_DEG = 8.0
"""Flexion of a finger or the thumb, beyond tenodesis, from which a channel closes the hand (chosen)."""
_MOVES_WRIST_DEG, _ALONE = 15.0, 0.25
"""Extension or flexion of the wrist of a channel that is the wrist's, and the greatest share of it by which
it moves fingers beyond tenodesis (chosen)."""
WRIST, THUMB = "wrist_extension", "thumb_flexion"


@dataclass(frozen=True, slots=True, kw_only=True)
class Posture:
    """A posture of a task.

    Attributes
    ----------
    name: for reports.
    deg: angles by output; others stay as at rest.
    most: greatest part of what a pulse of 400 us recruits: what is left makes up for fatigue and for what
        does not add up.
    weight: of its error.
    """

    name: str
    deg: Mapping[str, float]
    most: float
    weight: float = 1.0


_FINGERS = ("F2_flexion", "F3_flexion", "F4_flexion", "F5_flexion")
OPENED_DEG, OPENED_LIMITS_DEG = 18.0, (-30.0, 60.0)
"""Flexion of the fingers of the opened hand: of the shipped grasps, and what may be asked for (chosen)."""


def grasp_task(opened_deg: float = OPENED_DEG) -> tuple[Posture, ...]:
    """A hand that opens to this flexion of its fingers, that closes, and that presses on an object.

    Raises InputError for a flexion beyond what a hand may be asked for.
    """
    low, high = OPENED_LIMITS_DEG
    if not low <= opened_deg <= high:
        raise InputError("opened_deg", f"{opened_deg:g}", f"{low:g} to {high:g} deg of finger flexion")
    return (
        Posture(name="opened", deg={WRIST: 25.0, **dict.fromkeys(_FINGERS, opened_deg)}, most=0.6),
        Posture(name="closed", deg={WRIST: 25.0, **dict.fromkeys(_FINGERS, 80.0), THUMB: 30.0}, most=0.6),
        Posture(name="pressing", deg={WRIST: 25.0, **dict.fromkeys(_FINGERS, 105.0), THUMB: 45.0}, most=0.9,
                weight=0.5))


GRASP = grasp_task()
WEIGHTS = {WRIST: 1.0, **dict.fromkeys(_FINGERS, 0.5), THUMB: 0.7}
"""Weights of the outputs' errors (chosen: the wrist carries all fingers)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Responses:
    """Responses of n elements to k currents, in m outputs.

    Attributes
    ----------
    currents_ma: (k,); width_us: of the pulses.
    moved: (n, k, m), rad, change at the end of each current; NaN where it was not given.
    rest: (m,), rad, posture before a turn: the median.
    outputs: names of the outputs.
    """

    currents_ma: Array
    width_us: float
    moved: Array
    rest: Array
    outputs: tuple[str, ...]

    @property
    def effective_ma(self) -> Array:
        """Effective currents (k,): those of endless pulses."""
        return self.currents_ma * self.width_us / (self.width_us + CHRONAXIE_US)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Curve:
    """Recruitment curve of an element, and the change of the outputs at whole recruitment.

    Attributes
    ----------
    threshold_ma, spread: as in `Recruitment`; gain: (m,), rad.
    fit_percent: 100 (1 - |left| / |responses|), each current predicted from the others.
    """

    threshold_ma: float
    spread: float
    gain: Array
    fit_percent: float

    @property
    def current_ma(self) -> float:
        """Current at which a pulse of 400 us recruits 84 %, in steps of .5 mA."""
        return round(2.0 * _WIDEST * self.threshold_ma * math.exp(_ABOVE_HALF * self.spread)) / 2.0

    @property
    def at_bound(self) -> dict[str, str]:
        """The ends of the tried values that half_ma (threshold) or spread lies at: "or less" or "or more"."""
        ends = {name: "or less" if value <= tried[0] else "or more" if value >= tried[-1] else ""
                for name, value, tried in (("half_ma", self.threshold_ma, _THRESHOLDS),
                                           ("spread", self.spread, _SPREADS))}
        return {name: end for name, end in ends.items() if end}


def curve_of(effective_ma: Array, moved: Array) -> Curve:
    """Fit the curve of one element to its responses `moved` (k, m), rad, NaN where there is none."""
    known = np.isfinite(moved).all(axis=1)
    effective, seen = effective_ma[known], moved[known]
    fractions = np.array([ndtr(np.log(effective / threshold) / spread)
                          for spread in _SPREADS for threshold in _THRESHOLDS])

    def best(use: NDArray[np.bool_]) -> tuple[int, Array]:
        f, y = fractions[:, use], seen[use]
        gains = f @ y / (np.sum(f * f, axis=1) + 1e-3)[:, np.newaxis]
        left = (np.sum(y * y) - 2.0 * np.sum(gains * (f @ y), axis=1)
                + np.sum(gains * gains, axis=1) * np.sum(f * f, axis=1) + 1e-3 * np.sum(gains**2, axis=1))
        chosen = int(np.argmin(left))
        return chosen, gains[chosen]

    chosen, gain = best(np.ones(len(seen), dtype=bool))
    missed = 0.0
    for k in range(len(seen)):
        other, told = best(np.arange(len(seen)) != k)
        missed += float(np.sum((seen[k] - fractions[other, k] * told) ** 2))
    total = float(np.sum(seen**2))
    spread, threshold = divmod(chosen, len(_THRESHOLDS))
    return Curve(threshold_ma=float(_THRESHOLDS[threshold]), spread=_SPREADS[spread], gain=gain,
                 fit_percent=100.0 * (1.0 - math.sqrt(missed / total)) if total > 0.0 else 0.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Choice:
    """Elements of the channels.

    Attributes
    ----------
    elements: (channels,), number of each channel's element.
    curves: of these. currents_ma: of the channels.
    missed_deg: (postures, m), error that is left in each posture.
    closing: channels that close the hand; grasping: all but those that move the wrist alone.
    """

    elements: tuple[int, ...]
    curves: tuple[Curve, ...]
    currents_ma: tuple[float, ...]
    missed_deg: Array
    closing: tuple[int, ...]
    grasping: tuple[int, ...]


def choose_elements(
    seen: Responses, channels: int, greatest_ma: float, task: Sequence[Posture] = GRASP,
    weights: Mapping[str, float] = WEIGHTS,
) -> Choice:
    """Choose one element for each channel.

    Parameters
    ----------
    greatest_ma: greatest current of a channel; elements that would need more have less strength.
    task, weights: postures, and weights of errors by output (others: .5).

    Raises InputError where fewer elements than channels move the hand.
    """
    curves = [curve_of(seen.effective_ma, moved) for moved in seen.moved]
    gains = np.degrees([_reached(curve, greatest_ma) * curve.gain for curve in curves])
    candidates = [e for e, curve in enumerate(curves)
                  if np.abs(gains[e]).max() >= _LEAST_DEG and curve.fit_percent >= LEAST_FIT]
    if len(candidates) < channels:
        raise InputError("elements", f"{len(candidates)} of {len(curves)} move the hand by more than "
                         f"{_LEAST_DEG:g} deg, as their current rises", f"{channels}, one a channel",
                         "more current, fewer channels, or other places of the arrays")
    weight = np.array([weights.get(name, 0.5) for name in seen.outputs])
    rest = np.degrees(seen.rest)
    wanted = [np.array([posture.deg.get(name, at) - at for name, at in zip(seen.outputs, rest, strict=True)])
              for posture in task]
    effort = np.array([0.5 + curve.threshold_ma / 12.0 for curve in curves])

    def solved(elements: Sequence[int], posture: Posture, want: Array) -> tuple[float, Array]:
        chosen = list(elements)
        rows = np.vstack([weight[:, np.newaxis] * gains[chosen].T, np.diag(_EFFORT_DEG * effort[chosen])])
        found = lsq_linear(rows, np.concatenate([weight * want, np.zeros(len(chosen))]),
                           bounds=(0.0, posture.most), method="bvls")
        return 2.0 * posture.weight * float(found.cost), gains[chosen].T @ found.x - want

    def cost(elements: Sequence[int]) -> float:
        return sum(solved(elements, posture, want)[0] for posture, want in zip(task, wanted, strict=True))

    elements: list[int] = []
    while len(elements) < channels:
        elements.append(min((e for e in candidates if e not in elements), key=lambda e: cost([*elements, e])))
    least, improved = cost(elements), True
    while improved:
        improved = False
        for i in range(channels):
            trials = [[*elements[:i], e, *elements[i + 1:]] for e in candidates if e not in elements]
            best = min(trials, key=cost, default=elements)
            if (now := cost(best)) < least - _GAINED:
                elements, least, improved = best, now, True
    missed = np.array([solved(elements, posture, want)[1]
                       for posture, want in zip(task, wanted, strict=True)])
    closing, grasping = _roles(gains[elements], seen.outputs)
    return Choice(elements=tuple(elements), curves=tuple(curves[e] for e in elements), missed_deg=missed,
                  currents_ma=tuple(min(curves[e].current_ma, greatest_ma) for e in elements),
                  closing=closing, grasping=grasping)


def _reached(curve: Curve, greatest_ma: float) -> float:
    """Fraction that a pulse of 400 us recruits at the channel's current."""
    effective = min(curve.current_ma, greatest_ma) / _WIDEST
    return float(ndtr(math.log(effective / curve.threshold_ma) / curve.spread))


def _roles(gains: Array, outputs: Sequence[str]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Channels that close the hand, and those that move more than the wrist; gains (channels, m), deg."""
    wrist = gains[:, outputs.index(WRIST)] if WRIST in outputs else np.zeros(len(gains))
    fingers = [i for i, name in enumerate(outputs) if name != WRIST]
    alone = gains[:, fingers] - _TENODESIS * wrist[:, np.newaxis]
    closes = (alone.max(axis=1) >= _CLOSES_DEG) & (alone.mean(axis=1) > 0.0)
    of_wrist = ~closes & (np.abs(wrist) >= _MOVES_WRIST_DEG) & (
        np.abs(alone).mean(axis=1) < _ALONE * np.abs(wrist))
    return tuple(np.flatnonzero(closes).tolist()), tuple(np.flatnonzero(~of_wrist).tolist())


def model_of(choice: Choice, rest: Array, lags_s: Array) -> LinearModel:
    """Model of the channels with a lag (m,), s, of each output about the posture `rest` (m,), rad."""
    channels, outputs = len(choice.elements), len(rest)
    size, first = 2 * channels + outputs, 2 * channels
    a, b, c = np.zeros((size, size)), np.zeros((size, channels)), np.zeros((outputs, size))
    for i, curve in enumerate(choice.curves):
        a[2 * i, 2 * i + 1] = 1.0
        a[2 * i + 1, 2 * i:2 * i + 2] = -_NATURAL_RAD_S**2, -2.0 * _NATURAL_RAD_S
        b[2 * i + 1, i] = _NATURAL_RAD_S**2
        a[first:, 2 * i] = curve.gain / lags_s
    for row in range(outputs):
        a[first + row, first + row], c[row, first + row] = -1.0 / lags_s[row], 1.0
    return LinearModel(a=a, b=b, c=c, offset=rest, delay_ns=_DELAY_NS, recruitment=Recruitment(
        threshold_ma=tuple(curve.threshold_ma for curve in choice.curves),
        spread=tuple(curve.spread for curve in choice.curves), chronaxie_us=CHRONAXIE_US))
