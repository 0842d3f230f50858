"""Block kinds: what `kind = "..."` in an experiment may say, found through entry points.

A package of anybody's adds a kind by an entry point of the group "fesloop.blocks" whose value names the
frozen dataclass that is the block or plant.
"""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, cast

from fesloop.errors import InputError, did_you_mean

GROUP = "fesloop.blocks"


@cache
def _entries() -> dict[str, EntryPoint]:
    return {entry.name: entry for entry in entry_points(group=GROUP)}


def kinds() -> list[str]:
    """Every registered kind, by name."""
    return sorted(_entries())


@cache
def find(kind: str) -> type[Any]:
    """The block class of a kind.

    Raises InputError for an unknown kind, and for one whose package does not import.
    """
    entry = _entries().get(kind)
    if entry is None:
        remedy = (did_you_mean(kind, kinds()) if ":" not in kind else
                  "a class becomes a kind by an entry point of an installed package, in the group "
                  f'"{GROUP}"; in Python give an object of it to Node')
        raise InputError("kind", f"there is no block kind {kind!r}", ", ".join(kinds()), remedy)
    try:
        return cast("type[Any]", entry.load())
    except (ImportError, AttributeError) as fault:
        if isinstance(fault.__cause__ or fault.__context__, KeyboardInterrupt):
            raise KeyboardInterrupt from fault  # a module in C says "initialization failed" instead
        raise InputError("kind", f"block kind {kind!r} ({entry.value}) does not import: {fault}",
                         remedy="reinstall the package that provides it") from fault


def kind_of(block: type[Any]) -> str:
    """The kind under which a class is registered, else "module:Class"."""
    value = f"{block.__module__}:{block.__qualname__}"
    return next((name for name, entry in _entries().items() if entry.value == value), value)


def summary(kind: str) -> str:
    """First line of the docstring of a kind's class."""
    return (find(kind).__doc__ or "").strip().partition("\n")[0]
