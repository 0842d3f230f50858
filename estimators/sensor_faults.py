"""What is wrong with single sensors, said so that the wearer knows which one and what to do."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from fesloop.errors import InputError, InputErrors


class SensorFault(NamedTuple):
    """One fault of one sensor: its number, what was found, what is allowed, what to do."""

    sensor: int
    found: str
    allowed: str
    remedy: str


def sensor_name(sensor: int, names: Sequence[str]) -> str:
    """What messages call a sensor: the segment it sits on, or its number."""
    return names[sensor] if names else f"sensor {sensor}"


def first_of_each(faults: Iterable[SensorFault]) -> dict[int, SensorFault]:
    """The first fault of every sensor, by its number."""
    first: dict[int, SensorFault] = {}
    for fault in faults:
        first.setdefault(fault.sensor, fault)
    return first


def raise_faults(faults: Sequence[SensorFault], names: Sequence[str]) -> None:
    """Raise InputErrors, a line a sensor, unless there are no faults."""
    if faults:
        raise InputErrors([InputError(sensor_name(sensor, names), fault.found, fault.allowed, fault.remedy)
                           for sensor, fault in first_of_each(faults).items()])
