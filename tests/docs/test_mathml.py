"""Equations become MathML; one that cannot is a fault of its page."""

import pytest

pytest.importorskip("sphinx")
from docutils import nodes
from mathml import converted
from sphinx.errors import ExtensionError

pytestmark = pytest.mark.slow  # the quick lane does without Sphinx


def test_an_equation_is_mathml():
    node = nodes.math("", r"\frac{1}{1 - p}")
    assert converted(node).startswith("<math")
    assert "<mfrac>" in converted(node)
    assert 'display="block"' in converted(node, as_block=True)


def test_what_is_no_equation_is_named():
    node = nodes.math("", r"\nosuchthing{x}")
    with pytest.raises(ExtensionError, match="nosuchthing"):
        converted(node)
