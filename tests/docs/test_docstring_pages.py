"""Docstrings in a site that Sphinx builds."""

import sys

import pytest

pytest.importorskip("sphinx")
from docstring_pages import types_of
from sphinx.application import Sphinx

pytestmark = pytest.mark.slow  # the quick lane does without Sphinx

MODULE = '''
from __future__ import annotations
from dataclasses import dataclass
from typing import Literal

Law = Literal["slow", "quick"]


@dataclass(frozen=True, kw_only=True)
class Thing:
    """A thing of doi 10.3390/s19010208.

    Attributes
    ----------
    size_mm, mass_kg: of it, a * b.
    law: which.
    """

    size_mm: float
    mass_kg: float = 0.2
    law: Law = "slow"
'''


@pytest.fixture
def things(tmp_path, monkeypatch):
    """The folder of a module to be told of."""
    (tmp_path / "told_things.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path
    sys.modules.pop("told_things", None)


def test_types_are_those_of_the_fields(things):
    import told_things

    assert types_of(told_things.Thing) == {
        "size_mm": "float", "mass_kg": "float", "law": "'slow' | 'quick'"}


def test_a_page_has_a_list_of_parameters_and_a_link(things, monkeypatch):
    from docutils import nodes

    source = things / "source"
    source.mkdir()
    (source / "index.rst").write_text("Things\n======\n\n.. autoclass:: told_things.Thing\n")
    settings = {"extensions": ["sphinx.ext.autodoc", "docstring_pages"], "autodoc_typehints": "none"}
    app = Sphinx(source, None, things / "out", things / "trees", "dummy", settings, None, None,
                 warningiserror=True)
    app.build()
    page = app.env.get_doctree("index")
    assert [each.astext() for each in page.findall(nodes.term)] == ["size_mm, mass_kg", "law"]
    assert [each.astext() for each in page.findall(nodes.classifier)] == ["float", "'slow' | 'quick'"]
    assert [each["refuri"] for each in page.findall(nodes.reference)] == ["https://doi.org/10.3390/s19010208"]
