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


def fault_errors(faults: Iterable[SensorFault], names: Sequence[str]) -> dict[int, InputError]:
    """The first fault of every sensor that has one, by its number, in the order of these."""
    first: dict[int, InputError] = {}
    for sensor, found, allowed, remedy in faults:
        if sensor not in first:
            first[sensor] = InputError(sensor_name(sensor, names), found, allowed, remedy)
    return dict(sorted(first.items()))


def raise_faults(faults: Iterable[SensorFault], names: Sequence[str]) -> None:
    """Raise InputErrors, a line a sensor, unless there are no faults."""
    errors = fault_errors(faults, names)
    if errors:
        raise InputErrors(list(errors.values()))
