"""What the rows of a signal are called: joints, segments, fingers, muscles, else their numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fesloop.experiment.recording.signal_table import TableSignal
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.muscles import MUSCLES
from fesloop.hand.segments import Segment, SegmentTree
from fesloop.hand.skeleton import hand_tree

FINGERS = ("F1", "F2", "F3", "F4", "F5")
_HAND = hand_tree(HandSize())
_MUSCLE_PORTS = ("recruitment", "frequency", "activation", "fitness", "velocity", "voluntary")
_ANGULAR = ("rad", "rad/s", "rad/s^2")


def row_names(signal: TableSignal, block: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of a signal's rows, as many as its shape has; none for a scalar.

    They are those that its port states, such as sensors in the order of a recording; else the block's
    parameters are looked through.

    Parameters
    ----------
    block: parameters of the signal's node, as the recording's experiment has them.
    """
    if not signal.shape:
        return ()
    count = signal.shape[0]
    if signal.rows:
        return signal.rows
    named = _vector(signal, block) if len(signal.shape) == 1 else _matrix(signal, block)
    return named if len(named) == count else tuple(str(number) for number in range(count))


def _vector(signal: TableSignal, block: Mapping[str, Any]) -> tuple[str, ...]:
    """Of a signal of shape (n,): freedoms, sums of them, muscles or fingers."""
    rows = block.get("rows") or ()
    if signal.unit in _ANGULAR and len(rows) == signal.shape[0]:
        return tuple(str(row) for row in rows)
    if signal.port in _MUSCLE_PORTS and signal.shape == (len(MUSCLES),):
        return MUSCLES
    if signal.port == "contact_force":
        return FINGERS
    if signal.unit in _ANGULAR:
        return _tree(block).freedoms
    return ()


def _matrix(signal: TableSignal, block: Mapping[str, Any]) -> tuple[str, ...]:
    """Of a signal of shape (n, ...): fingertips, or what sensors sit on."""
    count = signal.shape[0]
    if signal.port.startswith("fingertip"):
        return FINGERS
    if signal.unit not in ("1", "m", "m/s^2", "rad/s", "T"):
        return ()
    chosen = block.get("sensed") or block.get("sites") or block.get("site_names") or ()
    if len(chosen) == count:
        return tuple(str(name) for name in chosen)
    if "segments" not in block and "hand" not in block:
        return ()
    names = _tree(block).names
    return names[len(names) - count:] if count >= len(names) - 1 else ()


def _tree(block: Mapping[str, Any]) -> SegmentTree:
    """Segments that a block was given, else the hand's."""
    given = block.get("segments") or ()
    if not given:
        return _HAND
    return SegmentTree(tuple(Segment(**{key: _frozen(value) for key, value in segment.items()})
                             for segment in given))


def _frozen(value: Any) -> Any:
    """Lists, as JSON has them, as tuples."""
    return tuple(_frozen(item) for item in value) if isinstance(value, list) else value
