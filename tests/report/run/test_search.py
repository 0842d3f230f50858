"""A search of a few queries in the whole loop: the page tells what was asked and what came of it."""

import re

import numpy as np
import pytest

from fesloop import Recording
from fesloop.experiment.metrics.search import SearchScore, asked_of
from fesloop.show.report.page import page_html
from fesloop.show.report.parts import Chart, Drawing, Fold, Notice, Page, Paragraph
from fesloop.show.report.run.search import search_sections

QUERIES = (((17,), 20.0), ((40, 46), 25.0), ((17,), 30.0), ((17, 18), 30.0))
SCORE = SearchScore(search="search", truth="hand.angles", movement="finger_opening")


@pytest.fixture(scope="module")
def searched(recorded):
    elements = str([list(elements) for elements, _ in QUERIES])
    return recorded("array_search_exhaustive", "strategy=listed", "duration_s=15", "optimum=0.5",
                    f"blocks.search.strategies.listed.elements={elements}",
                    f"blocks.search.strategies.listed.current_ma={[current for _, current in QUERIES]}")


@pytest.fixture(scope="module")
def parts(searched):
    with Recording(searched) as recording:
        (section,) = search_sections(recording)
    assert section.key == "search"
    return section.parts


@pytest.fixture(scope="module")
def asked(searched):
    with Recording(searched) as recording:
        return asked_of(recording, SCORE)


def drawings(parts):
    return {part.key: part for part in parts if isinstance(part, Drawing)}


def test_the_sentence_tells_what_was_found_and_beside_what(parts, asked):
    best = max(asked, key=lambda one: one.verdict.quality)
    text = next(part.text for part in parts if isinstance(part, Paragraph))
    assert text.startswith("4 queries for finger opening in 0.2 min.")
    assert f"of quality {best.quality:.2f} by the tracker and truly {best.verdict.quality:.2f}" in text
    assert f"{100.0 * best.verdict.quality / 0.5:.0f} % of the best there is, 0.50" in text


def test_electrodes_are_told_with_their_best_quality(parts, asked):
    svg = drawings(parts)["search-quality-0"].svg
    told = dict(re.findall(r"<title>(elements? [\d and]+): quality (-?[\d.]+)</title>", svg))
    best = {}
    for one in asked:
        best[one.elements] = max(best.get(one.elements, -9.0), one.verdict.quality)
    assert {key: float(value) for key, value in told.items()} == {
        f"element{'s' if len(elements) > 1 else ''} {' and '.join(map(str, elements))}": round(quality, 2)
        for elements, quality in best.items()}


def test_deeper_is_better(parts, asked):
    """Opacity of the discs of a role rises with quality."""
    svg = drawings(parts)["search-quality-0"].svg
    disc = r'class="fill-(series-\d)"[^>]*fill-opacity="([\d.]+)"><title>[^:]*: quality (-?[\d.]+)'
    found = re.findall(disc, svg)
    assert len(found) == 3
    for role in ("series-0", "series-1"):
        discs = sorted((abs(float(quality)), float(opacity))
                       for each, opacity, quality in found if each == role)
        assert [opacity for _, opacity in discs] == sorted(opacity for _, opacity in discs)
    assert {role for role, _, quality in found if float(quality) > 0.0} <= {"series-0"}


def test_the_path_goes_from_electrode_to_electrode_in_order(parts):
    svg = drawings(parts)["search-path-0"].svg
    found = re.findall(r"<title>(\d+): (elements? [\d and]+)</title>", svg)
    stops = {int(number): told for number, told in found}
    assert stops == {1: "element 17", 2: "elements 40 and 46", 3: "elements 17 and 18"}
    assert svg.count("<line") == 3


def test_quality_by_query_and_by_the_patients_time(parts, asked):
    queries, minutes = (part for part in parts if isinstance(part, Chart))
    lines = {line.name: line for line in queries.lines}
    np.testing.assert_array_equal(lines["query, true"].x, [1, 2, 3, 4])
    np.testing.assert_allclose(lines["query, true"].y, [one.verdict.quality for one in asked])
    np.testing.assert_allclose(lines["best there is"].y, 0.5)
    # The search saw the hand itself: what it recommends is the best so far.
    np.testing.assert_allclose(lines["recommendation, true"].y,
                               np.maximum.accumulate([one.verdict.quality for one in asked]))
    assert (queries.title, minutes.title) == ("Quality by query", "Quality by patient's time")
    np.testing.assert_allclose(minutes.lines[0].x * 60.0, [one.told_s for one in asked])


def test_every_query_is_listed(parts):
    (fold,) = [part for part in parts if isinstance(part, Fold)]
    rows = fold.parts[0].rows
    assert [row[1] for row in rows] == ["17", "40 + 46", "17", "17 + 18"]
    assert [row[2] for row in rows] == ["20.0", "25.0", "30.0", "30.0"]


def test_it_fits_a_page(searched):
    with Recording(searched) as recording:
        sections = search_sections(recording)
    assert "<svg" in page_html(Page(title="t", sentence="s", facts=[], sections=sections))


def test_a_search_that_is_not_judged_says_so(searched):
    with Recording(searched) as recording:
        del recording.experiment["score"]["search"]
        (section,) = search_sections(recording)
    (notice,) = section.parts
    assert isinstance(notice, Notice)
    assert "not scored" in notice.text


def test_no_answer_no_drawing(recorded):
    with Recording(recorded("array_search_exhaustive", "duration_s=1")) as recording:
        (section,) = search_sections(recording)
    assert [type(part) for part in section.parts] == [Notice]


def test_runs_without_a_search_have_no_section(learning):
    with Recording(learning) as recording:
        assert search_sections(recording) == []
