"""The project's docstrings as reStructuredText: prose, and parameters and attributes told as `name: text`.

Nothing in a docstring is markup but what is said here: a word in backticks is code, `doi 10...` a link, an
indented block is shown as it stands, lines that begin with "- " or "1. " are a list. All else is text, so
that no star or bar in a formula means anything.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby

HEADINGS = ("Parameters", "Attributes", "Returns", "Raises")
_RULE = re.compile(r"-{3,}")
_ENTRY = re.compile(r"(\*{0,2}[A-Za-z_]\w*(?:, \*{0,2}[A-Za-z_]\w*)*): ?(.*)")
_ITEM = re.compile(r"(?:[-*]|\d+\.) ")
_CODE = re.compile(r"(`+[^`]+`+)")
DOI = re.compile(r"\bdoi[: ]\s*(10\.\d{4,9}/[^\s`\"']*[^\s`\"'.,:;])")
_MARKUP = re.compile(r"([\\*|_<>@:])")
_AS_TEXT = "\\ "
"""Before a paragraph: whatever it begins with, it is no list, table or comment."""


def as_rst(lines: Sequence[str], types: Mapping[str, str]) -> list[str]:
    """Lines of reStructuredText from those of a docstring without its indentation.

    Parameters
    ----------
    lines: of the docstring.
    types: what is known of parameters and attributes by name, such as "float".
    """
    found: list[str] = []
    rest = list(lines)
    while rest:
        if len(rest) > 1 and rest[0] in HEADINGS and _RULE.fullmatch(rest[1]):
            heading, rest = rest[0], rest[2:]
            length = next((i for i, line in enumerate(rest) if not line.strip()), len(rest))
            found += [f".. rubric:: {heading}", "", *_listed(rest[:length], types), ""]
        else:
            length = next((i for i, line in enumerate(rest) if i and line in HEADINGS), len(rest))
            found += [line for block in _blocks(rest[:length]) for line in (*_prose(block), "")]
        rest = rest[length:]
    return found


def as_text(text: str) -> str:
    """A run of prose in which backticks and DOIs alone mean something."""
    found = ""
    for part in _CODE.split(" ".join(text.split())):
        written = f"``{part.strip('`')}``" if _CODE.fullmatch(part) else _linked(part)
        # Marked text ends only where no letter follows, nor comes before it.
        touching = found and written and (found[-1] + written[0]).strip("`").isalnum()
        found += ("\\ " if touching and "`" in (found[-1], written[0]) else "") + written
    return found


def doi_address(doi: str) -> str:
    """Where a DOI leads; what an address cannot hold is written as its codes."""
    return "https://doi.org/" + doi.replace("<", "%3C").replace(">", "%3E").replace(";", "%3B")


def found_doi(match: re.Match[str]) -> str:
    """The DOI of a match of `DOI`, without the bracket that closes around it."""
    doi = match[1]
    while doi.endswith(")") and doi.count(")") > doi.count("("):
        doi = doi[:-1].rstrip(".,:;")
    return doi


def _linked(text: str) -> str:
    """Text with its DOIs as links and everything else as it stands."""
    pieces, at = [], 0
    for match in DOI.finditer(text):
        doi = found_doi(match)
        link = f"`doi {_plain(doi)} <{doi_address(doi).replace('_', chr(92) + '_')}>`__"
        pieces += [_plain(text[at:match.start()]), link]
        at = match.start(1) + len(doi)
        if at < len(text) and not text[at].isspace():
            pieces.append("\\ ")
    return "".join([*pieces, _plain(text[at:])])


def _plain(text: str) -> str:
    return _MARKUP.sub(r"\\\1", text)


def _blocks(lines: Sequence[str]) -> Iterator[list[str]]:
    """Lines between blank ones; a change of what is indented ends a block too."""
    for blank, group in groupby(lines, key=lambda line: not line.strip()):
        if not blank:
            block: list[str] = []
            for line in group:
                if block and line[0] != " " and block[0][0] == " ":
                    yield block
                    block = []
                block.append(line)
            yield block


def _prose(block: list[str]) -> list[str]:
    """A paragraph, a list, or a block that is shown as it stands."""
    if block[0].startswith("  "):
        return ["::", "", *(f"    {line}" for line in block)]
    if not any(_ITEM.match(line) for line in block):
        return [_AS_TEXT + as_text(" ".join(block))]
    items: list[list[str]] = []
    for line in block:
        if _ITEM.match(line) or not items:
            items.append([])
        items[-1].append(line)
    lines: list[str] = []
    for item in items:
        marker = _ITEM.match(item[0])
        text = " ".join(item)
        lines += [_AS_TEXT + as_text(text), ""] if marker is None else [f"- {as_text(text[marker.end():])}"]
    return lines


def _listed(lines: Sequence[str], types: Mapping[str, str]) -> list[str]:
    """Entries `name: text` as a list of definitions, each with what is known of its type."""
    found: list[str] = []
    for names, text in _entries(lines, types):
        if not names:
            found += [_AS_TEXT + as_text(text), ""]
            continue
        bare = [name.lstrip("*") for name in names]
        known = list(dict.fromkeys(types[name] for name in bare if name in types))
        of_type = f" : ``{', '.join(known)}``" if known else ""
        found += [", ".join(f"**{_plain(name)}**" for name in names) + of_type,
                  f"    {_AS_TEXT}{as_text(text)}", ""]
    return found


def _entries(lines: Sequence[str], types: Mapping[str, str]) -> Iterator[tuple[list[str], str]]:
    """(names, text) of each entry; a second one may begin within a line, after a full stop."""
    texts: list[str] = []
    for line in lines:
        if texts and (line.startswith(" ") or not _ENTRY.fullmatch(line)):
            texts[-1] += " " + line.strip()
        else:
            texts.append(line.strip())
    later = re.compile(r"(?<=[.;]) (?=(?:" + "|".join(map(re.escape, sorted(types, key=len, reverse=True)))
                       + r")(?:, \w+)*: )") if types else None
    for text in texts:
        for entry in later.split(text) if later else [text]:
            match = _ENTRY.fullmatch(entry)
            yield (match[1].split(", "), match[2]) if match else ([], entry)
