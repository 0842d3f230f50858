"""Refusal of numbers that floats do not hold: gains may be as large as a file can write them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from fesloop.errors import RunError


@contextmanager
def within_floats(what: str) -> Iterator[None]:
    """Computing in which an overflow ends in a RunError; also decorates a function."""
    try:
        with np.errstate(over="raise"):
            yield
    except FloatingPointError:
        raise RunError(f"{what}: its numbers grow beyond the range of floats") from None
