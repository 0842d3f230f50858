"""Which postures a patient can be held in: the best pulse widths that stand still, on the settled plant."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.chain_slopes import ChainSlopes
from fesloop.apps.reproduce.open_chain import OpenChain
from fesloop.apps.reproduce.reachable_descent import UNIT_S, bounded_step
from fesloop.experiment.experiment import Experiment
from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
_HELD_S = 1.5
"""After which the hand lies still (chosen: it moves by less than .1 deg in the next second)."""
_STEPS, _DAMPINGS = 6, (1e-3, 1e-1, 10.0)
"""Linearisations at most, and how cautious each step may become, of the mean curvature (chosen)."""
_NEAR_RAD = 1e-3


class HeldPosture(NamedTuple):
    """The best that standing still reaches.

    Attributes
    ----------
    widths: (channels,), s. sums: (m,), rad, where they leave the hand.
    """

    widths: Array
    sums: Array


def held_postures(experiment: Experiment, current_ma: Array, targets: Array) -> tuple[list[HeldPosture], int]:
    """(the best for each of `targets` (k, m), rad, how often the plant was played).

    Muscles do not tire here. Each begins where the one before it ended.
    """
    chain = OpenChain(experiment, current_ma, round(_HELD_S / chain_period_s(experiment)) + 1, rested=True)
    slopes, found = ChainSlopes(chain), []
    widths = slopes.front.threshold
    for target in targets:
        found.append(_hold(chain, slopes, target, widths))
        widths = found[-1].widths
    return found, chain.rollouts


def chain_period_s(experiment: Experiment) -> float:
    """Of the ticks of `safety`, s."""
    clock = next(node for node in experiment.nodes if node.name == "safety").clock
    assert clock is not None
    return (clock.tick(1000) - clock.tick(0)) / 1000 / NS_PER_S


def _hold(chain: OpenChain, slopes: ChainSlopes, target: Array, start: Array) -> HeldPosture:
    """By damped least squares from `start`, widths (channels,), s."""
    least, last = slopes.front.threshold, chain.ticks - 1
    widths, (sums, matrix) = start, slopes.settled(start, last)
    for _ in range(_STEPS):
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
