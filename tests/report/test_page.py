import base64
import hashlib
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from made_up_pages import error, joint, page

from fesloop.errors import InputError
from fesloop.show.report.drawn import drawn_numbers
from fesloop.show.report.page import as_json, asset, page_html, rows, write_page
from fesloop.show.report.parts import Chart, Code, Fold, Line, Notice, Paragraph, Section, Table

HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)> \" ' `& ]]> -->"


class Seen(HTMLParser):
    """The elements of a page with their attributes, and the text of its scripts."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.elements, self.scripts, self.texts, self.inside = [], [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        self.inside = tag
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, tag):
        self.inside = ""

    def handle_data(self, text):
        if self.inside == "script":
            self.scripts[-1] += text
        elif self.inside != "style":
            self.texts.append(text)

    def all(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]


def hostile_page():
    """A page whose every text would like to be markup."""
    line = replace(error().lines[0], name=HOSTILE, role=HOSTILE)
    chart = replace(error(), key=HOSTILE, title=HOSTILE, x_label=HOSTILE, y_label=HOSTILE, text=HOSTILE,
                    lines=[line])
    parts = [chart, Paragraph(text=HOSTILE), Notice(text=HOSTILE), Code(text=HOSTILE),
             Table(title=HOSTILE, columns=[HOSTILE], rows=[[HOSTILE]]),
             Fold(title=HOSTILE, parts=[Paragraph(text=HOSTILE)])]
    return page(title=HOSTILE, sentence=HOSTILE, facts=[(HOSTILE, HOSTILE)],
                sections=[Section(key=HOSTILE, title=HOSTILE, parts=parts)])


def test_texts_are_texts_whatever_they_hold():
    calm, seen = Seen(page_html(page())), Seen(page_html(hostile_page()))
    assert len(seen.scripts) == len(calm.scripts) == 2
    assert seen.scripts[1] == calm.scripts[1]
    assert not seen.all("img")
    assert not [name for _, attributes in seen.elements for name in attributes if name.startswith("on")]
    (told,) = json.loads(seen.scripts[0])["parts"].values()
    assert told["lines"][0]["name"] == told["x_label"] == HOSTILE
    shown = "".join(seen.texts)
    assert shown.count(HOSTILE) == 10  # titles, headings, names, the code, what stands for the chart
    assert shown.count(HOSTILE.replace("`", "")) == 7  # where a backquote begins code


def test_the_policy_lets_the_one_script_run_and_nothing_be_asked_for():
    seen = Seen(page_html(page()))
    (policy,) = [meta["content"] for meta in seen.all("meta") if "http-equiv" in meta]
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    digest = base64.b64encode(hashlib.sha256(seen.scripts[1].encode()).digest()).decode()
    assert rules["script-src"] == f"'sha256-{digest}'"
    assert rules["default-src"] == "'none'"
    assert set(rules) <= {"default-src", "script-src", "style-src", "img-src", "base-uri", "form-action"}
    assert rules["style-src"] == "'unsafe-inline'"
    assert rules["img-src"] == "data:"


def test_a_page_names_no_other_file():
    text = page_html(page())
    seen = Seen(text)
    for _, attributes in seen.elements:
        assert not attributes.keys() & {"src", "srcset", "action", "poster"}
        assert attributes.get("href", "#").startswith(("#", "data:"))
    style = text[text.index("<style>"):text.index("</style>")]
    assert not re.search(r"url\(|@import", style)


def test_parts_of_trials_that_are_not_shown_are_hidden():
    seen = Seen(page_html(page()))
    told = [attributes for _, attributes in seen.elements if "data-trial" in attributes]
    assert {attributes["data-trial"] for attributes in told} == {"1", "2", "3"}
    assert all(("hidden" in attributes) == (attributes["data-trial"] != "3") for attributes in told)


def test_every_part_that_is_drawn_has_its_place_and_its_numbers():
    made = page()
    elements = Seen(page_html(made)).elements
    places = {attributes["data-part"] for _, attributes in elements if "data-part" in attributes}
    assert places == set(drawn_numbers(made)["parts"])
    assert {"error", "kinds", "decades", "hand", "index-1", "wrist-3", "stacked", "beside", "heat"} <= places


def test_two_parts_of_one_key_are_refused():
    parts = [error(), Fold(title="b", parts=[error()])]
    with pytest.raises(ValueError, match="'error' is there twice"):
        page_html(page(sections=[Section(key="a", title="a", parts=parts)]))


def test_charts_of_one_kind_stand_beside_each_other_and_others_do_not():
    one, two, other = joint("index", 1), joint("middle", 1), joint("index", 2)
    note = Paragraph(text="")
    assert rows([one, two, other, note, one]) == [[one, two], [other], [note], [one]]


@pytest.mark.parametrize(("cells", "right"), [
    (["1.2", "−3", "< 0.01"], True), (["1.2 ms", "–", "4"], True), (["+1e-3 (8 of 9)"], True),
    (["–", ""], False), (["1.2", "vqf"], False), ([], False)])
def test_a_column_of_numbers_is_aligned_to_the_right(cells, right):
    table = Table(columns=["value"], rows=[[cell] for cell in cells])
    seen = Seen(page_html(page(sections=[Section(key="a", title="a", parts=[table])])))
    assert all((cell.get("class") == "number") == right for cell in seen.all("td") + seen.all("th"))


def test_json_in_a_page_is_the_same_json():
    values = {"<!--": ["</script>", "\u2028", "µ", None, 1.5]}
    text = as_json(values)
    assert json.loads(text) == values
    assert "<" not in text


def test_a_page_is_written_once_and_is_small(tmp_path):
    write_page(page(), tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == page_html(page())
    assert (tmp_path / "page.html").stat().st_size < 1_500_000
    empty = page(sections=[], trials=(), shown=0)
    assert len(page_html(empty)) < len(asset("report.js")) + 80_000


def test_a_place_that_cannot_be_written_is_said(tmp_path):
    with pytest.raises(InputError, match=r"gone.page\.html: No such file"):
        write_page(page(), tmp_path / "gone" / "page.html")


def test_the_licences_of_what_is_bundled_stand_in_the_page():
    text = page_html(page())
    for name in ("three ", "@observablehq/plot ", "d3-shape ", "d3-scale "):
        assert f"\n{name}" in text
    assert text.count("Permission ") >= 10


def test_a_line_without_a_number_makes_a_page():
    bare = Chart(key="bare", title="bare", x_label="x", y_label="y",
                 lines=[Line(name="none", role="plain", x=np.empty(0), y=np.empty(0)),
                        Line(name="gaps", role="plain", x=np.arange(300.0), y=np.full(300, np.nan))])
    text = page_html(page(sections=[Section(key="a", title="a", parts=[bare])]))
    assert "NaN" not in Seen(text).scripts[0]
