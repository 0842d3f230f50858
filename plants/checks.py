"""Shared checks of parameters; each error names the parameter, the value found and the values allowed."""

from __future__ import annotations

import numpy as np

from fesloop.errors import InputError

MOST_ELEMENTS = 4096
"""Most elements of an electrode array (chosen: fifty times the largest array in use; tables fit in
memory)."""


def require_positive(owner: str, parameters: object, *keys: str) -> None:
    """Raise InputError unless every number under each key is finite and above 0."""
    for key in keys:
        value = np.asarray(getattr(parameters, key))
        if not (np.isfinite(value).all() and (value > 0.0).all()):
            raise InputError(f"{owner}.{key}", f"{getattr(parameters, key)}", "finite numbers above 0")


def require_not_negative(owner: str, parameters: object, *keys: str) -> None:
    """Raise InputError unless every number under each key is finite and 0 or more."""
    for key in keys:
        value = np.asarray(getattr(parameters, key))
        if not (np.isfinite(value).all() and (value >= 0.0).all()):
            raise InputError(f"{owner}.{key}", f"{getattr(parameters, key)}", "finite numbers, 0 or more")


def require_shape(owner: str, parameters: object, shape: tuple[int, ...], meaning: str, *keys: str) -> None:
    """Raise InputError unless the numbers under each key are finite and have the shape."""
    for key in keys:
        try:
            value = np.asarray(getattr(parameters, key), dtype=np.float64)
        except ValueError:
            raise InputError(f"{owner}.{key}", "rows of unequal length",
                             f"shape {shape}: {meaning}") from None
        if value.shape != shape:
            raise InputError(f"{owner}.{key}", f"shape {value.shape}", f"shape {shape}: {meaning}")
        if not np.isfinite(value).all():
            raise InputError(f"{owner}.{key}", f"{getattr(parameters, key)}", "finite numbers")
