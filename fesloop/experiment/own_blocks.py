"""Blocks defined in a notebook or a script: kinds of this process, with their source.

    @fesloop.block
    @dataclass(frozen=True, kw_only=True)
    class OwnPid: ...

makes `kind = "own_pid"` a kind like a shipped one. Its source, with all that it uses of the notebook
(functions, classes, constants, imports), is text that defines the class by itself. It is part of the document
of every experiment with the class: recordings keep it, workers of a study define the class from it, and
an experiment whose class has changed is another experiment.
"""

from __future__ import annotations
import __future__

import ast
import builtins
import inspect
import keyword
import linecache
import re
import symtable
import sys
import textwrap
import types
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from hashlib import sha256
from typing import Any, TypeVar, overload

import numpy as np

from fesloop.errors import InputError
from fesloop.experiment import registry

Class = TypeVar("Class", bound=type[Any])
_PLAIN = (bool, int, float, complex, str, bytes, type(None))
_IN_HAND = "another name, in lower case, with digits and underscores"
_defining = False


@overload
def block(cls: Class) -> Class: ...
@overload
def block(cls: str) -> Callable[[Class], Class]: ...
def block(cls: Any) -> Any:
    """Make a class of a notebook or a script a kind of block or plant in this process.

        @fesloop.block                    # kind "own_pid"; @fesloop.block("pi") names it
        @dataclass(frozen=True, kw_only=True)
        class OwnPid: ...

    Experiments, `--set` and studies take it as they take shipped kinds; their recordings keep its source. A
    class that is defined again takes the place of the former one.

    Raises InputError for a class that is no dataclass, breaks the contract (`fesloop.loop.block`), has the
    name of another kind, or whose source cannot be kept: one that is typed at a prompt, or uses values of the
    notebook that are no functions, classes, numbers, text or arrays.
    """
    if isinstance(cls, str):
        return lambda named: _registered(named, cls)
    return _registered(cls, None)


def _registered(cls: Any, kind: str | None) -> Any:
    if _defining:
        return cls
    if not isinstance(cls, type):
        raise InputError("block", f"{cls!r} is no class",
                         "a frozen dataclass with inputs, outputs, init, step",
                         "see docs/howto/add_a_block.md")
    if "__dataclass_fields__" not in vars(cls):
        raise InputError(cls.__name__, "is no dataclass", "@fesloop.block above @dataclass(frozen=True, "
                         "kw_only=True)", "see docs/howto/add_a_block.md")
    kind = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", cls.__name__).lower() if kind is None else kind
    if not re.fullmatch(r"[a-z][a-z0-9_]*", kind) or keyword.iskeyword(kind):
        raise InputError("kind", f"{kind!r} is no name of a kind", _IN_HAND)
    registry.register(kind, cls, source_of(cls))
    return cls


def kept_source(cls: type[Any]) -> str:
    """Source of a class that is no kind, or a comment that says why the recording cannot have it."""
    try:
        return source_of(cls)
    except InputError as fault:
        return f"# This run cannot be repeated from its recording: {fault}\n"


def define(code: Mapping[str, str]) -> None:
    """Define classes, by kind, from their sources; those that are known already stay."""
    known = registry.sources()
    for kind, source in code.items():
        if known.get(kind) != source:
            registry.register(kind, _defined(kind, source), source)


@lru_cache
def _defined(kind: str, source: str) -> type[Any]:
    """The class that a source ends with, in a module of its own."""
    global _defining
    name = f"fesloop_own_{kind}_{sha256(source.encode()).hexdigest()[:8]}"
    module = sys.modules[name] = types.ModuleType(name)
    linecache.cache[name] = len(source), None, source.splitlines(keepends=True), name
    _defining = True
    try:
        exec(compile(source, name, "exec", dont_inherit=True), vars(module))
    finally:
        _defining = False
    (*_, last) = (node for node in ast.parse(source).body if isinstance(node, ast.ClassDef))
    found: type[Any] = getattr(module, last.name)
    return found


def source_of(cls: type[Any]) -> str:
    """Text that defines a class by itself: imports, constants, functions and classes that it uses, then it.

    Raises InputError where that cannot be written down.
    """
    module = sys.modules.get(cls.__module__)
    names = {**(vars(module) if module is not None else {}), **_enclosed(cls)}
    pieces: dict[str, str] = {}
    _write(cls.__name__, cls, cls, names, pieces)
    future = any(each.__code__.co_flags & __future__.annotations.compiler_flag for each in _functions(cls))
    head = "from __future__ import annotations\n" if future else ""
    lines = [text for text in pieces.values() if text.startswith(("import ", "from "))]
    rest = [text for text in pieces.values() if not text.startswith(("import ", "from "))]
    return head + "\n".join(sorted(lines)) + "\n\n" + "\n\n".join(rest) + "\n"


def _write(name: str, value: Any, cls: type[Any], names: Mapping[str, Any], pieces: dict[str, str]) -> None:
    """Add the text that defines a name as a value, after that of all names which it uses."""
    if name in pieces:
        return
    pieces[name] = ""  # one that uses itself
    if (text := _import(name, value, cls)) is not None:
        pieces[name] = text
    elif isinstance(value, type) or inspect.isroutine(inspect.unwrap(value)):
        text = _text(name, value, cls)
        for used in _used(text):
            if used in names:
                _write(used, names[used], cls, names, pieces)
        del pieces[name]
        pieces[name] = text  # after what it uses
    elif _is_plain(value):
        pieces[name] = f"{name} = {value!r}"
    elif isinstance(value, np.ndarray) and value.dtype.kind in "biuf":
        _write("np", np, cls, names, pieces)
        pieces[name] = f"{name} = np.array({value.tolist()!r}, dtype={value.dtype.str!r})"
    else:
        raise InputError(cls.__name__, f"uses {name!r}, a {type(value).__name__}, which cannot be kept with "
                         "it", "functions, classes, numbers, text and arrays from outside",
                         f"make {name} a parameter of the class, or of its state")


def _import(name: str, value: Any, cls: type[Any]) -> str | None:
    """The line that imports a value; None for one of the class's own module, and for plain values."""
    if isinstance(value, types.ModuleType):
        return f"import {value.__name__} as {name}" if value.__name__ != name else f"import {name}"
    if _is_plain(value) or isinstance(value, np.ndarray):
        return None
    home, real = getattr(value, "__module__", None), getattr(value, "__name__", name)
    if isinstance(home, str) and home == cls.__module__:
        return None
    for place in (home, *_modules_with(real, value, cls)):
        if isinstance(place, str) and getattr(sys.modules.get(place), real, None) is value:
            return f"from {place} import {real}" + (f" as {name}" if real != name else "")
    return None


def _modules_with(name: str, value: Any, cls: type[Any]) -> Iterator[str]:
    """Imported modules that have a value under a name, the ones nearest to the top first."""
    users = (cls.__module__, "__main__", "__mp_main__")
    found = [place for place, module in list(sys.modules.items()) if place not in users
             and isinstance(module, types.ModuleType) and vars(module).get(name) is value]
    yield from sorted(found, key=lambda place: (place.count("."), "_" in place, len(place)))


def _is_plain(value: Any) -> bool:
    if isinstance(value, (tuple, list, frozenset, set)):
        return all(map(_is_plain, value))
    if isinstance(value, dict):
        return all(_is_plain(each) for pair in value.items() for each in pair)
    return type(value) in _PLAIN


def _used(text: str) -> list[str]:
    """Names that a definition takes from outside, sorted."""
    found: set[str] = set()
    pending = [symtable.symtable(text, "source", "exec")]
    while pending:
        table = pending.pop()
        pending += table.get_children()
        top = table.get_type() == "module"
        found |= {each.get_name() for each in table.get_symbols()
                  if each.is_referenced() and (top or each.is_global())}
    return sorted(name for name in found if not hasattr(builtins, name))


def _functions(cls: type[Any]) -> Iterator[types.FunctionType]:
    """Functions of a class's body."""
    for member in vars(cls).values():
        member = getattr(member, "__func__", getattr(member, "fget", member))
        member = inspect.unwrap(member) if callable(member) else member
        if isinstance(member, types.FunctionType):
            yield member


def _enclosed(cls: type[Any]) -> dict[str, Any]:
    """Variables of the function in which a class is defined."""
    found: dict[str, Any] = {}
    for function in _functions(cls):
        for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
            if name != "__class__":
                found[name] = cell.cell_contents
    return found


def _text(name: str, value: Any, cls: type[Any]) -> str:
    """Source of a class or function of a module or a notebook's cell."""
    text = _class_text(value) if isinstance(value, type) else _function_text(inspect.unwrap(value))
    if text is None:
        whole = f"{cls.__name__}: " if value is not cls else ""
        raise InputError(f"{whole}{name}", "has no source that could be kept with recordings",
                         "a class or function (`def`) in a cell of a notebook, or in a file",
                         "write it there, and import it or run the cell")
    return text


def _function_text(function: Any) -> str | None:
    try:
        text = textwrap.dedent(inspect.getsource(function))
        ast.parse(text)
    except (OSError, TypeError, SyntaxError):
        return None
    return None if function.__name__ == "<lambda>" else text


def _class_text(cls: type[Any]) -> str | None:
    """Source of a class, with its decorators, from the file or cell of its methods.

    `inspect.getsource` finds no class of a notebook before Python 3.13, and of a class that is defined twice
    the first.
    """
    for number, lines in _places(cls):
        try:
            tree = ast.parse("".join(lines))
        except SyntaxError:
            continue
        found = [node for node in ast.walk(tree)
                 if isinstance(node, ast.ClassDef) and node.name == cls.__name__ and (
                     number is None or node.lineno <= number <= (node.end_lineno or 0))]
        if found:
            first = min([found[-1].lineno, *(each.lineno for each in found[-1].decorator_list)])
            return textwrap.dedent("".join(lines[first - 1:found[-1].end_lineno])).strip("\n")
    return None


def _places(cls: type[Any]) -> Iterator[tuple[int | None, list[str]]]:
    """Texts that may define a class, with the line of a method: its module, or cells, the newest first."""
    for function in _functions(cls):
        yield function.__code__.co_firstlineno, linecache.getlines(function.__code__.co_filename)
    file = getattr(sys.modules.get(cls.__module__), "__file__", None)
    if file:
        yield None, linecache.getlines(file)
    else:
        for name in reversed(list(linecache.cache)):
            yield None, linecache.getlines(name)
