"""Strict check of plain tables against the annotations of parameter dataclasses, and objects made of them.

A table is checked by pydantic (strict, no extra keys) against a typed dict made from the dataclass, so the
dataclass stays the one place where a parameter is declared. `build` makes the object from a checked
table, `plain` the table from an object.
"""

from __future__ import annotations

import math
import types
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import MISSING, Field, fields, is_dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    NotRequired,
    Protocol,
    Required,
    Union,
    cast,
    get_args,
    get_origin,
    get_type_hints,
    runtime_checkable,
)

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ConfigDict, Discriminator, Tag
from pydantic import Field as Described
from typing_extensions import TypedDict, is_typeddict

from fesloop.errors import InputError


def matrix(where: str, rows: ArrayLike) -> NDArray[np.float64]:
    """Numbers, or rows of them, as an array. Raises InputError for rows of unequal length."""
    try:
        return np.atleast_1d(np.asarray(rows, dtype=np.float64))
    except ValueError:
        raise InputError(where, "rows of unequal length", "rows of one length") from None


def require_positive(owner: str, parameters: object, *keys: str) -> None:
    """Raise InputError unless every number under each key is finite and above 0."""
    for key in keys:
        value = np.asarray(getattr(parameters, key))
        if not (np.isfinite(value).all() and (value > 0.0).all()):
            raise InputError(f"{owner}.{key}", f"{getattr(parameters, key)}", "finite numbers above 0")


def require_not_negative(owner: str, parameters: object, *keys: str) -> None:
    """Raise InputError unless every number under each key is finite and 0 or more."""
    for key in keys:
        value = np.asarray(getattr(parameters, key))
        if not (np.isfinite(value).all() and (value >= 0.0).all()):
            raise InputError(f"{owner}.{key}", f"{getattr(parameters, key)}", "finite numbers, 0 or more")


def require_shape(owner: str, parameters: object, shape: tuple[int, ...], meaning: str, *keys: str) -> None:
    """Raise InputError unless the numbers under each key are finite and have the shape."""
    for key in keys:
        try:
            value = np.asarray(getattr(parameters, key), dtype=np.float64)
        except ValueError:
            raise InputError(f"{owner}.{key}", "rows of unequal length",
                             f"shape {shape}: {meaning}") from None
        if value.shape != shape:
            raise InputError(f"{owner}.{key}", f"shape {value.shape}", f"shape {shape}: {meaning}")
        if not np.isfinite(value).all():
            raise InputError(f"{owner}.{key}", f"{getattr(parameters, key)}", "finite numbers")


STRICT = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)
Kinds = Mapping[str, type[Any]]
NestedNumbers = list[float] | list[list[float]]
_LITERAL, _FILE = "matrices", "file"


class FileBacked(Protocol):
    """A class of parameters that can be read from a file of their own.

    Attributes
    ----------
    FILE_KEYS: further keys of a table {file = "..."}, each with its type.
    OFFERED_BY: the method by which a plant offers its own; empty where none does.
    """

    FILE_KEYS: ClassVar[Mapping[str, type]]
    OFFERED_BY: ClassVar[str]


@runtime_checkable
class ReadsFile(Protocol):
    """A class of parameters that reads the tables of its own files."""

    def file_tables(self, path: Path) -> dict[str, Any]:
        """Read the parameters' tables from a file, unchecked. Raises InputError for another kind of file."""


def hints_of(cls: type[Any], extras: bool = True) -> Mapping[str, Any]:
    """Annotations of a class's attributes, by name, resolved; with or without the `extras` of `Annotated`."""
    return _hints_of(cast(Hashable, cls), extras)


@cache
def _hints_of(cls: Hashable, extras: bool) -> Mapping[str, Any]:
    return MappingProxyType(get_type_hints(cls, include_extras=extras))


def table(cls: type[Any], kinds: Kinds, extra: Mapping[str, Any] | None = None,
          rename: Mapping[str, str] | None = None) -> Any:
    """Typed dict of a dataclass's parameters.

    `kinds` are those that may stand for a LinearModel; `extra` adds keys (name to annotation) and
    `rename` gives a field another name in files.
    """
    hints = hints_of(cls)
    keys: dict[str, Any] = dict(extra or {})
    for field in fields(cls):
        name = (rename or {}).get(field.name, field.name)
        if field.init:
            if name in keys:
                raise InputError(f"{cls.__module__}:{cls.__qualname__}.{name}",
                                 "is a key that fesloop itself uses beside a block's parameters",
                                 "another parameter name")
            keys[name] = _key(field, checked(hints[field.name], kinds))
    return closed(cls.__name__, keys)


def closed(name: str, keys: dict[str, Any]) -> Any:
    """Typed dict that takes these keys and no other."""
    make_typed_dict: Any = TypedDict
    made = make_typed_dict(name, keys)
    made.__pydantic_config__ = STRICT
    return made


def _key(field: Field[Any], annotation: Any) -> Any:
    if field.default is not MISSING:
        default = field.default
        if isinstance(default, float) and math.isinf(default):  # no limit
            annotation = Annotated[annotation, Described(allow_inf_nan=True)]
    elif field.default_factory is not MISSING:
        default = field.default_factory()
    else:
        return Required[annotation]
    return NotRequired[Annotated[annotation, Described(json_schema_extra={"default": plain(default)})]]


def checked(annotation: Any, kinds: Kinds) -> Any:
    """Annotation of the plain value in a file from which a value of `annotation` is made."""
    if _is_file_backed(annotation):
        return _file_backed(annotation, kinds)
    if is_dataclass(annotation) and isinstance(annotation, type):
        return table(annotation, kinds)
    annotation = _expanded(annotation)
    origin, args = get_origin(annotation), get_args(annotation)
    if origin is np.ndarray:
        return NestedNumbers
    if origin in (Union, types.UnionType):
        return Union[tuple(checked(arg, kinds) for arg in args)]  # noqa: UP007
    if origin is Annotated:
        return Annotated[(checked(args[0], kinds), *args[1:])]
    if origin in (None, Literal) or not args:
        return annotation
    return origin[tuple(arg if arg is ... else checked(arg, kinds) for arg in args)]


def _expanded(annotation: Any) -> Any:
    """Type behind an alias; `NDArray` is one from numpy 2.5 on, where Python is 3.12 or later."""
    alias = getattr(get_origin(annotation), "__value__", None)
    return annotation if alias is None else alias[get_args(annotation)]


def _is_file_backed(annotation: Any) -> bool:
    return isinstance(annotation, type) and hasattr(annotation, "FILE_KEYS")


def _file_backed(cls: type[FileBacked], kinds: Kinds) -> Any:
    """Annotation of the tables accepted for a class of parameters.

    `{kind = "finger", ...}` takes those that a part of this kind offers, other tables are the parameters, and
    `{file = "..."}` is replaced by the file's parameters (`fesloop.experiment.files.patients`).
    """
    parts = {kind: part for kind, part in kinds.items() if cls.OFFERED_BY and hasattr(part, cls.OFFERED_BY)}
    members = [Annotated[table(part, {}, {"kind": Required[Literal[kind]]}), Tag(kind)]
               for kind, part in parts.items()]
    members.append(Annotated[table(cls, {}), Tag(_LITERAL)])
    keys: dict[str, Any] = {key: NotRequired[hint] for key, hint in cls.FILE_KEYS.items()}
    file = closed(f"{cls.__name__}File", {"file": Required[str], **keys})
    members.append(Annotated[file, Tag(_FILE)])
    return Annotated[Union[tuple(members)], Discriminator(_model_tag)]  # noqa: UP007


def _model_tag(value: Any) -> Any:
    if isinstance(value, dict):
        return value.get("kind", _FILE if "file" in value else _LITERAL)
    return _LITERAL


def build(annotation: Any, value: Any, kinds: Kinds, where: str) -> Any:
    """Make an object from a checked plain value.

    Raises InputError, its place led by `where`, for what the object itself refuses, for matrices with rows of
    unequal length, and for numbers with which what the object derives from them leaves the range of floats.
    """
    if _is_file_backed(annotation) and isinstance(value, dict) and "kind" in value:
        rest = {key: item for key, item in value.items() if key != "kind"}
        return getattr(make(kinds[value["kind"]], rest, kinds, where), annotation.OFFERED_BY)()
    if is_dataclass(annotation) and isinstance(annotation, type):
        return make(annotation, value, kinds, where) if isinstance(value, dict) else value
    annotation = _expanded(annotation)
    origin, args = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return build(args[0], value, kinds, where)
    if origin in (Union, types.UnionType):
        return build(_member(args, value), value, kinds, where)
    if origin is np.ndarray:
        return matrix(where, value)
    if origin is tuple and isinstance(value, (list, tuple)):
        every = args if args[-1] is not ... else (args[0],) * len(value)
        return tuple(build(arg, item, kinds, f"{where}[{i}]")
                     for i, (arg, item) in enumerate(zip(every, value, strict=True)))
    if origin is dict and isinstance(value, dict):
        return {key: build(args[1], item, kinds, f"{where}.{key}") for key, item in value.items()}
    if annotation is Path:
        return Path(value)
    return float(value) if annotation is float and isinstance(value, int) else value


def _member(args: tuple[Any, ...], value: Any) -> Any:
    """Member of a union that a plain value belongs to."""
    for arg in map(_expanded, args):
        origin = get_origin(arg) or arg
        holds = {dict: is_dataclass(arg) or origin is dict, list: origin in (tuple, list, np.ndarray),
                 str: origin in (str, Path, Literal), bool: origin is bool, int: origin is int,
                 float: origin is float, type(None): arg is type(None)}
        if holds.get(type(value), False):
            return arg
    return float if isinstance(value, int) and float in args else Any


def make(cls: type[Any], values: Mapping[str, Any], kinds: Kinds, where: str) -> Any:
    """Make the object of a dataclass from its checked table."""
    hints = hints_of(cls)
    given = {key: build(hints[key], value, kinds, f"{where}.{key}") for key, value in values.items()}
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            return cls(**given)
    except (ArithmeticError, MemoryError, np.linalg.LinAlgError) as fault:
        why = str(fault) or "they need more memory than there is"
        raise InputError(where, f"its numbers cannot be computed with: {why}",
                         "numbers of a size that occurs") from fault
    except InputError as fault:
        place = _place(fault.where, where, hints, cls.__name__.lower())
        raise InputError(place, fault.found, fault.allowed, fault.remedy) from fault


def _place(inner: str, where: str, names: Mapping[str, Any], own: str) -> str:
    """Path of a parameter that an object names, after the path of the object without its own name.

    A parameter may have the object's `own` name, as that of a hand's measures has.
    """
    def is_key(path: str) -> bool:
        return path.partition(".")[0].partition("[")[0] in names

    first, _, rest = inner.partition(".")
    if is_key(rest) and (first == own or not is_key(inner)):
        inner = rest
    return f"{where}.{inner}" if is_key(inner) else f"{where}: {inner}"


def plain(value: Any, declared: Any = Any) -> Any:
    """Plain value in a file for a parameter object: tables, lists, numbers, text. None is left out.

    An int where a float is `declared` is that float, so that both spellings are one experiment.
    """
    if is_dataclass(value) and not isinstance(value, type):
        hints = hints_of(type(value), extras=False)
        items = ((field.name, getattr(value, field.name)) for field in fields(value) if field.init)
        return {name: plain(item, hints[name]) for name, item in items if item is not None}
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [plain(item, hint) for item, hint in zip(value, _items(declared, len(value)), strict=False)]
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if type(value) is int:
        members = {declared, *get_args(declared)}
        return float(value) if float in members and int not in members else value
    return str(value) if isinstance(value, (Fraction, Path)) else value


def _items(declared: Any, size: int) -> Sequence[Any]:
    """The annotations of a list's items."""
    for member in (declared, *get_args(declared)):
        args = get_args(member)
        if get_origin(member) in (tuple, list) and args:
            return args if get_origin(member) is tuple and args[-1] is not ... else (args[0],) * size
    return (Any,) * size


def keys_at(annotation: Any, path: Sequence[Any], document: Any) -> list[str]:
    """Valid keys at a path of a document of the given form."""
    for key in path:
        annotation = _below(_bare(annotation, document), key)
        document = document[key]
    bare = _bare(annotation, document)
    return list(bare.__annotations__) if is_typeddict(bare) else []


def _bare(annotation: Any, document: Any) -> Any:
    """The annotation without wrappers, and of a union the member of the document's kind."""
    while get_origin(annotation) in (Annotated, Required, NotRequired):
        annotation = get_args(annotation)[0]
    if get_origin(annotation) not in (Union, types.UnionType):
        return annotation
    members = [_bare(arg, document) for arg in get_args(annotation)]
    members = [m for m in members if is_typeddict(m) or get_origin(m) in (dict, list, tuple)]
    kind = document.get("kind") if isinstance(document, Mapping) else None
    for member in members:
        if is_typeddict(member) and kind in get_args(_bare(member.__annotations__.get("kind"), None)):
            return member
    return members[-1] if members else annotation


def _below(annotation: Any, key: Any) -> Any:
    """Annotation of the value under a key."""
    if is_typeddict(annotation):
        return annotation.__annotations__.get(key)
    args = get_args(annotation)
    return args[-1] if get_origin(annotation) is dict else args[0] if args else None
