"""Writes parts of pages when the site is built, from what the project holds itself.

In a page, fenced blocks of these names stand for what is made of their argument or their lines:

    {benches}                 every committed result of a bench
    {block-kinds} PACKAGE     every block kind of a package
    {commands}                every command of the program
    {experiments}             the shipped experiments that its lines name
    {result} NAME             a committed result
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from block_kinds import block_pages
from command_pages import command_pages
from experiment_pages import experiment_page
from result_tables import benches, result
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment

_FENCE = re.compile(r"^```\{(benches|block-kinds|commands|experiments|result)\} ?(.*)\n((?:.*\n)*?)```$",
                    re.MULTILINE)
_LINK = re.compile(r"\[([^\[\]]+)\]\((\.\.?/[^)#\s]+)\)")


def setup(app: Sphinx) -> dict[str, Any]:
    """As Sphinx asks of an extension."""
    app.connect("source-read", _process)
    app.connect("env-get-outdated", _with_generated_parts)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def written_out(text: str) -> str:
    """A page with its generated parts in place."""
    makers: dict[str, Callable[[str, list[str]], Iterable[str]]] = {
        "benches": lambda argument, lines: benches(),
        "block-kinds": lambda argument, lines: block_pages(argument),
        "commands": lambda argument, lines: command_pages(),
        "experiments": lambda argument, lines: (line for name in lines for line in experiment_page(name)),
        "result": lambda argument, lines: result(argument)}
    return _FENCE.sub(lambda match: "\n".join(makers[match[1]](match[2], match[3].split())), text)


def without_folders(text: str, folder: Path) -> str:
    """A page whose links to folders of the sources, which lead nowhere on a site, are their text alone."""
    return _LINK.sub(lambda match: match[1] if (folder / match[2]).is_dir() else match[0], text)


def _process(app: Sphinx, page: str, source: list[str]) -> None:
    source[0] = without_folders(written_out(source[0]), Path(app.env.doc2path(page)).parent)


def _with_generated_parts(
    app: Sphinx, env: BuildEnvironment, added: set[str], changed: set[str], removed: set[str]
) -> list[str]:
    """Pages that are read anew by every build, as what they are made of may have changed."""
    return [page for page in env.found_docs if _FENCE.search(Path(env.doc2path(page)).read_text())]
