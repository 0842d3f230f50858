"""Docstrings as reStructuredText, held against what docutils makes of it."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("sphinx")
from docstrings import as_rst, as_text, doi_address
from docutils import nodes
from docutils.core import publish_doctree

pytestmark = pytest.mark.slow  # the quick lane does without Sphinx

LOUD = {"report_level": 1, "halt_level": 1}
ITEM = re.compile(r"([-*]|\d+\.) ")
PLAIN = st.text(st.characters(codec="ascii", categories=["L", "N", "P", "S", "Zs"], exclude_characters="`"),
                min_size=1)


def read(lines, **types):
    return publish_doctree("\n".join(as_rst(lines, types)), settings_overrides=LOUD)


@given(PLAIN.filter(lambda text: text.strip() and "doi" not in text and not ITEM.match(text.strip())))
def test_prose_reads_as_it_is_written(text):
    document = read([text.strip()])
    assert document.astext().split() == text.split()
    assert not list(document.findall(nodes.reference))


def test_entries_are_terms_with_their_types():
    document = read(["Turns.", "", "Parameters", "----------", "turn: about z, rad,", "    counted on.",
                     "low, high: ends.", "", "Raises nothing."], turn="float", low="int", high="int")
    terms = [each.astext() for each in document.findall(nodes.term)]
    types = [each.astext() for each in document.findall(nodes.classifier)]
    texts = [each.astext() for each in document.findall(nodes.definition)]
    assert terms == ["turn", "low, high"]
    assert types == ["float", "int"]
    assert texts == ["about z, rad, counted on.", "ends."]
    assert [each.astext() for each in document.findall(nodes.rubric)] == ["Parameters"]
    assert [each.astext() for each in document.children[0:1]] == ["Turns."]
    assert document.children[-1].astext() == "Raises nothing."


def test_a_second_entry_on_a_line_is_an_entry_where_its_name_is_known():
    entry = ["Attributes", "----------", "name: in the key. role: of its colour. note: see there."]
    document = read(entry, name="str", role="str")
    assert [each.astext() for each in document.findall(nodes.term)] == ["name", "role"]
    assert [each.astext() for each in document.findall(nodes.definition)] == [
        "in the key.", "of its colour. note: see there."]


def test_words_in_backticks_are_code_also_beside_letters():
    document = publish_doctree(as_text("several `Duration`s, (`a * b`)"), settings_overrides=LOUD)
    assert [each.astext() for each in document.findall(nodes.literal)] == ["Duration", "a * b"]
    assert document.astext() == "several Durations, (a * b)"


def test_an_indented_block_stands_as_it_is():
    document = read(["So:", "", "    x* = |a|_1", "      more", "", "then."])
    block, = document.findall(nodes.literal_block)
    assert block.astext() == "x* = |a|_1\n  more"
    assert document.children[-1].astext() == "then."


def test_lines_with_dashes_are_a_list():
    document = read(["- one thing", "  and more", "- another"])
    assert [each.astext() for each in document.findall(nodes.list_item)] == ["one thing and more", "another"]


@pytest.mark.parametrize(("text", "doi"), [
    ("after it (doi 10.3390/s19010208, eq. 3).", "10.3390/s19010208"),
    ("so says doi\n10.1186/1743-0003-11-70.", "10.1186/1743-0003-11-70"),
    ("An 1983 (doi 10.1016/0021-9290(83)90053-X) as quoted", "10.1016/0021-9290(83)90053-X"),
    ("(doi 10.1016/S1050-6411(03)00102-0)", "10.1016/S1050-6411(03)00102-0"),
    ("(doi 10.1002/(SICI)1097-0258(19981130)17:22<2635::AID-SIM954>3.0.CO;2-C).",
     "10.1002/(SICI)1097-0258(19981130)17:22<2635::AID-SIM954>3.0.CO;2-C")])
def test_dois_lead_to_what_they_name(text, doi):
    document = publish_doctree(as_text(text), settings_overrides=LOUD)
    link, = document.findall(nodes.reference)
    assert link.astext() == f"doi {doi}"
    assert link["refuri"] == doi_address(doi)
    assert document.astext().split() == text.split()
