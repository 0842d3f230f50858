"""Lets `sphinx.ext.autodoc` show this project's docstrings: see `docstrings`."""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Iterable, Mapping
from contextlib import suppress
from typing import Any, Literal, get_args, get_origin

from docstrings import as_rst
from sphinx.application import Sphinx


def setup(app: Sphinx) -> dict[str, Any]:
    """As Sphinx asks of an extension."""
    app.connect("autodoc-process-docstring", _process)
    app.connect("autodoc-process-signature", _signature)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _process(app: Sphinx, what: str, name: str, shown: Any, options: Any, lines: list[str]) -> None:
    """Write a docstring's lines anew, in place, as autodoc wants it."""
    lines[:] = as_rst([line.rstrip() for line in lines], types_of(shown))


def _signature(
    app: Sphinx, what: str, name: str, shown: Any, options: Any, signature: str | None, returned: str | None
) -> tuple[str, None] | None:
    """None for a contract, which nobody makes objects of."""
    return ("", None) if getattr(shown, "_is_protocol", False) else None


def types_of(shown: Any) -> dict[str, str]:
    """Annotations of what a class or function takes or holds, by name, as they are written."""
    annotations: dict[str, Any] = {}
    for owner in reversed(getattr(shown, "__mro__", (shown,))):
        annotations |= getattr(owner, "__annotations__", {})
    parameters: Iterable[inspect.Parameter] = ()
    with suppress(TypeError, ValueError):  # what has no signature is told by its annotations alone
        parameters = inspect.signature(shown).parameters.values()
    annotations |= {each.name: each.annotation for each in parameters
                    if each.annotation is not inspect.Parameter.empty}
    names = vars(sys.modules[shown.__module__]) if getattr(shown, "__module__", None) in sys.modules else {}
    return {name: _written(annotation, names) for name, annotation in annotations.items()
            if name != "return" and "ClassVar" not in str(annotation)}


def _written(annotation: Any, names: Mapping[str, Any]) -> str:
    """An annotation as it is read; a name for a few words is those words."""
    if isinstance(annotation, str):
        meant = names.get(annotation)
        return " | ".join(map(repr, get_args(meant))) if get_origin(meant) is Literal else annotation
    if isinstance(annotation, type) and not hasattr(annotation, "__args__"):
        return annotation.__qualname__
    return re.sub(r"\b(?:[a-z_]\w*\.)+(?=[A-Za-z_])", "", str(annotation))
