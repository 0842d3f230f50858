"""The viewer's page: the hand of a report, and the script that asks for frames."""

from __future__ import annotations

import base64
import hashlib
from functools import cache
from importlib.resources import files

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from fesloop.show.report.drawn import drawn_numbers
from fesloop.show.report.page import as_json, asset
from fesloop.show.report.parts import Page, Section
from fesloop.show.view.shown import Source

_SCRIPT = "view.js"


@cache
def policy() -> str:
    """Content-Security-Policy: this one script, and frames from where the page is from."""
    digest = base64.b64encode(hashlib.sha256(asset(_SCRIPT).encode()).digest()).decode("ascii")
    return (f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; img-src data:; "
            "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'")


def page_html(source: Source) -> str:
    """The page of a source."""
    figure = source.figure
    page = Page(title=source.title, sentence=figure.text, facts=(), trials=list(source.spans),
                shown=min(source.spans, default=0),
                sections=[Section(key="hand", title="Hand", parts=[figure])])
    spans = {str(trial): [span.first_s, span.last_s] for trial, span in source.spans.items()}
    template = files("fesloop.show.view").joinpath("assets", "view.html.jinja").read_text(encoding="utf-8")
    made = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return made.from_string(template).render(
        page=page, figure=figure, notices=source.notices, style=Markup(asset("page.css")),
        script=Markup(asset(_SCRIPT)), licences=Markup(asset("licences.txt")),
        numbers=Markup(as_json(drawn_numbers(page))), spans=Markup(as_json(spans)))
