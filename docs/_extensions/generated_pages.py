"""Directives that write parts of pages when the site is built, from what the project holds itself."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, ClassVar

from block_kinds import block_pages
from docutils import nodes
from experiment_pages import experiment_page
from result_tables import RESULTS, result
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


def setup(app: Sphinx) -> dict[str, Any]:
    """As Sphinx asks of an extension."""
    app.add_directive("block-kinds", BlockKinds)
    app.add_directive("experiments", Experiments)
    app.add_directive("result", Result)
    app.connect("source-read", _without_folders)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _without_folders(app: Sphinx, page: str, source: list[str]) -> None:
    """Links to folders of the sources lead nowhere on a site: their text alone stays."""
    here = Path(app.env.doc2path(page)).parent

    def text_or_link(match: re.Match[str]) -> str:
        return match[1] if (here / match[2]).is_dir() else match[0]

    source[0] = re.sub(r"\[([^\[\]]+)\]\((\.\.?/[^)#\s]+)\)", text_or_link, source[0])


class Generated(SphinxDirective):
    """A directive whose content is Markdown made of its arguments."""

    def markdown(self) -> Iterable[str]:
        """Lines, headings counted from 1 below where the directive stands."""
        raise NotImplementedError

    def run(self) -> list[nodes.Node]:
        """The nodes that Sphinx puts in the directive's place."""
        return self.parse_text_to_nodes("\n".join(self.markdown()), allow_section_headings=True)


class BlockKinds(Generated):
    """Every block kind of a package."""

    required_arguments: ClassVar[int] = 1

    def markdown(self) -> Iterable[str]:
        """See `block_pages`."""
        return block_pages(self.arguments[0])


class Experiments(Generated):
    """The shipped experiments that its content names, a line each."""

    has_content: ClassVar[bool] = True

    def markdown(self) -> Iterable[str]:
        """See `experiment_page`."""
        return [line for name in self.content if name.strip() for line in experiment_page(name.strip())]


class Result(Generated):
    """A committed result."""

    required_arguments: ClassVar[int] = 1

    def markdown(self) -> Iterable[str]:
        """See `result`."""
        self.env.note_dependency(str(RESULTS / f"{self.arguments[0]}.json"))
        return result(self.arguments[0])
