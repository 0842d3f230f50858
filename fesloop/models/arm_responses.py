"""How stimulated arms respond to pulses: recruitment, delay and activation, of a person and of a population.

Recruitment of the muscles under an electrode is the normal distribution function of (ln I - ln threshold) /
spread, I the effective current: current over 1 + chronaxie / pulse width. Activation follows it after a delay
as a critically damped second order. A population holds estimates of single people, so that one of them can be
left out, and pools them by a model of two variances: between people, and within.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from functools import cache
from importlib.resources import files
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import ndtr

Array = NDArray[np.float64]
CHAIN_S = 0.0475
"""Mean delay of the recordings' laboratory: 0 to 50 ms until a thread sends the newest width, 10 ms on a
serial line, 0 to 25 ms until the next pulse."""
FRICTION_NM = (0.36, 0.05, 0.03, 0.03)
"""Dry friction of the recordings' exoskeleton, by joint, from its steps."""
CHRONAXIE_US = {"biceps": 97.0, "pronator teres": 157.0, "extensor carpi radialis longus": 119.0}
"""Of one person, by a strength-duration curve each."""
OTHER_CHRONAXIE_US = 122.0
"""Of other muscles (chosen: the geometric mean of these)."""
_PRIOR_SD = 0.5
"""Of both standard deviations of a pool, half-normal (chosen; delays in units of `_DELAY_UNIT_S`)."""
_DELAY_UNIT_S = 0.05
_LEAST_DELAY_S, _LEAST_SPREAD = 0.005, 0.03
"""Least values of random people (chosen)."""


def chronaxie_s(electrode: str) -> float:
    """Chronaxie of the muscle under an electrode, s."""
    return 1e-6 * CHRONAXIE_US.get(electrode, OTHER_CHRONAXIE_US)


def effective_a(current_a: float | Array, pulse_width_s: Array, chronaxie_s: float | Array) -> Array:
    """Effective current: current over 1 + chronaxie / pulse width (Lapicque); 0 at no width."""
    return np.asarray(current_a * pulse_width_s / (pulse_width_s + chronaxie_s))


class Response(NamedTuple):
    """Response of one muscle of one person, as estimated from one course.

    Attributes
    ----------
    person, electrode: names.
    delay_s: from pulse to torque. frequency_rad_s: natural frequency of activation.
    highest: probit of the share that the highest pulse width recruits.
    spread: of the logarithm of effective current. threshold_ma: effective current that recruits half.
    """

    person: str
    electrode: str
    delay_s: float
    frequency_rad_s: float
    highest: float
    spread: float
    threshold_ma: float


class Widths(NamedTuple):
    """Usable pulse widths of a muscle of one person, as found before a recording.

    Attributes
    ----------
    person, electrode: names.
    log_highest: ln of the effective current, mA, at the highest width.
    log_range: ln of its ratio to that at the lowest width.
    """

    person: str
    electrode: str
    log_highest: float
    log_range: float


class Estimate(NamedTuple):
    """A `Response`, and the standard deviations of delay, s, of the logarithm of natural frequency, of
    `highest`, and of the logarithm of spread."""

    response: Response
    sd: tuple[float, float, float, float]


class Pool(NamedTuple):
    """Normal distribution of a number over people and their muscles.

    Attributes
    ----------
    mean: of all. between: sd between people. within: sd between muscles of a person.
    """

    mean: float
    between: float
    within: float

    def drawn(self, muscles: int, rng: np.random.Generator) -> Array:
        """The number in each muscle (muscles,) of a random person."""
        return np.asarray(self.mean + self.between * rng.normal() + self.within * rng.normal(size=muscles))


class ArmResponse(NamedTuple):
    """Response of a person's muscles.

    Attributes
    ----------
    electrodes: names (e,).
    delay_s, frequency_rad_s: of all muscles.
    threshold_ma, spread, chronaxie_s: (e,), of recruitment.
    highest: (e,), share that the highest usable pulse width recruits; torques of a person are those at it.
    lowest: (e,), share that the lowest recruits.
    """

    electrodes: tuple[str, ...]
    delay_s: float
    frequency_rad_s: float
    threshold_ma: Array
    spread: Array
    chronaxie_s: Array
    highest: Array
    lowest: Array


class ArmResponses:
    """A population of responses.

    Parameters
    ----------
    estimates: of single courses. widths: usable pulse widths.
    """

    def __init__(self, estimates: Sequence[Estimate], widths: Sequence[Widths]) -> None:
        self.estimates, self.widths = tuple(estimates), tuple(widths)
        people = [each.response.person for each in estimates]
        sd = np.array([each.sd for each in estimates])
        rows = np.array([[each.response.delay_s / _DELAY_UNIT_S, np.log(each.response.frequency_rad_s),
                          each.response.highest, np.log(each.response.spread)] for each in estimates])
        sd[:, 0] /= _DELAY_UNIT_S
        self.delay, self.log_frequency, self.highest, self.log_spread = (
            pooled(rows[:, k], sd[:, k], people) for k in range(4))
        known = sorted({each.electrode for each in widths})
        logs = np.array([each.log_highest for each in widths])
        self.log_highest = {name: float(np.mean([each.log_highest for each in widths
                                                 if each.electrode == name])) for name in known}
        left = logs - np.array([self.log_highest[each.electrode] for each in widths])
        self.widths_pool = pooled(left, np.zeros(len(left)), [each.person for each in widths])
        self.log_range = float(np.mean([each.log_range for each in widths]))

    @classmethod
    @cache
    def shipped(cls) -> ArmResponses:
        """The population of seven able-bodied people (docs/models/people.md)."""
        document = json.loads((files(__package__) / "arm_responses.json").read_text("utf-8"))
        return cls([Estimate(Response(*each[:7]), tuple(each[7:])) for each in document["estimates"]],
                   [Widths(*each) for each in document["widths"]])

    @property
    def people(self) -> tuple[str, ...]:
        """Names of those whose recordings it comes from."""
        return tuple(sorted({each.response.person for each in self.estimates}
                            | {each.person for each in self.widths}))

    def as_document(self) -> dict[str, object]:
        """Plain lists and numbers, of four digits."""
        return {"estimates": [[*each.response[:2], *_short(each.response[2:]), *_short(each.sd)]
                              for each in self.estimates],
                "widths": [[*each[:2], *_short(each[2:])] for each in self.widths]}

    def without(self, people: Collection[str]) -> ArmResponses:
        """The population of the others."""
        return ArmResponses([each for each in self.estimates if each.response.person not in people],
                            [each for each in self.widths if each.person not in people])

    def middle(self, electrodes: Sequence[str]) -> ArmResponse:
        """A person in the middle of the population."""
        count = len(electrodes)
        return self._of(electrodes, self.delay.mean, self.log_frequency.mean,
                        np.full(count, self.highest.mean), np.full(count, self.log_spread.mean),
                        np.full(count, self.widths_pool.mean))

    def drawn(self, electrodes: Sequence[str], rng: np.random.Generator) -> ArmResponse:
        """A random person."""
        count = len(electrodes)
        delay, frequency = (float(np.mean(pool.drawn(count, rng)))
                            for pool in (self.delay, self.log_frequency))
        return self._of(electrodes, delay, frequency, self.highest.drawn(count, rng),
                        self.log_spread.drawn(count, rng), self.widths_pool.drawn(count, rng))

    def _of(self, electrodes: Sequence[str], delay: float, log_frequency: float, highest: Array,
            log_spread: Array, widths: Array) -> ArmResponse:
        spread = np.maximum(np.exp(log_spread), _LEAST_SPREAD)
        overall = float(np.mean(list(self.log_highest.values())))
        logs = widths + [self.log_highest.get(name, overall) for name in electrodes]
        return ArmResponse(
            tuple(electrodes), max(delay * _DELAY_UNIT_S, _LEAST_DELAY_S), float(np.exp(log_frequency)),
            np.exp(logs - spread * highest), spread, np.array([chronaxie_s(name) for name in electrodes]),
            np.asarray(ndtr(highest)), np.asarray(ndtr(highest - self.log_range / spread)))


def pooled(values: Array, sds: Array, people: Sequence[str]) -> Pool:
    """Mean and standard deviations, between and within people, of estimates (n,) with errors `sds` (n,).

    Standard deviations have the greatest posterior density: restricted likelihood times half-normal priors
    of scale `_PRIOR_SD`; the mean is that of generalised least squares.
    """
    same = np.equal.outer(np.array(people), np.array(people)).astype(float)

    def solved(logs: Array) -> tuple[float, float]:
        between, within = np.exp(2.0 * logs)
        total = between * same + np.diag(within + sds**2)
        ones = np.linalg.solve(total, np.ones(len(values)))
        mean = float(ones @ values / ones.sum())
        left = values - mean
        cost = 0.5 * (np.linalg.slogdet(total)[1] + np.log(ones.sum()) + left @ np.linalg.solve(total, left))
        return mean, float(cost + 0.5 * (between + within) / _PRIOR_SD**2)

    def cost(logs: Array) -> float:
        return solved(logs)[1]

    found = minimize(cost, np.log([0.2, 0.2]), method="Nelder-Mead", bounds=[(-5.0, 2.0)] * 2)
    between, within = np.exp(found.x)
    return Pool(solved(found.x)[0], float(between), float(within))


def _short(values: Sequence[float]) -> list[float]:
    return [float(f"{value:.4g}") for value in values]
