"""What a page's script is given can be drawn, whatever a damaged file held."""

import base64
from dataclasses import replace

import numpy as np
import pytest
from made_up_pages import channels, drawing, error, heat_map, page

from fesloop.show.report import svg
from fesloop.show.report.drawn import drawn_numbers
from fesloop.show.report.page import write_page
from fesloop.show.report.parts import Mark, Paragraph, Section


def drawn(chart):
    """A chart as a script is given it, and the page's arrays."""
    found = drawn_numbers(page(sections=[Section(key="one", title="One", parts=[chart])]))
    return found["parts"][chart.key], found["arrays"]


def test_limits_and_marks_that_are_no_numbers_are_left_out():
    nowhere = [(np.nan, 1.0), ("\x1b", 2.0), (0.0, 10**400), (None, 2.0), (1.0, [2.0])]
    marks = [*(Mark(text="nowhere", at=at, until=until) for at, until in nowhere),
             Mark(text="here", at=1.0, until=np.float64(2.0))]
    chart, _ = drawn(replace(error(), limits=(0.0, np.inf), marks=marks))
    assert chart["limits"] is None
    assert chart["marks"] == [{"text": "here", "at": 1.0, "until": 2.0}]


def test_a_point_that_is_infinite_is_a_gap():
    line = replace(error().lines[0], x=np.arange(3.0), y=np.array([1.0, np.inf, 2.0]), low=None, high=None)
    chart, arrays = drawn(replace(error(), lines=[line]))
    values = np.frombuffer(base64.b64decode(arrays[chart["lines"][0]["y"]]["f8"]))
    assert np.array_equal(values, [1.0, np.nan, 2.0], equal_nan=True)


def test_one_value_far_outside_of_what_is_seen_makes_no_steps_of_the_others():
    y = np.sin(np.arange(600.0))
    y[300] = 1e9
    line = replace(error().lines[0], x=np.arange(600.0), y=y, low=None, high=None)
    chart, arrays = drawn(replace(error(), lines=[line], limits=(-1.0, 1.0)))
    assert np.array_equal(np.frombuffer(base64.b64decode(arrays[chart["lines"][0]["y"]]["f8"])), y)
    chart, arrays = drawn(replace(error(), lines=[line], limits=None))
    assert "i2" in arrays[chart["lines"][0]["y"]]


def test_names_with_letters_that_no_file_takes_are_written(tmp_path):
    words = "a\x01b\ud800c\u2028"
    picture = drawing(svg.drawing(9.0, 9.0, [svg.text(0.0, 0.0, words), svg.rect(0.0, 0.0, 1.0, 1.0, "ink",
                                                                               tooltip=words)]))
    path = tmp_path / "page.html"
    write_page(page(title=words, sections=[Section(key="one", title=words, parts=[
        Paragraph(text=words), picture])]), path)
    text = path.read_text(encoding="utf-8")
    assert text.count("a\N{REPLACEMENT CHARACTER}b\N{REPLACEMENT CHARACTER}c") == 2


@pytest.mark.parametrize(("low", "high", "given", "why"), [
    (np.nan, np.nan, np.nan, "No cell has a value."), (1.0, 6.0, np.nan, "No cell has a value."),
    (np.nan, 6.0, 2.0, "Cells have no colours"), (-np.inf, np.inf, 2.0, "Cells have no colours")])
def test_a_map_without_ends_of_its_colours_is_written_with_a_note(tmp_path, low, high, given, why):
    heat = replace(heat_map(), low=low, high=high, values=np.full((2, 3), given))
    assert heat.lack.startswith(why)
    told, _ = drawn(heat)
    assert (told["low"], told["high"]) == (None, None)
    path = tmp_path / "page.html"
    write_page(page(sections=[Section(key="one", title="One", parts=[heat])]), path)
    assert f'<p class="notice" role="note">{heat.lack}</p>' in path.read_text(encoding="utf-8")


def test_a_map_with_ends_has_its_colours_and_no_note():
    told, _ = drawn(heat_map())
    assert (told["low"], told["high"]) == (1.0, 6.0)
    assert heat_map().lack == ""


def test_strips_are_given_with_all_their_lines():
    told, _ = drawn(channels(3))
    assert told["kind"] == "strips"
    assert [line["name"] for line in told["lines"]] == ["channel 0", "channel 1", "channel 2"]
    assert told["limits"] == [0.0, 25.0]
    assert told["timed"]
    without, _ = drawn(replace(channels(1), limits=(0.0, np.nan)))
    assert without["limits"] is None
