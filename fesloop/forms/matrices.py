"""Matrices from nested lists of numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.errors import InputError


def matrix(where: str, rows: ArrayLike) -> NDArray[np.float64]:
    """Numbers, or rows of them, as an array. Raises InputError for rows of unequal length."""
    try:
        return np.atleast_1d(np.asarray(rows, dtype=np.float64))
    except ValueError:
        raise InputError(where, "rows of unequal length", "rows of one length") from None
