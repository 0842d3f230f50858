"""Functions that make models and calibrations of recordings, found through entry points.

An entry of the group "fesloop.identifiers" takes a recording's path and returns an object whose `model` can
be saved. One of "fesloop.calibrators" does the same with a `calibration`.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import entry_points
from typing import Any

from fesloop.errors import InputError


def identifier() -> Callable[..., Any]:
    """The function that identifies a patient's model. Raises InputError if none is installed."""
    return _first("fesloop.identifiers", "identify", "no installed package identifies models")


def calibrator() -> Callable[..., Any]:
    """The function that calibrates a recording. Raises InputError if none is installed."""
    return _first("fesloop.calibrators", "calibrate", "no installed package calibrates recordings")


def _first(group: str, command: str, found: str) -> Callable[..., Any]:
    """The first entry of a group, by name."""
    entry = next(iter(sorted(entry_points(group=group), key=lambda each: each.name)), None)
    if entry is None:
        raise InputError(command, found, remedy=f"install one with an entry point in {group!r}")
    function: Callable[..., Any] = entry.load()
    return function
