"""Charts, bars and heat maps: none is empty, all follow the trial, the play head and the width."""

import re

import numpy as np
import pytest
from made_up_pages import page

from fesloop.report.parts import Bars, Chart, Line, Section


def drawn(shown, key):
    """The figure of a part, scrolled to and drawn."""
    figure = shown.locator(f"#part-{key}")
    figure.scroll_into_view_if_needed()
    figure.locator(".plot svg").wait_for()
    return figure


@pytest.mark.parametrize("width", [1280, 400])
@pytest.mark.parametrize(("key", "shapes", "count"), [
    ("error", "[aria-label=line] path", 1), ("kinds", "[aria-label=dot] circle", 2),
    ("decades", "[aria-label=line] path", 1), ("index-3", "[aria-label=line] path", 3),
    ("stacked", "[aria-label=bar] rect", 4), ("beside", "[aria-label=bar] rect", 4),
    ("heat", "[aria-label=rect] rect", 6)])
def test_no_figure_is_empty(opened, key, shapes, count, width):
    figure = drawn(opened(page(), width=width), key)
    marks = figure.locator(shapes)
    boxes = [marks.nth(i).bounding_box() for i in range(marks.count())]
    assert len(boxes) == count
    svg = figure.locator("svg").first.bounding_box()
    for box in boxes:
        assert box["width"] * box["height"] > 4
        assert svg["x"] <= box["x"]
        assert box["x"] + box["width"] <= min(svg["x"] + svg["width"], width) + 1


def test_bars_have_three_digits_and_counts_none_after_the_point(opened):
    bars = Bars(key="told", title="told", x_label="error, deg", names=["a", "b", "c"],
                values={"error": [1.301, 0.0499, 12.0]}, roles={"error": "plain"}, stacked=False)
    figure = drawn(opened(page(sections=[Section(key="a", title="a", parts=[bars])])), "told")
    texts = figure.locator("[aria-label=text] text").all_text_contents()
    assert texts == ["1.30", "0.0499", "12"]


def test_a_number_that_is_not_known_is_a_gap(opened):
    figure = drawn(opened(page()), "index-3")
    paths = figure.locator("[aria-label=line] path")
    assert [paths.nth(i).get_attribute("d").count("M") for i in range(3)] == [1, 2, 1]


def test_a_line_goes_where_its_numbers_say(opened):
    """A sine of an amplitude of 1 in limits of 2: its path spans half of the frame."""
    x = np.linspace(0.0, 1.0, 401)
    chart = Chart(key="sine", title="sine", x_label="x", y_label="y", limits=(-2.0, 2.0),
                  lines=[Line(name="sine", role="plain", x=x, y=np.sin(2 * np.pi * x))])
    shown = opened(page(sections=[Section(key="a", title="a", parts=[chart])]))
    figure = drawn(shown, "sine")
    path = figure.locator("[aria-label=line] path").get_attribute("d")
    points = np.array([pair.split(",") for pair in re.findall(r"[ML]([^ML]+)", path)], dtype=float)
    assert len(points) == 401
    ticks = figure.locator('[aria-label="y-axis tick"] path')
    ends = [float(re.search(r",([\d.]+)\)", ticks.nth(i).get_attribute("transform"))[1])
            for i in (0, ticks.count() - 1)]
    per_unit = (ends[0] - ends[1]) / 4.0
    zero = (ends[0] + ends[1]) / 2.0
    assert (zero - points[:, 1]) / per_unit == pytest.approx(np.sin(2 * np.pi * x), abs=0.01)
    across = points[:, 0] - points[0, 0]
    assert across / across[-1] == pytest.approx(x, abs=1e-3)


def test_what_is_pointed_at_is_told(opened):
    shown = opened(page())
    figure = drawn(shown, "error")
    dots = figure.locator("[aria-label=dot] circle")
    dots.nth(1).hover()
    told = figure.locator(".told")
    assert told.is_visible()
    assert re.sub(r"\s+", " ", told.inner_text()).endswith("error 4")
    heat = drawn(shown, "heat")
    heat.locator("[aria-label=rect] rect").nth(4).hover(force=True)
    assert "5 deg" in heat.locator(".told").inner_text()


def test_a_chart_of_time_moves_the_play_head_and_follows_it(opened):
    shown = opened(page())
    figure = drawn(shown, "index-3")
    frame = figure.locator("[aria-label=line] path").first.bounding_box()
    heads = "[...document.querySelectorAll('.play-head')].map((head) => head.getBoundingClientRect().x)"
    shown.mouse.click(frame["x"] + 0.75 * frame["width"], frame["y"] + 0.5 * frame["height"])
    assert shown.locator(".bar .time").inner_text().startswith("1.5")
    first, second = shown.evaluate(heads)[:2]
    assert first == pytest.approx(frame["x"] + 0.75 * frame["width"], abs=2)
    other = shown.locator("#part-middle-3 [aria-label=line] path").first.bounding_box()
    assert second == pytest.approx(other["x"] + 0.75 * other["width"], abs=2)


def test_the_chosen_trial_is_shown_and_no_other(opened):
    shown = opened(page())
    for trial in (1, 2, 3):
        shown.locator("#trial").select_option(str(trial))
        drawn(shown, f"index-{trial}")
        for other in (1, 2, 3):
            assert shown.locator(f"#part-index-{other}").is_visible() == (other == trial)


def test_trials_are_stepped_through_up_to_the_ends(opened):
    shown = opened(page())
    on, back = (shown.get_by_role("button", name=name) for name in ("Next trial", "Trial before"))
    assert on.is_disabled()
    back.click()
    back.click()
    assert shown.locator("#trial").input_value() == "1"
    assert back.is_disabled()
    on.press("Enter")
    assert shown.locator("#part-index-2").is_visible()


def test_charts_of_one_kind_share_a_key(opened):
    shown = opened(page())
    drawn(shown, "index-3")
    names = shown.locator(".multiples:visible > .key li").all_inner_texts()
    assert names == ["reference", "truth", "estimate"]


def test_names_stand_at_lines_ends_where_there_is_room(opened):
    x = np.arange(3.0)
    chart = Chart(key="two", title="two", x_label="x", y_label="y", lines=[
        Line(name=name, role="plain", x=x, y=x + by) for name, by in (("one", 0.0), ("other", 0.01))])
    sections = [Section(key="a", title="a", parts=[chart])]
    figure = drawn(opened(page(sections=sections)), "two")
    boxes = [figure.locator(".end").nth(i).bounding_box() for i in range(2)]
    assert figure.locator(".end").all_text_contents() == ["one", "other"]
    assert abs(boxes[0]["y"] - boxes[1]["y"]) >= 14
    narrow = drawn(opened(page(sections=sections), width=400), "two")
    assert narrow.locator(".end").count() == 0
    assert narrow.locator(".key li").all_inner_texts() == ["one", "other"]


@pytest.mark.parametrize("y", [
    [], [np.nan] * 3, [1.0], [2.0, 2.0], [np.inf, 1.0, -np.inf], [1e308, -1e308, 0.0]])
def test_numbers_that_make_no_line_make_no_trouble(opened, y):
    line = Line(name="odd", role="plain", x=np.arange(float(len(y))), y=np.array(y))
    charts = [Chart(key=f"odd-{log}", title="odd", x_label="x", y_label="y", lines=[line], x_log=log)
              for log in (False, True)]
    shown = opened(page(sections=[Section(key="a", title="a", parts=charts)]))
    for log in (False, True):
        assert "NaN" not in drawn(shown, f"odd-{log}").locator(".plot").inner_html()
