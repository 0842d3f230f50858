"""Axes and levels of a study, from the levels of its cells."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean

AxisLevel = float | str
Axes = dict[str, tuple[AxisLevel, ...]]
_ALIKE = 1e-6
"""Relative difference below which a number selects a level, so that 41.66667 finds 125 / 3."""


def axes_of(tables: Sequence[Mapping[str, Any]]) -> tuple[Axes, dict[str, NDArray[np.int64]]]:
    """Levels of each axis, and the index of each cell's level on it, (cells,).

    `tables` are the levels of the cells by axis. Levels that are all numbers ascend; all others are text, in
    the order of the cells. Raises KeyError where a cell lacks an axis of the others.
    """
    axes: Axes = {}
    places: dict[str, NDArray[np.int64]] = {}
    for axis in tables[0] if tables else ():
        given = [table[axis] for table in tables]
        numeric = all(is_number(value) for value in given)
        levels: list[AxisLevel] = given if numeric else [level_text(value) for value in given]
        ordered = dict.fromkeys(sorted(set(levels)) if numeric else levels)
        axes[axis] = tuple(ordered)
        number = {level: place for place, level in enumerate(ordered)}
        places[axis] = np.array([number[level] for level in levels], dtype=np.int64)
    return axes, places


def is_number(value: object) -> TypeGuard[int | float]:
    """Whether a level is a number; true and false are not."""
    return type(value) in (int, float)


def is_numeric(levels: Sequence[AxisLevel]) -> bool:
    """Whether all levels are numbers."""
    return all(is_number(level) for level in levels)


def level_text(value: Any) -> str:
    """Text of a level: strings as they are, everything else as in a study file."""
    if isinstance(value, str):
        return value
    return f"{value:g}" if is_number(value) else json.dumps(value)


def place_of(axes: Mapping[str, Sequence[AxisLevel]], axis: str, given: Any) -> int:
    """Index of a level on an axis. Raises InputError for an unknown axis or level."""
    require_axis(axes, axis)
    levels = axes[axis]
    if given in levels and not isinstance(given, bool):
        return levels.index(given)
    if is_number(given):
        near = [i for i, level in enumerate(levels) if is_number(level)
                and abs(level - given) <= _ALIKE * max(abs(level), abs(given))]
        if len(near) == 1:
            return near[0]
    texts = [level_text(level) for level in levels]
    if level_text(given) in texts:
        return texts.index(level_text(given))
    shown = ", ".join(texts[:20]) + (", ..." if len(texts) > 20 else "")
    raise InputError(f"{axis} = {level_text(given)}", "is not a level of the study", shown,
                     did_you_mean(level_text(given), texts))


def require_axis(axes: Mapping[str, Any], axis: str) -> None:
    """Raise InputError for an axis that the study does not have."""
    if axis not in axes:
        raise InputError(axis, "is not an axis of the study", ", ".join(axes) or "it has none",
                         did_you_mean(axis, axes))
