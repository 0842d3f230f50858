"""Definitions of the numbers that commands print: unit, what each is, and when there is none.

They are written in `words.toml`; `fesloop explain`, the reports and docs/metrics.md are made from it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib import resources
from typing import Any

from fesloop.errors import InputError, did_you_mean
from fesloop.forms.toml import tables_of

_LINK = re.compile(r"\[([^]]*)\]\([^)]*\)")


@dataclass(frozen=True, slots=True, kw_only=True)
class Definition:
    """Definition of a number.

    Attributes
    ----------
    name: as in --json.
    command: what prints it.
    unit: "" for a count, a share or a word.
    what: what it is. Text may hold links of Markdown, `plain_text` takes them out.
    nan: when there is no number, and why; "" where there always is one.
    shown: headings or labels under which a table prints it, where these are not the name.
    parts: names of its parts, with a definition each.
    never_negative: whether it is 0 or more by its definition.
    """

    name: str
    command: str
    unit: str = ""
    what: str
    nan: str = ""
    shown: tuple[str, ...] = ()
    parts: Mapping[str, str] = field(default_factory=dict)
    never_negative: bool = False

    def as_table(self) -> dict[str, Any]:
        """The definition as `fesloop explain --json` prints it."""
        return {**asdict(self), "what": plain_text(self.what), "nan": plain_text(self.nan)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """Definitions that belong together, under one heading of the page."""

    title: str
    command: str
    about: str
    definitions: tuple[Definition, ...]


@cache
def groups() -> tuple[Group, ...]:
    """Every definition, in the order of the page."""
    file = resources.files("fesloop.experiment.metrics") / "words.toml"
    return tuple(
        Group(title=table["title"], command=table["command"], about=table["about"], definitions=tuple(
            Definition(name=name, command=table["command"], unit=each.get("unit", ""), what=each["is"],
                       nan=each.get("nan", ""), shown=tuple(each.get("shown", ())),
                       parts=each.get("parts", {}), never_negative=each.get("least") == 0)
            for name, each in table["metrics"].items()))
        for table in tables_of(file.read_text("utf-8")).values())


def definitions_of(name: str, others: Iterable[str] = ()) -> list[Definition]:
    """Definitions of a number by its name, its heading, or a path to it.

    Several commands may print different numbers of one name. A path is that of a run's metrics, with dots or,
    as the summary of a run prints it, with blanks: "joints.MCP.joint_rmse_deg", "aperture_mm hold".

    Raises InputError for an unknown name, with the known name most like it; `others` are known beside these.
    """
    parts = re.split(r"[.\s]+", name.strip())
    if parts[0] == "joints" and len(parts) > 2:
        del parts[:2]
    every = [each for group in groups() for each in group.definitions]
    for given in (name.strip(), parts[0]):
        found = [each for each in every if given.lower() in map(str.lower, (each.name, *each.shown))]
        if found:
            return found
    known = [*dict.fromkeys(text for each in every for text in (each.name, *each.shown)), *others]
    raise InputError("explain", f"no command prints a number {name!r}", "",
                     did_you_mean(name, known) or did_you_mean(parts[0], known)
                     or "`fesloop explain` lists all")


def definition_text(name: str) -> str:
    """Definition of a metric of a run with its parts, as one text; "" for one that is not defined."""
    found = next((each for group in groups() for each in group.definitions if each.name == name), None)
    if found is None:
        return ""
    return " ".join([plain_text(found.what), *(f"{part}: {what}." for part, what in found.parts.items())])


def is_never_negative(path: str) -> bool:
    """Whether a run's metric, such as "joints.MCP.joint_rmse_deg", is 0 or more by its definition."""
    try:
        return all(each.never_negative for each in definitions_of(path))
    except InputError:
        return False  # a metric of a package that defines none


def plain_text(text: str) -> str:
    """A text without the links of Markdown, for a terminal."""
    return _LINK.sub(r"\1", text)
