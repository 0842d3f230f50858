"""How stimulated arms respond to pulses: recruitment, delay and activation, of a person and of a population.

Recruitment of the muscles under an electrode is the normal distribution function of (ln I - ln threshold) /
spread, I the effective current: current over 1 + chronaxie / pulse width. Activation follows it after a delay
as a critically damped second order. A population holds estimates of single people, so that one of them can be
left out, and pools them by a model of three variances: between people, among muscles, and what is left.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import ndtr, ndtri

Array = NDArray[np.float64]
CHAIN_S = 0.0475
"""Mean delay of the recordings' laboratory: 0 to 50 ms until a thread sends the newest width, 10 ms on a
serial line, 0 to 25 ms until the next pulse."""
FRICTION_NM = (0.36, 0.05, 0.03, 0.03)
"""Dry friction of the recordings' exoskeleton, by joint, from its steps."""
CHRONAXIE_US = {"biceps": 97.0, "pronator teres": 157.0, "extensor carpi radialis longus": 119.0}
"""Chronaxies of one person, each from a strength-duration curve."""
OTHER_CHRONAXIE_US = 122.0
"""Chronaxie of other muscles (chosen: the geometric mean of these)."""
_PRIOR_SD = 0.5
"""Prior scale of both standard deviations of a pool, half-normal (chosen; delays in units of
`DELAY_UNIT_S`)."""
DELAY_UNIT_S = 0.05
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
    mean: of all. between: sd between people. among: sd among muscles. within: sd of what is left.
    muscles: by name, what the muscle adds to the mean, and its sd.
    """

    mean: float
    between: float
    among: float
    within: float
    muscles: Mapping[str, tuple[float, float]]

    def of(self, electrode: str) -> tuple[float, float]:
        """Mean of a muscle over people, and sd of what is not known of it."""
        added, sd = self.muscles.get(electrode, (0.0, self.among))
        return self.mean + added, sd

    def drawn(self, electrodes: Sequence[str], rng: np.random.Generator) -> Array:
        """The number in each muscle (muscles,) of a random person."""
        known = np.array([self.of(name) for name in electrodes])
        scatter = np.hypot(self.within, known[:, 1]) * rng.normal(size=len(electrodes))
        return np.asarray(known[:, 0] + self.between * rng.normal() + scatter)

    def middle(self, electrodes: Sequence[str]) -> Array:
        """The number in each muscle (muscles,) of a person in the middle."""
        return np.array([self.of(name)[0] for name in electrodes])


class ArmResponse(NamedTuple):
    """Response of a person's muscles.

    Attributes
    ----------
    electrodes: names (e,).
    delay_s, frequency_rad_s: of all muscles, the mean (of logarithms) of theirs.
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

    def pulse_width_s(self, shares: Array, current_a: float | Array) -> Array:
        """Pulse widths (e,) that recruit `shares` (e,) at a current; infinite where none does."""
        effective = 1e-3 * self.threshold_ma * np.exp(self.spread * ndtri(shares))
        room = np.asarray(current_a - effective)
        return np.where(room > 0.0, self.chronaxie_s * effective / np.where(room > 0.0, room, 1.0), np.inf)


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
        rows = np.array([[each.response.delay_s / DELAY_UNIT_S, np.log(each.response.frequency_rad_s),
                          each.response.highest, np.log(each.response.spread)] for each in estimates])
        sd[:, 0] /= DELAY_UNIT_S
        muscles = [each.response.electrode for each in estimates]
        self.delay, self.log_frequency, self.highest, self.log_spread = (
            pooled(rows[:, k], sd[:, k], people, muscles) for k in range(4))
        known = sorted({each.electrode for each in widths})
        logs = np.array([each.log_highest for each in widths])
        self.log_highest = {name: float(np.mean([each.log_highest for each in widths
                                                 if each.electrode == name])) for name in known}
        left = logs - np.array([self.log_highest[each.electrode] for each in widths])
        self.widths_pool = pooled(left, np.zeros(len(left)), [each.person for each in widths],
                                  [each.electrode for each in widths])
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
        return self._of(electrodes, *(pool.middle(electrodes) for pool in self._pools))

    def drawn(self, electrodes: Sequence[str], rng: np.random.Generator) -> ArmResponse:
        """A random person."""
        return self._of(electrodes, *(pool.drawn(electrodes, rng) for pool in self._pools))

    @property
    def _pools(self) -> tuple[Pool, ...]:
        return self.delay, self.log_frequency, self.highest, self.log_spread, self.widths_pool

    def _of(self, electrodes: Sequence[str], delay: Array, log_frequency: Array, highest: Array,
            log_spread: Array, widths: Array) -> ArmResponse:
        spread = np.maximum(np.exp(log_spread), _LEAST_SPREAD)
        overall = float(np.mean(list(self.log_highest.values())))
        logs = widths + [self.log_highest.get(name, overall) for name in electrodes]
        return ArmResponse(
            tuple(electrodes), max(float(delay.mean()) * DELAY_UNIT_S, _LEAST_DELAY_S),
            float(np.exp(log_frequency.mean())),
            np.exp(logs - spread * highest), spread, np.array([chronaxie_s(name) for name in electrodes]),
            np.asarray(ndtr(highest)), np.asarray(ndtr(highest - self.log_range / spread)))


def pooled(values: Array, sds: Array, people: Sequence[str], muscles: Sequence[str]) -> Pool:
    """Mean and standard deviations of estimates (n,) with errors `sds` (n,), each of a person's muscle.

    Standard deviations have the greatest posterior density: restricted likelihood times half-normal priors
    of scale `_PRIOR_SD`; the mean is that of generalised least squares, what muscles add the best linear
    prediction.
    """
    person, muscle = (np.equal.outer(np.array(names), np.array(names)).astype(float)
                      for names in (people, muscles))

    def total_of(variances: Array) -> Array:
        between, among, within = variances
        return np.asarray(between * person + among * muscle + np.diag(within + sds**2))

    def mean_of(total: Array) -> tuple[float, float]:
        weights = np.linalg.solve(total, np.ones(len(values)))
        return float(weights @ values / weights.sum()), float(weights.sum())

    def cost(logs: Array) -> float:
        variances = np.exp(2.0 * logs)
        total = total_of(variances)
        mean, weight = mean_of(total)
        left = values - mean
        fit = np.linalg.slogdet(total)[1] + np.log(weight) + left @ np.linalg.solve(total, left)
        return float(0.5 * fit + 0.5 * variances.sum() / _PRIOR_SD**2)

    found = minimize(cost, np.log([0.2, 0.2, 0.2]), method="Nelder-Mead", bounds=[(-5.0, 2.0)] * 3)
    variances = np.exp(2.0 * found.x)
    total = total_of(variances)
    mean, _ = mean_of(total)
    added = {}
    for name in sorted(set(muscles)):
        own = variances[1] * np.equal(np.array(muscles), name)
        solved = np.linalg.solve(total, np.column_stack([own, values - mean]))
        added[name] = (float(own @ solved[:, 1]), float(np.sqrt(max(variances[1] - own @ solved[:, 0], 0.0))))
    between, among, within = np.sqrt(variances)
    return Pool(mean, float(between), float(among), float(within), added)


def _short(values: Sequence[float]) -> list[float]:
    return [float(f"{value:.4g}") for value in values]
