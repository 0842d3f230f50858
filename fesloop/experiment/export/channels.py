"""Channels of a signal, one for each of its numbers: labels, units and quantities."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal

from fesloop.experiment.recording.reading import TableSignal
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.movements import MUSCLES
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
    """Names of the elements of a signal of shape (n,): freedoms, sums of them, or muscles."""
    rows = block.get("rows") or ()
    if signal.unit in _ANGULAR and len(rows) == signal.shape[0]:
        return tuple(str(row) for row in rows)
    if signal.port in _MUSCLE_PORTS and signal.shape == (len(MUSCLES),):
        return MUSCLES
    if signal.unit in _ANGULAR:
        return _tree(block).freedoms
    return ()


def _matrix(signal: TableSignal, block: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of the rows of a signal of shape (n, ...): fingertips, or the segments of sensors."""
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


Quantity = Literal["acceleration", "rate", "field", "orientation", "joint_angle", "position", "velocity",
                   "other"]
_OF_UNIT: dict[str, Quantity] = {"m/s^2": "acceleration", "rad/s": "rate", "T": "field", "m": "position",
                                 "m/s": "velocity"}
_PARTS = {"A,s": ("current", "width"), "A,s,Hz": ("current", "width", "frequency")}
"""Components of signals whose last axis has several quantities."""


@dataclass(frozen=True, slots=True)
class Channel:
    """One number of a signal.

    Attributes
    ----------
    label: after the signal's name, "F2p.x"; empty for a scalar.
    unit: SI.
    point: the joint, segment, finger or channel of stimulation that it is of; empty for a scalar.
    component: x, y, z, w, current, width, frequency, or a number; empty where there is one a point.
    """

    label: str
    unit: str
    point: str
    component: str


def quantity(signal: TableSignal) -> Quantity:
    """Quantity of a signal, by its unit, shape and port; "other" if it is no motion."""
    if signal.port == "sd" or signal.port.endswith("_sd") or not signal.shape:
        return "other"
    if signal.unit == "rad" and len(signal.shape) == 1:
        return "joint_angle"
    if signal.unit == "1" and signal.shape[-1] == 4 and "orientation" in signal.port:
        return "orientation"
    if signal.shape[-1] == 3 and (len(signal.shape) > 1 or signal.unit in ("m", "m/s")):
        return _OF_UNIT.get(signal.unit, "other")
    return "other"


def channels(signal: TableSignal, block: Mapping[str, Any]) -> tuple[Channel, ...]:
    """A signal's channels in the order of its values in memory: the last axis changes fastest.

    Parameters
    ----------
    block: parameters of the signal's node, as the recording's experiment has them.
    """
    components, units = _components(signal)
    axes = signal.shape[:-1] if components else signal.shape
    if not axes:
        points = [""]
    else:
        inner = [[str(number) for number in range(size)] for size in axes[1:]]
        points = [".".join(parts) for parts in product(row_names(signal, block), *inner)]
    if not components:
        return tuple(Channel(point, signal.unit, point, "") for point in points)
    return tuple(Channel(f"{point}.{component}" if point else component, unit, point, component)
                 for point in points for component, unit in zip(components, units, strict=True))


def _components(signal: TableSignal) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names and units along the last axis, where it holds the components of one thing."""
    what = quantity(signal)
    if what == "orientation":
        return ("w", "x", "y", "z"), (signal.unit,) * 4
    if what not in ("joint_angle", "other"):
        return ("x", "y", "z"), (signal.unit,) * 3
    parts = _PARTS.get(signal.unit, ())
    if parts and signal.shape and signal.shape[-1] == len(parts):
        return parts, tuple(signal.unit.split(","))
    if len(signal.shape) == 2 and signal.shape[-1] == 3 and signal.port.endswith("_sd"):
        return ("x", "y", "z"), (signal.unit,) * 3
    return (), ()
