"""What makes a patient's model of a recording, found through entry points of the group "fesloop.identifiers".

The entry is a function of a recording's path; what it gives has a `model` that can be saved.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import entry_points
from typing import Any

from fesloop.errors import InputError

GROUP = "fesloop.identifiers"


def identifier() -> Callable[..., Any]:
    """The first entry of the group, by name. Raises InputError if there is none."""
    entry = next(iter(sorted(entry_points(group=GROUP), key=lambda each: each.name)), None)
    if entry is None:
        raise InputError("identify", "no installed package identifies models",
                         remedy=f"install one with an entry point in {GROUP!r}")
    found: Callable[..., Any] = entry.load()
    return found
