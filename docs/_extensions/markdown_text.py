"""Pieces of Markdown that are written by programs: cells, tables, links of DOIs."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from docstrings import DOI, doi_address, found_doi

_NUMBER = re.compile(r"-?[\d.]+( \(.*\))?")
_MARKUP = re.compile(r"([\\|*_<>\[\]$`])")


def cell(value: object) -> str:
    """A value as text in which nothing is markup."""
    return _MARKUP.sub(r"\\\1", " ".join(str(value).split()))


def code(text: object) -> str:
    """Text as code in a cell of a table."""
    return f"`{text}`".replace("|", r"\|")


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Lines of a table whose cells are Markdown already; numbers stand to the right."""
    columns = [[row[i] for row in rows] for i in range(len(head))]
    numeric = [bool(rows) and all(_NUMBER.fullmatch(each) for each in column) for column in columns]
    yield "| " + " | ".join(head) + " |"
    yield "|" + "|".join("---:" if each else "---" for each in numeric) + "|"
    yield from ("| " + " | ".join(row) + " |" for row in rows)
    yield ""


def with_links(text: str) -> str:
    """Prose whose DOIs lead to what they name."""
    def linked(match: re.Match[str]) -> str:
        doi = found_doi(match)
        return f"[doi {doi}]({doi_address(doi)})" + match[1][len(doi):]

    return DOI.sub(linked, text)
