"""The axes of a study as its cells have them: names, levels in order, which level each cell has."""

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
"""Relative difference below which a number that is asked for is a level, so that 41.66667 finds 125 / 3."""


def axes_of(tables: Sequence[Mapping[str, Any]]) -> tuple[Axes, dict[str, NDArray[np.int64]]]:
    """Axes of cells, and the place of each cell's level on each of them, (cells,).

    `tables` are the levels of the cells by axis. An axis of numbers alone is in ascending order; any other is
    text, in the order in which the cells come. Raises KeyError where a cell lacks an axis of the others.
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
    """Whether a level is a number; a switch, true or false, is none."""
    return type(value) in (int, float)


def is_numeric(levels: Sequence[AxisLevel]) -> bool:
    """Whether an axis is one of numbers."""
    return all(is_number(level) for level in levels)


def level_text(value: Any) -> str:
    """A level as it is written: text bare, everything else as in a study file."""
    if isinstance(value, str):
        return value
    return f"{value:g}" if is_number(value) else json.dumps(value)


def place_of(axes: Mapping[str, Sequence[AxisLevel]], axis: str, asked: Any) -> int:
    """Where a level stands on an axis; InputError for an axis or a level that is not there."""
    require_axis(axes, axis)
    levels = axes[axis]
    if asked in levels and not isinstance(asked, bool):
        return levels.index(asked)
    if is_number(asked):
        near = [i for i, level in enumerate(levels) if is_number(level)
                and abs(level - asked) <= _ALIKE * max(abs(level), abs(asked))]
        if len(near) == 1:
            return near[0]
    texts = [level_text(level) for level in levels]
    if level_text(asked) in texts:
        return texts.index(level_text(asked))
    shown = ", ".join(texts[:20]) + (", ..." if len(texts) > 20 else "")
    raise InputError(f"{axis} = {level_text(asked)}", "is not a level of the study", shown,
                     did_you_mean(level_text(asked), texts))


def require_axis(axes: Mapping[str, Any], axis: str) -> None:
    """Raise InputError for an axis that the study does not have."""
    if axis not in axes:
        raise InputError(axis, "is no axis of the study", ", ".join(axes) or "it has none",
                         did_you_mean(axis, axes))
