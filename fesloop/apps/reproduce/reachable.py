"""Lower bound of a patient's tracking error under any stimulation: the reachable floor.

Surface stimulation cannot control every joint. For a given reference, the best admissible pulse widths are
computed offline on the simulated plant itself, without noise and without an object; the remaining error is
not due to a controller of these channels and currents. The result is an upper bound of the true floor: the
search is local, knots are `SPACING_S` apart, stimulation changes from `LEAD_S` before the window on, and
axons fire one by one, which leaves some tenths of a degree. The difference between searches from several
starts (`Floor.spread_deg`) tells how tight it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.chain_slopes import ChainSlopes
from fesloop.apps.reproduce.open_chain import OpenChain
from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.running import Experiment
from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
UNIT_S = 100e-6
"""Unit of the changes of pulse width (chosen to make them about 1)."""
_DAMPING, _LESS, _MORE, _MOST = 1e-2, 0.3, 5.0, 1e3
"""Initial damping relative to the mean curvature; its factors after a successful and a failed step; its limit
(chosen)."""
_TOLERANCE = 0.01
"""Share by which the error must fall in `_PATIENCE` steps to continue (chosen)."""
_PATIENCE = 3
_NEWTON_STEPS, _STATIONARY = 60, 1e-6
"""Largest number of steps, and tolerance, of one bounded least squares (chosen: it ends after some ten)."""


class Descent(NamedTuple):
    """Result of a descent.

    Attributes
    ----------
    widths: (ticks, channels), s. course: (ticks - first, m), rad.
    rmse_rad: over the window, at the start and after each step that helped.
    settled: whether it ended because the error no longer fell.
    """

    widths: Array
    course: Array
    rmse_rad: tuple[float, ...]
    settled: bool


class Aim(NamedTuple):
    """The reference to be followed.

    Attributes
    ----------
    reference: (ticks, m), rad. first, begin: ticks from which on widths may change, and errors count.
    """

    reference: Array
    first: int
    begin: int

    def errors(self, course: Array) -> Array:
        """Errors (ticks - begin, m) of a course from tick `first` on."""
        return self.reference[self.begin:] - course[self.begin - self.first:]


def hats(ticks: int, first: int, spacing: int) -> Array:
    """(ticks, k), piecewise linear shapes with knots every `spacing` ticks from `first` on, 0 before."""
    knots = np.arange(first, ticks, spacing)
    shapes: Array = np.clip(1.0 - np.abs(np.arange(ticks)[:, np.newaxis] - knots) / spacing, 0.0, None)
    shapes[:first] = 0.0
    return shapes


def bounded_step(slopes: Array, errors: Array, damping: float, lower: Array, upper: Array) -> Array:
    """Minimise |slopes d - errors|^2 + damping |d|^2 over d within bounds.

    Projected Newton (Bertsekas 1982, doi 10.1137/0320018): components on a bound whose gradient points
    outwards stay there, the others take a Newton step with line search.
    """
    gram = slopes.T @ slopes + damping * np.eye(slopes.shape[1])
    pull = slopes.T @ errors

    def cost(d: Array) -> float:
        return float(0.5 * d @ gram @ d - pull @ d)

    step = np.clip(np.zeros(len(pull)), lower, upper)
    for _ in range(_NEWTON_STEPS):
        gradient = gram @ step - pull
        held = ((step <= lower) & (gradient > 0.0)) | ((step >= upper) & (gradient < 0.0))
        free = np.flatnonzero(~held)
        if not free.size or np.abs(gradient[free]).max() < _STATIONARY * (1e-12 + np.abs(pull).max()):
            break
        way, share, before = np.zeros_like(step), 1.0, cost(step)
        way[free] = np.linalg.solve(gram[np.ix_(free, free)], -gradient[free])
        while cost(np.clip(step + share * way, lower, upper)) >= before and share > _STATIONARY:
            share *= 0.5
        if share <= _STATIONARY:
            break
        step = np.clip(step + share * way, lower, upper)
    return step


def descend(
    chain: OpenChain, slopes: ChainSlopes, aim: Aim, start: Array, spacing: int, steps: int
) -> Descent:
    """Descend from widths `start` (ticks, channels), s, by at most `steps` linearisations.

    Widths before tick `aim.first` stay. Widths below threshold are raised to the threshold, which changes no
    course and makes their slopes visible.
    """
    shapes = hats(chain.ticks, aim.first, spacing)
    peaks, later = np.argmax(shapes, axis=0), (np.arange(chain.ticks) >= aim.first)[:, np.newaxis]
    least, most = slopes.front.threshold, chain.width_most
    widths = np.where(later, np.clip(start, least, most), start)
    course, jacobian = slopes.jacobian(widths, aim.first, shapes)
    fallen, damping = [_rmse(aim.errors(course))], _DAMPING
    for _ in range(steps):
        matrix = UNIT_S * jacobian[aim.begin - aim.first:].reshape(aim.errors(course).size, -1)
        lower, upper = ((bound - widths[peaks]).ravel() / UNIT_S for bound in (least, most))
        curvature = float(np.mean(np.sum(matrix**2, axis=0)))
        while damping < _MOST:
            change = bounded_step(matrix, aim.errors(course).ravel(), damping * curvature, lower, upper)
            moved = UNIT_S * shapes @ change.reshape(len(peaks), -1)
            tried = np.where(later, np.clip(widths + moved, least, most), widths)
            seen = chain.course(tried, aim.first)
            if _rmse(aim.errors(seen)) < fallen[-1]:
                break
            damping *= _MORE
        else:
            return Descent(widths, course, tuple(fallen), True)
        widths, course, damping = tried, seen, _LESS * damping
        fallen.append(_rmse(aim.errors(seen)))
        if len(fallen) > _PATIENCE and fallen[-1] > (1.0 - _TOLERANCE) * fallen[-1 - _PATIENCE]:
            return Descent(widths, course, tuple(fallen), True)
        _, jacobian = slopes.jacobian(widths, aim.first, shapes)
    return Descent(widths, course, tuple(fallen), False)


def _rmse(errors: Array) -> float:
    return float(np.sqrt(np.mean(errors**2)))


_HELD_S = 1.5
"""Time after which the hand is at rest (chosen: it moves by less than .1 deg in the next second)."""
_POSTURE_STEPS, _DAMPINGS = 6, (1e-3, 1e-1, 10.0)
"""Largest number of linearisations, and dampings tried, relative to the mean curvature (chosen)."""
_NEAR_RAD = 1e-3


class HeldPosture(NamedTuple):
    """Best reachable static posture.

    Attributes
    ----------
    widths: (channels,), s. sums: (m,), rad, of the posture.
    """

    widths: Array
    sums: Array


def held_postures(experiment: Experiment, current_ma: Array, targets: Array) -> tuple[list[HeldPosture], int]:
    """Best static posture for each of `targets` (k, m), rad, and the number of simulations.

    Muscles do not tire here. Each search starts from the result of the one before.
    """
    chain = OpenChain(experiment, current_ma, round(_HELD_S / chain_period_s(experiment)) + 1, rested=True)
    slopes, found = ChainSlopes(chain), []
    widths = slopes.front.threshold
    for target in targets:
        found.append(_hold(chain, slopes, target, widths))
        widths = found[-1].widths
    return found, chain.rollouts


def chain_period_s(experiment: Experiment) -> float:
    """Period of the block `safety`, s."""
    clock = next(node for node in experiment.nodes if node.name == "safety").clock
    assert clock is not None
    return (clock.tick(1000) - clock.tick(0)) / 1000 / NS_PER_S


def _hold(chain: OpenChain, slopes: ChainSlopes, target: Array, start: Array) -> HeldPosture:
    """Search from `start`, widths (channels,), s, by damped least squares."""
    least, last = slopes.front.threshold, chain.ticks - 1
    widths, (sums, matrix) = start, slopes.settled(start, last)
    for _ in range(_POSTURE_STEPS):
        before = float(np.sum((target - sums) ** 2))
        curvature = UNIT_S**2 * float(np.mean(np.sum(matrix**2, axis=0)))
        for damping in _DAMPINGS:
            change = bounded_step(UNIT_S * matrix, target - sums, damping * curvature,
                                  (least - widths) / UNIT_S, (chain.width_most - widths) / UNIT_S)
            tried = np.clip(widths + UNIT_S * change, least, chain.width_most)
            seen, steeper = slopes.settled(tried, last)
            if np.sum((target - seen) ** 2) < before:
                break
        else:
            break
        widths, sums, matrix = tried, seen, steeper
        if np.abs(target - sums).max() < _NEAR_RAD:
            break
    return HeldPosture(widths, sums)


SPACING_S = 0.1
"""Spacing of knots of the pulse widths (chosen: half the spacing gains nothing)."""
LEAD_S = 0.7
"""Time before the window from which widths are optimised (chosen: earlier widths have no effect)."""
_STEPS = 16
_POSTURES_S = 0.4
"""Spacing of the postures of the quasi-static start (chosen)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Floor:
    """Least error found over the window.

    Attributes
    ----------
    rmse_deg, rows_deg: of all sums, and (m,) of each.
    widths_s: (n, channels), as limited by `safety`; constant after the window.
    course: (n, m), rad, resulting sums; NaN before the search's first tick and after the window.
    ends_deg: by start, error at the end of its search; settled: by start, whether the error no longer fell.
    static_deg: (m,), error of the best static postures along the reference, without fatigue.
    rollouts: number of simulations.
    """

    rmse_deg: float
    rows_deg: Array
    widths_s: Array
    course: Array
    ends_deg: Mapping[str, float]
    settled: Mapping[str, bool]
    static_deg: Array
    rollouts: int

    @property
    def spread_deg(self) -> float:
        """Error of the second best search minus that of the best, deg."""
        best = sorted(self.ends_deg.values())
        return best[1] - best[0] if len(best) > 1 else float("inf")


def reference_course(recording: Recording, trial: int) -> Array:
    """Scored reference of a trial at its ticks, (n, m), rad."""
    reference = recording.experiment["score"]["reference"]
    return np.asarray(recording.signal(reference, trial).values)


def learnt_widths(recording: Recording, trial: int) -> Array:
    """Widths that the block `safety` put out in a trial, (n, channels), s: a start for `reachable_floor`."""
    widths: Array = np.asarray(recording.signal("safety.stimulation", trial).values)[:, :, 1]
    return widths


def reachable_floor(
    experiment: Experiment, reference: Array, window_s: tuple[float, float],
    starts: Mapping[str, Array] | None = None, current_ma: Array | None = None,
) -> Floor:
    """Search for the least error over [from, until) from several starts.

    The starts are no stimulation (`rest`), the best static postures along the reference (`postures`), and
    `starts`, whose own error is never exceeded.

    Parameters
    ----------
    experiment: with nodes `safety`, `stimulator`, `electrodes`, `muscles`, `hand`; its score's truth is a
        node of kind `synergies`.
    reference: (n, m), rad, at the ticks of `safety`, for the sums of the score's truth.
    window_s: in which errors count, s.
    starts: by name, widths (n, channels), s, such as those of a learning controller.
    current_ma: (channels,); None: those of the node `controller`.

    Raises InputError for parameters that do not fit together.
    """
    currents = _currents(experiment) if current_ma is None else np.asarray(current_ma, dtype=np.float64)
    probe = OpenChain(experiment, currents, 1)
    begin, end = (probe.tick_at(time_s) for time_s in window_s)
    if not 0 <= begin < end <= len(reference) or reference.shape[1:] != (len(probe.rows),):
        raise InputError("reference", f"shape {reference.shape}, window {window_s[0]:g} to {window_s[1]:g} s",
                         f"(n, {len(probe.rows)}), a window of at least a tick within its n ticks")
    given = _checked(starts or {}, end, len(currents))
    chain = OpenChain(experiment, currents, end)
    per_s = 1.0 / (1e-9 * probe.time_ns(1))
    aim = Aim(reference[:end], max(0, begin - round(LEAD_S * per_s)), begin)
    slopes = ChainSlopes(chain)
    every = max(1, round(_POSTURES_S * per_s))
    instants = np.arange(begin, end, every)
    postures, held = held_postures(experiment, currents, reference[instants])
    places = np.arange(end)[:, np.newaxis]
    between = np.array([np.interp(places[:, 0], instants, column)
                        for column in np.array([each.widths for each in postures]).T]).T
    named = {"rest": np.zeros((end, len(currents))), "postures": np.where(places < aim.first, 0.0, between),
             **given}
    ends = {name: descend(chain, slopes, aim, start, max(1, round(SPACING_S * per_s)), _STEPS)
            for name, start in named.items()}
    best = min(ends.values(), key=lambda each: each.rmse_rad[-1])
    widths, course = _lowered(chain, slopes, aim, best)
    errors = np.degrees(aim.errors(course))
    missed = np.degrees(reference[instants] - [each.sums for each in postures])
    whole = np.full(reference.shape, np.nan)
    whole[aim.first:end] = course
    return Floor(
        rmse_deg=float(np.sqrt(np.mean(errors**2))), rows_deg=np.sqrt(np.mean(errors**2, axis=0)),
        widths_s=np.vstack([widths, np.repeat(widths[-1:], len(reference) - end, axis=0)]), course=whole,
        ends_deg={name: float(np.degrees(each.rmse_rad[-1])) for name, each in ends.items()},
        settled={name: each.settled for name, each in ends.items()},
        static_deg=np.sqrt(np.mean(missed**2, axis=0)), rollouts=chain.rollouts + held)


def _currents(experiment: Experiment) -> Array:
    """Currents of the node `controller`, mA."""
    for node in experiment.nodes:
        part: Any = node.part
        if node.name == "controller" and hasattr(part, "current_ma"):
            return np.asarray(part.current_ma, dtype=np.float64)
    raise InputError("current_ma", "no node `controller` that has currents", "current_ma, one a channel")


def _checked(starts: Mapping[str, Array], ticks: int, channels: int) -> dict[str, Array]:
    """Starts up to the window's end."""
    for name, widths in starts.items():
        if widths.ndim != 2 or len(widths) < ticks or widths.shape[1] != channels:
            raise InputError(f"starts.{name}", f"shape {widths.shape}", f"({ticks} or more, {channels})")
    return {name: widths[:ticks] for name, widths in starts.items()}


def _lowered(chain: OpenChain, slopes: ChainSlopes, aim: Aim, best: Descent) -> tuple[Array, Array]:
    """Admitted widths and their course, without pulses below threshold unless that increases the error."""
    lowered = chain.admitted(np.where(best.widths <= slopes.front.threshold, 0.0, best.widths))
    course = chain.course(lowered, aim.first)
    if np.mean(aim.errors(course) ** 2) <= np.mean(aim.errors(best.course) ** 2) * (1.0 + 1e-9):
        return lowered, course
    return chain.admitted(best.widths), best.course
