"""JSON of the parts that a page's script draws: charts, strips, bars, heat maps and the hand."""

from __future__ import annotations

import base64
import hashlib
import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.show.picture.hand_mesh import Mesh
from fesloop.show.report.parts import (
    Bars,
    Chart,
    Figure3d,
    Fold,
    Frames,
    HeatMap,
    Line,
    Page,
    Part,
    Solid,
    Strips,
)

Array = NDArray[np.float64]
Encoded = Mapping[str, str | float | int]

_FEW = 64
"""Most numbers that are written exactly (chosen: values of bars and short lines are read off)."""
_HUGE = 1e300
"""Magnitude beyond which differences may overflow."""
_LEVELS = 65534
"""Levels of 16 bits, less one for NaN."""
_NONE = -32768
"""NaN in 16 bits."""
_FAR = 50.0
"""Largest ratio of range to visible range for 16 bits (chosen: a level is then below a pixel of a chart)."""
_EVEN = 1e-9
"""Largest deviation of evenly spaced numbers, as a share of the span (rounding of some hundred additions)."""


@dataclass(frozen=True, slots=True)
class Numbers:
    """Arrays of a page, each stored once; parts refer to them by their index in `kept`."""

    kept: list[Encoded] = field(default_factory=list)
    places: dict[str, int] = field(default_factory=dict)

    def add(self, values: ArrayLike, seen: float = math.inf) -> int:
        """Index of an array's numbers, in C order; `seen`: visible range."""
        return self._place(encoded(np.asarray(values, dtype=np.float64).ravel(), seen))

    def add_whole(self, values: ArrayLike) -> int:
        """Index of an array of non-negative integers."""
        return self._place(_bytes("u4", np.asarray(values).ravel()))

    def _place(self, made: Encoded) -> int:
        key = hashlib.sha256(repr(sorted(made.items())).encode()).hexdigest()
        if key not in self.places:
            self.places[key] = len(self.kept)
            self.kept.append(made)
        return self.places[key]


def encoded(values: Array, seen: float = math.inf) -> Encoded:
    """Encode numbers (n,) as evenly spaced, as 64-bit floats, or as 16-bit levels.

    Levels divide the range: decoded numbers are off by at most half its 65534th part. Numbers far beyond the
    range that is `seen` are written as floats, because levels would be too coarse.
    """
    finite = values[np.isfinite(values)]
    spaced = len(finite) > 0 and not np.isinf(values).any() and float(np.abs(finite).max()) < _HUGE
    if spaced and len(values) > 2 and _even(values):
        return {"from": float(values[0]), "to": float(values[-1]), "count": len(values)}
    if not spaced or len(values) <= _FEW:
        return _bytes("f8", values)
    low, span = float(finite.min()), float(np.ptp(finite))
    if span > _FAR * seen:
        return _bytes("f8", values)
    step = span / _LEVELS or 1.0
    with np.errstate(invalid="ignore"):
        levels = np.where(np.isfinite(values), np.rint((values - low) / step) - 32767, _NONE)
    return {**_bytes("i2", levels), "low": low, "step": step}


def _even(values: Array) -> bool:
    if not np.isfinite(values).all():
        return False
    line = np.linspace(values[0], values[-1], len(values))
    return bool(np.abs(values - line).max() <= _EVEN * abs(values[-1] - values[0]))


def _bytes(kind: str, values: NDArray[np.generic]) -> dict[str, str | float | int]:
    return {kind: base64.b64encode(values.astype(f"<{kind}").tobytes()).decode("ascii")}


Drawn = Chart | Strips | Bars | HeatMap | Figure3d


def drawn_numbers(page: Page) -> dict[str, Any]:
    """Data of a page's script, fit for JSON: arrays, and parts by key, which refer to arrays by index.

    Limits, marks and points that are not finite, as from a damaged file, are left out.

    Raises ValueError where two parts of the page have the same key.
    """
    numbers = Numbers()
    parts: dict[str, dict[str, Any]] = {}
    for part in _drawn(part for section in page.sections for part in section.parts):
        if part.key in parts:
            raise ValueError(f"a page's parts need keys of their own; {part.key!r} is there twice")
        parts[part.key] = _described(part, numbers)
    return {"trials": [int(trial) for trial in page.trials], "shown": int(page.shown),
            "at": None if page.at_s is None else float(page.at_s), "parts": parts,
            "arrays": numbers.kept}


def _drawn(parts: Iterator[Part]) -> Iterator[Drawn]:
    for part in parts:
        if isinstance(part, Drawn):
            yield part
        elif isinstance(part, Fold):
            yield from _drawn(iter(part.parts))


def _described(part: Drawn, numbers: Numbers) -> dict[str, Any]:
    match part:
        case Chart():
            return _chart(part, numbers)
        case Strips():
            return _strips(part, numbers)
        case Bars():
            return _bars(part, numbers)
        case HeatMap():
            return _heat_map(part, numbers)
        case Figure3d():
            return _figure(part, numbers)


def _chart(chart: Chart, numbers: Numbers) -> dict[str, Any]:
    limits = _limits(chart.limits)
    return {"kind": "chart", "x_label": chart.x_label, "y_label": chart.y_label,
            "lines": [_line(line, numbers, limits) for line in chart.lines],
            "marks": [{"text": mark.text, "at": float(mark.at), "until": float(mark.until)}
                      for mark in chart.marks if _are_numbers((mark.at, mark.until))],
            "timed": chart.timed, "limits": limits,
            "x_levels": [*chart.x_levels], "x_log": chart.x_log}


def _strips(strips: Strips, numbers: Numbers) -> dict[str, Any]:
    limits = _limits(strips.limits)
    return {"kind": "strips", "x_label": strips.x_label, "y_label": strips.y_label,
            "lines": [_line(line, numbers, limits) for line in strips.lines], "timed": strips.timed,
            "limits": limits}


def _limits(ends: tuple[float, float] | None) -> list[float] | None:
    """Limits of an axis; None if they are not finite numbers."""
    return None if ends is None or not _are_numbers(ends) else [float(ends[0]), float(ends[1])]


def _are_numbers(values: Sequence[Any]) -> bool:
    """Return whether all values are finite numbers; a damaged file may hold text or huge integers."""
    kinds, most = (int, float, np.integer, np.floating), sys.float_info.max
    return all(isinstance(each, kinds) and bool(-most <= each <= most) for each in values)


def _line(line: Line, numbers: Numbers, limits: Sequence[float] | None = None) -> dict[str, Any]:
    """JSON of a line; `limits`: visible range of y, None for all of it."""
    seen = math.inf if limits is None else limits[1] - limits[0]
    y, low, high = (None if each is None else numbers.add(np.where(np.isfinite(each), each, np.nan), seen)
                    for each in (line.y, line.low, line.high))
    return {"name": line.name, "role": line.role, "style": line.style, "x": numbers.add(line.x), "y": y,
            "low": low, "high": high}


def _bars(bars: Bars, numbers: Numbers) -> dict[str, Any]:
    return {"kind": "bars", "x_label": bars.x_label, "names": [*bars.names], "stacked": bars.stacked,
            "series": [{"name": name, "role": bars.roles[name], "values": numbers.add(list(values))}
                       for name, values in bars.values.items()]}


def _heat_map(heat: HeatMap, numbers: Numbers) -> dict[str, Any]:
    low, high = (None, None) if heat.lack else (float(heat.low), float(heat.high))
    return {"kind": "heat_map", "x_label": heat.x_label, "y_label": heat.y_label,
            "x_levels": [*heat.x_levels], "y_levels": [*heat.y_levels], "values": numbers.add(heat.values),
            "cells": [[*row] for row in heat.cells], "told": [[*row] for row in heat.told],
            "value_label": heat.value_label, "low": low, "high": high,
            "better": heat.better, "contours": [_line(line, numbers) for line in heat.contours]}


def _figure(figure: Figure3d, numbers: Numbers) -> dict[str, Any]:
    return {"kind": "hand", "view": [*map(float, figure.view)],
            "shapes": {name: [_mesh(mesh, numbers) for mesh in meshes]
                       for name, meshes in figure.shapes.items()},
            "objects": [_solid(solid) for solid in figure.objects],
            "trials": {str(trial): _frames(frames, numbers) for trial, frames in figure.trials.items()}}


def _mesh(mesh: Mesh, numbers: Numbers) -> dict[str, int]:
    return {"vertices": numbers.add(mesh.vertices), "faces": numbers.add_whole(mesh.faces)}


def _solid(solid: Solid) -> dict[str, Any]:
    return {"kind": solid.kind, "half_sizes": [*map(float, solid.half_sizes)], "role": solid.role,
            "moves": solid.moves, "pose": [*map(float, solid.pose)]}


def _frames(frames: Frames, numbers: Numbers) -> dict[str, Any]:
    return {"start_s": float(frames.start_s), "step_s": float(frames.step_s),
            "hands": {name: _poses(poses, numbers) for name, poses in frames.hands.items()},
            "objects": _poses(frames.objects, numbers)}


def _poses(poses: Array, numbers: Numbers) -> dict[str, int]:
    """JSON of poses, orientations and positions apart, because their ranges differ."""
    return {"frames": len(poses), "bodies": poses.shape[1], "orientations": numbers.add(poses[..., :4]),
            "positions": numbers.add(poses[..., 4:])}
