"""Drivers by name, found through entry points of the group "fesloop.stimulators"."""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import cast

from fesloop.errors import InputError, did_you_mean
from plants.devices.driver import StimulatorDriver

GROUP = "fesloop.stimulators"


@cache
def _entries() -> dict[str, EntryPoint]:
    return {entry.name: entry for entry in entry_points(group=GROUP)}


def driver_names() -> list[str]:
    """Every registered driver."""
    return sorted(_entries())


def driver_place(name: str) -> str:
    """Where the driver of that name is, as "module:Class"; InputError where there is none."""
    if name not in _entries():
        raise InputError("driver", f"there is no stimulator driver {name!r}", ", ".join(driver_names()),
                         did_you_mean(name, driver_names()))
    return _entries()[name].value


def find_driver(name: str) -> type[StimulatorDriver]:
    """The driver's class; InputError for one that does not exist or does not import."""
    place = driver_place(name)
    try:
        return cast("type[StimulatorDriver]", _entries()[name].load())
    except (ImportError, AttributeError) as fault:
        raise InputError("driver", f"{name!r} ({place}) does not import: {fault}",
                         remedy="reinstall the package that provides it") from fault
