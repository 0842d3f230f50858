"""The output `aligned` of a tracker: whether the initial pose, if it needs one, has been taken."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.signals import Port

ALIGNED_PORT = Port("aligned", (1,), "1")
"""0 while the wearer keeps still in the initial pose, 1 afterwards and for trackers that need none."""


def aligned_value(aligned: bool) -> NDArray[np.float64]:
    """The value of `aligned`, (1,); read-only."""
    return _ALIGNED if aligned else _ALIGNING


def _constant(value: float) -> NDArray[np.float64]:
    array = np.array([value])
    array.flags.writeable = False
    return array


_ALIGNED, _ALIGNING = _constant(1.0), _constant(0.0)
