"""Equations as MathML, by docutils' own converter: no script, no font, no request."""

from typing import Any

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError


def setup(app: Sphinx) -> dict[str, Any]:
    """As Sphinx asks of an extension."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def inline(self: Any, node: nodes.math) -> None:
    """An equation within a line."""
    self.body.append(converted(node))
    raise nodes.SkipNode


def block(self: Any, node: nodes.math_block) -> None:
    """An equation on lines of its own, with its number where it has one."""
    number = f'<span class="eqno">({node["number"]})</span>' if node.get("number") else ""
    anchors = "".join(f'<span id="{each}"></span>' for each in node.get("ids", []))
    self.body.append(f'<div class="math">{anchors}{number}{converted(node, as_block=True)}</div>\n')
    raise nodes.SkipNode


def converted(node: nodes.Element, as_block: bool = False) -> str:
    """MathML of a node's TeX; ExtensionError, which ends the build, where there is none."""
    try:
        return str(tex2mathml(node.astext(), as_block))
    except MathError as fault:
        where = f"{node.source}:{node.line}"
        raise ExtensionError(f"{where}: cannot be drawn: {node.astext()!r}: {fault}") from fault
