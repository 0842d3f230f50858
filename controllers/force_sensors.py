"""Places of the force sensors whose readings a controller gets: given to it, or stated by their block."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.hand.anthropometry import PARTS
from fesloop.hand.grip import require_places
from fesloop.loop.signals import Sensors

Array = NDArray[np.float64]


def wired_places(places: tuple[str, ...], sources: Mapping[str, Sensors]) -> tuple[str, ...]:
    """Places of the sensors wired to the input `force`, by their source, or the given ones.

    Raises InputError for a source that states other places than the given ones, and for one whose sensors
    have names that are no parts of the hand, unless `places` gives theirs.
    """
    source = sources.get("force")
    if source is None:
        return places
    if not set(source.names) <= set(PARTS):
        if not places:
            require_places(source.names, "force")
        return places
    if places and places != source.names:
        raise InputError("places", ", ".join(places), ", ".join(source.names) + ", as the wired sensors are",
                         "remove it")
    return source.names


def require_felt(places: tuple[str, ...], contact_places: tuple[str, ...]) -> None:
    """Raise InputError for places that do not exist, and for contact at places without a sensor."""
    require_places(places, "places")
    require_places(contact_places, "contact_places")
    missing = [place for place in contact_places if places and place not in places]
    if missing:
        raise InputError("contact_places", f"{', '.join(missing)}: no force sensor is there",
                         ", ".join(places), "remove them, or add sensors to `places` of the sensors' block")


def contact_force(force: Array, places: tuple[str, ...], contact_places: tuple[str, ...]
                  ) -> tuple[float, str]:
    """Greatest of the forces (k,), N, on `contact_places`, or of all if that is empty, and its place.

    `places`: (k,); empty for sensors without names, whose place is then a number. NaN counts as no force.
    """
    names = places or tuple(f"sensor {i}" for i in range(force.size))
    felt = [i for i, name in enumerate(names) if name in (contact_places or names)]
    strongest = felt[int(np.argmax(np.nan_to_num(force[felt], nan=0.0, posinf=np.inf)))]
    return float(force[strongest]), names[strongest]


def require_count(places: tuple[str, ...], shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Raise InputError for readings of sensors without known places."""
    if "force" in shapes and not places:
        raise InputError("places", f"is missing, and the {shapes['force'][0]} wired forces have no names",
                         "a part of the hand for each: " + ", ".join(PARTS))
