"""A controller's reference held against what it measures: the same rows, within their ranges of motion."""

from __future__ import annotations

import math
from collections.abc import Iterator

from fesloop.errors import InputError
from fesloop.loop.wiring import Node, Wiring

_REFERENCES = ("reference", "reference_preview")
_MEASURED = "measured"
_ROUNDING = 1e-8
"""rad; angles that were turned into degrees and back."""


def row_faults(wiring: Wiring) -> list[InputError]:
    """References that list other rows than what is measured, or another order, or leave their ranges.

    Rows are known of a node that has `rows`, names of what its output lists; ranges of one that has `ranges`
    (m, 2), rad. A reference without names is known by its `extremes` (m, 2), rad.
    """
    sources: dict[str, dict[str, Node]] = {}
    for end in wiring.connections:
        port = end.target.part.inputs[end.target_port].name
        sources.setdefault(end.target.name, {})[port] = end.source
    faults: list[InputError] = []
    for controller, by_port in sources.items():
        measured = by_port.get(_MEASURED)
        told = {by_port[port].name: by_port[port] for port in _REFERENCES if port in by_port}
        if measured is not None:
            for reference in told.values():
                faults += _faults(reference, measured, controller)
    return faults


def _faults(reference: Node, measured: Node, controller: str) -> Iterator[InputError]:
    """What is wrong with one reference of a controller."""
    rows, names = _rows(reference), _rows(measured)
    if not names:
        return
    where = f"blocks.{reference.name}"
    if rows and rows != names:
        yield InputError(f"{where}.rows", ", ".join(rows),
                         f"{', '.join(names)}, as {measured.name} has that {controller} measures",
                         "give both the same rows in the same order")
    if rows or not (hasattr(reference.part, "extremes") and hasattr(measured.part, "ranges")):
        return
    told, limits = reference.part.extremes, measured.part.ranges
    for row, ends, (low, high) in zip(names, told, limits, strict=True):
        for value in ends:
            if not low - _ROUNDING <= value <= high + _ROUNDING:
                yield InputError(
                    where, f"{math.degrees(value):.5g} deg is outside the range of motion of {row}",
                    f"{math.degrees(low):.5g} to {math.degrees(high):.5g} deg", "stay within it")


def _rows(node: Node) -> tuple[str, ...]:
    """Names of what a node's output lists; none where it does not say."""
    return tuple(getattr(node.part, "rows", ()))
