"""A page as one HTML file that needs nothing else: no server, no network, no other file."""

from __future__ import annotations

import base64
import hashlib
import json
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from fesloop.errors import InputError
from fesloop.show.report.arrangement import rows, thinned_in_words, trial_of
from fesloop.show.report.drawing import checked_svg
from fesloop.show.report.drawn import drawn_numbers
from fesloop.show.report.parts import Page, Table

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
    """A page's HTML, whole."""
    script = asset("report.js")
    return _environment().from_string(asset("page.html.jinja")).render(
        page=page, policy=policy(script), style=Markup(asset("page.css")), script=Markup(script),
        licences=Markup(asset("licences.txt")), numbers=Markup(as_json(drawn_numbers(page))))


def policy(script: str) -> str:
    """Content-Security-Policy under which a page may run this one script and ask for nothing at all."""
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    return (f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; img-src data:; "
            "base-uri 'none'; form-action 'none'")


def as_json(values: Any) -> str:
    """JSON that can stand in a `<script>`: nothing in it closes the element or opens a comment."""
    text = json.dumps(values, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


@cache
def asset(name: str) -> str:
    """Text of a file that pages are made of."""
    return files("fesloop.show.report").joinpath("assets", name).read_text(encoding="utf-8")


def _environment() -> Environment:
    made = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    made.globals.update(
        kind_of=lambda part: type(part).__name__, rows=rows, trial_of=trial_of, numeric=numeric,
        thinned_in_words=thinned_in_words,
        checked_svg=lambda part: Markup(checked_svg(part)))
    return made


def numeric(table: Table, column: int) -> bool:
    """Whether a table's column holds numbers: each cell starts like one or says that there is none."""
    cells = [row[column].strip() for row in table.rows if column < len(row)]
    told = [cell for cell in cells if cell.lower() not in _NO_NUMBER]
    return bool(told) and all(cell.lstrip("+-−<>≤≥±~≈ .")[:1] in _DIGITS for cell in told)
