"""Pages of block kinds, from the registry: a heading a kind, and its class as its docstring tells it."""

from __future__ import annotations

from collections.abc import Iterator

from fesloop.experiment import registry


def kinds_of(package: str) -> list[str]:
    """Registered kinds whose class lives in a package, by name."""
    return [kind for kind in registry.kinds() if registry.find(kind).__module__.startswith(f"{package}.")]


def block_pages(package: str) -> Iterator[str]:
    """Lines of MyST Markdown, to stand under a heading of the first level."""
    for kind in kinds_of(package):
        block = registry.find(kind)
        name = f"{block.__module__}.{block.__qualname__}"
        yield from (f"## `{kind}`", "", "```{eval-rst}", f".. autoclass:: {name}", "```", "")
