"""The single numbers of a signal, a channel each: what they are called, their units, what they measure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal

from fesloop.experiment.export.element_names import row_names
from fesloop.experiment.recording.signal_table import TableSignal

Quantity = Literal["acceleration", "rate", "field", "orientation", "joint_angle", "position", "velocity",
                   "other"]
_OF_UNIT: dict[str, Quantity] = {"m/s^2": "acceleration", "rad/s": "rate", "T": "field", "m": "position",
                                 "m/s": "velocity"}
_PARTS = {"A,s": ("current", "width"), "A,s,Hz": ("current", "width", "frequency")}
"""Of signals whose last axis holds several quantities."""


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
    """What a signal measures, as its unit, shape and port say; "other" for what is no motion."""
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
    """A signal's channels in the order in which its values lie in memory, the last axis running fastest.

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
