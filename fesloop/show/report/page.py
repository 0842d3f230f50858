"""A page as one self-contained HTML file."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from fesloop.errors import InputError
from fesloop.show.report.drawn import drawn_numbers
from fesloop.show.report.parts import Chart, Drawing, HeatMap, Line, Page, Part, Strips, Table


def trial_of(part: Part) -> int | None:
    """Trial that a part belongs to; None if it belongs to all."""
    return getattr(part, "trial", None)


def alike(one: Part, other: Part) -> bool:
    """Return whether two parts are charts, or heat maps, of the same quantity, to be shown side by side."""
    if isinstance(one, HeatMap) and isinstance(other, HeatMap):
        return ((one.x_label, one.y_label, one.value_label, one.low, one.high)
                == (other.x_label, other.y_label, other.value_label, other.low, other.high))
    return (isinstance(one, Chart) and isinstance(other, Chart)
            and (one.trial, one.timed, one.y_label, _names(one.lines))
            == (other.trial, other.timed, other.y_label, _names(other.lines)))


def _names(lines: Sequence[Line]) -> list[str]:
    return [line.name for line in lines]


def rows(parts: Sequence[Part]) -> list[list[Part]]:
    """Parts in their order, similar neighbours grouped."""
    found: list[list[Part]] = []
    for part in parts:
        if found and alike(found[-1][-1], part):
            found[-1].append(part)
        else:
            found.append([part])
    return found


def thinned_in_words(part: Part) -> str:
    """Sentence on how a chart merges samples into points; empty if each sample is a point."""
    lines = part.lines if isinstance(part, (Chart, Strips)) else ()
    thinned = [line for line in lines if line.thinned > 1]
    if not thinned:
        return ""
    first = "a line is the first of them" if all(line.style == "steps" for line in thinned) \
        else "a line is their mean"
    band = ", the band their extremes" if any(line.low is not None for line in thinned) else ""
    return f"A point stands for up to {max(line.thinned for line in thinned)} samples: {first}{band}."


_ELEMENTS = frozenset((
    "svg", "g", "defs", "title", "desc", "path", "rect", "circle", "ellipse", "line", "polyline", "polygon",
    "text", "tspan", "marker", "clipPath", "linearGradient", "stop", "pattern", "use"))
_SPACE = "{http://www.w3.org/2000/svg}"


def checked_svg(drawing: Drawing) -> str:
    """Check a drawing's `<svg>` and return it unchanged.

    Raises ValueError if it is not one well-formed `<svg>` with a viewBox, or could run code or load
    resources: it may hold only shapes and texts, no `on...` attributes, and no external addresses.
    """
    where = f"drawing {drawing.key!r}"
    try:
        root = ElementTree.fromstring(drawing.svg)
    except ElementTree.ParseError as error:
        raise ValueError(f"{where} is not well-formed: {error}") from error
    if _local(root.tag) != "svg" or "viewBox" not in root.attrib:
        raise ValueError(f"{where} is not an <svg> with a viewBox")
    for element in root.iter():
        if _local(element.tag) not in _ELEMENTS:
            raise ValueError(f"{where} holds <{element.tag}>, which a page does not take")
        for name, value in element.attrib.items():
            if _runs(_local(name), value):
                raise ValueError(f"{where} holds {name}={value!r}, which a page does not take")
    return drawing.svg


def _local(name: object) -> str:
    return str(name).removeprefix(_SPACE).removeprefix("{http://www.w3.org/1999/xlink}")


def _runs(name: str, value: str) -> bool:
    """Return whether an attribute runs code or refers to something outside the drawing."""
    if name.lower().startswith("on"):
        return True
    if name == "href":
        return not value.startswith("#")
    return "url(" in value.replace("url(#", "")


_DIGITS = frozenset("0123456789")
_NO_NUMBER = frozenset(("", "-", "–", "—", "n/a", "none"))


def write_page(page: Page, path: Path) -> None:
    """Write a page to a file.

    Raises InputError where the file cannot be written, ValueError where two parts have the same key or a
    drawing holds what a page does not take.
    """
    text = page_html(page)
    try:
        path.write_text(text, encoding="utf-8", errors="replace", newline="\n")
    except (OSError, ValueError) as error:
        found = getattr(error, "strerror", None) or str(error)
        raise InputError(str(path), found, "", "give a file that can be written") from error


def page_html(page: Page) -> str:
    """HTML of a page."""
    script = asset("report.js")
    return _environment().from_string(asset("page.html.jinja")).render(
        page=page, policy=policy(script), style=Markup(asset("page.css")), script=Markup(script),
        licences=Markup(asset("licences.txt")), numbers=Markup(as_json(drawn_numbers(page))))


def policy(script: str) -> str:
    """Content-Security-Policy that allows this one script and no requests."""
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    return (f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; img-src data:; "
            "base-uri 'none'; form-action 'none'")


def as_json(values: Any) -> str:
    """JSON that is safe inside a `<script>` element."""
    text = json.dumps(values, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


@cache
def asset(name: str) -> str:
    """Text of an asset of pages."""
    return files("fesloop.show.report").joinpath("assets", name).read_text(encoding="utf-8")


def _environment() -> Environment:
    made = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    made.globals.update(
        kind_of=lambda part: type(part).__name__, rows=rows, trial_of=trial_of, numeric=numeric,
        thinned_in_words=thinned_in_words,
        checked_svg=lambda part: Markup(checked_svg(part)))
    return made


def numeric(table: Table, column: int) -> bool:
    """Return whether a column holds numbers: each cell begins like one or stands for a missing one."""
    cells = [row[column].strip() for row in table.rows if column < len(row)]
    told = [cell for cell in cells if cell.lower() not in _NO_NUMBER]
    return bool(told) and all(cell.lstrip("+-−<>≤≥±~≈ .")[:1] in _DIGITS for cell in told)
