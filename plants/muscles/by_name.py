"""Numbers of muscles, given by name."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.hand.movements import MUSCLES, muscle


def each_muscle(usual: float, own: Mapping[str, float], where: str) -> NDArray[np.float64]:
    """The number of each muscle, (muscles,): from `own` by name, `usual` for all others.

    Raises InputError, which begins with `where`, for an unknown muscle.
    """
    numbers = np.full(len(MUSCLES), usual)
    for name, number in own.items():
        try:
            numbers[muscle(name)] = number
        except InputError as fault:
            raise InputError(where, fault.found, fault.allowed, fault.remedy) from fault
    return numbers
