"""Towards the pulse widths whose course comes nearest to another: damped least squares within limits."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.chain_slopes import ChainSlopes
from fesloop.apps.reproduce.open_chain import OpenChain

Array = NDArray[np.float64]
UNIT_S = 100e-6
"""Of the changes sought (chosen: all of them then are about 1)."""
_DAMPING, _LESS, _MORE, _MOST = 1e-2, 0.3, 5.0, 1e3
"""Damping at first, of the mean curvature; how it changes after a step that helped and one that did not;
where it is given up (chosen)."""
_TOLERANCE = 0.01
"""Share by which the error must fall in `_PATIENCE` steps to go on (chosen)."""
_PATIENCE = 3
_NEWTON_STEPS, _STATIONARY = 60, 1e-6
"""Of one bounded least squares (chosen: it ends after some ten)."""


class Descent(NamedTuple):
    """Where a descent ended.

    Attributes
    ----------
    widths: (ticks, channels), s. course: (ticks - first, m), rad.
    rmse_rad: over the window, at the start and after each step that helped.
    settled: whether it ended because it no longer fell.
    """

    widths: Array
    course: Array
    rmse_rad: tuple[float, ...]
    settled: bool


class Aim(NamedTuple):
    """What is to be followed.

    Attributes
    ----------
    reference: (ticks, m), rad. first, begin: ticks from which on widths may change, and errors count.
    """

    reference: Array
    first: int
    begin: int

    def errors(self, course: Array) -> Array:
        """(ticks - begin, m) of a course from tick `first` on."""
        return self.reference[self.begin:] - course[self.begin - self.first:]


def hats(ticks: int, first: int, spacing: int) -> Array:
    """(ticks, k), piecewise linear shapes with knots every `spacing` ticks from `first` on, 0 before."""
    knots = np.arange(first, ticks, spacing)
    shapes: Array = np.clip(1.0 - np.abs(np.arange(ticks)[:, np.newaxis] - knots) / spacing, 0.0, None)
    shapes[:first] = 0.0
    return shapes


def bounded_step(slopes: Array, errors: Array, damping: float, lower: Array, upper: Array) -> Array:
    """The d within bounds that makes |slopes d - errors|^2 + damping |d|^2 least.

    Projected Newton (Bertsekas 1982, doi 10.1137/0320018): what sits on a bound and is pushed against it
    stays there, the others go the way of their own curvature, as far as makes things better.
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
    """From widths `start` (ticks, channels), s, at most `steps` linearisations on.

    What widths do before tick `aim.first` stays. Widths that recruit nothing are lifted to where they begin
    to, which changes no course: from there it can be seen which way to go.
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
