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
from functools import cache, lru_cache, partial
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeVar, overload

import numpy as np

from fesloop.errors import InputError
from fesloop.experiment import registry

Class = TypeVar("Class", bound=type[Any])
_PLAIN = (bool, int, float, complex, str, bytes, type(None))
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
        raise InputError("kind", f"{kind!r} is no name of a kind",
                         "lower-case letters, digits and underscores, no word of Python")
    registry.register(kind, cls, _Source(cls))
    return cls


def kept_source(cls: type[Any]) -> str:
    """Source of a class that is no kind, or a comment that says why the recording cannot have it."""
    try:
        return source_of(cls)
    except InputError as fault:
        return f"# This run cannot be repeated from its recording: {fault}\n"


def define(code: Mapping[str, str]) -> None:
    """Define classes, by kind, from their sources; those that are known already stay."""
    for kind, source in code.items():
        if registry.source(kind) != source:
            registry.register(kind, _defined(kind, source), partial(str, source))


@cache
def _folder() -> TemporaryDirectory[str]:
    """Folder of the sources that this process has defined classes from; it goes with the process."""
    return TemporaryDirectory(prefix="fesloop-")


@lru_cache
def _defined(kind: str, source: str) -> type[Any]:
    """The class that a source ends with, in a module of its own."""
    global _defining
    name = f"fesloop_own_{kind}_{sha256(source.encode()).hexdigest()[:8]}"
    module = sys.modules[name] = types.ModuleType(name)
    file = Path(_folder().name) / f"{name}.py"  # numba caches what it compiles of files alone
    file.write_text(source, encoding="utf-8")
    module.__file__ = str(file)
    _defining = True
    try:
        exec(compile(source, str(file), "exec", dont_inherit=True), vars(module))
    finally:
        _defining = False
    (*_, last) = (node for node in ast.parse(source).body if isinstance(node, ast.ClassDef))
    found: type[Any] = getattr(module, last.name)
    return found


def source_of(cls: type[Any]) -> str:
    """Text that defines a class by itself: imports, constants, functions and classes that it uses, then it.

    Raises InputError where that cannot be written down.
    """
    return _Source(cls)()


class _Source:
    """Text that defines a class by itself, as long as what it uses remains the same."""

    def __init__(self, cls: type[Any]) -> None:
        self._cls = cls
        self._write_all()

    def __call__(self) -> str:
        """The text; it is written anew where a name that the class uses has another value than before.

        Otherwise it is that of when the class was registered: its file may have been edited since.
        """
        names = self._names()
        if any(name not in names or not self._same(name, value, names[name])
               for name, value in self._values.items() if value is not self._cls):
            self._write_all()
        return self._text

    def _names(self) -> dict[str, Any]:
        module = sys.modules.get(self._cls.__module__)
        return {**(vars(module) if module is not None else {}), **_enclosed(self._cls)}

    def _same(self, name: str, before: Any, now: Any) -> bool:
        constant = _constant(name, now)
        return before is now if constant is None else constant == self._pieces[name]

    def _write_all(self) -> None:
        self._pieces: dict[str, str] = {}
        self._values: dict[str, Any] = {}
        self._write(self._cls.__name__, self._cls, self._names())
        future = any(each.__code__.co_flags & __future__.annotations.compiler_flag
                     for each in _functions(self._cls))
        imports = [text for text in self._pieces.values() if text.startswith(("import ", "from "))]
        rest = [text for text in self._pieces.values() if not text.startswith(("import ", "from "))]
        if any(re.search(r"\b(inf|nan)\b", text) for text in rest):
            imports.append("from math import inf, nan")
        head = ["from __future__ import annotations"] if future else []
        self._text = "\n\n\n".join(["\n".join([*head, *sorted(set(imports))]), *rest]) + "\n"

    def _write(self, name: str, value: Any, names: Mapping[str, Any]) -> None:
        """Add the text that defines a name as a value, after that of all names which it uses."""
        if name in self._pieces:
            return
        cls, self._values[name] = self._cls, value
        self._pieces[name] = ""  # one that uses itself
        text = _import(name, value, cls) or _constant(name, value)
        if text is None and (isinstance(value, type) or inspect.isroutine(inspect.unwrap(value))):
            text = _definition(name, value, cls)
            for used in _used(text):
                if used in names:
                    self._write(used, names[used], names)
        if text is None:
            raise InputError(cls.__name__, f"uses {name!r}, a {type(value).__name__}, which cannot be kept "
                             "with it", "functions, classes, numbers, text and arrays from outside",
                             f"make {name} a parameter of the class, or of its state")
        del self._pieces[name]
        self._pieces[name] = text  # after what it uses


def _constant(name: str, value: Any) -> str | None:
    """The line that defines plain values; None for anything else."""
    if isinstance(value, np.ndarray) and value.dtype.kind in "biuf":
        return f"{name} = __import__('numpy').array({value.tolist()!r}, dtype={value.dtype.str!r})"
    if isinstance(value, np.generic) and value.dtype.kind in "biuf":
        return f"{name} = __import__('numpy').{type(value).__name__}({value.item()!r})"
    return f"{name} = {value!r}" if _is_plain(value) else None


def _import(name: str, value: Any, cls: type[Any]) -> str | None:
    """The line that imports a value; None for one of the class's own module, and for plain values."""
    if isinstance(value, types.ModuleType):
        return f"import {value.__name__} as {name}" if value.__name__ != name else f"import {name}"
    if _constant(name, value) is not None:
        return None
    home = getattr(value, "__module__", None) or type(value).__module__
    real = getattr(value, "__name__", name)
    if home == cls.__module__:
        return None
    for known in dict.fromkeys((real, name)):  # an alias of a type has the name of the type
        for place in (home, *_modules_with(known, value, home)):
            if getattr(sys.modules.get(place), known, None) is value:
                return f"from {place} import {known}" + (f" as {name}" if known != name else "")
    return None


def _modules_with(name: str, value: Any, home: str) -> list[str]:
    """Modules of the package that a value is of that have it under a name, the ones nearest to the top first.

    Only that package is searched: which others have imported it differs from process to process.
    """
    package = home.partition(".")[0]
    found = [place for place, module in list(sys.modules.items()) if place.partition(".")[0] == package
             and isinstance(module, types.ModuleType) and vars(module).get(name) is value]
    return sorted(found, key=lambda place: (place.count("."), "_" in place, len(place), place))


def _is_plain(value: Any) -> bool:
    if isinstance(value, (tuple, list)):
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


def _definition(name: str, value: Any, cls: type[Any]) -> str:
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
        text = textwrap.dedent(inspect.getsource(function)).strip("\n")
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
        for entry in reversed(list(linecache.cache.values())):
            if len(entry) == 4 and entry[1] is None:  # of no file
                yield None, entry[2]
