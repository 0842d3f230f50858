"""Pages of block kinds, from the registry: a heading a kind, and its class as its docstring tells it."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from typing import Any

from fesloop.experiment import registry


def kinds_of(package: str) -> list[str]:
    """Registered kinds whose class lives in a package, by name."""
    return [kind for kind in registry.kinds() if registry.find(kind).__module__.startswith(f"{package}.")]


def block_pages(package: str) -> Iterator[str]:
    """Lines of MyST Markdown, to stand under a heading of the first level."""
    for kind in kinds_of(package):
        block = registry.find(kind)
        yield from (f"## `{kind}`", "", "```{eval-rst}", f".. autoclass:: {importable(block)}", "```", "")


def importable(block: type[Any]) -> str:
    """The shortest path by which a class can be imported."""
    room, name = block.__module__.rpartition(".")[0], block.__qualname__
    public = room.count(".") > 0 and getattr(import_module(room), name, None) is block
    return f"{room if public else block.__module__}.{name}"
