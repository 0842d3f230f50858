"""The keys that a table of a typed form takes."""

from __future__ import annotations

import types
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, NotRequired, Required, Union, get_args, get_origin

from typing_extensions import is_typeddict


def keys_at(annotation: Any, path: Sequence[Any], document: Any) -> list[str]:
    """The keys that are valid at a path of a document of the given form."""
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
    """The annotation of what stands under a key."""
    if is_typeddict(annotation):
        return annotation.__annotations__.get(key)
    args = get_args(annotation)
    return args[-1] if get_origin(annotation) is dict else args[0] if args else None
