"""Compiled functions, kept on disk until a source that they depend on changes.

Numba keeps a compiled function while its own file is unchanged, with the versions of functions of other files
at the time of compilation. `compiled` keeps it only while its file, and every file of fesloop or of its own
package that this file imports, directly or not, is unchanged.
"""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, overload

import numba
from numba.core import caching

_Function = TypeVar("_Function", bound=Callable[..., Any])
_IMPORT = re.compile(r"^(?:from|import) +([\w.]+)(?: +import +(\([^)]*\)|.*))?", re.MULTILINE)
_OURS = ("fesloop", "plants", "estimators", "controllers")


@overload
def compiled(function: _Function) -> _Function: ...
@overload
def compiled(*, inline: str) -> Callable[[_Function], _Function]: ...
def compiled(function: Any = None, **options: Any) -> Any:
    """Compile a function with Numba at its first call, and keep the result on disk."""
    decorate = numba.njit(cache=True, **options)
    return decorate if function is None else decorate(function)


def compiled_callback(signature: Any) -> Callable[[Any], Any]:
    """Compile a function for C code that calls it, which has its `address`, and keep the result on disk."""
    decorate: Callable[[Any], Any] = numba.cfunc(signature, cache=True)
    return decorate


@cache
def sources(module: str) -> tuple[Path, ...]:
    """Files that a loaded module consists of: its own, and those of ours that it imports, directly or not."""
    found: dict[str, Path] = {}
    ours = {*_OURS, module.partition(".")[0]}
    left = [module]
    while left:
        name = left.pop()
        file = getattr(sys.modules.get(name), "__file__", None)
        if name in found or file is None:
            continue
        found[name] = Path(file)
        left += [each for each in _imported(Path(file).read_text()) if each.partition(".")[0] in ours]
    return tuple(sorted(found.values()))


def _imported(text: str) -> Iterator[str]:
    """Modules that a source imports when it is loaded; `from a import b` may be a module a.b."""
    for module, names in _IMPORT.findall(text):
        yield module
        yield from (f"{module}.{name}" for name in re.findall(r"\w+", names))


@cache
def _stamp(module: str) -> str:
    """Digest of a module's sources, and of what else it says that its functions are `compiled_for`."""
    digest = hashlib.blake2b(repr(vars(sys.modules[module]).get("compiled_for")).encode(), digest_size=16)
    for path in sources(module):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _stamped(locator: Any) -> Any:
    """A place where Numba keeps compiled functions, for those whose sources are known."""

    class Stamped(locator):  # type: ignore[misc]
        def get_source_stamp(self) -> Any:
            return self.stamp

        @classmethod
        def from_function(cls, py_func: Any, py_file: str) -> Any:
            module = sys.modules.get(py_func.__module__)
            if module is None or "compiled" not in vars(module) or vars(module)["compiled"] is not compiled:
                return None
            found = super().from_function(py_func, py_file)
            if found is not None:
                found.stamp = _stamp(py_func.__module__)
            return found

    return Stamped


def _register() -> None:
    """Have Numba ask for our stamp: same folders and names of files as its own."""
    kinds = [getattr(caching, name, None) or getattr(caching, f"_{name}")
             for name in ("UserProvidedCacheLocator", "InTreeCacheLocator", "UserWideCacheLocator")]
    caching.CacheImpl._locator_classes[:0] = [_stamped(kind) for kind in kinds]


_register()


@compiled
def assign(target: Any, source: Any) -> None:
    """Copy `source` (n,) into `target` (n,).

    The assignment of an array to a slice compiles the text of its error too, which takes 2 s in every process
    that compiles one.
    """
    for i in range(target.size):
        target[i] = source[i]
