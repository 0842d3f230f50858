"""Dry friction of a joint, as a play: what a force has to overcome before it shows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled

Array = NDArray[np.float64]


@compiled
def play(force: Array, friction: Array, start: Array) -> Array:
    """Part (n, k) of a force that passes dry friction: up to `friction` (k,) behind `force` (n, k).

    The output stays where it is while it is within `friction` of the force, and follows at that distance
    beyond (the play operator; Visintin 1994, doi 10.1007/978-3-662-11557-2, section III.2). `start` (k,) is
    the output before. Between two rows the force is taken as monotonic: rows at all its extrema are exact.
    """
    passed = np.empty(force.shape)
    for k in range(force.shape[1]):
        last = start[k]
        for i in range(force.shape[0]):
            last = min(max(last, force[i, k] - friction[k]), force[i, k] + friction[k])
            passed[i, k] = last
    return passed
